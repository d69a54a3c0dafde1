//! Statistics of a rough surface, and random surfaces with the same statistics: `cargo run --example surface`.
//!
//! The surface is drawn from a Gaussian field with known statistics, so that each estimate has an exact value beside
//! it. `asperity_formats::read` and `HeightMap::from_scan` read a measured surface instead.

#![expect(clippy::print_stdout, reason = "the numbers are what this example shows")]

use std::error::Error;

use asperity::correlation::{Autocorrelation, Axis, CorrelationModel, Covariance, MeasuredCovariance};
use asperity::map::Grid;
use asperity::random::{standard_normal, stream};
use asperity::surface::{RandomSurface, SpectralField, areal};

fn main() -> Result<(), Box<dyn Error>> {
    // 512 × 512 points, 1 µm apart; rms height 0.8 µm, correlation e^{−r/ℓ} with ℓ = 10 µm.
    let grid = Grid::new(512, 512, 1e-6, 1e-6)?;
    let covariance = Covariance::isotropic(CorrelationModel::Exponential, 0.8e-6, 10e-6)?;
    let field = SpectralField::free(&covariance, grid)?;
    let map = field.generate(&standard_normal(&mut stream(1, "example", 0), field.xi_len()));

    let found = areal::parameters(&map)?;
    let correlation = Autocorrelation::estimate(&map)?;
    let length_m = correlation.correlation_length_m(Axis::X).ok_or("no correlation length")?;
    println!("one map                 estimate     exact");
    println!("rms height Sq           {:.3} µm     0.800 µm", 1e6 * found.sq_m);
    println!(
        "mean height Sa          {:.3} µm     {:.3} µm",
        1e6 * found.sa_m,
        0.8 * (2.0 / std::f64::consts::PI).sqrt()
    );
    println!("skewness Ssk            {:+.2}        0", found.ssk);
    println!("kurtosis Sku            {:.2}         3", found.sku);
    println!("correlation length      {:.1} µm      10.0 µm", 1e6 * length_m);

    // Random surfaces with the measured autocorrelation, without a model.
    let measured = MeasuredCovariance::new(&correlation)?;
    let like = SpectralField::free(&measured, Grid::new(256, 256, 1e-6, 1e-6)?)?;
    println!("\nsurfaces like it        Sq           correlation length");
    for index in 0..4 {
        let map = like.generate(&standard_normal(&mut stream(1, "like it", index), like.xi_len()));
        let length_m = Autocorrelation::estimate(&map)?.correlation_length_m(Axis::X).unwrap_or(f64::NAN);
        println!("{index:<24}{:.3} µm     {:.1} µm", 1e6 * areal::parameters(&map)?.sq_m, 1e6 * length_m);
    }
    Ok(())
}
