//! Coverage of the 95 % intervals of all methods, on small patches that are solved a hundred thousand times.

use asperity::contact::{Boundary, Control, HalfSpace};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::pressure::{MethodComparison, PressureEstimate, Problem};
use asperity::surface::KarhunenLoeve;
use asperity_validation::methods::{estimates, names};

use crate::Result;
use crate::parallel::each;

/// Points along either side.
const POINTS: usize = 16;
/// Contact solutions for the true values; 256 cells of each are pooled.
const TRUTH: usize = 60_000;
/// Number of intervals of an estimate: P(contact), mean, quantiles of 10, 50 and 90 %, and the simultaneous band.
const INTERVALS: usize = 6;
const QUANTILES: [f64; 3] = [0.1, 0.5, 0.9];

/// A small patch.
struct World {
    name: &'static str,
    plane_m: f64,
    hardness_pa: Option<f64>,
    fine_solves: usize,
}

const WORLDS: [World; 2] = [
    World { name: "elastic", plane_m: -0.6, hardness_pa: None, fine_solves: 200 },
    World { name: "elasto-plastic", plane_m: -2.0, hardness_pa: Some(12.0), fine_solves: 300 },
];

/// Counts of one method over the replicates.
#[derive(Debug, Clone, Default)]
struct Count {
    estimates: u32,
    /// Numbers of reported intervals, and of those that contain the true value.
    reported: [u32; INTERVALS],
    covering: [u32; INTERVALS],
    /// Sums of the errors of P(contact) and mean, of their squares, and of the widths of the intervals.
    errors: [f64; 2],
    squares: [f64; 2],
    widths: [f64; 2],
}

impl Count {
    fn add(&mut self, found: &PressureEstimate, truth: &PressureEstimate) {
        self.estimates += 1;
        let mut count = |place: usize, covers: Option<bool>| {
            self.reported[place] += u32::from(covers.is_some());
            self.covering[place] += u32::from(covers == Some(true));
        };
        let (contact, mean) = (found.contact_probability_interval, found.mean_interval_pa());
        count(0, contact.map(|interval| interval.contains(truth.contact_probability)));
        count(1, mean.map(|interval| interval.contains(truth.mean_pa)));
        for (place, probability) in QUANTILES.into_iter().enumerate() {
            let wanted = truth.distribution.quantile(probability);
            count(2 + place, found.quantile_interval_pa(probability).map(|interval| interval.contains(wanted)));
        }
        let covers = |band: &asperity::pressure::Band| {
            band.values.iter().enumerate().all(|(i, value)| {
                let ([low, high], cdf) = (band.simultaneous(i), truth.distribution.cdf(*value));
                low <= cdf && cdf <= high
            })
        };
        count(5, found.band.as_ref().map(covers));
        let errors = [found.contact_probability - truth.contact_probability, found.mean_pa - truth.mean_pa];
        for (k, interval) in [contact, mean].into_iter().enumerate() {
            self.errors[k] += errors[k];
            self.squares[k] += errors[k].powi(2);
            self.widths[k] += interval.map_or(f64::NAN, |interval| interval.high - interval.low);
        }
    }

    fn row(&self, name: &str) {
        let percentage = |k: usize| match self.reported[k] {
            0 => "–".to_owned(),
            reported => format!("{:.1}", 100.0 * f64::from(self.covering[k]) / f64::from(reported)),
        };
        let n = f64::from(self.estimates.max(1));
        let errors = |k: usize| {
            let [bias, error, half] = [self.errors[k] / n, (self.squares[k] / n).sqrt(), 0.5 * self.widths[k] / n];
            format!("{bias:+.4} | {error:.4} | {half:.4}")
        };
        let percentages: Vec<String> = (0..INTERVALS).map(percentage).collect();
        println!("| `{name}` | {} | {} | {} |", percentages.join(" | "), errors(0), errors(1));
    }
}

/// Prints a table for each world.
pub(crate) fn print(replicates: u64) -> Result<()> {
    println!(
        "\n## Intervals\n\nPercentage of 95 % intervals that contain the true value, over {replicates} studies of a small patch: {POINTS}² points \
         on 1 m, the surface and the half-space of case C. The standard error of a percentage is √(.95 · .05/{replicates}) = {:.1} %. The true value is estimated by \
         {TRUTH} solutions with 256 cells each. The other columns state the bias of P(contact) and of the mean in pascal, their root \
         mean square errors, and the mean half widths of their intervals. Expansions have 3 variables, degree 2, and 2,000 fresh samples.",
        (95.0 * 5.0 / replicates as f64).sqrt()
    );
    for world in &WORLDS {
        let grid = Grid::with_size(POINTS, POINTS, 1.0, 1.0)?;
        let length_m = 0.15 * std::f64::consts::SQRT_2;
        let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, length_m)?;
        let surface = KarhunenLoeve::periodic_without_constant(&covariance, grid, 8)?.rescaled();
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: std::f64::consts::FRAC_1_PI };
        let half_space = HalfSpace::new(grid, 1.0, boundary)?;
        let control = Control::Plane { height_m: world.plane_m };
        let problem = Problem::new(&surface, &half_space, control, world.hardness_pa)?;
        let sizes = MethodComparison { fine_solves: 20, reference_samples: TRUTH, ..MethodComparison::new(1) };
        let truth = sizes.run(&problem, &Silent)?.reference.ok_or("no reference")?.estimate;
        let capped = world.hardness_pa.map_or_else(String::new, |hardness_pa| {
            let plastic = 1.0 - truth.distribution.cdf_left(hardness_pa);
            format!(", hardness {hardness_pa} Pa, which {:.1} % of the pressures reach", 100.0 * plastic)
        });
        let quantiles: Vec<String> = QUANTILES.map(|p| format!("{:.3}", truth.distribution.quantile(p))).into();
        println!(
            "\n### Small patch, {}: {} fine solves\n\nPlane at {} m{capped}: P(contact) {:.4}, mean {:.4} Pa, quantiles {} Pa. Every interval of a quantile at a \
             point mass contains it.\n",
            world.name,
            world.fine_solves,
            world.plane_m,
            truth.contact_probability,
            truth.mean_pa,
            quantiles.join(", ")
        );
        let found = each(replicates, world.name, |seed| {
            let sizes = MethodComparison {
                fine_solves: world.fine_solves,
                reference_samples: 2,
                ..MethodComparison::new(seed)
            };
            let study = MethodComparison { variables: 3, degree: 2, surrogate_samples: 2000, ..sizes };
            let outcomes = estimates(&study, &problem, &Silent)?;
            let mut counts = vec![Count::default(); outcomes.len()];
            for (count, outcome) in counts.iter_mut().zip(&outcomes) {
                if let Ok(estimate) = outcome {
                    count.add(estimate, &truth);
                }
            }
            Ok(counts)
        })?;
        println!(
            "| method | P(contact) | mean | 10 % | 50 % | 90 % | band | P: bias | error | half width | mean: bias | error | half width \
             |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
        );
        for (k, name) in names().into_iter().enumerate() {
            let mut all = Count::default();
            found.iter().for_each(|counts| all.merge(&counts[k]));
            all.row(name);
        }
    }
    Ok(())
}

impl Count {
    fn merge(&mut self, other: &Self) {
        self.estimates += other.estimates;
        for k in 0..INTERVALS {
            self.reported[k] += other.reported[k];
            self.covering[k] += other.covering[k];
        }
        for k in 0..2 {
            self.errors[k] += other.errors[k];
            self.squares[k] += other.squares[k];
            self.widths[k] += other.widths[k];
        }
    }
}
