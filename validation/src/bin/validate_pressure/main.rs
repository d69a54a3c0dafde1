//! The law of the random pressure by the default method and by Monte Carlo, against references, and how often intervals of all
//! methods hold the truth, as Markdown.
//!
//! `cargo run --release -p asperity-validation --bin validate_pressure -- [REPLICATES [STUDIES]]` prints what
//! `docs/validation/pressure.md` holds, two replicates at a time on a thread each; `just validate` writes it.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "the tables are what this program is for, with progress beside"
)]

mod coverage;
mod parallel;

use std::error::Error;
use std::time::Instant;

use asperity::chaos::DiscreteDistribution;
use asperity::chaos::distance::{kolmogorov_smirnov, wasserstein_1};
use asperity::contact::{Boundary, Control, HalfSpace, Solver};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::pressure::{MethodComparison, PressureEstimate, Problem, Sampling, solve};
use asperity::stats::{Interval, NORMAL_95, wilson_interval};
use asperity::surface::{KarhunenLoeve, ModesRoute};

use crate::parallel::each;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Points along either side of the periodic map of one metre.
const POINTS: usize = 64;
/// Contact solutions of a reference: of which 256 cells each are pooled, and of which the cell alone counts.
const POOLED: usize = 20_000;
const SINGLE: usize = 40_000;

struct Case {
    name: &'static str,
    /// Squared exponential of this standard deviation in metre, e^{−r²/2s²}.
    spread_m: f64,
    modes: usize,
    rescaled: bool,
    free: bool,
    hardness_pa: Option<f64>,
    /// Fine solves that are compared.
    sizes: &'static [usize],
}

const CASES: [Case; 4] = [
    Case {
        name: "A: s = 5.5 pixels, 101 modes",
        spread_m: 5.5 / POINTS as f64,
        modes: 101,
        rescaled: false,
        free: false,
        hardness_pa: None,
        sizes: &[500, 2000],
    },
    Case {
        name: "C: s = 0.15 m, 8 modes, scaled to unit variance",
        spread_m: 0.15,
        modes: 8,
        rescaled: true,
        free: false,
        hardness_pa: None,
        sizes: &[500, 2000],
    },
    Case {
        name: "F: free patch, ℓ = s√2 = 0.1 m, 101 modes",
        spread_m: 0.1 * std::f64::consts::FRAC_1_SQRT_2,
        modes: 101,
        rescaled: false,
        free: true,
        hardness_pa: None,
        sizes: &[500],
    },
    Case {
        name: "H: case F with the hardness 12 Pa",
        spread_m: 0.1 * std::f64::consts::FRAC_1_SQRT_2,
        modes: 101,
        rescaled: false,
        free: true,
        hardness_pa: Some(12.0),
        sizes: &[500],
    },
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
    /// Intervals of P(contact) and of the mean that hold the reference, its own error added.
    held: [f64; 2],
}

/// One estimate and the seconds that it took.
struct Timed {
    distribution: DiscreteDistribution,
    contact: Known,
    mean: Known,
    seconds: f64,
}

/// A value, its standard error, and the half width of its interval about the middle.
#[derive(Clone, Copy)]
struct Known {
    value: f64,
    se: f64,
    middle: f64,
    half: f64,
}

impl Known {
    fn new(value: f64, se: f64, interval: Option<Interval>) -> Self {
        let ends = interval.unwrap_or(Interval { low: f64::NAN, high: f64::NAN });
        Self { value, se, middle: 0.5 * (ends.low + ends.high), half: 0.5 * (ends.high - ends.low) }
    }

    fn holds(&self, truth: f64, its_se: f64) -> bool {
        (self.middle - truth).abs() <= self.half.hypot(NORMAL_95 * its_se)
    }
}

impl Errors {
    fn add(&mut self, found: &Timed, reference: &PressureEstimate) {
        let Timed { distribution, contact, mean, seconds } = found;
        self.count += 1.0;
        self.ks += kolmogorov_smirnov(distribution, &reference.distribution);
        self.wasserstein += wasserstein_1(distribution, &reference.distribution) / reference.distribution.std();
        self.probability += (contact.value - reference.contact_probability).powi(2);
        self.probability_se += contact.se.powi(2);
        self.mean += (mean.value - reference.mean_pa).powi(2);
        self.mean_se += mean.se.powi(2);
        let holds = [
            contact.holds(reference.contact_probability, reference.contact_probability_se),
            mean.holds(reference.mean_pa, reference.mean_se_pa),
        ];
        self.held.iter_mut().zip(holds).for_each(|(held, holds)| *held += f64::from(u8::from(holds)));
        self.seconds.push(*seconds);
    }

    fn seconds(&self) -> f64 {
        let mut seconds = self.seconds.clone();
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    }

    fn row(&self, name: &str) {
        let n = self.count;
        println!(
            "| {name} | {:.4} | {:.4} | {:.4} ({:.4}) | {:.0} % | {:.4} ({:.4}) | {:.0} % | {:.2} |",
            self.ks / n,
            self.wasserstein / n,
            (self.probability / n).sqrt(),
            (self.probability_se / n).sqrt(),
            100.0 * self.held[0] / n,
            (self.mean / n).sqrt(),
            (self.mean_se / n).sqrt(),
            100.0 * self.held[1] / n,
            self.seconds()
        );
    }
}

