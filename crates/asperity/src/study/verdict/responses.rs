//! Friction of the contact as a function of the uncertain values, learnt from solved strips.

mod axis;
mod points;

use toml::Table;

use self::axis::Axis;
pub(super) use self::points::ContactPoints;
use super::machines::{BETWEEN_PARTS, Machines};
use crate::chaos::{Expansion, Observed, Propagation, Resamples};
use crate::friction::WindowFriction;
use crate::friction::replicates::{LevelMoments, MomentReplicates};
use crate::monitor::Monitor;
use crate::stats::{Moments, NORMAL_95, student_quantile};
use crate::study::check::VerdictStudy;
use crate::study::output::StageOutput;
use crate::study::result::LearntFriction;
use crate::study::uncertain::Place;
use crate::study::{StudyError, sentence};

/// Smallest number of strips per point.
const LEAST_STRIPS: usize = 4;
/// Solved points per uncertain value and one, before any are solved near the limit of vibration.
const POINTS_PER_VALUE: usize = 4;
/// Largest number of rounds of points near the limit of vibration.
const MOST_ROUNDS: usize = 4;
/// Machines among which those near the limit of vibration are found.
const CANDIDATES: usize = 512;
/// Part of the half width of the probability's interval that the error of friction may take.
const PART_OF_HALF_WIDTH: f64 = 0.5;
/// Step for the slope of an expansion at the end of its range.
const SLOPE_STEP: f64 = 1e-3;
/// Standard error of the mean friction coefficient in percent above which there is a warning.
const LARGEST_PERCENT: f64 = 5.0;
/// Learnt moments, the mean first.
const MOMENTS: [fn(&LevelMoments) -> f64; 4] =
    [|level| level.mean, |level| level.std, |level| level.correlation_length_m, |level| level.stiffness_pa_per_m];
const MEAN: usize = 0;
/// Keys of [vibration] that change the pressure of the contact.
const LOADS: [&str; 2] = ["normal_force", "nominal_area"];

/// Friction learnt as a function of the values that change the contact.
pub(super) struct FrictionResponses {
    axes: Vec<Axis>,
    /// Expansions of the logarithms of the moments, which are nearly products of powers.
    moments: [Option<Expansion>; MOMENTS.len()],
    /// Relative standard error of the mean that is due to the few strips.
    strips_error: f64,
    /// Relative standard error of the mean near the limit of vibration that is due to the expansion.
    expansion_error: f64,
    pub(super) learnt: LearntFriction,
}

impl FrictionResponses {
    /// Solves strips at points of the values that change the contact, and at machines near the limit of vibration, until the error of
    /// friction is a small part of the interval of the probability; `None` if all values are exact.
    ///
    /// # Errors
    /// A point has no answer, or the monitor cancelled.
    pub(super) fn learn(
        points: &ContactPoints<'_>,
        verdict: &VerdictStudy,
        window: &WindowFriction,
        monitor: &dyn Monitor,
        output: &mut StageOutput,
    ) -> Result<Option<Self>, StudyError> {
        let places = contact_places(verdict);
        if places.is_empty() {
            return Ok(None);
        }
        let seed = points.seed();
        let axes: Vec<Axis> = places.into_iter().filter_map(|place| Axis::new(place, verdict)).collect();
        let parameters = axes.iter().map(Axis::parameter).collect::<Result<Vec<_>, _>>()?;
        let round = axes.len() + 1;
        let first = POINTS_PER_VALUE * round;
        let mut propagation = Propagation::new(parameters, first, seed)?;
        let mut found = Vec::with_capacity(first);
        for index in 0..first {
            monitor.progress("verdict: friction", index, first);
            let mut table = verdict.central.clone();
            for (axis, scaled) in axes.iter().zip(propagation.point(index)) {
                axis.place.set(&mut table, axis.value(scaled));
            }
            found.push(points.solve(&table)?);
        }
        monitor.progress("verdict: friction", first, first);
        let mut responses = Self::fit(axes, &propagation, &found, seed)?;
        for count in 1..=MOST_ROUNDS {
            let machines = Machines::new(verdict, window, Some(&responses), seed);
            let near = Near::new(&machines, round, (count - 1) * CANDIDATES, monitor);
            let mut differences = Vec::new();
            for (index, table) in near.tables.iter().enumerate() {
                monitor.progress("verdict: friction near the limit", index, near.tables.len());
                let solved = points.solve(table)?;
                let predicted = responses.at(table, window).mean.ln();
                differences.extend(solved.as_ref().map(|solved| solved.all.mean.ln() - predicted));
                propagation.push(responses.axes.iter().map(|axis| axis.xi(table)).collect());
                found.push(solved);
            }
            let difference = Moments::new(&differences);
            let near_limit = responses.learnt.points_near_limit + near.tables.len();
            responses = Self::fit(responses.axes, &propagation, &found, seed)?;
            responses.learnt.points_near_limit = near_limit;
            if differences.len() > 1 {
                responses.expansion_error = difference.mean.hypot(difference.standard_error());
                responses.learnt.difference_near_limit = Some(difference.mean.hypot(difference.std));
            }
            let error = responses.strips_error.hypot(responses.expansion_error);
            if near.change(error) <= PART_OF_HALF_WIDTH * verdict.half_width
                || responses.strips_error > responses.expansion_error
            {
                break;
            }
        }
        responses.state(output);
        Ok(Some(responses))
    }

