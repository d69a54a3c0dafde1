//! Probability of vibration against the number of independent windows that share the load.
//!
//! The friction of n independent windows at one pressure has the mean of one window and its variance over n. One window is the
//! paper's reading of a contact; a nominal area has the variance and the correlation of its own windows, which may be dependent.
//!
//! A rough slider carries its windows along. A part with n windows has their mean friction, so the variance between parts falls like the
//! variance along a path: by 1/n. All windows of a part have the statistics of its surface in common, so differences between scans do not
//! depend on n.
//!
//! The rows have fewer machines than the verdict, whose answers are their control variate (`changed`).
//! The row that is the verdict itself has its probability.

use super::machines::{Machine, Machines};
use super::probability::Probability;
use super::sampled::{Evaluate, Sampled};
use super::sharing::Sharing;
use super::{changed, number};
use crate::monitor::{Cancelled, Monitor};
use crate::study::Table;
use crate::study::result::AreaAsOne;

/// Numbers of windows.
pub(super) const ROWS: usize = 5;
/// Machines of each number of windows if friction fluctuates, and the number of them after which sampling ends if all have the same
/// answer.
pub(super) const FLUCTUATING: usize = 128;
const FIRST: usize = 64;
/// Machines of each number of windows if friction does not fluctuate.
pub(super) const CONSTANT: usize = 1024;

/// Name of the table.
const TABLE: &str = "verdict_area";

/// Computes the probabilities for numbers of windows from 1 to all of the nominal area; `None` if the area of one window is unknown or
/// the nominal area has fewer than two of them. All numbers of windows share machines and realisations of friction. `verdict` is the
/// probability of the study itself, and `fluctuates` states whether the friction of one window does.
pub(super) fn area_as_one(
    machines: &Machines<'_>,
    nominal: &Machine,
    sampled: &Sampled,
    verdict: &Probability,
    evaluate: &Evaluate<'_>,
    fluctuates: bool,
    monitor: &dyn Monitor,
) -> Result<Option<Vec<AreaAsOne>>, Cancelled> {
    let Some(window_m2) = nominal.window.area_m2 else { return Ok(None) };
    let all = nominal.inputs.nominal_contact().area_m2 / window_m2;
    if all < 2.0 {
        return Ok(None);
    }
    let numbers_of_machines = if fluctuates { [FIRST, FLUCTUATING] } else { [CONSTANT; 2] };
    let rows = numbers(all).into_iter().map(|windows| {
        let sharing = if windows < all { Sharing::Windows(windows) } else { Sharing::Area };
        let (probability, interval) = if sharing.is_the_studys(nominal.inputs.upscaling) {
            (verdict.value, verdict.interval)
        } else {
            let shared = machines.with_sharing(sharing);
            let pairs = changed::pairs(&shared, sampled, numbers_of_machines, evaluate, monitor)?;
            changed::controlled(&pairs, |machine| number(machine.vibrates), verdict, machines.variables() == 0)
        };
        Ok(AreaAsOne {
            windows,
            friction_std: sharing.friction_std(&nominal.window),
            probability,
            probability_interval: [interval.low, interval.high],
        })
    });
    let rows = rows.collect::<Result<Vec<_>, Cancelled>>()?;
    Ok(Some(rows.into_iter().filter(|row| row.probability.is_finite()).collect()))
}

/// Returns whole numbers of windows at equal ratios, below the last.
fn numbers(all: f64) -> Vec<f64> {
    let mut numbers: Vec<f64> = (0..ROWS - 1).map(|k| all.powf(k as f64 / (ROWS - 1) as f64).round()).collect();
    numbers.retain(|windows| *windows < all);
    numbers.dedup();
    numbers.push(all);
    numbers
}

