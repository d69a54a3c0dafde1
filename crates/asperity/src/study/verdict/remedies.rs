//! Changes of one value after which vibration is improbable.

use std::cell::RefCell;

use asperity_base::blocks::{self, Task};
use asperity_base::numeric::try_root_between;

use super::machines::{Change, Machine, Machines};
use super::sampled::Evaluated;
use crate::chaos::{Design, SamplingError, SamplingMethod};
use crate::monitor::{Cancelled, Monitor};
use crate::stats::{Interval, Moments, quantile_sorted, student_quantile};
use crate::study::StudyError;
use crate::study::check::{RemedyStudy, VerdictStudy};
use crate::study::file::Hold;
use crate::study::result::{ModelResult, Reach, Remedy};

/// Randomisations of the Sobol' points.
pub(in crate::study) const REPLICATES: usize = 8;
/// Points of each randomisation; fewer where friction fluctuates, because each machine then costs an ensemble.
pub(in crate::study) const POINTS: usize = 512;
pub(in crate::study) const FLUCTUATING_POINTS: usize = 64;
/// Steps from the present value to each end of the range in the search for the nearest value.
pub(in crate::study) const STEPS: usize = 8;
/// Tolerance of a value, relative to the range, and the distance within which the values of one replicate and of all differ.
const TOLERANCE: f64 = 1e-5;
const NEAR: f64 = 0.01;
/// Name of the damping ratio.
pub(in crate::study) const DAMPING: &str = "vibration.damping_ratio";
/// Stream of the points.
const STREAM: &str = "study/verdict/remedies";

/// Evaluates a machine, given its index in the sample.
pub(super) type Evaluate<'a> = dyn Fn(&Machine, usize) -> Result<Evaluated, String> + Sync + 'a;

/// Returns the remedies of a study.
pub(super) fn remedies(
    machines: &Machines<'_>,
    study: &VerdictStudy,
    evaluate: &Evaluate<'_>,
    fluctuates: bool,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Vec<Remedy>, StudyError> {
    let variables = points(machines.variables(), if fluctuates { FLUCTUATING_POINTS } else { POINTS }, seed)?;
    let remedies = study.remedies.iter().map(|remedy| {
        Changed { machines, remedy, variables: &variables, evaluate, fluctuates, limits: RefCell::default(), monitor }
            .remedy(study)
    });
    remedies.collect()
}

/// Returns the standard normal variables of all replicates with `count` points each.
pub(super) fn points(variables: usize, count: usize, seed: u64) -> Result<Vec<Vec<f64>>, SamplingError> {
    if variables == 0 {
        return Ok(vec![Vec::new()]);
    }
    let design = Design::new(SamplingMethod::Sobol, seed, STREAM, count, variables)?;
    let mut points = Vec::with_capacity(REPLICATES * count);
    for replicate in 0..REPLICATES {
        let design = design.replicate(replicate)?;
        points.extend((0..count).map(|index| design.xi(index)));
    }
    Ok(points)
}

/// Returns the machines with other central values.
pub(super) fn moved<'a>(machines: &Machines<'a>, changes: &[Change]) -> Result<Machines<'a>, String> {
    let (mut inputs, mut hold, mut exact) = (machines.inputs().clone(), Hold::default(), Vec::new());
    for change in changes {
        match machines.places().iter().position(|uncertain| *uncertain == change.place) {
            Some(input) => {
                inputs = inputs.with_moved(input, change.value).map_err(|error| error.to_string())?;
                if change.hold == Hold::Damper {
                    hold = change.hold;
                }
            }
            None => exact.push(*change),
        }
    }
    Ok(machines.with_inputs(inputs, hold).with_changes(exact))
}

/// Machines under a change of one central value.
struct Changed<'a> {
    machines: &'a Machines<'a>,
    remedy: &'a RemedyStudy,
    /// Standard normal variables of all replicates.
    variables: &'a [Vec<f64>],
    evaluate: &'a Evaluate<'a>,
    fluctuates: bool,
    /// Limit damping ratios of the first machines, once a change of the damping ratio needs them.
    limits: RefCell<Vec<f64>>,
    monitor: &'a dyn Monitor,
}

/// Margins of the machines at one central value, in the order of the replicates. A machine vibrates if its margin is negative.
struct Margins {
    margins: Vec<f64>,
    /// Whether only the signs are known.
    signs: bool,
}

