//! Mean friction against the shortest waves of the strips and against their pitch: results, table and words.

use crate::friction::SolvedLevel;
use crate::friction::cutoff::{CutoffBlock, CutoffPlan, CutoffStudy, OperatingMean, STRIPS};
use crate::monitor::Monitor;
use crate::study::check::FrictionStudy;
use crate::study::file::WindowShape;
use crate::study::friction_strips::strip_problem;
use crate::study::output::StageOutput;
use crate::study::result::{CutoffPoint, CutoffResult, FinerPitch, Pair, pair};
use crate::study::surface_stage::SurfaceStage;
use crate::study::{StudyError, Table, sentence};
use crate::surface::model::XiOrder;

/// Fraction of contact cells at the hardness from which on yielding explains why shorter waves change nothing.
const MOSTLY_PLASTIC: f64 = 0.5;

/// Returns the settings of the strips of a plan after some halvings of their pitch.
fn study_of(plan: &CutoffPlan, study: &FrictionStudy, halvings: u32) -> FrictionStudy {
    let width_m = study.size_m[1];
    FrictionStudy {
        points: plan.points.map(|points| points << halvings),
        size_m: [plan.length_m, width_m],
        // The mean over a strip does not depend on the window, which has to fit in ten times.
        window_m: [study.window_m[0].min(0.1 * plan.length_m), width_m],
        window_shape: WindowShape::Rectangle,
        ..study.clone()
    }
}

/// Solved strips of every cutoff and of halves of the pitch.
pub(super) struct SolvedCutoffs {
    plan: CutoffPlan,
    pub(super) pitch_m: f64,
    /// Blocks of the cutoffs, the strips' own first.
    blocks: Vec<(f64, CutoffBlock)>,
    /// The strips' own cutoff on halves of the pitch.
    finer: Vec<CutoffBlock>,
}

impl SolvedCutoffs {
    /// Solves the strips at a mean pressure, that of the operating level of `levels` ones, and halves their pitch until it `is_resolved` or
    /// the work is too large; `None` for Coulomb's law.
    pub(super) fn solve(
        friction: &FrictionStudy,
        surface: &SurfaceStage,
        (levels, pascal): (usize, f64),
        is_resolved: impl Fn(&Self) -> bool,
        seed: u64,
        monitor: &dyn Monitor,
    ) -> Result<(Option<Self>, StageOutput), StudyError> {
        let mut output = StageOutput::default();
        let shortest_m = surface.model.shortest_wave_m();
        let Some(plan) = friction.cutoff_plan(levels, shortest_m) else { return Ok((None, output)) };
        let own = strip_problem(&study_of(&plan, friction, 0))?.0;
        let generated = surface.model.strip(own.grid(), own.is_periodic(), XiOrder::Variance)?;
        let closes = own.is_periodic() && surface.model.closes();
        let study = CutoffStudy::new(plan, &own, (generated.surface.as_ref(), closes), pascal, seed);
        let mut task = study.task(study.cutoffs() + 1, monitor);
        let mut solved = Self { plan, pitch_m: study.pitch_m(), blocks: Vec::new(), finer: Vec::new() };
        let unsolved =
            |place: &str, reason: String| format!("the study of the cut-off has no answer {place}: {reason}");
        for index in 0..study.cutoffs() {
            let cutoff_m = study.cutoff_m(index);
            match study.solve(index, &task)? {
                Ok(found) => solved.blocks.push((cutoff_m, found)),
                Err(reason) if index == 0 => {
                    output.warnings.push(unsolved("at the strips' own cut-off", reason));
                    return Ok((None, output));
                }
                Err(reason) => {
                    output.warnings.push(unsolved(&format!("at {}", sentence::si(cutoff_m, "m")), reason));
                }
            }
        }
        for halvings in 1..=plan.halvings {
            if halvings > 1 {
                task = study.task(1, monitor);
            }
            let problem = strip_problem(&study_of(&plan, friction, halvings))?.0;
            match study.solve_halved(&problem, halvings, &task)? {
                Ok(found) => solved.finer.push(found),
                Err(reason) => {
                    let pitch = sentence::si(solved.finer_pitch_m(solved.finer.len()), "m");
                    output.warnings.push(unsolved(&format!("at the pitch {pitch}"), reason));
                    break;
                }
            }
            if is_resolved(&solved) {
                break;
            }
        }
        Ok((Some(solved), output))
    }

