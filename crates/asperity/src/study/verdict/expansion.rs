//! Solved points from which friction is expanded, more of them near the limit of vibration.

use super::axis::{Axis, contact_places};
use super::machines::Machines;
use super::points::ContactPoints;
use super::responses::FrictionResponses;
use crate::chaos::Propagation;
use crate::friction::WindowFriction;
use crate::monitor::Monitor;
use crate::stats::{Moments, NORMAL_95};
use crate::study::StudyError;
use crate::study::check::VerdictStudy;
use crate::study::output::StageOutput;
use crate::study::uncertain::{CUT_OFF, Point};

/// Solved points per uncertain value and one, before any are solved near the limit of vibration.
const POINTS_PER_VALUE: usize = 4;
/// Largest number of rounds of points near the limit of vibration.
const MOST_ROUNDS: usize = 4;
/// Machines among which those near the limit of vibration are found.
const CANDIDATES: usize = 512;
/// Part of the half width of the probability's interval that the error of friction may take.
const PART_OF_HALF_WIDTH: f64 = 0.5;

/// Solves strips at points of the values that change the contact, and at machines near the limit of vibration, until the error of
/// friction is a small part of the interval of the probability; `None` if all values are exact.
///
/// # Errors
/// A point has no answer, or the monitor cancelled.
pub(super) fn expand_friction(
    points: &ContactPoints<'_>,
    verdict: &VerdictStudy,
    window: &WindowFriction,
    monitor: &dyn Monitor,
    output: &mut StageOutput,
) -> Result<Option<FrictionResponses>, StudyError> {
    let mut places = contact_places(verdict);
    if !window.mean_errors.cut_off.is_empty() {
        places.retain(|place| place.name() != CUT_OFF);
    }
    places.retain(|place| !points.scan.is_factor(*place));
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
        let mut point = verdict.central.clone();
        for (axis, scaled) in axes.iter().zip(propagation.point(index)) {
            axis.place.set(&mut point, axis.value(scaled));
        }
        found.push(points.solve(&point)?);
    }
    monitor.progress("verdict: friction", first, first);
    let mut responses = FrictionResponses::fit(axes, &propagation, &found, seed)?;
    for count in 1..=MOST_ROUNDS {
        let machines = Machines::new(verdict, window, Some(&responses), seed);
        let near = Near::new(&machines, round, (count - 1) * CANDIDATES, monitor);
        let mut differences = Vec::new();
        for (index, point) in near.points.iter().enumerate() {
            monitor.progress("verdict: friction near the limit", index, near.points.len());
            let solved = points.solve(point)?;
            let predicted = responses.at(point, window).mean.ln();
            differences.extend(solved.as_ref().map(|solved| solved.all.mean.ln() - predicted));
            propagation.push(responses.axes.iter().map(|axis| axis.xi(point)).collect());
            found.push(solved);
        }
        monitor.progress("verdict: friction near the limit", near.points.len(), near.points.len());
        let difference = Moments::new(&differences);
        let near_limit = responses.result.points_near_limit + near.points.len();
        responses = FrictionResponses::fit(responses.axes, &propagation, &found, seed)?;
        responses.result.points_near_limit = near_limit;
        if differences.len() > 1 {
            responses.expansion_error = difference.mean.hypot(difference.standard_error());
            responses.result.difference_near_limit = Some(difference.mean.hypot(difference.std));
        }
        if near.suffices(responses.strips_error, responses.expansion_error, verdict.half_width) {
            break;
        }
    }
    responses.state(output);
    Ok(Some(responses))
}

/// Returns the number of points at which friction is usually solved for a number of values.
pub(super) fn solved_points(values: usize) -> usize {
    (POINTS_PER_VALUE + 1) * (values + 1)
}

/// Machines near the limit of vibration.
struct Near {
    points: Vec<Point>,
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
        let points = near.iter().take(count).map(|(.., variables)| machines.point_at(variables)).collect();
        Self { points, margins: near.into_iter().map(|(margin, slope, _)| (margin, slope)).collect() }
    }

    /// Returns whether more points would hardly narrow the interval of the probability, whose half width may be `half_width`: the error of
    /// friction widens it little, or is mostly that of the strips.
    fn suffices(&self, strips_error: f64, expansion_error: f64, half_width: f64) -> bool {
        strips_error > expansion_error
            || self.change(strips_error.hypot(expansion_error)) <= PART_OF_HALF_WIDTH * half_width
    }

    /// Returns the half width of the probability's interval that a relative standard error of friction causes.
    fn change(&self, error: f64) -> f64 {
        let fraction = |sign: f64| {
            let vibrates = |(margin, slope): &&(f64, f64)| margin + sign * NORMAL_95 * error * slope < 0.0;
            self.margins.iter().filter(vibrates).count() as f64 / self.margins.len().max(1) as f64
        };
        0.5 * (fraction(1.0) - fraction(-1.0)).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_friction_changes_the_answers_of_machines_within_1_96_errors() {
        // Margins of −1/2 … 1/2 at equal distances; a change of ln μ by .1·1.96 moves the margin by twice that.
        let margins: Vec<_> = (0..1000).map(|i| ((f64::from(i) + 0.5) / 1000.0 - 0.5, 2.0)).collect();
        let near = Near { points: Vec::new(), margins };
        assert!((near.change(0.1) - 0.392).abs() < 1e-12, "{}", near.change(0.1));
        // It may take half of the half width; points lower the error of the expansion only.
        assert!(near.suffices(0.06, 0.08, 0.785) && !near.suffices(0.06, 0.08, 0.783));
        assert!(near.suffices(0.08, 0.06, 0.1));
    }
}