fn main() -> Result<()> {
    let number = |place: usize, usual: u64| std::env::args().nth(place).map_or(Ok(usual), |word| word.parse());
    let (replicates, studies) = (number(1, 20)?, number(2, 1000)?);
    println!(
        "# The law of the random pressure\n\nThe pressure at the centre cell of a Gaussian surface of {POINTS}² points on 1 m with unit variance, on a half-space of \
         E\\* = 1 Pa, under a plane at the mean height; in cases A and C periodic, without the constant mode, with the mean compliance 1/π m/Pa. \
         Written by `cargo run --release -p asperity-validation --bin validate_pressure` (`just validate`). Means over {replicates} replicates; root mean square \
         errors of P(contact) and of the mean with the root mean square of the standard errors that were told, and the share of 95 % intervals \
         that hold the reference, whose own error is added; median seconds on one thread, two at work. References: {POOLED} solutions with \
         256 cells each, of the free patches {SINGLE} solutions at the cell; KS below their own error, about .9/√{SINGLE} = {:.4}, says nothing.",
        0.87 / (SINGLE as f64).sqrt()
    );
    for case in &CASES {
        compare(case, replicates)?;
    }
    coverage::print(studies)
}

fn compare(case: &Case, replicates: u64) -> Result<()> {
    let grid = Grid::with_size(POINTS, POINTS, 1.0, 1.0)?;
    let length_m = case.spread_m * std::f64::consts::SQRT_2;
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, length_m)?;
    let surface = if case.free {
        KarhunenLoeve::new(&covariance, grid, case.modes, ModesRoute::Separable)?
    } else {
        KarhunenLoeve::periodic_without_constant(&covariance, grid, case.modes)?
    };
    let surface = if case.rescaled { surface.rescaled() } else { surface };
    let periodic = Boundary::Periodic { mean_compliance_m_per_pa: std::f64::consts::FRAC_1_PI };
    let half_space = HalfSpace::new(grid, 1.0, if case.free { Boundary::Free } else { periodic })?;
    let solver = Solver { tolerance: 1e-6, ..Solver::default() };
    let control = Control::Plane { height_m: 0.0 };
    let problem = Problem::new(&surface, &half_space, control, case.hardness_pa)?.with_solver(solver);
    let sizes = MethodComparison {
        fine_solves: 20,
        reference_samples: if case.free { SINGLE } else { POOLED },
        ..MethodComparison::new(1)
    };
    let start = Instant::now();
    let reference = sizes.run(&problem, &Silent)?.reference.estimate;
    eprintln!("{}: reference in {:.0} s", case.name, start.elapsed().as_secs_f64());
    println!(
        "\n## Case {}\n\nP(contact) {:.5} ± {:.5}, mean {:.4} ± {:.4} Pa, standard deviation {:.4} Pa.",
        case.name,
        reference.contact_probability,
        reference.contact_probability_se,
        reference.mean_pa,
        reference.mean_se_pa,
        reference.distribution.std()
    );
    if let Some(hardness_pa) = case.hardness_pa {
        let plastic = (1.0 - reference.distribution.cdf_left(hardness_pa)) / reference.contact_probability;
        println!("Of the contacts {:.1} % are plastic.", 100.0 * plastic);
    }
    println!(
        "\n| estimate | KS | W₁/sd | P(contact) | held | mean, Pa | held | s |\n|---|---:|---:|---:|---:|---:|---:|---:|"
    );
    for fine_solves in case.sizes.iter().copied() {
        let found = each(replicates, &format!("{}, {fine_solves}", case.name), |seed| {
            let study = MethodComparison { fine_solves, ..MethodComparison::new(seed) };
            let start = Instant::now();
            let sampling = Sampling::monte_carlo(seed, "validation", fine_solves, study.valid_fraction);
            let samples = solve(&problem, sampling, &Silent)?;
            let (distribution, n) = (samples.distribution()?, samples.len() as f64);
            let (p, mean) = (samples.contact_probability(), distribution.mean());
            let [p_se, mean_se] = [(p * (1.0 - p) / n).sqrt(), distribution.std() / n.sqrt()];
            let half = NORMAL_95 * mean_se;
            let monte_carlo = Timed {
                seconds: start.elapsed().as_secs_f64(),
                contact: Known::new(p, p_se, Some(wilson_interval(samples.in_contact(), samples.len()))),
                mean: Known::new(mean, mean_se, Some(Interval { low: mean - half, high: mean + half })),
                distribution,
            };
            let start = Instant::now();
            let (found, solves) = study.estimate_default(&problem, &Silent)?;
            let (p, p_se) = (found.contact_probability, found.contact_probability_se);
            let default = Timed {
                seconds: start.elapsed().as_secs_f64(),
                contact: Known::new(p, p_se, found.contact_probability_interval),
                mean: Known::new(found.mean_pa, found.mean_se_pa, found.mean_interval_pa()),
                distribution: found.distribution,
            };
            let told = solves.iter().map(|s| format!("{} on {}²", s.solves, s.shape.1)).collect::<Vec<_>>();
            Ok((monte_carlo, default, told.join(", ")))
        })?;
        let (mut monte_carlo, mut default) = (Errors::default(), Errors::default());
        for (by_monte_carlo, by_default, _) in &found {
            monte_carlo.add(by_monte_carlo, &reference);
            default.add(by_default, &reference);
        }
        let coarse = found.last().map_or("", |(_, _, coarse)| coarse.as_str());
        monte_carlo.row(&format!("Monte Carlo, {fine_solves}"));
        default.row(&format!("default, {fine_solves} ({coarse})"));
        // Monte Carlo's variance at the default's seconds, from its distribution rather than the few replicates, over the default's: the larger
        // one of that found and that told.
        let time = default.seconds() / monte_carlo.seconds();
        let p = reference.contact_probability;
        let n = fine_solves as f64 * time;
        println!(
            "| *Monte Carlo at the default's time: mean square error* | | | *× {:.1}* | | *× {:.0}* | | |",
            p * (1.0 - p) / n / (default.probability.max(default.probability_se) / default.count),
            reference.distribution.std().powi(2) / n / (default.mean.max(default.mean_se) / default.count)
        );
    }
    Ok(())
}