    /// Returns the pitch of entry number `index` of `finer` in metre.
    fn finer_pitch_m(&self, index: usize) -> f64 {
        self.pitch_m / f64::from(2_u32 << index)
    }

    /// Returns the relative changes of the mean from each pitch to half of it and the half widths of their 95 % intervals.
    pub(super) fn changes(&self) -> Vec<Pair> {
        let own = self.blocks.first().map(|(_, own)| own);
        let coarser = own.into_iter().chain(&self.finer);
        coarser.zip(&self.finer).map(|(coarse, fine)| fine.change_from(coarse)).collect()
    }

    /// Returns the results at the operating level, of which the mean was `mean_at_pitch` before its extrapolation.
    pub(super) fn result(
        &self,
        friction: &FrictionStudy,
        surface: &SurfaceStage,
        lead: &SolvedLevel,
        mean_at_pitch: f64,
    ) -> Option<(CutoffResult, StageOutput)> {
        let unchanged = &self.blocks.first()?.1;
        let anchor = OperatingMean::new(lead);
        let plastic_floor = friction.plastic_floor();
        let possible = |mean: f64| plastic_floor.map_or(mean, |floor| mean.max(floor));
        let points = self.blocks.iter().map(|(cutoff_m, found)| {
            let (mean, interval) = anchor.of(found, unchanged);
            CutoffPoint {
                cutoff_m: *cutoff_m,
                mean: possible(mean),
                mean_interval: interval.map(|interval| pair(interval).map(possible)),
                rms_slope: found.rms_slope,
                plastic_fraction: found.plastic_fraction,
            }
        });
        let at_pitch = OperatingMean { mean: mean_at_pitch, ..anchor };
        let finer_pitches = self.finer.iter().enumerate().map(|(index, found)| {
            let ((mean, interval), (change, change_interval)) =
                (at_pitch.of(found, unchanged), at_pitch.change(found, unchanged));
            let (mean_interval, change_interval) = (interval.map(pair), pair(change_interval));
            FinerPitch { pitch_m: self.finer_pitch_m(index), mean, mean_interval, change, change_interval }
        });
        let mut result = CutoffResult {
            mean_pressure_pa: lead.strips.mean_pressure_pa,
            strips: STRIPS,
            strip_length_m: self.plan.length_m,
            pitch_m: self.pitch_m,
            cutoff_m: self.plan.cutoff_m,
            band_end_m: surface.band_end_m,
            plastic_floor,
            points: points.collect(),
            finer_pitches: finer_pitches.collect(),
            known: String::new(),
        };
        result.known = known(&result, &anchor);
        let mut output = StageOutput::default();
        output.tables.push(("friction_cutoff", Table::of(&result.points)));
        output.assumptions.push(result.known.clone());
        Some((result, output))
    }
}

/// Interpolates the mean at a cutoff linearly in the logarithm of the wavelength; returns the mean of the nearest end beyond it.
fn mean_at(points: &[CutoffPoint], cutoff_m: f64) -> f64 {
    let after = points.partition_point(|point| point.cutoff_m <= cutoff_m);
    match (after.checked_sub(1).map(|before| &points[before]), points.get(after)) {
        (Some(low), Some(high)) => {
            let fraction = (cutoff_m / low.cutoff_m).ln() / (high.cutoff_m / low.cutoff_m).ln();
            low.mean + fraction * (high.mean - low.mean)
        }
        (Some(end), None) | (None, Some(end)) => end.mean,
        (None, None) => f64::NAN,
    }
}