    fn fit(
        axes: Vec<Axis>,
        propagation: &Propagation,
        found: &[Option<MomentReplicates>],
        seed: u64,
    ) -> Result<Self, StudyError> {
        let mut moments = [const { None }; MOMENTS.len()];
        let (mut strips_error, mut expansion_error) = (0.0, 0.0);
        for (own, moment) in moments.iter_mut().zip(0..) {
            if let Some((expansion, [noise, unexplained])) = learn_moment(propagation, found, moment, seed)? {
                if moment == MEAN {
                    (strips_error, expansion_error) = (noise, unexplained);
                }
                *own = Some(expansion);
            }
        }
        let learnt = LearntFriction {
            inputs: axes.iter().map(|axis| axis.place.name()).collect(),
            points: found.len(),
            points_near_limit: 0,
            difference_near_limit: None,
            standard_error: strips_error.hypot(expansion_error),
        };
        Ok(Self { axes, moments, strips_error, expansion_error, learnt })
    }

    /// Returns the relative standard errors of the mean by cause.
    pub(super) fn errors(&self) -> Vec<(&'static str, f64)> {
        vec![("strips", self.strips_error), ("expansion", self.expansion_error)]
    }

    /// States what was learnt, with its error.
    fn state(&mut self, output: &mut StageOutput) {
        let error = self.strips_error.hypot(self.expansion_error);
        self.learnt.standard_error = error;
        let percent = |share: f64| sentence::digits(100.0 * share);
        let difference = self.learnt.difference_near_limit.map_or_else(String::new, |difference| {
            format!(
                "; before the {} points near the limit of vibration were added, it differed there from the solved coefficient by {} % \
                 (root mean square)",
                self.learnt.points_near_limit,
                percent(difference)
            )
        });
        output.assumptions.push(format!(
            "The friction coefficient as a function of {} is expanded from {} solved points{difference}. Its standard error is {} %.",
            self.learnt.inputs.join(", "),
            self.learnt.points,
            percent(error)
        ));
        if 100.0 * error > LARGEST_PERCENT {
            output.warnings.push(format!(
                "the friction coefficient as a function of the uncertain values has a standard error of {} %; raise `realisations` \
                 in [friction]",
                percent(error)
            ));
        }
    }