impl Margins {
    /// Returns a continuous number that is positive if fewer than the fraction `probability` of the machines vibrate.
    fn excess(&self, probability: f64) -> f64 {
        if self.signs {
            return probability - fraction_below_zero(&self.margins);
        }
        let mut sorted = self.margins.clone();
        sorted.sort_by(f64::total_cmp);
        quantile_sorted(&sorted, probability.clamp(0.0, 1.0))
    }

    /// Returns whether three times as many machines, or a third of them, may vibrate as the fraction `probability`.
    fn is_near(&self, probability: f64) -> bool {
        (probability / 3.0..3.0 * probability).contains(&fraction_below_zero(&self.margins))
    }

    /// Returns the half width of the 95 % interval of the fraction that vibrates.
    fn half_width(&self) -> f64 {
        if self.margins.len() < REPLICATES {
            return 0.0;
        }
        let replicates = self.margins.chunks(self.margins.len().div_ceil(REPLICATES));
        let error = Moments::new(&replicates.map(fraction_below_zero).collect::<Vec<_>>()).sample_std();
        student_quantile(0.975, (REPLICATES - 1) as f64) * error / (REPLICATES as f64).sqrt()
    }
}

/// Returns the fraction of negative margins.
pub(super) fn fraction_below_zero(margins: &[f64]) -> f64 {
    margins.iter().filter(|margin| **margin < 0.0).count() as f64 / margins.len() as f64
}