/// Returns the table of the probabilities.
pub(super) fn table(rows: &[AreaAsOne]) -> (&'static str, Table) {
    (TABLE, Table::of(rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chaos::UncertainInput;
    use crate::distribution::{Marginal, standard_normal_cdf};
    use crate::friction::{StatedFriction, Upscaling, WindowFriction};
    use crate::monitor::Silent;
    use crate::study::Study;
    use crate::study::verdict::machines::between_parts;
    use crate::study::verdict::sampled::Evaluated;

    #[test]
    fn numbers_of_windows_rise_by_equal_ratios_from_one_to_all() {
        let found = numbers(18_511.1);
        assert_eq!((found.len(), found[0], found[ROWS - 1]), (ROWS, 1.0, 18_511.1));
        for pair in found[1..].windows(2) {
            assert!((pair[1] / pair[0] / 18_511.1_f64.powf(1.0 / 4.0) - 1.0).abs() < 0.05, "{found:?}");
        }
        assert_eq!(numbers(3.2), [1.0, 2.0, 3.2]);
    }

    /// A machine that vibrates if μ > 0.2 (closed form of its limit of the damping ratio).
    const STUDY: &str = "seed = 1\n[surface]\nrms_height = \"1 um\"\ncorrelation_length = \"20 um\"\ncovariance = \"exponential\"\n\
                         marginal = \"normal\"\nbody = \"slider\"\n[material]\nyoungs_modulus = \"210 GPa\"\n\
                         shear_strength = \"385 MPa\"\n[friction]\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\n\
                         damping_ratio = 0.2229535019025\nnormal_force = \"2.5 kN\"\nnominal_area = \"64 mm^2\"\n\
                         dimensionless_belt_velocity = 0.1\nstribeck = 4.2\n";

    #[test]
    fn parts_of_a_rough_slider_differ_less_the_more_windows_share_the_load() {
        const MACHINES: usize = 1024;
        let (mean, std, area_reduction) = (0.19, 0.038, 1.0 / 16.0);
        let stated =
            StatedFriction { mean, std: 0.0, length_m: 1e-3, marginal: Marginal::STANDARD_NORMAL, window_m: [1e-3; 2] };
        let window = WindowFriction {
            between_parts_std: std,
            variance_reduction: area_reduction,
            computed: true,
            ..WindowFriction::from_statement(stated, 64e-6, Some(4.2))
        };
        let evaluate = |machine: &Machine, _: usize| Evaluated::constant_friction(machine);
        let rows = [Upscaling::Paper, Upscaling::Area].map(|upscaling| {
            let text = format!("{STUDY}upscaling = \"{upscaling}\"\n");
            let study = Study::parse(&text, "study.toml").unwrap().verdict.unwrap();
            let parts: Vec<(_, UncertainInput)> = between_parts(&window).unwrap().into_iter().collect();
            let study = study.with_latent(parts);
            let machines = Machines::new(&study, &window, None, 1);
            let nominal = machines.nominal().unwrap();
            let sampled = Sampled::until(&machines, &evaluate, 0.02, MACHINES, &Silent).unwrap();
            let verdict = verdict_of(&sampled);
            let rows =
                area_as_one(&machines, &nominal, &sampled, &verdict, &evaluate, false, &Silent).unwrap().unwrap();
            let own = if upscaling == Upscaling::Paper { 0 } else { rows.len() - 1 };
            assert_eq!(rows[own].probability, verdict.value, "the verdict of the study itself");
            assert_eq!(rows[own].probability_interval, [verdict.interval.low, verdict.interval.high]);
            rows
        });
        let probabilities = rows.each_ref().map(|rows| rows.iter().map(|row| row.probability).collect::<Vec<_>>());
        let is_equal = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
        assert!(probabilities[0].iter().zip(&probabilities[1]).all(is_equal), "{probabilities:?}");
        let study = Study::parse(STUDY, "study.toml").unwrap().verdict.unwrap();
        // The nominal area of 64 mm² has fewer than two windows of 40 mm².
        let large = WindowFriction { area_m2: Some(40e-6), ..window.clone() };
        let machines = Machines::new(&study, &large, None, 1);
        let (nominal, sampled) = (machines.nominal().unwrap(), Sampled::default());
        let verdict = verdict_of(&sampled);
        assert_eq!(area_as_one(&machines, &nominal, &sampled, &verdict, &evaluate, false, &Silent), Ok(None));
        let (name, columns) = table(&rows[0]);
        assert_eq!(name, "verdict_area");
        assert_eq!(columns.column("probability"), Some(&probabilities[0][..]));
        for row in &rows[0] {
            let reduction = if row.windows < 64.0 { 1.0 / row.windows } else { area_reduction };
            assert!((row.friction_std / (std * reduction.sqrt()) - 1.0).abs() < 1e-12, "{row:?}");
            // A lognormal factor of mean 1 with the variance of one window over n. Each of eight replicates has one machine in each
            // 1/128 of its probability: the error of the mean is less than a third of a machine of a replicate.
            let log_std = ((std / mean).powi(2) * reduction).ln_1p().sqrt();
            let wanted = standard_normal_cdf(-((0.2_f64 / mean).ln() + 0.5 * log_std * log_std) / log_std);
            assert!((row.probability - wanted).abs() <= 4.0 / MACHINES as f64, "{row:?}, not {wanted}");
            let [low, high] = row.probability_interval;
            assert!(low <= wanted && wanted <= high && high - low < 16.0 / MACHINES as f64, "{row:?}, not {wanted}");
        }
    }

    fn verdict_of(sampled: &Sampled) -> Probability {
        let found = sampled.probability();
        Probability { value: found.value, interval: found.interval(), sources: Vec::new() }
    }
}