    /// Returns the friction of a study file's values, `window` being the friction at their centres.
    pub(super) fn at(&self, table: &Table, window: &WindowFriction) -> WindowFriction {
        let xi: Vec<f64> = self.axes.iter().map(|axis| axis.xi(table)).collect();
        let [mean, std, length, stiffness] =
            self.moments.each_ref().map(|moment| moment.as_ref().map(|expansion| continued(expansion, &xi).exp()));
        // The standard deviation of a point is that of all windows; its fractions along the path and between parts are those of
        // `window`. Only the windows of a smooth slider have the correlation of the strips along the path.
        let all = window.std.hypot(window.between_parts_std);
        let fractions = if all > 0.0 { [window.std / all, window.between_parts_std / all] } else { [1.0, 0.0] };
        WindowFriction {
            mean: mean.unwrap_or(window.mean),
            std: std.map_or(window.std, |std| std * fractions[0]),
            between_parts_std: std.map_or(window.between_parts_std, |std| std * fractions[1]),
            length_m: length.filter(|_| window.between_parts_std == 0.0).unwrap_or(window.length_m),
            stiffness_pa_per_m: stiffness.or(window.stiffness_pa_per_m),
            ..window.clone()
        }
    }
}

/// Evaluates an expansion, continued linearly beyond −1 … 1: friction is nearly a product of powers, and polynomials are wild there.
fn continued(expansion: &Expansion, xi: &[f64]) -> f64 {
    let end: Vec<f64> = xi.iter().map(|xi| xi.clamp(-1.0, 1.0)).collect();
    let beyond: f64 = xi.iter().zip(&end).map(|(xi, end)| (xi - end).powi(2)).sum::<f64>().sqrt();
    let at_end = expansion.evaluate(&end);
    if beyond == 0.0 {
        return at_end;
    }
    let step = SLOPE_STEP / beyond;
    let inside: Vec<f64> = xi.iter().zip(&end).map(|(xi, end)| end - step * (xi - end)).collect();
    at_end + (at_end - expansion.evaluate(&inside)) / step
}

/// Returns the values that change the contact, uncertain ones and those of remedies.
pub(in crate::study) fn contact_places(verdict: &VerdictStudy) -> Vec<Place> {
    let changes_contact = |place: &Place| {
        let key = place.key();
        (key.section != "vibration" || LOADS.contains(&key.name)) && place.name() != BETWEEN_PARTS
    };
    let mut places: Vec<Place> = Vec::new();
    for place in verdict.places.iter().copied().chain(verdict.remedies.iter().map(|remedy| remedy.place)) {
        if changes_contact(&place) && !places.contains(&place) {
            places.push(place);
        }
    }
    places
}

/// Returns the number of points at which friction is usually solved for a number of values.
pub(in crate::study) fn solved_points(values: usize) -> usize {
    (POINTS_PER_VALUE + 1) * (values + 1)
}

/// Returns the number of strips at each point.
pub(in crate::study) fn strips_per_point(realisations: usize) -> usize {
    LEAST_STRIPS.max(realisations.div_ceil(2))
}

/// Machines near the limit of vibration.
struct Near {
    /// Their study files.
    tables: Vec<Table>,
    /// Change of the margin over that of ln μ, and margin, of all candidates.
    margins: Vec<(f64, f64)>,
}

/// Relative change of friction for the slope of the margin.
const CHANGE: f64 = 0.01;

impl Near {
    /// Finds the `count` machines with the smallest margins among samples from number `from` on.
    fn new(machines: &Machines<'_>, count: usize, from: usize, monitor: &dyn Monitor) -> Self {
        let changed = machines.with_friction_factor(CHANGE.exp());
        let margin = |machines: &Machines<'_>, variables: &[f64]| {
            let machine = machines.at(variables).ok()?;
            Some(machine.dynamics.margins().ok()?.from_stick)
        };
        let mut near = Vec::new();
        for index in from..from + CANDIDATES {
            if monitor.cancelled() {
                break;
            }
            let variables = machines.variables_of(index);
            if let Some((own, other)) = margin(machines, &variables).zip(margin(&changed, &variables)) {
                near.push((own, (other - own) / CHANGE, variables));
            }
        }
        // The distance in ln μ, not in damping: friction is what the points are to teach.
        near.sort_by(|a, b| (a.0 / a.1).abs().total_cmp(&(b.0 / b.1).abs()));
        let tables = near.iter().take(count).map(|(.., variables)| machines.table_at(variables)).collect();
        Self { tables, margins: near.into_iter().map(|(margin, slope, _)| (margin, slope)).collect() }
    }

    /// Returns the half width of the probability's interval that a relative standard error of friction causes.
    fn change(&self, error: f64) -> f64 {
        let share = |sign: f64| {
            let vibrates = |(margin, slope): &&(f64, f64)| margin + sign * NORMAL_95 * error * slope < 0.0;
            self.margins.iter().filter(vibrates).count() as f64 / self.margins.len().max(1) as f64
        };
        0.5 * (share(1.0) - share(-1.0)).abs()
    }
}

