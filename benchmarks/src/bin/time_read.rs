//! Times reading a file: `cargo run --release -p asperity-benchmarks --bin time_read -- FILE [REPEATS] [HEIGHTS.npy]`.
//!
//! Prints `rows columns best median` with times in second, and writes the heights to HEIGHTS.npy if it is given. The first read
//! is not timed, because it loads the file into the page cache.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "prints times")]

use std::{env, error::Error, hint::black_box, path::PathBuf, process::ExitCode, time::Instant};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args().skip(1);
    let file = PathBuf::from(arguments.next().ok_or("usage: time_read FILE [REPEATS] [HEIGHTS.npy]")?);
    let repeats: usize = arguments.next().map_or(Ok(5), |count| count.parse())?;
    let scan = asperity_formats::read(&file)?;
    if let Some(heights) = arguments.next() {
        asperity_formats::write(&scan, &PathBuf::from(heights))?;
    }
    let (rows, columns) = scan.heights_m.dim();
    drop(scan);
    let mut times_s = Vec::new();
    for _ in 0..repeats.max(1) {
        let start = Instant::now();
        let scan = asperity_formats::read(&file)?;
        times_s.push(start.elapsed().as_secs_f64());
        black_box(&scan);
    }
    times_s.sort_by(f64::total_cmp);
    println!("{rows} {columns} {} {}", times_s[0], times_s[times_s.len() / 2]);
    Ok(())
}
