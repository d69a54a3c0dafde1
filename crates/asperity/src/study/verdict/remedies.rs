//! Changes of one value after which vibration is improbable.

use asperity_base::blocks::Task;
use asperity_base::numeric::try_root_between;
use asperity_base::sentence;
use asperity_results::keys::DAMPING_RATIO;

use super::answers::Answers;
use super::decided;
use super::machines::{Change, Machines};
use super::margins::{Limits, Moved, is_damping, margins, moved};
use super::replicates::{REPLICATES, points};
use super::sampled::{Evaluate, Evaluated};
use crate::distribution::standard_normal_cdf;
use crate::monitor::{Cancelled, Monitor};
use crate::random;
use crate::stats::{Interval, NORMAL_95};
use crate::study::StudyError;
use crate::study::check::{RemedyStudy, VerdictStudy};
use crate::study::result::{Reach, Remedy, Risk};

/// Points of each randomisation; more where friction fluctuates, because few machines are decided by ensembles.
pub(super) const POINTS: usize = 512;
pub(super) const FLUCTUATING_POINTS: usize = 1024;
/// Steps from the present value to each end of the range in the search for the nearest value.
pub(super) const STEPS: usize = 8;
/// Values at which the probability is drawn, and how far they reach beyond the farthest target, relative to its distance.
pub(super) const RISKS: usize = 13;
const BEYOND: f64 = 0.2;
/// Tolerance of a value, and the distance within which the values of one replicate and of all differ, relative to the range or, if it is
/// wider, to the value.
const TOLERANCE: f64 = 1e-5;
const NEAR: f64 = 0.01;
/// Fraction of a moved distribution beyond the physical bounds above which there is a warning.
const LARGEST_TRUNCATED_MASS: f64 = 1e-3;
/// Half widths of the interval within which the search for a value ends where friction fluctuates, and beyond which its slope is taken.
const CLOSE: f64 = 0.2;
const FAR: f64 = 3.0;
/// Stream of the machines that are decided.
const DECIDED: &str = "study/verdict/remedies/decided";