/// Expands the logarithm of one moment, with the standard errors due to the few strips and to the expansion; `None` for a moment that is undefined or zero.
fn learn_moment(
    propagation: &Propagation,
    found: &[Option<MomentReplicates>],
    moment: usize,
    seed: u64,
) -> Result<Option<(Expansion, [f64; 2])>, StudyError> {
    let strips = found.iter().flatten().map(|replicates| replicates.without.len()).max().unwrap_or(0);
    let of = |moments: &LevelMoments| MOMENTS[moment](moments).ln();
    let values: Vec<f64> = found.iter().map(|found| found.as_ref().map_or(f64::NAN, |r| of(&r.all))).collect();
    let without: Vec<Vec<f64>> = (0..strips)
        .map(|strip| {
            let one = |found: &Option<MomentReplicates>| {
                found.as_ref().and_then(|r| r.without.get(strip)).map_or(f64::NAN, of)
            };
            found.iter().map(one).collect()
        })
        .collect();
    if moment != MEAN && values.iter().any(|value| !value.is_finite()) {
        return Ok(None);
    }
    let observed = Observed { values: &values, without: &without, resolution: 0.0 };
    let propagated = propagation.respond(&observed, &Resamples { count: 20, ..Resamples::new(seed) })?;
    let unexplained = propagated.leave_one_out.sqrt() * propagated.std.value;
    // A standard error of few strips follows Student's distribution.
    let few = if strips > 1 { student_quantile(0.975, (strips - 1) as f64) / NORMAL_95 } else { 1.0 };
    Ok(Some((propagated.expansion, [few * propagated.noise.standard_error, unexplained])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Marginal;
    use crate::friction::StatedFriction;
    use crate::study::Study;

    const STUDY: &str = "seed = 1\n[surface]\nrms_height = \"1 um\"\ncorrelation_length = \"20 um\"\ncovariance = \"exponential\"\n\
                         marginal = \"normal\"\n[material]\nyoungs_modulus = \"210 GPa\"\nshear_strength = \"385 ± 30 MPa\"\n\
                         [friction]\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.2\n\
                         normal_force = \"2.5 kN\"\nnominal_area = \"64 mm^2\"\ndimensionless_belt_velocity = 0.1\n\
                         stribeck = 4.2\n";

    /// Friction whose moments are powers of τ/(385 MPa).
    fn moments(ratio: f64) -> LevelMoments {
        LevelMoments {
            mean: 0.2 * ratio,
            std: 0.05 * ratio.powi(2),
            coefficient_of_variation: 0.25 * ratio,
            correlation_length_m: 2e-4 / ratio,
            stiffness_pa_per_m: 1e12 * ratio.sqrt(),
        }
    }

    #[test]
    fn the_error_of_few_strips_is_that_of_the_jackknife_with_students_factor() {
        let study = Study::parse(STUDY, "study.toml").unwrap();
        let verdict = study.verdict.as_ref().unwrap();
        let axes: Vec<Axis> = contact_places(verdict).into_iter().filter_map(|p| Axis::new(p, verdict)).collect();
        let propagation = Propagation::new(vec![axes[0].parameter().unwrap()], 8, 1).unwrap();
        // Without a strip, ln μ changes by ±d everywhere: the variance of the jackknife is 3/4·4d².
        let (d, all) = (1e-3_f64, moments(1.0));
        let without = [d, -d, d, -d].map(|change| LevelMoments { mean: all.mean * change.exp(), ..all }).to_vec();
        let found = vec![Some(MomentReplicates { all, without }); 8];
        let responses = FrictionResponses::fit(axes, &propagation, &found, 1).unwrap();
        let wanted = d * 3.0_f64.sqrt() * 3.182_446 / 1.959_964;
        assert!((responses.strips_error / wanted - 1.0).abs() < 1e-3, "{} instead of {wanted}", responses.strips_error);
    }

    #[test]
    fn an_error_of_friction_changes_the_answers_of_machines_within_1_96_errors() {
        // Margins of −1/2 … 1/2 at equal distances; a change of ln μ by .1·1.96 moves the margin by twice that.
        let margins: Vec<_> = (0..1000).map(|i| ((f64::from(i) + 0.5) / 1000.0 - 0.5, 2.0)).collect();
        let near = Near { tables: Vec::new(), margins };
        assert!((near.change(0.1) - 0.392).abs() < 1e-12, "{}", near.change(0.1));
    }

    #[test]
    fn learnt_powers_of_a_value_are_predicted_within_its_range_and_beyond() {
        let study = Study::parse(STUDY, "study.toml").unwrap();
        let verdict = study.verdict.as_ref().unwrap();
        let axes: Vec<Axis> = contact_places(verdict).into_iter().filter_map(|p| Axis::new(p, verdict)).collect();
        let place = axes[0].place;
        assert_eq!((axes.len(), place.name().as_str()), (1, "material.shear_strength"));
        let propagation = Propagation::new(vec![axes[0].parameter().unwrap()], 8, 1).unwrap();
        let found: Vec<_> = (0..8)
            .map(|index| {
                let all = moments(axes[0].value(propagation.point(index)[0]) / 385e6);
                Some(MomentReplicates { all, without: vec![all; 4] })
            })
            .collect();
        let responses = FrictionResponses::fit(axes, &propagation, &found, 1).unwrap();
        assert!(responses.errors().iter().all(|(_, error)| *error < 1e-9), "{:?}", responses.errors());
        assert_eq!((responses.learnt.inputs[0].as_str(), responses.learnt.points), ("material.shear_strength", 8));
        let stated = StatedFriction {
            mean: 0.2,
            std: 0.04,
            length_m: 2e-4,
            marginal: Marginal::STANDARD_NORMAL,
            window_m: [1e-3; 2],
        };
        // The standard deviation 0.05 of all windows is 0.04 along the path and 0.03 between the parts of a slider.
        for between_parts_std in [0.0, 0.03] {
            let std = if between_parts_std > 0.0 { 0.04 } else { 0.05 };
            let stated = StatedFriction { std, ..stated.clone() };
            let window = WindowFriction {
                between_parts_std,
                stiffness_pa_per_m: Some(1e12),
                ..WindowFriction::from_statement(stated, 64e-6, Some(4.2))
            };
            for ratio in [0.5, 0.9, 1.0, 1.2, 1.6] {
                let mut table = verdict.central.clone();
                place.set(&mut table, 385e6 * ratio);
                let (at, wanted) = (responses.at(&table, &window), moments(ratio));
                let parts = wanted.std / 0.05;
                let length = if between_parts_std > 0.0 { 2e-4 } else { wanted.correlation_length_m };
                for (found, wanted) in [
                    (at.mean, wanted.mean),
                    (at.std, std * parts),
                    (at.length_m, length),
                    (at.stiffness_pa_per_m.unwrap(), wanted.stiffness_pa_per_m),
                ] {
                    assert!((found / wanted - 1.0).abs() < 1e-6, "{found} instead of {wanted} at {ratio}");
                }
                assert!((at.between_parts_std - between_parts_std * parts).abs() < 1e-9, "{at:?}");
            }
        }
    }
}
