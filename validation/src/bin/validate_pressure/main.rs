//! Compares the distribution of the random pressure by the default method and by Monte Carlo with references, counts how often the intervals
//! of all methods contain the true value, and prints both as Markdown.
//!
//! `cargo run --release -p asperity-validation --bin validate_pressure -- [REPLICATES [STUDIES]]` prints `docs/validation/pressure.md` and
//! runs two replicates at a time, each on one thread; `just validate` writes the file.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "prints tables, and its progress")]

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
/// Contact solutions of a reference that pools 256 cells of each, and of one that uses a single cell.
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
    /// Numbers of fine solves.
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

/// Errors and computing times of one estimate over the replicates.
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
    /// Numbers of intervals of P(contact) and of the mean that contain the reference, widened by its own error.
    covering: [f64; 2],
}

/// One estimate and its computing time.
struct Timed {
    distribution: DiscreteDistribution,
    contact: Estimated,
    mean: Estimated,
    seconds: f64,
}

/// An estimated value, its standard error, and the middle and half width of its interval.
#[derive(Clone, Copy)]
struct Estimated {
    value: f64,
    se: f64,
    middle: f64,
    half: f64,
}

impl Estimated {
    fn new(value: f64, se: f64, interval: Option<Interval>) -> Self {
        let ends = interval.unwrap_or(Interval { low: f64::NAN, high: f64::NAN });
        Self { value, se, middle: 0.5 * (ends.low + ends.high), half: 0.5 * (ends.high - ends.low) }
    }

    fn covers(&self, truth: f64, its_se: f64) -> bool {
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
        let covers = [
            contact.covers(reference.contact_probability, reference.contact_probability_se),
            mean.covers(reference.mean_pa, reference.mean_se_pa),
        ];
        self.covering.iter_mut().zip(covers).for_each(|(count, covers)| *count += f64::from(u8::from(covers)));
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
            100.0 * self.covering[0] / n,
            (self.mean / n).sqrt(),
            (self.mean_se / n).sqrt(),
            100.0 * self.covering[1] / n,
            self.seconds()
        );
    }
}

fn main() -> Result<()> {
    let number = |place: usize, usual: u64| std::env::args().nth(place).map_or(Ok(usual), |word| word.parse());
    let (replicates, studies) = (number(1, 20)?, number(2, 1000)?);
    println!(
        "# Distribution of the random pressure\n\nThis page compares the default method with Monte Carlo, and counts how often the intervals of all \
         methods contain the true value. `cargo run --release -p asperity-validation --bin validate_pressure` (`just validate`) writes it.\n\n\
         The pressure is that at the centre cell of a Gaussian surface of {POINTS}² points on 1 m with unit variance, on a half-space of \
         E\\* = 1 Pa, under a plane at the mean height. Cases A and C are periodic, without the constant mode, with the mean compliance 1/π m/Pa.\n\n\
         The tables state the mean distances KS and W₁ over {replicates} replicates; the root mean square error of P(contact) and of the mean, with the \
         root mean square of the reported standard errors in brackets; the percentage of 95 % intervals that contain the reference, widened by its own \
         error; and the median computing time in seconds on one thread, with two replicates at work. The references use {POOLED} solutions with 256 cells \
         each, those of free patches {SINGLE} solutions at the cell. A KS distance below the reference's own error, about 0.9/√{SINGLE} = {:.4}, is not \
         significant.",
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
    let reference = sizes.run(&problem, &Silent)?.reference.ok_or("no reference")?.estimate;
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
        "\n| estimate | KS | W₁/sd | P(contact) | coverage | mean, Pa | coverage | s |\n|---|---:|---:|---:|---:|---:|---:|---:|"
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
                contact: Estimated::new(p, p_se, Some(wilson_interval(samples.in_contact(), samples.len()))),
                mean: Estimated::new(mean, mean_se, Some(Interval { low: mean - half, high: mean + half })),
                distribution,
            };
            let start = Instant::now();
            let (found, solves) = study.estimate_default(&problem, &Silent)?;
            let (p, p_se) = (found.contact_probability, found.contact_probability_se);
            let default = Timed {
                seconds: start.elapsed().as_secs_f64(),
                contact: Estimated::new(p, p_se, found.contact_probability_interval),
                mean: Estimated::new(found.mean_pa, found.mean_se_pa, found.mean_interval_pa()),
                distribution: found.distribution,
            };
            let counts = solves.iter().map(|s| format!("{} on {}²", s.solves, s.shape.1)).collect::<Vec<_>>();
            Ok((monte_carlo, default, counts.join(", ")))
        })?;
        let (mut monte_carlo, mut default) = (Errors::default(), Errors::default());
        for (by_monte_carlo, by_default, _) in &found {
            monte_carlo.add(by_monte_carlo, &reference);
            default.add(by_default, &reference);
        }
        let coarse = found.last().map_or("", |(_, _, coarse)| coarse.as_str());
        monte_carlo.row(&format!("Monte Carlo, {fine_solves}"));
        default.row(&format!("default, {fine_solves} ({coarse})"));
        // The variance of Monte Carlo follows from the distribution, not from the few replicates; that of the default is the larger one of the
        // observed and the reported variance.
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
