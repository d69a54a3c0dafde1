//! The law of the random pressure by the default method and by Monte Carlo, against references of pooled cells, as Markdown.
//!
//! `cargo run --release -p asperity --example validate_pressure -- [REPLICATES]` prints what `docs/validation/pressure.md` holds, on
//! one thread; `just validate` writes it.
#![expect(clippy::print_stdout, reason = "the tables are what this program is for")]

mod coverage;

use std::error::Error;
use std::time::Instant;

use asperity::chaos::StepLaw;
use asperity::chaos::distance::{kolmogorov_smirnov, wasserstein_1};
use asperity::contact::{Boundary, Control, HalfSpace, Solver};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::pressure::{Estimate, PressureError, Problem, Sampling, Study, solve};
use asperity::surface::KarhunenLoeve;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Points along either side of the periodic map of one metre.
const POINTS: usize = 64;
/// Contact solutions of a reference, of which 256 cells each are pooled.
const REFERENCE: usize = 20_000;

struct Case {
    name: &'static str,
    /// Squared exponential of this standard deviation in metre, e^{−r²/2s²}.
    spread_m: f64,
    modes: usize,
    rescaled: bool,
}

const CASES: [Case; 2] = [
    Case { name: "A: s = 5.5 pixels, 101 modes", spread_m: 5.5 / POINTS as f64, modes: 101, rescaled: false },
    Case { name: "C: s = 0.15 m, 8 modes, scaled to unit variance", spread_m: 0.15, modes: 8, rescaled: true },
];

/// Errors of one estimate, and the seconds that it took.
#[derive(Default)]
struct Errors {
    count: f64,
    ks: f64,
    wasserstein: f64,
    probability: f64,
    probability_se: f64,
    mean: f64,
    mean_se: f64,
    seconds: Vec<f64>,
}

impl Errors {
    fn add(
        &mut self,
        law: &StepLaw,
        [p, p_se]: [f64; 2],
        [mean, mean_se]: [f64; 2],
        reference: &Estimate,
        seconds: f64,
    ) {
        self.count += 1.0;
        self.ks += kolmogorov_smirnov(law, &reference.law);
        self.wasserstein += wasserstein_1(law, &reference.law) / reference.law.std();
        self.probability += (p - reference.contact_probability).powi(2);
        self.probability_se += p_se * p_se;
        self.mean += (mean - reference.mean_pa).powi(2);
        self.mean_se += mean_se * mean_se;
        self.seconds.push(seconds);
    }

    fn seconds(&self) -> f64 {
        let mut seconds = self.seconds.clone();
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    }

    fn row(&self, name: &str) {
        let n = self.count;
        println!(
            "| {name} | {:.4} | {:.4} | {:.4} ({:.4}) | {:.4} ({:.4}) | {:.2} |",
            self.ks / n,
            self.wasserstein / n,
            (self.probability / n).sqrt(),
            (self.probability_se / n).sqrt(),
            (self.mean / n).sqrt(),
            (self.mean_se / n).sqrt(),
            self.seconds()
        );
    }
}

fn main() -> Result<()> {
    if std::env::args().nth(1).as_deref() == Some("coverage") {
        return coverage::print(std::env::args().nth(2).map_or(Ok(1000), |word| word.parse())?);
    }
    let replicates: u64 = std::env::args().nth(1).map_or(Ok(20), |word| word.parse())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    println!(
        "# The law of the random pressure\n\nThe pressure at the centre cell of a periodic Gaussian surface of {POINTS}² points on 1 m with unit variance, \
         without the constant mode, on a half-space of E\\* = 1 Pa and mean compliance 1/π m/Pa, under a plane at the mean height. \
         Written by `cargo run --release -p asperity --example validate_pressure` (`just validate`). Means over {replicates} replicates; root mean square \
         errors of P(contact) and of the mean with the root mean square of the standard errors that were told; median seconds on one \
         thread. References: {REFERENCE} solutions with 256 cells each."
    );
    for case in &CASES {
        let grid = Grid::covering(POINTS, POINTS, 1.0, 1.0)?;
        let length_m = case.spread_m * std::f64::consts::SQRT_2;
        let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, length_m)?;
        let surface = KarhunenLoeve::periodic_without_constant(&covariance, grid, case.modes)?;
        let surface = if case.rescaled { surface.rescaled() } else { surface };
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: std::f64::consts::FRAC_1_PI };
        let half_space = HalfSpace::new(grid, 1.0, boundary)?;
        let solver = Solver { tolerance: 1e-6, ..Solver::default() };
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None)?.with_solver(solver);
        let sizes = Study { fine_solves: 20, reference_samples: REFERENCE, ..Study::new(1) };
        let reference = sizes.run(&problem, &Silent)?.reference.estimate;
        println!(
            "\n## Case {}\n\nP(contact) {:.5} ± {:.5}, mean {:.4} ± {:.4} Pa, standard deviation {:.4} Pa.\n",
            case.name,
            reference.contact_probability,
            reference.contact_probability_se,
            reference.mean_pa,
            reference.mean_se_pa,
            reference.law.std()
        );
        println!("| estimate | KS | W₁/sd | P(contact) | mean, Pa | s |\n|---|---:|---:|---:|---:|---:|");
        for fine_solves in [500, 2000] {
            let (mut monte_carlo, mut default) = (Errors::default(), Errors::default());
            let mut coarse = String::new();
            for seed in 0..replicates {
                let study = Study { fine_solves, ..Study::new(seed) };
                pool.install(|| -> std::result::Result<(), PressureError> {
                    let start = Instant::now();
                    let sampling = Sampling::monte_carlo(seed, "validation", fine_solves, study.valid_share);
                    let samples = solve(&problem, sampling, &Silent)?;
                    let (law, n) = (samples.law()?, samples.len() as f64);
                    let p = samples.contact_probability();
                    let seconds = start.elapsed().as_secs_f64();
                    let [p_se, mean_se] = [(p * (1.0 - p) / n).sqrt(), law.std() / n.sqrt()];
                    monte_carlo.add(&law, [p, p_se], [law.mean(), mean_se], &reference, seconds);
                    let start = Instant::now();
                    let (found, solves) = study.law(&problem, &Silent)?;
                    let seconds = start.elapsed().as_secs_f64();
                    let p = [found.contact_probability, found.contact_probability_se];
                    default.add(&found.law, p, [found.mean_pa, found.mean_se_pa], &reference, seconds);
                    let told = solves.iter().map(|s| format!("{} on {}²", s.solves, s.shape.1));
                    coarse = told.collect::<Vec<_>>().join(", ");
                    Ok(())
                })?;
            }
            monte_carlo.row(&format!("Monte Carlo, {fine_solves}"));
            default.row(&format!("default, {fine_solves} ({coarse})"));
            // Monte Carlo's variance at the default's seconds, from its law and not from the few replicates.
            let time = default.seconds() / monte_carlo.seconds();
            let p = reference.contact_probability;
            let n = fine_solves as f64 * time;
            println!(
                "| *Monte Carlo at the default's time: mean square error* | | | *× {:.1}* | *× {:.0}* | |",
                p * (1.0 - p) / n / (default.probability / default.count),
                reference.law.std().powi(2) / n / (default.mean / default.count)
            );
        }
    }
    Ok(())
}
