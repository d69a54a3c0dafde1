//! Times building and evaluating expansions and designs, and prints JSON.
//!
//! `RAYON_NUM_THREADS=1 cargo run --release -p asperity-benchmarks --bin time_chaos [points]`
//!
//! Each time is the best of five.
#![expect(clippy::print_stdout, reason = "prints times")]

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use asperity::chaos::{Basis, Design, Expansion, SamplingMethod};

fn main() -> Result<(), Box<dyn Error>> {
    let points: usize = std::env::args().nth(1).as_deref().unwrap_or("200000").parse()?;
    let mut evaluations = Vec::new();
    for (variables, degree, points) in [(8, 2, points), (8, 3, points), (8, 5, points / 10), (101, 2, points / 20)] {
        let basis = Basis::hermite(variables, degree)?;
        let coefficients = (0..basis.len()).map(|k| (k as f64).sin() / (k + 1) as f64).collect();
        let terms = basis.len();
        let expansion = Expansion::new(basis, coefficients);
        let design = Design::new(SamplingMethod::MonteCarlo, 1, "time", points, variables)?;
        let xi_samples: Vec<Vec<f64>> = (0..points).map(|i| design.xi(i)).collect();
        let seconds = least(|| drop(black_box(expansion.evaluate_many(black_box(&xi_samples)))));
        evaluations.push(serde_json::json!({
            "variables": variables, "degree": degree, "terms": terms, "points": points,
            "points_per_second": points as f64 / seconds, "nanoseconds_per_point": 1e9 * seconds / points as f64,
        }));
    }
    let sets = [(8, 3), (101, 2), (1000, 1)].map(|(variables, degree)| {
        let seconds = least(|| drop(black_box(Basis::hermite(variables, degree))));
        serde_json::json!({ "variables": variables, "degree": degree, "seconds": seconds })
    });
    let mut designs = Vec::new();
    for (name, method, samples, dimensions) in [
        ("sobol", SamplingMethod::Sobol, 1000, 101),
        ("sobol", SamplingMethod::Sobol, 1000, 1000),
        ("sobol", SamplingMethod::Sobol, 1000, 1867),
        ("latin_hypercube", SamplingMethod::LatinHypercube, 500, 10),
        ("maximin_latin_hypercube", SamplingMethod::MaximinLatinHypercube, 500, 10),
        ("maximin_latin_hypercube", SamplingMethod::MaximinLatinHypercube, 2000, 10),
    ] {
        let start = Instant::now();
        let design = Design::new(method, 1, "time", samples, dimensions)?;
        let first_s = start.elapsed().as_secs_f64();
        let again_s = least(|| drop(black_box(Design::new(method, 1, "time", samples, dimensions))));
        let points_s = least(|| (0..samples).for_each(|i| drop(black_box(design.xi(i)))));
        designs.push(serde_json::json!({
            "method": name, "samples": samples, "dimensions": dimensions,
            "first_seconds": first_s, "seconds": again_s, "points_seconds": points_s,
        }));
    }
    let threads = rayon::current_num_threads();
    let times =
        serde_json::json!({ "threads": threads, "evaluate_many": evaluations, "sets": sets, "designs": designs });
    println!("{times:#}");
    Ok(())
}

fn least(mut work: impl FnMut()) -> f64 {
    (0..5)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}