/// Returns a sentence on the mean as a function of the shortest waves.
fn known(result: &CutoffResult, anchor: &OperatingMean) -> String {
    let (mu, metre) = (sentence::digits, |m| sentence::si(m, "m"));
    let [own, next, ..] = &result.points[..] else {
        return format!(
            "How the friction coefficient depends on the shortest waves is not known: strips of the pitch {} are too narrow for \
             a cut-off above their own.",
            metre(result.pitch_m)
        );
    };
    let last = result.points.last().unwrap_or(next);
    let floor = result.plastic_floor.map(|floor| format!("the plastic floor τ_max/H = {}", mu(floor)));
    if (next.mean - own.mean).abs() > anchor.material() {
        let beyond = match floor {
            _ if own.mean > next.mean => String::new(),
            Some(floor) => format!("; shorter waves would lower it, down to {floor} at most"),
            None => "; shorter waves would lower it, and without a hardness there is no floor".into(),
        };
        let band = match result.band_end_m {
            Some(band) if band > own.cutoff_m => {
                format!(
                    " The scan is reliable down to {}, where it is {}.",
                    metre(band),
                    mu(mean_at(&result.points, band))
                )
            }
            Some(band) => format!(" The scan is reliable down to {}.", metre(band)),
            None => String::new(),
        };
        return format!(
            "The friction coefficient is known only as far as the shortest waves are: it is {} without waves below {} and {} with \
             all waves down to {}, the shortest that the strips hold{beyond}.{band}",
            mu(last.mean),
            metre(last.cutoff_m),
            mu(own.mean),
            metre(own.cutoff_m),
        );
    }
    let values = format!(
        "it is {} without waves below {} and {} with all waves down to {}",
        mu(next.mean),
        metre(next.cutoff_m),
        mu(own.mean),
        metre(own.cutoff_m)
    );
    match floor.filter(|_| own.plastic_fraction >= MOSTLY_PLASTIC) {
        Some(floor) => format!(
            "Yielding makes the friction coefficient independent of the shortest waves: {values}; {} % of the contact cells have the \
             hardness, and it cannot be below {floor}.",
            mu(100.0 * own.plastic_fraction)
        ),
        None => format!(
            "The shortest waves hardly change the friction coefficient: {values}, with root mean square slopes of {} and {}.",
            mu(next.rms_slope),
            mu(own.rms_slope)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(means: [f64; 3], plastic_fraction: f64, plastic_floor: Option<f64>) -> CutoffResult {
        let points = means.into_iter().enumerate().map(|(index, mean)| CutoffPoint {
            cutoff_m: 2e-6 * f64::from(1 << index),
            mean,
            mean_interval: None,
            rms_slope: 0.1,
            plastic_fraction,
        });
        CutoffResult {
            mean_pressure_pa: 3e6,
            strips: STRIPS,
            strip_length_m: 1e-3,
            pitch_m: 1e-6,
            cutoff_m: 2e-6,
            band_end_m: Some(4e-6),
            plastic_floor,
            points: points.collect(),
            finer_pitches: Vec::new(),
            known: String::new(),
        }
    }

    #[test]
    fn the_sentence_says_what_limits_the_knowledge() {
        let anchor = OperatingMean { mean: 0.2, half: Some(0.01) };
        let elastic = result([0.2, 0.25, 0.3], 0.1, Some(0.15));
        let text = known(&elastic, &anchor);
        for wanted in
            ["only as far as", "0.3 without waves below 8 µm", "0.2 with all waves down to 2 µm", "H = 0.15 at most"]
        {
            assert!(text.contains(wanted), "{wanted} in {text}");
        }
        assert!(text.contains("reliable down to 4 µm, where it is 0.25"), "{text}");
        assert!(known(&result([0.2, 0.25, 0.3], 0.0, None), &anchor).contains("no floor"));
        assert!(known(&result([0.2, 0.205, 0.3], 0.7, Some(0.19)), &anchor).starts_with("Yielding makes"));
        assert!(known(&result([0.2, 0.205, 0.3], 0.1, Some(0.15)), &anchor).starts_with("The shortest waves hardly"));
    }

    #[test]
    fn a_mean_between_cutoffs_is_linear_in_the_logarithm_of_the_wavelength() {
        let points = result([0.2, 0.25, 0.3], 0.0, None).points;
        for (cutoff_m, wanted) in [(1e-6, 0.2), (2e-6, 0.2), (4e-6 * 2_f64.sqrt(), 0.275), (8e-6, 0.3), (1.0, 0.3)] {
            assert!((mean_at(&points, cutoff_m) - wanted).abs() < 1e-12, "{cutoff_m:e}");
        }
    }
}
