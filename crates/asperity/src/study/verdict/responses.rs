//! Friction of the contact as a function of the uncertain values, expanded from solved strips.

use super::axis::Axis;
use crate::chaos::{Expansion, Observed, Propagation, Resamples};
use crate::friction::WindowFriction;
use crate::friction::replicates::{LevelMoments, MomentReplicates};
use crate::stats::{NORMAL_95, student_95};
use crate::study::output::StageOutput;
use crate::study::result::LearntFriction;
use crate::study::uncertain::Point;
use crate::study::{StudyError, sentence};

/// Step for the slope of an expansion at the end of its range.
const SLOPE_STEP: f64 = 1e-3;
/// Standard error of the mean friction coefficient in percent above which there is a warning.
const LARGEST_PERCENT: f64 = 5.0;
/// Expanded moments, the mean first.
const MOMENTS: [fn(&LevelMoments) -> f64; 4] =
    [|level| level.mean, |level| level.std, |level| level.correlation_length_m, |level| level.stiffness_pa_per_m];
const MEAN: usize = 0;
/// Friction as a function of the values that change the contact.
pub(super) struct FrictionResponses {
    pub(super) axes: Vec<Axis>,
    /// Expansions of the logarithms of the moments, which are nearly products of powers.
    moments: [Option<Expansion>; MOMENTS.len()],
    /// Relative standard error of the mean that is due to the few strips.
    pub(super) strips_error: f64,
    /// Relative standard error of the mean near the limit of vibration that is due to the expansion.
    pub(super) expansion_error: f64,
    pub(super) result: LearntFriction,
}

impl FrictionResponses {
    /// Expands the moments of the points of `propagation`, which `found` are.
    pub(super) fn fit(
        axes: Vec<Axis>,
        propagation: &Propagation,
        found: &[Option<MomentReplicates>],
        seed: u64,
    ) -> Result<Self, StudyError> {
        let mut moments = [const { None }; MOMENTS.len()];
        let (mut strips_error, mut expansion_error) = (0.0, 0.0);
        for (own, moment) in moments.iter_mut().zip(0..) {
            if let Some((expansion, [noise, unexplained])) = expand_moment(propagation, found, moment, seed)? {
                if moment == MEAN {
                    (strips_error, expansion_error) = (noise, unexplained);
                }
                *own = Some(expansion);
            }
        }
        let result = LearntFriction {
            inputs: axes.iter().map(|axis| axis.place.name()).collect(),
            points: found.len(),
            points_near_limit: 0,
            difference_near_limit: None,
            standard_error: strips_error.hypot(expansion_error),
        };
        Ok(Self { axes, moments, strips_error, expansion_error, result })
    }