/// Returns the remedies of a study, and warnings. `evaluate` counts the fluctuation of friction, and `friction_error` is the relative
/// standard error of the mean friction.
pub(super) fn remedies(
    machines: &Machines<'_>,
    study: &VerdictStudy,
    (evaluate, fluctuates): (&Evaluate<'_>, bool),
    friction_error: f64,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<(Vec<Remedy>, Vec<String>), StudyError> {
    let remedies = study.computed_remedies(machines.variables() == 0, fluctuates);
    if remedies.is_empty() {
        return Ok(Default::default());
    }
    let points = points(machines.variables(), if fluctuates { FLUCTUATING_POINTS } else { POINTS }, seed)?;
    let normal = random::standard_normal(&mut random::stream(seed, DECIDED, 0), points.len());
    let draws: Vec<f64> = normal.into_iter().map(standard_normal_cdf).collect();
    let damping = remedies.iter().any(|remedy| is_damping(remedy.place, machines.model()));
    let limits = damping.then(|| Limits::new(&Ok(machines.clone()), &points, monitor)).transpose()?;
    let mut warnings = Vec::new();
    // Both sides of the present value, and the search for each target.
    let task = Task::new(monitor, "verdict: remedies", remedies.len() * (2 + study.targets.len()));
    let mut drawn = false;
    let remedies = remedies.iter().map(|remedy| {
        let limits = limits.as_ref().filter(|_| is_damping(remedy.place, machines.model()));
        let evaluate = fluctuates.then_some(evaluate);
        let draws = &draws;
        let changed = Changed { machines, remedy, points: &points, limits, evaluate, draws, friction_error, monitor };
        let (found, doubts) = changed.remedy(study, &task)?;
        // A change that nobody asked for needs no warning.
        if !study.states_remedies && !doubts.is_empty() {
            return Ok(None);
        }
        warnings.extend(doubts);
        let risk = if drawn || machines.variables() == 0 { Vec::new() } else { changed.risk(&found)? };
        drawn |= !risk.is_empty();
        Ok::<_, StudyError>(Some(Remedy { risk, ..found }))
    });
    let remedies: Vec<Option<Remedy>> = remedies.collect::<Result<_, _>>()?;
    Ok((remedies.into_iter().flatten().collect(), warnings))
}

/// Machines under a change of one central value.
struct Changed<'a> {
    machines: &'a Machines<'a>,
    remedy: &'a RemedyStudy,
    /// Standard normal variables of all replicates.
    points: &'a [Vec<f64>],
    /// Limit damping ratios of the machines, for a change of the damping ratio.
    limits: Option<&'a Limits>,
    /// Evaluates a machine whose friction fluctuates; `None` with constant friction.
    evaluate: Option<&'a Evaluate<'a>>,
    /// Draws that select the machines for ensembles.
    draws: &'a [f64],
    /// Relative standard error of the mean friction of all machines.
    friction_error: f64,
    monitor: &'a dyn Monitor,
}

impl Changed<'_> {
    /// Returns the remedy, with warnings.
    fn remedy(&self, study: &VerdictStudy, task: &Task<'_>) -> Result<(Remedy, Vec<String>), StudyError> {
        let RemedyStudy { place, low, high, hold } = *self.remedy;
        let unstated =
            || StudyError::Verdict(format!("the study does not state {}, which a remedy changes", place.name()));
        let now = self.machines.central_value(place).ok_or_else(unstated)?;
        let side = |to: f64| task.step(|| self.side(now.clamp(low, high), to))?;
        let sides = [side(low)?, side(high)?];
        let mut reach = Vec::with_capacity(study.targets.len());
        for &probability in &study.targets {
            let search = || sides.iter().map(|side| self.nearest(side, probability)).collect::<Result<Vec<_>, _>>();
            let found = task.step(search)??;
            let distance = |found: &(f64, Interval)| (found.0 - now).abs();
            let nearest = found.into_iter().flatten().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest
                .map(|(value, own)| Ok::<_, Cancelled>((value, self.with_friction_errors(value, own, probability)?)))
                .transpose()?;
            reach.push(Reach {
                probability,
                value: nearest.map(|(value, _)| value),
                value_interval: nearest.map(|(_, interval)| [interval.low.max(low), interval.high.min(high)]),
                friction_coefficient: nearest.and_then(|(value, _)| self.friction(value)),
            });
        }
        let truncated = reach.iter().find_map(|reach| self.truncated(reach.value?)).into_iter();
        let warnings = truncated.chain(self.unanswered(sides.iter().flatten(), study.valid_fraction)).collect();
        let friction_coefficient_now = self.friction(now);
        let remedy = Remedy {
            input: place.name(),
            unit: place.key().unit.into(),
            held: (place.name() != DAMPING_RATIO).then(|| hold.name().into()),
            now,
            range: [low, high],
            friction_coefficient_now,
            reach,
            risk: Vec::new(),
        };
        Ok((remedy, warnings))
    }

    /// Returns the probability from the present value to beyond the farthest one that reaches a target; nothing without one, and if the
    /// present value reaches all of them.
    fn risk(&self, found: &Remedy) -> Result<Vec<Risk>, Cancelled> {
        let (now, [low, high]) = (found.now, found.range);
        let reached = found.reach.iter().filter_map(|reach| reach.value).filter(|value| *value != now);
        let Some(farthest) = reached.max_by(|a, b| (a - now).abs().total_cmp(&(b - now).abs())) else {
            return Ok(Vec::new());
        };
        let to = (now + (1.0 + BEYOND) * (farthest - now)).clamp(low, high);
        let count = self.points.len().div_ceil(if self.evaluate.is_none() { 1 } else { REPLICATES });
        let values = (0..RISKS).map(|step| now + (to - now) * step as f64 / (RISKS - 1) as f64);
        let risk = |value| {
            if self.monitor.cancelled() {
                return Err(Cancelled);
            }
            Ok(Risk { value, probability: self.answers(value, count)?.probability() })
        };
        values.map(risk).collect()
    }

    /// Returns the machines with another central value.
    fn moved(&self, value: f64) -> Moved<'_> {
        let RemedyStudy { place, hold, .. } = *self.remedy;
        moved(self.machines, &[Change { place, value, hold }])
    }

    /// Returns a warning if a smaller fraction than `valid_fraction` of the machines has an answer at a value of the search.
    fn unanswered<'s>(
        &self,
        mut sides: impl Iterator<Item = &'s (f64, Answers)>,
        valid_fraction: f64,
    ) -> Option<String> {
        let (value, answers) = sides.find(|(_, answers)| 1.0 - answers.unanswered() < valid_fraction)?;
        let machines = self.moved(*value);
        let answer = |point: &Vec<f64>| -> Result<(), String> {
            Evaluated::constant_friction(&machines.as_ref().map_err(Clone::clone)?.at(point)?).map(drop)
        };
        let reason = self.points.iter().find_map(|point| answer(point).err()).unwrap_or_default();
        let (name, unit) = (self.remedy.place.name(), self.remedy.place.key().unit);
        Some(format!(
            "the remedy by {name} counts machines without an answer as vibrating: {} % of them at {}, the first because {reason}",
            sentence::digits(100.0 * answers.unanswered()),
            format!("{} {unit}", sentence::digits(*value)).trim_end()
        ))
    }

    /// Returns a warning if the physical bounds truncate the distribution that a remedy moved to a value.
    fn truncated(&self, value: f64) -> Option<String> {
        let place = self.remedy.place;
        let input = self.machines.places().iter().position(|uncertain| *uncertain == place)?;
        let moved = self.machines.inputs().with_moved(input, value).ok()?;
        let mass = moved.inputs()[input].truncated_mass();
        let at = format!("{} {}", sentence::digits(value), place.key().unit);
        (mass > LARGEST_TRUNCATED_MASS).then(|| {
            format!(
                "the remedy by {} moves its distribution: at {}, {} % of it lies beyond the physical bounds and is left out; state a \
                 lognormal distribution, which keeps its relative width",
                place.name(),
                at.trim_end(),
                sentence::digits(100.0 * mass)
            )
        })
    }

    /// Returns the friction coefficient of the machine with all values at their centres.
    fn friction(&self, value: f64) -> Option<f64> {
        self.moved(value).and_then(|machines| machines.nominal()).ok().map(|machine| machine.window.mean)
    }

    /// Evaluates the first `count` machines at one central value. A machine without an answer counts as vibrating.
    fn answers(&self, value: f64, count: usize) -> Result<Answers, Cancelled> {
        let (machines, points) = (self.moved(value), &self.points[..count]);
        let margins = match self.limits {
            Some(limits) => limits.margins(&machines, self.remedy.place, points),
            None => margins(&machines, points, self.monitor)?,
        };
        let Some(evaluate) = self.evaluate else { return Ok(Answers::with_constant_friction(margins)) };
        let vibrates = |index: usize| {
            if self.monitor.cancelled() {
                return Err(Cancelled);
            }
            let machine = machines.as_ref().map_err(Clone::clone).and_then(|machines| machines.at(&points[index]));
            Ok(machine.and_then(|machine| evaluate(&machine, index)).map_or(true, |machine| machine.vibrates))
        };
        let terms = decided::terms(&margins, &self.draws[..count], &vibrates, self.monitor)?;
        Ok(Answers::with_fluctuation(margins, &terms))
    }

    /// Evaluates machines of the first replicate at values from the present one to an end of the range.
    fn side(&self, from: f64, to: f64) -> Result<Vec<(f64, Answers)>, Cancelled> {
        let count = self.points.len().div_ceil(REPLICATES);
        searched(from, to).map(|value| Ok((value, self.answers(value, count)?))).collect()
    }

    /// Returns the first value on a side at which at most the fraction `probability` of the machines vibrates, with its interval.
    fn nearest(&self, side: &[(f64, Answers)], probability: f64) -> Result<Option<(f64, Interval)>, Cancelled> {
        let mut before: Option<[f64; 2]> = None;
        for (value, first) in side {
            // The first replicate excludes values that are far from the target.
            let here = match first.excess(probability) {
                margin if margin < 0.0 && !first.is_near(probability) => margin,
                _ => self.answers(*value, self.points.len())?.excess(probability),
            };
            match before {
                _ if here < 0.0 => before = Some([*value, here]),
                None => return Ok(Some((*value, Interval { low: *value, high: *value }))),
                Some(other) => {
                    let [a, b] = self.narrowed([other, [*value, here]], probability)?;
                    return match self.evaluate {
                        Some(_) => self.root_of_fluctuating(a, b, probability).map(Some),
                        None => self.root([a[0], b[0]], probability).map(Some),
                    };
                }
            }
        }
        Ok(None)
    }

    /// Returns two values, with their excess, between two of opposite excess and a ratio larger than ten, such that it is not.
    fn narrowed(&self, [mut a, mut b]: [[f64; 2]; 2], probability: f64) -> Result<[[f64; 2]; 2], Cancelled> {
        while is_wide(a[0], b[0]) {
            let middle = geometric(a[0], b[0], 0.5);
            let excess = self.answers(middle, self.points.len())?.excess(probability);
            *if excess < 0.0 { &mut a } else { &mut b } = [middle, excess];
        }
        Ok([a, b])
    }

    /// Returns the value between two values at which the fraction `probability` of the machines vibrates, with its interval.
    fn root(&self, [a, b]: [f64; 2], probability: f64) -> Result<(f64, Interval), Cancelled> {
        let (one, all) = (self.points.len().div_ceil(REPLICATES), self.points.len());
        let excess = |value: f64, count: usize| Ok::<f64, Cancelled>(self.answers(value, count)?.excess(probability));
        let solve = |[a, b]: [f64; 2], count: usize| {
            let ends = [[a, excess(a, count)?], [b, excess(b, count)?]];
            try_root_between(|value| excess(value, count), ends[0], ends[1], self.tolerance(a, b))
        };
        // The root of one replicate, a cheap one, brackets the root of all.
        let near = |value: f64| NEAR * if value == 0.0 { b - a } else { (b - a).clamp(-value.abs(), value.abs()) };
        let bracket = solve([a, b], one)?.map(|root| [-1.0, 1.0].map(|side| root + side * near(root)));
        let found = match bracket {
            Some(bracket) => solve(bracket, all)?,
            None => None,
        };
        let value = match found {
            Some(value) => value,
            None => solve([a, b], all)?.unwrap_or(b),
        };
        let answers = self.answers(value, all)?;
        let end = value + near(value);
        let slope = (excess(end, all)? - excess(value, all)?) / (end - value);
        Ok((value, answers.interval(value, slope, probability)))
    }

    /// Returns the same where friction fluctuates: the search ends within the error of the probability. `a` and `b` are values with their
    /// excess.
    fn root_of_fluctuating(&self, a: [f64; 2], b: [f64; 2], probability: f64) -> Result<(f64, Interval), Cancelled> {
        let mut known = vec![a, b];
        let mut last = None;
        let excess = |value: f64| -> Result<f64, Cancelled> {
            let answers = self.answers(value, self.points.len())?;
            let excess = answers.excess(probability);
            let is_close = excess.abs() <= CLOSE * answers.error(probability);
            known.push([value, excess]);
            last = Some((value, answers));
            Ok(if is_close { 0.0 } else { excess })
        };
        let value = try_root_between(excess, a, b, self.tolerance(a[0], b[0]))?.unwrap_or(b[0]);
        let answers = match last {
            Some((at, answers)) if at == value => answers,
            _ => self.answers(value, self.points.len())?,
        };
        let slope = slope_at(value, &known, [a, b], FAR * answers.error(probability));
        Ok((value, answers.interval(value, slope, probability)))
    }

    /// Returns the interval of a value with the errors of the friction that all machines share: those of the mean, independent of its own,
    /// and, to one side, those of the pitch and of the model.
    fn with_friction_errors(&self, value: f64, own: Interval, probability: f64) -> Result<Interval, Cancelled> {
        let RemedyStudy { place, low, high, hold } = *self.remedy;
        let biases = self.machines.mean_errors().computational().map(|(_, factors)| factors);
        let is_exact = self.friction_error == 0.0 && biases.iter().all(|factors| *factors == [1.0; 2]);
        if is_exact {
            return Ok(own);
        }
        // The present value may suffice with a reserve. Another friction first uses it up.
        let suffices = own.low == own.high;
        let points = &self.points[..self.points.len().div_ceil(REPLICATES)];
        let margins = |value: f64, factor: f64| {
            let machines = self.machines.with_friction_factor(factor);
            let margins = margins(&moved(&machines, &[Change { place, value, hold }]), points, self.monitor)?;
            Ok::<_, Cancelled>(Answers::with_constant_friction(margins))
        };
        let now = margins(value, 1.0)?;
        // Where friction fluctuates, as many machines are beyond the limit of its margin.
        let quantile = if self.evaluate.is_some() && !suffices { now.probability() } else { probability };
        let wide = if value == 0.0 { high - low } else { value.abs().min(high - low) };
        let step = if value < 0.5 * (low + high) { NEAR } else { -NEAR } * wide;
        let slope = (margins(value + step, 1.0)?.excess(quantile) - now.excess(quantile)) / step;
        let reserve = if suffices { now.excess(quantile).max(0.0) } else { 0.0 };
        let change = |factor: f64| match factor {
            1.0 => Ok(0.0),
            factor => {
                let lost = now.excess(quantile) - margins(value, factor)?.excess(quantile);
                Ok::<_, Cancelled>(if suffices { (lost - reserve).max(0.0) } else { lost } / slope)
            }
        };
        let sides = |[least, most]: [f64; 2]| {
            let [a, b] = [change(least)?, change(most)?];
            Ok::<_, Cancelled>([-a.min(b).min(0.0), a.max(b).max(0.0)])
        };
        let spread = NORMAL_95 * self.friction_error;
        let of_mean = sides([-spread, spread].map(f64::exp))?;
        let (mut below, mut above) = ((value - own.low).hypot(of_mean[0]), (own.high - value).hypot(of_mean[1]));
        for factors in biases {
            let of_bias = sides(factors)?;
            (below, above) = (below + of_bias[0], above + of_bias[1]);
        }
        let end = |value: f64, unknown: f64| if value.is_nan() { unknown } else { value };
        Ok(Interval { low: end(value - below, low), high: end(value + above, high) })
    }

    /// Returns the tolerance of a value between two values.
    fn tolerance(&self, a: f64, b: f64) -> f64 {
        let value = if a * b.signum() > 0.0 && b != 0.0 { a.abs().min(b.abs()) } else { a.abs().max(b.abs()) };
        TOLERANCE * (self.remedy.high - self.remedy.low).min(value)
    }
}

