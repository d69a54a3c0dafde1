//! Probability of vibration against the number of independent windows that share the load.
//!
//! The friction of n independent windows at one pressure has the mean of one window and its variance over n. One window is the
//! paper's reading of a contact; a nominal area has the variance and the correlation of its own windows, which may be dependent.

use asperity_base::blocks::{self, Task};

use super::machines::{Machine, Machines};
use super::remedies::Evaluate;
use super::sampled::Sampled;
use crate::friction::{Upscaling, WindowFriction};
use crate::monitor::{Cancelled, Monitor};
use crate::stats::wilson_interval;
use crate::study::CsvTable;
use crate::study::result::AreaAsOne;

/// Numbers of windows.
pub(in crate::study) const ROWS: usize = 8;
/// Machines of each number of windows, and the number of them after which sampling ends if all have the same answer.
pub(in crate::study) const MOST: usize = 256;
const FIRST: usize = 64;

/// Name of the table.
const TABLE: &str = "verdict_area";

/// Relation of the variance of friction to that of one window.
#[derive(Clone, Copy)]
enum Sharing {
    /// That many independent windows.
    Windows(f64),
    /// The windows of the nominal area.
    Area,
}

impl Sharing {
    /// Returns the friction of one window whose nominal area has this variance.
    fn of(self, window: &WindowFriction) -> WindowFriction {
        let variance_reduction = match self {
            Self::Windows(windows) => 1.0 / windows,
            Self::Area => window.variance_reduction,
        };
        WindowFriction { variance_reduction, ..window.clone() }
    }

    /// Returns a machine whose friction averages in this way.
    fn machine(self, machine: &Machine) -> Machine {
        let mut shared = machine.clone();
        shared.study.upscaling = Upscaling::Area;
        shared.window = self.of(&machine.window);
        shared
    }

    /// Returns whether the verdict itself averages in this way.
    fn is_the_studys(self, upscaling: Upscaling) -> bool {
        match self {
            Self::Windows(windows) => upscaling == Upscaling::Paper && windows == 1.0,
            Self::Area => upscaling == Upscaling::Area,
        }
    }
}

/// Computes the probabilities for numbers of windows from 1 to all of the nominal area; `None` if the area of one window is unknown or
/// the nominal area has fewer than two of them. All numbers of windows share machines and realisations of friction.
pub(super) fn area_as_one(
    machines: &Machines<'_>,
    nominal: &Machine,
    sampled: &Sampled,
    evaluate: &Evaluate<'_>,
    monitor: &dyn Monitor,
) -> Result<Option<Vec<AreaAsOne>>, Cancelled> {
    let Some(window_m2) = nominal.window.area_m2 else { return Ok(None) };
    let all = nominal.study.nominal_contact().area_m2 / window_m2;
    if all < 2.0 {
        return Ok(None);
    }
    let rows = numbers(all).into_iter().map(|windows| {
        let sharing = if windows < all { Sharing::Windows(windows) } else { Sharing::Area };
        let (vibrating, count) = counted(machines, sharing, nominal.study.upscaling, sampled, evaluate, monitor)?;
        let probability = vibrating as f64 / count as f64;
        let interval = wilson_interval(vibrating, count);
        Ok(AreaAsOne {
            windows,
            friction_std: sharing.of(&nominal.window).upscaled_std(Upscaling::Area),
            probability,
            // The answer for exact values has no error.
            probability_interval: if machines.variables() == 0 {
                [probability; 2]
            } else {
                [interval.low, interval.high]
            },
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

/// Returns how many machines vibrate, and the number of machines with an answer.
fn counted(
    machines: &Machines<'_>,
    sharing: Sharing,
    upscaling: Upscaling,
    sampled: &Sampled,
    evaluate: &Evaluate<'_>,
    monitor: &dyn Monitor,
) -> Result<(usize, usize), Cancelled> {
    let most = sampled.machines.len().min(MOST);
    let (mut vibrating, mut count) = (0, 0);
    for (from, to) in [(0, most.min(FIRST)), (most.min(FIRST), most)] {
        let task = Task::new(monitor, "verdict: area as one", to - from);
        let answers: Vec<Option<bool>> = blocks::map::<_, Result<_, Cancelled>>(from..to, |index| {
            task.step(|| {
                let known = sampled.machines[index].as_ref().ok()?;
                if sharing.is_the_studys(upscaling) {
                    return Some(known.vibrates);
                }
                let machine = machines.at(&machines.variables_of(index)).ok()?;
                Some(evaluate(&sharing.machine(&machine), index).ok()?.vibrates)
            })
        })?;
        vibrating += answers.iter().flatten().filter(|vibrates| **vibrates).count();
        count += answers.iter().flatten().count();
        if vibrating == 0 || vibrating == count {
            break;
        }
    }
    Ok((vibrating, count))
}

/// Returns the table of the probabilities.
pub(super) fn table(rows: &[AreaAsOne]) -> (&'static str, CsvTable) {
    let column = |of: fn(&AreaAsOne) -> f64| rows.iter().map(of).collect::<Vec<f64>>();
    let table = CsvTable::new([
        ("windows", column(|row| row.windows)),
        ("friction_std", column(|row| row.friction_std)),
        ("probability", column(|row| row.probability)),
        ("probability_low", column(|row| row.probability_interval[0])),
        ("probability_high", column(|row| row.probability_interval[1])),
    ]);
    (TABLE, table.with_first("windows"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_windows_rise_by_equal_ratios_from_one_to_all() {
        let found = numbers(18_511.1);
        assert_eq!((found.len(), found[0], found[ROWS - 1]), (ROWS, 1.0, 18_511.1));
        for pair in found[2..].windows(2) {
            assert!((pair[1] / pair[0] / 18_511.1_f64.powf(1.0 / 7.0) - 1.0).abs() < 0.05, "{found:?}");
        }
        assert_eq!(numbers(3.2), [1.0, 2.0, 3.0, 3.2]);
    }
}
