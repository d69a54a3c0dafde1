//! How often the intervals and tests of the friction stage tell the truth, over many runs, as Markdown.
//!
//! `cargo run --release -p asperity-validation --bin validate_friction -- [RUNS [ONLY]]` prints what `docs/validation/friction.md`
//! holds; `just validate` writes it.
#![expect(clippy::print_stdout, reason = "the tables are what this program is for")]

mod correlation;
mod field;
mod marginal;
mod moments;
mod observed;
mod planted;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let runs: usize = arguments.next().map_or(Ok(1000), |word| word.parse())?;
    let only = arguments.next().unwrap_or_default();
    println!(
        "# Friction as a process: do the intervals hold?\n\n`just validate` writes this page. Every row stands for {runs} \
         independent runs on synthetic processes whose truth is known. A coverage of 95 % is known to ±{:.1} % (one standard error).",
        100.0 * (0.95 * 0.05 / runs as f64).sqrt()
    );
    let wanted = |part: &str| part.contains(&only);
    if wanted("moments") {
        println!("\n{}", moments::section(runs));
    }
    if wanted("marginal") {
        println!("\n{}", marginal::section(runs));
    }
    if wanted("correlation") {
        println!("\n{}", correlation::section(runs)?);
    }
    if wanted("observed") {
        // A run fits some forty models.
        println!("\n{}", observed::section((runs / 10).max(10))?);
    }
    Ok(())
}