/// Returns the values of the search from one value to another, with equal differences, or with equal ratios if their ratio is larger than
/// ten.
fn searched(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let steps = if from == to { 0 } else { STEPS };
    (0..=steps).map(move |step| match step as f64 / STEPS as f64 {
        1.0 => to,
        part if is_wide(from, to) => geometric(from, to, part),
        part => from + (to - from) * part,
    })
}

/// Returns whether the ratio of two values of equal sign is larger than ten.
fn is_wide(a: f64, b: f64) -> bool {
    a != 0.0 && b != 0.0 && a.signum() == b.signum() && (a / b).log10().abs() > 1.0
}

/// Returns the value at `part` of the way between two values of equal sign, on a logarithmic scale.
fn geometric(a: f64, b: f64, part: f64) -> f64 {
    a.signum() * a.abs().powf(1.0 - part) * b.abs().powf(part)
}

/// Returns the slope of the excess at `value`, between the nearest known values on both sides whose excess is at least `far`, or else
/// the ends; closer values differ by their errors. Without a slope it is zero: the interval is the whole range.
fn slope_at(value: f64, known: &[[f64; 2]], ends: [[f64; 2]; 2], far: f64) -> f64 {
    let [a, b] = ends.map(|end| {
        let beyond = known.iter().filter(|[_, excess]| excess.is_finite() && excess * end[1].signum() >= far);
        beyond.min_by(|x, y| (x[0] - value).abs().total_cmp(&(y[0] - value).abs())).copied().unwrap_or(end)
    });
    let slope = (b[1] - a[1]) / (b[0] - a[0]);
    if slope.is_finite() { slope } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::WindowFriction;
    use crate::study::Study;
    use crate::study::verdict::machines::Machine;
    use crate::study::verdict::machines::tests::{LINEAR, constant, stated};

    #[test]
    fn the_slope_is_that_between_the_nearest_values_whose_excess_exceeds_its_error() {
        // The excess is y + y³ at x = 1 + y; at two values close to the root errors exceed it, and one answer has no limit.
        let excess = |x: f64| [x, (x - 1.0) + (x - 1.0).powi(3)];
        let ends = [excess(-1.0), excess(4.0)];
        let mut known: Vec<_> = [-1.0, 4.0, 0.0, 3.0, 0.5, 2.0].map(excess).to_vec();
        known.extend([[0.9, 0.1], [1.1, -0.2], [0.6, f64::NEG_INFINITY]]);
        let slope = |far: f64| slope_at(1.0, &known, ends, far);
        // From −.625 at .5 to 2 at 2, from −2 at 0 to 2 at 2, and from −2 at 0 to 10 at 3.
        assert!((slope(0.6) - 2.625 / 1.5).abs() < 1e-12, "{}", slope(0.6));
        assert!((slope(2.0) - 2.0).abs() < 1e-12, "{}", slope(2.0));
        assert!((slope_at(1.6, &known, ends, 2.0) - 2.0).abs() < 1e-12);
        assert!((slope_at(1.0, &known[..4], ends, 1.9) - 12.0 / 3.0).abs() < 1e-12);
        // No value is far enough: the ends, also where the first has the larger excess.
        let wide = (ends[1][1] - ends[0][1]) / 5.0;
        assert!((slope(100.0) - wide).abs() < 1e-12);
        let falling = [[0.0, 1.5], [4.0, -1.0]];
        assert!((slope_at(1.0, &[[0.5, 1.2], [3.0, -0.9]], falling, 0.8) + 2.1 / 2.5).abs() < 1e-12);
        assert_eq!(slope_at(1.0, &[], [[1.0, 0.0], [1.0, 0.5]], 0.8), 0.0);
    }

    #[test]
    fn a_search_over_decades_has_steps_of_equal_ratio() {
        let values: Vec<f64> = searched(2.0, 2e8).collect();
        assert!(values.windows(2).all(|pair| (pair[1] / pair[0] - 10.0).abs() < 1e-12), "{values:?}");
        assert_eq!((values.len(), values[0], values[8]), (9, 2.0, 2e8));
        assert!(searched(-3.0, -30.1).all(|value| (-30.1..=-3.0).contains(&value)));
        // A difference of signs, and a ratio of ten.
        for (from, to) in [(-1.0, 1e9), (0.0, 1e9), (1.0, 10.0)] {
            let values: Vec<f64> = searched(from, to).collect();
            assert!((values[4] - 0.5 * (from + to)).abs() < 1e-6, "{values:?}");
        }
        assert_eq!(searched(7.0, 7.0).collect::<Vec<_>>(), [7.0]);
    }

    #[test]
    #[ignore = "slow"]
    fn values_under_fluctuating_friction_are_those_of_the_closed_form() {
        // A machine vibrates if ζ − b/2 + .0017 e < .004, with a normal variable e of its realisations: ζ − b/2 − .004 + .0017 e has
        // the standard deviation √(.005² + .01² + .0017²) = .0113094, and its quantile at P is zero.
        let std = (0.005_f64.powi(2) + 0.01_f64.powi(2) + 0.0017_f64.powi(2)).sqrt();
        let remedies_text = "[verdict]\nremedies = [{ input = \"vibration.damping_ratio\", range = [0.01, 0.5] }, \
                             { input = \"vibration.linear_weakening\", range = [0.01, 0.2] }]\n";
        let (mut covered, mut all, mut widths) = (0, 0, [0.0; 2]);
        for seed in 1..=6 {
            let (study, window) = stated(&format!("{LINEAR}{remedies_text}"));
            let verdict = study.verdict.as_ref().unwrap();
            let machines = Machines::new(verdict, &window, None, seed);
            let evaluate = |machine: &Machine, index: usize| {
                let mut evaluated = Evaluated::constant_friction(machine)?;
                let noise = random::standard_normal(&mut random::stream(seed, "test", index as u64), 1)[0];
                evaluated.vibrates = evaluated.margins.from_stick + 0.0017 * noise < 0.004;
                Ok(evaluated)
            };
            let mut verdict = verdict.clone();
            // A machine of another weakening needs another evaluation, which takes longer.
            verdict.remedies.truncate(if seed == 1 { 2 } else { 1 });
            let (found, _) =
                remedies(&machines, &verdict, (&evaluate, true), 0.0, seed, &crate::monitor::Silent).unwrap();
            for (remedy, slope) in found.iter().zip([1.0_f64, -2.0]) {
                for (target, score) in [1.644_853_6, 2.326_347_9].into_iter().enumerate() {
                    let reach = &remedy.reach[target];
                    let margin = 0.004 + score * std;
                    let wanted = if slope > 0.0 { 0.05 + margin } else { 0.11 - 2.0 * margin };
                    let [low, high] = reach.value_interval.unwrap();
                    covered += usize::from(low <= wanted && wanted <= high);
                    all += 1;
                    assert!(
                        (reach.value.unwrap() - wanted).abs() < 2e-3 * slope.abs(),
                        "{reach:?} instead of {wanted}"
                    );
                    widths[target] += (high - low) / slope.abs();
                }
            }
        }
        // 7,000 independent machines have an interval of ± .00068 at 5 %, and 512 that ensembles decide one of ± .0044 at 1 %.
        assert!(widths[0] < 0.5 * all as f64 * 2.0 * 0.00068, "{widths:?}");
        assert!(widths[1] / (0.5 * all as f64) < 2.0 * 0.0044 / 3.0, "{widths:?}");
        assert!(covered >= all - 2, "{covered} of {all}");
    }

    #[test]
    #[ignore = "slow"]
    fn the_present_value_reaches_a_target_that_single_replicates_miss() {
        // M = ζ − b/2 is negative with the probability Φ(−.005/.0111803) = .3274. The error of 4,096 Sobol' points is below 2e-3, and
        // that of the first 512 is larger for some seeds.
        let remedy = "[verdict]\ntargets = [0.3294]\nremedies = [{ input = \"vibration.damping_ratio\", range = [0.05, 0.06] }]\n";
        let (study, window) = stated(&format!("{LINEAR}{remedy}"));
        for seed in 1..=8 {
            let (found, _) = of_constant_friction(&study, &window, seed);
            assert_eq!(found[0].reach[0].value, Some(0.055), "seed {seed}");
        }
    }

    #[test]
    #[ignore = "slow"]
    fn values_under_constant_friction_have_intervals_of_their_replicates() {
        // M = ζ − b/2 has the standard deviation .0111803. 4,096 independent machines give its quantiles at 5 and 1 % with half widths of
        // .9e-3 and 1.5e-3, Student's factor included; Sobol' points undercut them.
        let three = "[verdict]\nremedies = [{ input = \"vibration.damping_ratio\", range = [0.01, 0.5] }, \
                     { input = \"vibration.linear_weakening\", range = [0.01, 0.2] }, \
                     { input = \"vibration.damping_ratio\", range = [0.01, 0.066] }]\n";
        let (study, window) = stated(&format!("{LINEAR}{three}"));
        let (found, warnings) = of_constant_friction(&study, &window, 1);
        // At 1 % the centre of b is 2.9 standard deviations above 0.
        assert!(warnings.len() == 1 && warnings[0].contains("0.1879 % of it lies beyond"), "{warnings:?}");
        assert_eq!([0, 1, 2].map(|remedy: usize| found[remedy].reach.len()), [2; 3]);
        for (remedy, (now, slope)) in found.iter().zip([(0.055, 1.0), (0.1, 2.0)]) {
            assert!((remedy.now - now).abs() < 1e-12 && remedy.friction_coefficient_now == Some(0.3), "{remedy:?}");
            for (reach, (wanted, half_width)) in remedy.reach.iter().zip([(0.013_390, 0.9e-3), (0.021_009, 1.5e-3)]) {
                let wanted = now + if slope == 1.0 { wanted } else { -2.0 * wanted };
                assert!((reach.value.unwrap() - wanted).abs() < half_width * slope, "{reach:?} instead of {wanted}");
                let [low, high] = reach.value_interval.unwrap();
                assert!(low < reach.value.unwrap() && reach.value.unwrap() < high, "{reach:?}");
                assert!(high - low < 2.0 * half_width * slope && high - low > 0.05 * half_width, "{reach:?}");
                assert_eq!(reach.friction_coefficient, Some(0.3));
            }
        }
        // The targets lie beyond the last range.
        assert!(
            found[2].reach.iter().all(|reach| reach.value.is_none() && reach.value_interval.is_none()),
            "{found:?}"
        );
    }

    #[test]
    fn damping_and_load_are_changed_if_no_remedy_is_stated() {
        // Under the ratio r of the load M = ζ − r b/2 has the mean .055 − .05 r and the standard deviation √(.005² + (.01 r)²).
        let probability = |damping: f64, r: f64| standard_normal_cdf((0.05 * r - damping) / 0.005_f64.hypot(0.01 * r));
        let (study, window) = stated(LINEAR);
        let (found, warnings) = of_constant_friction(&study, &window, 1);
        let [damping, load] = &found[..] else { panic!("{found:?}") };
        assert!(warnings.is_empty(), "{warnings:?}");
        for reach in &damping.reach {
            assert!((probability(reach.value.unwrap(), 1.0) / reach.probability - 1.0).abs() < 0.1, "{reach:?}");
        }
        for reach in &load.reach {
            assert!(
                (probability(0.055, reach.value.unwrap() / load.now) / reach.probability - 1.0).abs() < 0.1,
                "{reach:?}"
            );
        }
        // The curve begins at the present value and ends beyond the last target.
        assert_eq!((damping.risk.len(), damping.risk[0].value, load.risk.len()), (RISKS, damping.now, 0));
        assert!(damping.risk[RISKS - 1].value > damping.reach[1].value.unwrap());
        for Risk { value, probability: found } in &damping.risk {
            assert!((found - probability(*value, 1.0)).abs() < 2e-3, "{found} at {value}");
        }
        let none = stated(&format!("{LINEAR}[verdict]\nremedies = []\n"));
        assert!(of_constant_friction(&none.0, &none.1, 1).0.is_empty());
    }

    /// Returns a study of a machine with M = ζ − b/2, b of 0.2 ± 0.02 and ζ of 0.1 ± 0.01, which vibrates with P = ½.
    fn study_text(lists: &[&str]) -> String {
        let lists: Vec<String> = lists.iter().map(|list| format!("{{ input = \"vibration.{list} }}")).collect();
        let machine = LINEAR.replace("\"0.1 ± 0.02\"", "\"0.2 ± 0.02\"").replace("0.055 ± 0.005", "0.1 ± 0.01");
        format!("{machine}[verdict]\nremedies = [{}]\n", lists.join(", "))
    }

    /// Returns the remedies of that machine, and warnings.
    fn found(lists: &[&str]) -> (Vec<Remedy>, Vec<String>) {
        let (study, window) = stated(&study_text(lists));
        of_constant_friction(&study, &window, 1)
    }

    fn of_constant_friction(study: &Study, window: &WindowFriction, seed: u64) -> (Vec<Remedy>, Vec<String>) {
        let verdict = study.verdict.as_ref().unwrap();
        let machines = Machines::new(verdict, window, None, seed);
        remedies(&machines, verdict, (&constant, false), 0.0, seed, &crate::monitor::Silent).unwrap()
    }

    #[test]
    #[ignore = "slow"]
    fn machines_without_an_answer_are_no_remedy() {
        // More weakening makes vibration more probable; the velocity, and a frequency with the damper, do not change P. Some or all machines
        // of the ranges have no answer: their friction would be negative, or its fluctuation lacks a distribution.
        let (found, warnings) = found(&[
            "linear_weakening\", range = [0.2, 5.0]",
            "dimensionless_belt_velocity\", range = [0.1, 5.0]",
            "natural_frequency\", range = [\"1 rad/s\", \"1000 rad/s\"]",
            "friction_std\", range = [0.1, 0.2]",
        ]);
        for remedy in &found {
            assert!(remedy.reach.iter().all(|reach| reach.value.is_none()), "{remedy:?}");
        }
        assert_eq!(warnings.len(), 4, "{warnings:?}");
        for (warning, remedy) in warnings.iter().zip(&found) {
            assert!(warning.contains(&remedy.input) && warning.contains("without an answer"), "{warning}");
        }
        assert!(warnings[3].contains("100 %") && warnings[3].contains("the first because"), "{}", warnings[3]);
    }

    #[test]
    #[ignore = "slow"]
    fn a_distribution_that_its_bounds_truncate_at_a_remedy_is_a_warning() {
        let text = study_text(&["linear_weakening\", range = [0.01, 0.3]"]).replace("0.2 ± 0.02", "0.2 ± 0.05");
        let warnings = |damping: &str| {
            let (study, window) = stated(&text.replace("\"0.1 ± 0.01\"", damping));
            of_constant_friction(&study, &window, 1).1
        };
        // For ζ = .06 the centre of b is near .12 − 1.645·.05 = .038 at P = 5 %, and Φ(−.76) of b negative. ζ = .18 needs no change.
        let found = warnings("0.06");
        assert!(
            found.len() == 1 && found[0].contains("vibration.linear_weakening moves its distribution"),
            "{found:?}"
        );
        assert!(warnings("0.18").is_empty());
    }

    #[test]
    #[ignore = "slow"]
    fn values_do_not_depend_on_the_width_of_the_range() {
        // At 5 and 1 % ζ is .1 + 1.6449 and 2.3263 times .0141421.
        let wide = |input: &str, ends: [&str; 4]| {
            ends.map(|end| format!("{input}\", range = [{end}], hold = \"damping_ratio\""))
        };
        let damping = wide("damping_ratio", ["0.01, 1", "0.01, 1e4", "0.0, 1e12", "1e-9, 1e300"]);
        let (found, _) = found(&damping.each_ref().map(String::as_str));
        for remedy in &found {
            for (reach, wanted) in remedy.reach.iter().zip([0.123_262, 0.132_900]) {
                let ([low, high], value) = (reach.value_interval.unwrap(), reach.value.unwrap());
                // 4,096 independent machines have half widths of 1.1e-3 and 1.9e-3.
                assert!((value - wanted).abs() < 1e-3 && low < value && value < high && high - low < 3e-3, "{reach:?}");
                assert!((value - found[0].reach[usize::from(wanted > 0.13)].value.unwrap()).abs() < 2e-5, "{reach:?}");
            }
        }
        // A mass of m kg divides b: .1 − .1/m is 1.6449·.01·√(1 + 1/m²) at m = 1.2651, where M changes with m by .068.
        let mass = wide(
            "mass",
            ["\"0.1 kg\", \"10 kg\"", "\"0.1 kg\", \"1e4 kg\"", "\"0.1 kg\", \"1e6 kg\"", "\"1 kg\", \"5 kg\""],
        );
        let (found, _) = self::found(&mass.each_ref().map(String::as_str));
        for remedy in &found {
            let (value, first) = (remedy.reach[0].value.unwrap(), found[0].reach[0].value.unwrap());
            assert!((value - 1.2651).abs() < 1.1e-3 / 0.068 && (value - first).abs() < 2e-5, "{remedy:?}");
        }
    }

    #[test]
    #[ignore = "slow"]
    fn the_interval_of_a_value_contains_the_errors_of_the_friction() {
        let text = study_text(&["damping_ratio\", range = [0.02, 0.5]"])
            .replace("\"linear\"\nlinear_weakening = \"0.2 ± 0.02\"", "\"stribeck\"\nstribeck = 2.0")
            .replace("[verdict]", "[verdict]\ntargets = [0.05]");
        let at_damping = |now: f64, factor: f64, grid: [f64; 2], error: f64| {
            let (study, mut window) = stated(&text.replace("0.1 ± 0.01", &format!("{now} ± 0.01")));
            let verdict = study.verdict.as_ref().unwrap();
            window.mean_errors.grid = grid;
            let machines = Machines::new(verdict, &window, None, 1).with_friction_factor(factor);
            let found = remedies(&machines, verdict, (&constant, false), error, 1, &crate::monitor::Silent);
            let reach = &found.unwrap().0[0].reach[0];
            let (value, [low, high]) = (reach.value.unwrap(), reach.value_interval.unwrap());
            (value, value - low, high - value)
        };
        let reach = |factor: f64, grid: [f64; 2], error: f64| at_damping(0.1, factor, grid, error);
        let exact = |factor: f64| reach(factor, [1.0; 2], 0.0);
        let (value, below, above) = exact(1.0);
        // A bias extends the interval to its side, an independent error adds in quadrature.
        let biased = reach(1.0, [0.95, 1.0], 0.0);
        assert_eq!((biased.0, biased.2), (value, above));
        let wanted = value - exact(0.95).0;
        assert!(wanted > 5.0 * below && (biased.1 - below - wanted).abs() < 0.1 * wanted, "{biased:?}, {wanted}");
        let spread = 0.5 * (exact(0.0196_f64.exp()).0 - exact((-0.0196_f64).exp()).0);
        let found = reach(1.0, [1.0; 2], 0.01);
        assert!((found.1 - below.hypot(spread)).abs() < 0.1 * spread, "{found:?}, {spread}");
        assert!((found.2 - above.hypot(spread)).abs() < 0.1 * spread, "{found:?}, {spread}");
        // A present value that suffices has a reserve, and a smaller friction needs no more damping.
        let now = value + 0.1 * wanted;
        assert_eq!(at_damping(now, 1.0, [0.95, 1.0], 0.0), (now, 0.0, 0.0));
        let found = at_damping(now, 1.0, [1.0, 1.05], 0.0);
        let wanted = exact(1.05).0 - now;
        assert!(found.1 == 0.0 && (found.2 - wanted).abs() < 0.15 * wanted, "{found:?}, {wanted}");
    }

    #[test]
    fn a_wide_bracket_is_narrowed_to_a_decade() {
        // P is a half at ζ = b/2, b of .2: M = ζ − .1 for the machine with all values at their centres.
        let text = study_text(&["damping_ratio\", range = [0.0, 1e300]"]);
        let (study, window) = stated(&text);
        let verdict = study.verdict.as_ref().unwrap();
        let machines = Machines::new(verdict, &window, None, 1);
        let points = vec![vec![0.0; machines.variables()]];
        let monitor = &crate::monitor::Silent;
        let limits = Limits::new(&Ok(machines.clone()), &points, monitor).unwrap();
        let limits = Some(&limits);
        let remedy = &verdict.remedies[0];
        let changed = Changed {
            machines: &machines,
            remedy,
            points: &points,
            limits,
            evaluate: None,
            draws: &[],
            friction_error: 0.0,
            monitor,
        };
        for (ends, within) in [([1e-9, 1e300], [0.01, 1.0]), ([0.05, 0.2], [0.05, 0.2]), ([0.0, 1e300], [0.0, 1e300])] {
            let [a, b] = changed.narrowed(ends.map(|end| [end, end - 0.1]), 0.5).unwrap();
            assert!(within[0] <= a[0] && a[0] < 0.1 && 0.1 < b[0] && b[0] <= within[1], "{a:?} {b:?}");
            assert!(a[1] < 0.0 && b[1] > 0.0);
        }
        assert_eq!(changed.narrowed([[0.0, -0.1], [0.2, 0.1]], 0.5).unwrap()[0][0], 0.0);
        assert_eq!(changed.narrowed([[0.2, -0.1], [0.0, 0.1]], 0.5).unwrap()[1][0], 0.0);
    }

    #[test]
    #[ignore = "slow"]
    fn the_nearest_of_two_values_is_stated() {
        // K = [2, 1 − kμ; 1, 2/3 + k] with the contact spring k has modes that meet at μ = (1 + (k − 4/3)²/4)/k. That is above the quantile
        // of μ at 95 %, .55 + 1.6449·.03, for k below 1.7363 and above 3.3279.
        // There μ changes with k by −.229 and .120, and 4,096 independent machines have a standard error of .00099 of the quantile.
        for (now, wanted, slope) in [(2.0, 1.7363, 0.229), (3.0, 3.3279, 0.120), (2.8, 3.3279, 0.120)] {
            let text = format!(
                "seed = 1\n[vibration]\nmodel = \"mode_coupling\"\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\n\
                 normal_force = \"2.5 kN\"\nnominal_area = \"833 mm^2\"\nstatic_friction = \"0.55 ± 0.03\"\nfriction_std = 0\n\
                 dimensionless_belt_velocity = 0.5\ndamping_ratio = 0\ncontact_spring = {now}\n\
                 [verdict]\ntargets = [0.05]\nremedies = [{{ input = \"vibration.contact_spring\", range = [1.0, 5.0] }}]\n"
            );
            let (study, window) = stated(&text);
            let (found, _) = of_constant_friction(&study, &window, 1);
            let reach = &found[0].reach[0];
            let (value, error) = (reach.value.unwrap(), 0.000_99 / slope);
            assert!((value - wanted).abs() < 3.0 * error, "{now}: {reach:?} instead of {wanted}");
            // Student's factor of eight replicates is 2.36.
            let [low, high] = reach.value_interval.unwrap();
            assert!(low < value && value < high && high - low < 2.0 * 2.36 * error, "{reach:?}");
        }
    }
}