    /// States the expansion with its error.
    pub(super) fn state(&mut self, output: &mut StageOutput) {
        let error = self.strips_error.hypot(self.expansion_error);
        self.result.standard_error = error;
        let percent = |fraction: f64| sentence::digits(100.0 * fraction);
        let difference = self.result.difference_near_limit.map_or_else(String::new, |difference| {
            format!(
                "; before the {} points near the limit of vibration were added, it differed there from the solved coefficient by {} % \
                 (root mean square)",
                self.result.points_near_limit,
                percent(difference)
            )
        });
        output.assumptions.push(format!(
            "The friction coefficient as a function of {} is expanded from {} solved points{difference}. Its standard error is {} %.",
            self.result.inputs.join(", "),
            self.result.points,
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

    /// Returns the friction at a point, `window` being the friction at their centres.
    pub(super) fn at(&self, point: &Point, window: &WindowFriction) -> WindowFriction {
        let xi: Vec<f64> = self.axes.iter().map(|axis| axis.xi(point)).collect();
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

/// Expands the logarithm of one moment, with the standard errors due to the few strips and to the expansion; `None` for a moment that is undefined or zero.
fn expand_moment(
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
    let few = if strips > 1 { student_95(strips) / NORMAL_95 } else { 1.0 };
    Ok(Some((propagated.expansion, [few * propagated.noise.standard_error, unexplained])))
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::axis::contact_places;
    use super::*;
    use crate::chaos::Basis;
    use crate::distribution::Marginal;
    use crate::friction::StatedFriction;
    use crate::study::Study;

    const STUDY: &str = "seed = 1\n[surface]\nrms_height = \"1 um\"\ncorrelation_length = \"20 um\"\ncovariance = \"exponential\"\n\
                         marginal = \"normal\"\n[material]\nyoungs_modulus = \"385 ± 30 GPa\"\nshear_strength = \"385 MPa\"\n\
                         [friction]\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.2\n\
                         normal_force = \"2.5 kN\"\nnominal_area = \"64 mm^2\"\ndimensionless_belt_velocity = 0.1\n\
                         stribeck = 4.2\n";

    /// Friction whose moments are powers of E/(385 GPa).
    fn moments(ratio: f64) -> LevelMoments {
        LevelMoments {
            mean: 0.2 * ratio,
            std: 0.05 * ratio.powi(2),
            coefficient_of_variation: 0.25 * ratio,
            correlation_length_m: 2e-4 / ratio,
            stiffness_pa_per_m: 1e12 * ratio.sqrt(),
        }
    }

    /// Returns the friction of a study whose moments are powers of its uncertain strength.
    pub(in crate::study::verdict) fn of_powers(study: &Study) -> FrictionResponses {
        let verdict = study.verdict.as_ref().unwrap();
        let axes: Vec<Axis> = contact_places(verdict).into_iter().filter_map(|p| Axis::new(p, verdict)).collect();
        assert_eq!((axes.len(), axes[0].place.name().as_str()), (1, "material.youngs_modulus"));
        let propagation = Propagation::new(vec![axes[0].parameter().unwrap()], 8, 1).unwrap();
        let point = |index: usize| {
            let all = moments(axes[0].value(propagation.point(index)[0]) / 385e9);
            Some(MomentReplicates { all, without: vec![all; 4] })
        };
        let found: Vec<_> = (0..8).map(point).collect();
        FrictionResponses::fit(axes, &propagation, &found, 1).unwrap()
    }

    #[test]
    fn beyond_its_range_an_expansion_is_continued_along_its_slope() {
        // f = x² + xy has the value .5 and the slope 2x + y = 1.5 at the end (1, −.5) of its range.
        let points: Vec<[f64; 2]> =
            (0..25).map(|i| [f64::from(i / 5) * 0.5 - 1.0, f64::from(i % 5) * 0.5 - 1.0]).collect();
        let values: Vec<f64> = points.iter().map(|[x, y]| x * x + x * y).collect();
        let (expansion, _) = Expansion::fit(Basis::hermite(2, 2).unwrap(), &points, &values).unwrap();
        for (point, wanted) in
            [([0.5, -0.5], 0.0), ([3.0, -0.5], 3.5), ([-2.0, 1.0], 1.0), ([2.0, 3.0], 2.0 + 3.0 + 2.0)]
        {
            let found = continued(&expansion, &point);
            assert!((found - wanted).abs() < 5e-3, "{found} instead of {wanted} at {point:?}");
        }
    }

    #[test]
    fn the_error_of_few_strips_is_that_of_the_jackknife_with_students_factor() {
        let study = Study::parse(STUDY, "study.toml").unwrap();
        let verdict = study.verdict.as_ref().unwrap();
        let axes: Vec<Axis> = contact_places(verdict).into_iter().filter_map(|p| Axis::new(p, verdict)).collect();
        let propagation = Propagation::new(vec![axes[0].parameter().unwrap()], 8, 1).unwrap();
        // Without a strip, ln μ changes by ±d everywhere: the variance of the jackknife is 3/4·4d².
        for (d, percent, is_large) in [(1e-3_f64, " 0.28", false), (2e-2, " 5.6", true)] {
            let all = moments(1.0);
            let without = [d, -d, d, -d].map(|change| LevelMoments { mean: all.mean * change.exp(), ..all }).to_vec();
            let found = vec![Some(MomentReplicates { all, without }); 8];
            let axes = vec![Axis::new(axes[0].place, verdict).unwrap()];
            let mut responses = FrictionResponses::fit(axes, &propagation, &found, 1).unwrap();
            let wanted = d * 3.0_f64.sqrt() * 3.182_446 / 1.959_964;
            let error = responses.strips_error;
            assert!((error / wanted - 1.0).abs() < 1e-3, "{error} instead of {wanted}");
            responses.result.difference_near_limit = Some(0.03);
            responses.result.points_near_limit = 2;
            let mut output = StageOutput::default();
            responses.state(&mut output);
            assert!((responses.result.standard_error / wanted - 1.0).abs() < 1e-3);
            let [assumption] = &output.assumptions[..] else { panic!("{:?}", output.assumptions) };
            for part in [percent, "the 2 points near the limit", "by 3 %"] {
                assert!(assumption.contains(part), "{assumption}");
            }
            assert_eq!(
                output.warnings.iter().any(|warning| warning.contains(percent)),
                is_large,
                "{:?}",
                output.warnings
            );
        }
    }

    #[test]
    fn expanded_powers_of_a_value_are_predicted_within_its_range_and_beyond() {
        let study = Study::parse(STUDY, "study.toml").unwrap();
        let verdict = study.verdict.as_ref().unwrap();
        let responses = of_powers(&study);
        let place = responses.axes[0].place;
        assert!(responses.strips_error < 1e-9 && responses.expansion_error < 1e-9);
        assert_eq!((responses.result.inputs[0].as_str(), responses.result.points), ("material.youngs_modulus", 8));
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
                let mut point = verdict.central.clone();
                place.set(&mut point, 385e9 * ratio);
                let (at, wanted) = (responses.at(&point, &window), moments(ratio));
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
