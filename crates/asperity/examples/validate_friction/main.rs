//! How often the intervals and tests of the friction process tell the truth, as Markdown.
//!
//! `cargo run --release -p asperity --example validate_friction -- [RUNS [ONLY]]` prints what `docs/validation/friction.md` holds;
//! `just validate` writes it.
#![expect(clippy::print_stdout, reason = "the tables are what this program is for")]

mod marginal;
mod moments;
mod planted;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let runs = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(1000);
    let only = arguments.next().unwrap_or_default();
    println!("# Validation of the friction process\n");
    if "moments".contains(&only) {
        println!("{}", moments::section(runs));
    }
    if "marginal".contains(&only) {
        println!("{}", marginal::section(runs));
    }
}
