//! Counts the coverage of the intervals and the rejections by the tests of the friction stage over many runs, and prints both as Markdown.
//!
//! `cargo run --release -p asperity-validation --bin validate_friction -- [RUNS [ONLY]]` prints `docs/validation/friction.md`; `just
//! validate` writes the file.
#![expect(clippy::print_stdout, reason = "prints tables")]

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
        "# Friction as a process: coverage of the intervals\n\n`just validate` writes this page. Every row summarises {runs} \
         independent runs, or as many as it states, on synthetic processes whose true values are known. A coverage of 95 % has a standard error of {:.1} %.",
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
        println!("\n{}", observed::section(runs)?);
    }
    Ok(())
}