impl Changed<'_> {
    fn remedy(&self, study: &VerdictStudy) -> Result<Remedy, StudyError> {
        let RemedyStudy { place, low, high, .. } = *self.remedy;
        let now = self.now();
        let sides = [self.side(now.clamp(low, high), low)?, self.side(now.clamp(low, high), high)?];
        let mut reach = Vec::with_capacity(study.targets.len());
        for &probability in &study.targets {
            let found = sides.iter().map(|side| self.nearest(side, probability)).collect::<Result<Vec<_>, _>>()?;
            let distance = |found: &(f64, Interval)| (found.0 - now).abs();
            let nearest = found.into_iter().flatten().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            reach.push(Reach {
                probability,
                value: nearest.map(|(value, _)| value),
                value_interval: nearest.map(|(_, interval)| [interval.low.max(low), interval.high.min(high)]),
                friction_coefficient: nearest.and_then(|(value, _)| self.friction(value)),
            });
        }
        let friction_coefficient_now = self.friction(now);
        Ok(Remedy { input: place.name(), unit: place.key().unit.into(), now, friction_coefficient_now, reach })
    }

    /// Returns the present central value.
    fn now(&self) -> f64 {
        self.machines.central_value(self.remedy.place)
    }

    /// Returns the machines with another central value.
    fn moved(&self, value: f64) -> Result<Machines<'_>, String> {
        let RemedyStudy { place, hold, .. } = *self.remedy;
        moved(self.machines, &[Change { place, value, hold }])
    }

    /// Returns the friction coefficient of the machine with all values at their centres.
    fn friction(&self, value: f64) -> Option<f64> {
        self.moved(value).and_then(|machines| machines.nominal()).ok().map(|machine| machine.window.mean)
    }

    /// Returns the margins of `count` machines at another damping ratio, on which the limit of the damping does not depend.
    fn damping_margins(&self, value: f64, count: usize) -> Result<Margins, Cancelled> {
        let machines = self.moved(value);
        let damping = |index: usize| Some(machines.as_ref().ok()?.value_of(self.remedy.place, &self.variables[index]));
        let known = self.limits.borrow().len();
        if known < count {
            let Self { machines, variables, evaluate, monitor, .. } = *self;
            let limit = |index: usize| {
                if monitor.cancelled() {
                    return Err(Cancelled);
                }
                let machine = machines.at(&variables[index]);
                let evaluated =
                    machine.and_then(|machine| Ok((machine.study.damping_ratio, evaluate(&machine, index)?)));
                // A machine without an answer counts as vibrating.
                Ok(evaluated.map_or(f64::INFINITY, |(damping, machine)| damping - machine.margins.from_stick))
            };
            let more = blocks::map::<_, Result<Vec<f64>, Cancelled>>(known..count, limit)?;
            self.limits.borrow_mut().extend(more);
        }
        let limits = self.limits.borrow();
        let margins =
            (0..count).map(|index| damping(index).map_or(f64::NEG_INFINITY, |damping| damping - limits[index]));
        Ok(Margins { margins: margins.collect(), signs: false })
    }

    /// Evaluates `count` machines at one central value. A value with which a machine has no answer counts as vibrating.
    fn margins(&self, value: f64, count: usize) -> Result<Margins, Cancelled> {
        if self.remedy.place.name() == DAMPING && !self.fluctuates && self.machines.model() == ModelResult::StickSlip {
            return self.damping_margins(value, count);
        }
        let machines = self.moved(value);
        let Self { variables, evaluate, fluctuates, monitor, .. } = *self;
        let margin = |index: usize| -> Result<f64, Cancelled> {
            if monitor.cancelled() {
                return Err(Cancelled);
            }
            let evaluated = machines
                .as_ref()
                .map_err(Clone::clone)
                .and_then(|machines| machines.at(&variables[index]).and_then(|machine| evaluate(&machine, index)));
            Ok(match evaluated {
                Ok(machine) if !fluctuates => machine.margins.from_stick,
                Ok(machine) if !machine.vibrates => 1.0,
                _ => -1.0,
            })
        };
        Ok(Margins { margins: blocks::map::<_, Result<Vec<_>, _>>(0..count, margin)?, signs: self.fluctuates })
    }

    /// Evaluates machines of the first replicate at values from the present one to an end of the range.
    fn side(&self, from: f64, to: f64) -> Result<Vec<(f64, Margins)>, Cancelled> {
        let count = self.variables.len().div_ceil(REPLICATES);
        let steps = if from == to { 0 } else { STEPS };
        let task = Task::new(self.monitor, "verdict: remedies", steps + 1);
        (0..=steps)
            .map(|step| {
                let value = from + (to - from) * step as f64 / steps.max(1) as f64;
                Ok((value, task.step(|| self.margins(value, count))??))
            })
            .collect()
    }

    /// Returns the first value on a side at which at most the fraction `probability` of the machines vibrates, with its interval.
    fn nearest(&self, side: &[(f64, Margins)], probability: f64) -> Result<Option<(f64, Interval)>, Cancelled> {
        let all = self.variables.len();
        let excess = |value: f64| Ok::<f64, Cancelled>(self.margins(value, all)?.excess(probability));
        let mut before: Option<(f64, f64)> = None;
        for (value, first) in side {
            // The first replicate excludes values that are far from the target.
            let here = match first.excess(probability) {
                margin if margin < 0.0 && before.is_none_or(|(_, at)| at < 0.0) && !first.is_near(probability) => {
                    margin
                }
                _ => excess(*value)?,
            };
            match before {
                _ if here < 0.0 => before = Some((*value, here)),
                None => return Ok(Some((*value, Interval { low: *value, high: *value }))),
                Some((other, _)) => return self.root([other, *value], probability).map(Some),
            }
        }
        Ok(None)
    }

    /// Returns the value between two values at which the fraction `probability` of the machines vibrates, with its interval.
    fn root(&self, [a, b]: [f64; 2], probability: f64) -> Result<(f64, Interval), Cancelled> {
        let (one, all) = (self.variables.len().div_ceil(REPLICATES), self.variables.len());
        let excess = |value: f64, count: usize| Ok::<f64, Cancelled>(self.margins(value, count)?.excess(probability));
        let tolerance = TOLERANCE * (self.remedy.high - self.remedy.low);
        let solve = |[a, b]: [f64; 2], count: usize| {
            let ends = [[a, excess(a, count)?], [b, excess(b, count)?]];
            try_root_between(|value| excess(value, count), ends[0], ends[1], tolerance)
        };
        // The root of one replicate, a cheap one, brackets the root of all.
        let near = solve([a, b], one)?.map(|root| [-NEAR, NEAR].map(|step| root + step * (b - a)));
        let found = match near {
            Some(near) => solve(near, all)?,
            None => None,
        };
        let value = match found {
            Some(value) => value,
            None => solve([a, b], all)?.unwrap_or(b),
        };
        let margins = self.margins(value, all)?;
        // The number of vibrating machines is constant over short steps.
        let ends = if self.fluctuates { [a, b] } else { [value, value + NEAR * (b - a)] };
        let slope = (excess(ends[1], all)? - excess(ends[0], all)?) / (ends[1] - ends[0]);
        let half_width = margins.half_width();
        let [low, high] = [half_width, -half_width]
            .map(|change| value - (margins.excess(probability + change) - margins.excess(probability)) / slope);
        Ok((value, Interval { low: low.min(high), high: low.max(high) }))
    }
}
