//! Distribution of the random pressure of a small patch: `cargo run --example pressure`.
//!
//! The pressure at the centre cell of a periodic Gaussian surface under a plane at its mean height: 64 × 64 points on 1
//! m, 8 modes scaled to unit variance, contact modulus 1 Pa (case C of `docs/pressure.md`, which gives the known
//! values).

#![expect(clippy::print_stdout, reason = "the numbers are what this example shows")]

use std::error::Error;

use asperity::contact::{Boundary, Control, HalfSpace};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::pressure::{MethodComparison, Problem, Sampling, solve};
use asperity::surface::KarhunenLoeve;

fn main() -> Result<(), Box<dyn Error>> {
    let grid = Grid::with_size(64, 64, 1.0, 1.0)?;
    let length_m = 0.15 * std::f64::consts::SQRT_2;
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, length_m)?;
    let surface = KarhunenLoeve::periodic_without_constant(&covariance, grid, 8)?.rescaled();
    let boundary = Boundary::Periodic { mean_compliance_m_per_pa: std::f64::consts::FRAC_1_PI };
    let half_space = HalfSpace::new(grid, 1.0, boundary)?;
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None)?;

    // 200 contact solutions: first plain Monte Carlo, then the same number with coarser grids as predictors.
    let samples = solve(&problem, Sampling::monte_carlo(1, "example", 200, 0.95), &Silent)?;
    let (multilevel, _) =
        MethodComparison { fine_solves: 200, ..MethodComparison::new(1) }.estimate_default(&problem, &Silent)?;
    let (share, n) = (samples.contact_probability(), samples.len() as f64);
    let counted = samples.distribution()?;
    println!("200 contact solutions   P(contact)         mean pressure");
    println!(
        "Monte Carlo             {share:.3} ± {:.3}      {:.3} ± {:.3} Pa",
        (share * (1.0 - share) / n).sqrt(),
        counted.mean(),
        counted.std() / n.sqrt()
    );
    println!(
        "multilevel (default)    {:.3} ± {:.3}      {:.3} ± {:.3} Pa",
        multilevel.contact_probability, multilevel.contact_probability_se, multilevel.mean_pa, multilevel.mean_se_pa
    );
    println!("known                   0.357              1.351 Pa");
    for probability in [0.5, 0.9] {
        let interval = multilevel.quantile_interval_pa(probability).ok_or("no interval")?;
        let value = multilevel.distribution.quantile(probability);
        println!("{:.0} % quantile: {value:.2} Pa [{:.2}, {:.2}]", 100.0 * probability, interval.low, interval.high);
    }
    Ok(())
}
