//! Coverage of the intervals of the friction stage over many runs, as Markdown.
//!
//! `cargo run --release -p asperity --example validate_friction -- [RUNS]` prints what `docs/validation/friction.md` holds;
//! `just validate` writes it.
#![expect(clippy::print_stdout, reason = "the tables are what this program is for")]

mod correlation;
mod field;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let runs: usize = std::env::args().nth(1).map_or(Ok(1000), |word| word.parse())?;
    println!(
        "# Friction as a process: do the intervals hold?\n\n`just validate` writes this page. Every row stands for {runs} \
         independent runs on synthetic processes whose truth is known. A coverage of 95 % is known to ±{:.1} % (one standard error).",
        100.0 * (0.95 * 0.05 / runs as f64).sqrt()
    );
    println!("\n{}", correlation::section(runs)?);
    Ok(())
}
