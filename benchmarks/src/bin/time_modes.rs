//! Measures time and memory of 101 Karhunen–Loève modes of covariances that are not separable.
//!
//! `cargo run --release -p asperity-benchmarks --bin time_modes -- 256 [exponential|matern|oblique|measured]`
//!
//! The surface is a square of `points` × `points` with a correlation length of a fifth of the side. On Linux the program also prints the
//! processor time of all threads, which does not depend on other programs, and the largest resident memory.
#![expect(clippy::print_stdout, reason = "prints times")]

use std::error::Error;
use std::time::Instant;

use asperity::correlation::{
    Autocorrelation, CorrelationModel, Covariance, MeasuredCovariance, Rotated, StationaryCovariance,
};
use asperity::map::Grid;
use asperity::random;
use asperity::surface::{KarhunenLoeve, ModesRoute, RandomSurface, SpectralField};

const MODES: usize = 101;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let points: usize = arguments.next().as_deref().unwrap_or("256").parse()?;
    let only = arguments.next();
    let grid = Grid::with_size(points, points, 1.0, 1.0)?;
    let exponential = Covariance::isotropic(CorrelationModel::Exponential, 1.0, 0.2)?;
    let matern = Covariance::isotropic(CorrelationModel::Matern { nu: 1.5 }, 1.0, 0.2)?;
    let long = Covariance::new(CorrelationModel::Matern { nu: 1.5 }, 1.0, 0.3, 0.1)?;
    let oblique = Rotated::new(long, 0.5)?;
    for name in ["exponential", "matern", "oblique", "measured"] {
        if only.as_deref().is_some_and(|only| only != name) {
            continue;
        }
        // The covariance is measured on a map ten lengths wide, twice the width of the square of the modes.
        let measured = if name == "measured" { Some(measured(points, &exponential)?) } else { None };
        let covariance: &dyn StationaryCovariance = match (name, &measured) {
            (_, Some(measured)) => measured,
            ("exponential", _) => &exponential,
            ("matern", _) => &matern,
            _ => &oblique,
        };
        let (start, before) = (Instant::now(), processor_s());
        let surface = KarhunenLoeve::new(covariance, grid, MODES, ModesRoute::General)?;
        let wall_s = start.elapsed().as_secs_f64();
        let start = Instant::now();
        surface.generate(&random::standard_normal(&mut random::stream(1, "time modes", 0), MODES));
        let draw_s = start.elapsed().as_secs_f64();
        println!(
            "{name}: {points} × {points}, {MODES} modes, captured variance {:.6}, wall {wall_s:.2} s, processor {}, one map \
             {draw_s:.3} s, largest memory {}",
            surface.captured_variance(),
            formatted(processor_s().zip(before).map(|(after, before)| after - before), "s"),
            formatted(largest_memory_gb(), "GB"),
        );
    }
    Ok(())
}

fn measured(points: usize, covariance: &Covariance) -> Result<MeasuredCovariance, Box<dyn Error>> {
    let wide = Grid::with_size(points, points, 2.0, 2.0)?;
    let field = SpectralField::periodic(covariance, wide);
    let xi = random::standard_normal(&mut random::stream(2, "time modes", 0), field.xi_len());
    let measured = MeasuredCovariance::new(&Autocorrelation::estimate(&field.generate(&xi))?)?;
    println!("measured: {:?}", measured.report());
    Ok(measured)
}

fn formatted(value: Option<f64>, unit: &str) -> String {
    value.map_or_else(|| "unknown".into(), |value| format!("{value:.2} {unit}"))
}

/// Returns the processor time of all threads so far.
fn processor_s() -> Option<f64> {
    const TICKS_PER_SECOND: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = text.rsplit(')').next()?.split_whitespace().skip(11);
    let ticks: f64 = fields.next()?.parse::<f64>().ok()? + fields.next()?.parse::<f64>().ok()?;
    Some(ticks / TICKS_PER_SECOND)
}

/// Returns the largest resident memory so far.
fn largest_memory_gb() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0 / 1e9)
}
