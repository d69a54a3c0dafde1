//! Mean friction against the shortest waves that the strips keep, and against their pitch.
//!
//! In elastic contact μ is inversely proportional to the root mean square slope of the surface, which its shortest waves decide. Strips
//! of the study's own surface are solved again at the mean pressure of the leading level, without the waves below cut-offs in
//! octaves, and with half the pitch. All have the same random numbers, so the ratio of their friction to that of the unchanged strips is
//! known better than either; it multiplies the study's own mean.

use crate::contact::{Boundary, Control, rms_gradient};
use crate::friction::strip::Record;
use crate::monitor::Monitor;
use crate::quantity::Length;
use crate::stats::{Interval, student_quantile};
use crate::study::config::{FrictionLawKind, FrictionSection, MaterialSection, WindowShape};
use crate::study::friction_stage::{Setup, SolvedLevel};
use crate::study::friction_uncertainty::PartOf;
use crate::study::output::StageOutput;
use crate::study::result::{CutoffPoint, CutoffResult, HalvedPitch, pair};
use crate::study::surface_stage::SurfaceStage;
use crate::study::{StudyError, Table, sentence};
use crate::surface::RandomSurface;
use crate::surface::filter::{Edges, Respaced};
use crate::surface::model::Texture;
use crate::surface::scanned::ScannedSurface;

/// Name of the task in progress.
const TASK: &str = "friction cut-off";
/// Strips for each cut-off.
pub(in crate::study) const STRIPS: usize = 4;
/// Most octaves above the strips' own cut-off.
const OCTAVES: u32 = 4;
/// A cut-off is at most this multiple of the shorter side of a strip.
const LONGEST: f64 = 1.0;
/// Work of a strip of half the pitch over that of a strip: four times the cells and a few iterations more.
const HALVED_WORK: f64 = 5.0;
/// Strips are shortened, by halves, until their work is at most this fraction of the levels' work,
const WORK: f64 = 0.3;
/// but not below this fraction of their length, so many widths or so many points.
const SHORTEST: f64 = 1.0 / 16.0;
const LEAST_WIDTHS: f64 = 4.0;
const LEAST_POINTS: usize = 64;
/// Changes of μ below this fraction do not matter, however well they are known.
const NEGLIGIBLE: f64 = 0.01;
/// From this fraction of contact cells at the hardness on, yielding explains why shorter waves change nothing.
const MOSTLY_PLASTIC: f64 = 0.5;

/// Which strips are solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::study) struct Plan {
    /// Points (x, y) of a strip, at the pitch of the study.
    pub(in crate::study) points: [usize; 2],
    /// Length of a strip in metre.
    length_m: f64,
    /// Octaves above the strips' own cut-off.
    octaves: u32,
}

impl Plan {
    /// The strips for a section with so many levels; none for Coulomb's law, which does not depend on the contact.
    pub(in crate::study) fn new(section: &FrictionSection, levels: usize) -> Option<Self> {
        if section.law == FrictionLawKind::Coulomb {
            return None;
        }
        let ([mut nx, ny], [length, width]) = (section.points, section.strip);
        let (whole, dx_m, dy_m) = (nx as f64, length.0 / nx as f64, width.0 / ny as f64);
        let longest_m = LONGEST * length.0.min(width.0) * (1.0 + 1e-9);
        let fits = |octave: &u32| 2.0 * dx_m.max(dy_m) * f64::from(1_u32 << octave) <= longest_m;
        let octaves = (1..=OCTAVES).take_while(fits).count() as u32;
        let allowed = WORK * (levels * section.realisations) as f64;
        let work = |nx: usize| Self { points: [nx, ny], length_m: 0.0, octaves }.work(section);
        let halves = |nx: usize| {
            let shorter = (nx / 2) as f64;
            nx.is_multiple_of(2)
                && shorter >= SHORTEST * whole
                && nx / 2 >= LEAST_POINTS
                && shorter * dx_m >= LEAST_WIDTHS * width.0
        };
        while work(nx) > allowed && halves(nx) {
            nx /= 2;
        }
        Some(Self { points: [nx, ny], length_m: nx as f64 * dx_m, octaves })
    }

    /// Its work in solutions of the section's own strips.
    pub(in crate::study) fn work(&self, section: &FrictionSection) -> f64 {
        let share = self.points[0] as f64 / section.points[0] as f64;
        STRIPS as f64 * share * (f64::from(1 + self.octaves) + HALVED_WORK)
    }

    /// The section of its strips, or of those of half the pitch.
    fn section(&self, section: &FrictionSection, halved: bool) -> FrictionSection {
        let factor = if halved { 2 } else { 1 };
        FrictionSection {
            strip: [Length(self.length_m), section.strip[1]],
            points: self.points.map(|points| factor * points),
            // The mean over a strip does not depend on the window, which has to fit in ten times.
            window: Length(section.window.0.min(0.1 * self.length_m)),
            window_width: None,
            window_shape: WindowShape::Rectangle,
            realisations: STRIPS,
            ..section.clone()
        }
    }
}

/// Strips at one cut-off.
struct Solved {
    /// ΣF/ΣN of each strip.
    means: Vec<f64>,
    plastic_fraction: f64,
    rms_slope: f64,
}

/// A ratio of means over strips of the same random numbers, and half its 95 % interval.
struct Ratio {
    value: f64,
    half: f64,
}

impl Ratio {
    /// Ratio of the sums, with the spread of the strips about it and Student's factor.
    fn between(changed: &[f64], unchanged: &[f64]) -> Self {
        let n = changed.len() as f64;
        let base = unchanged.iter().sum::<f64>() / n;
        let value = changed.iter().sum::<f64>() / n / base;
        let squares: f64 = changed.iter().zip(unchanged).map(|(a, b)| (a - value * b).powi(2)).sum();
        Self { value, half: student_quantile(0.975, n - 1.0) * (squares / (n * (n - 1.0))).sqrt() / base }
    }
}

/// The mean that the ratios multiply: that of the leading level.
struct Anchor {
    mean: f64,
    /// Half of its 95 % interval, where it has one; 0 where friction does not vary.
    half: Option<f64>,
}

impl Anchor {
    fn of(lead: &SolvedLevel) -> Self {
        let process = &lead.process;
        let varies = process.moments.std > 0.0;
        let interval = process.estimates.mean.map(|mean| mean.interval);
        let half = if varies { interval.map(|i| 0.5 * (i.high - i.low)) } else { Some(0.0) };
        Self { mean: lead.mean, half }
    }

    fn times(&self, ratio: &Ratio) -> (f64, Option<Interval>) {
        let mean = self.mean * ratio.value;
        let half = self.half.map(|half| (ratio.value * half).hypot(self.mean * ratio.half));
        (mean, half.map(|half| Interval { low: mean - half, high: mean + half }))
    }

    /// The least change that matters.
    fn material(&self) -> f64 {
        self.half.unwrap_or(0.0).max(NEGLIGIBLE * self.mean)
    }
}

/// Solves the strips of every cut-off and of half the pitch at the mean pressure of the leading level; none for Coulomb's law.
pub(super) fn run(
    section: &FrictionSection,
    material: &MaterialSection,
    surface: &SurfaceStage,
    (levels, lead): (&[SolvedLevel], usize),
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<(Option<CutoffResult>, StageOutput), StudyError> {
    let mut output = StageOutput::default();
    let Some(plan) = Plan::new(section, levels.len()) else { return Ok((None, output)) };
    let lead = &levels[lead];
    let own = Setup::new(&plan.section(section, false), material)?;
    let generated = surface.model.strip(own.grid, own.periodic)?;
    let strips = generated.surface.as_ref();
    // The sum of cosines of arbitrary directions does not close at the edges of a strip.
    let closes = own.periodic && !matches!(surface.model.texture, Texture::WeierstrassMandelbrot { .. });
    let edges = if closes { Edges::Periodic } else { Edges::Mirrored };
    let pitch_m = own.grid.dx_m().max(own.grid.dy_m());
    let control = Control::MeanPressure { pascal: lead.level.mean_pressure_pa };
    let total = plan.octaves as usize + 2;
    let solve = |setup: &Setup, surface: &dyn RandomSurface, part: usize| {
        let part = PartOf { monitor, task: TASK, before: part * STRIPS, total: total * STRIPS };
        solved(setup, surface, control, seed, &part)
    };
    let mut failed = |what: String, reason: String| {
        output.warnings.push(format!("the study of the cut-off has no answer {what}: {reason}"));
    };
    let unchanged = match solve(&own, strips, 0)? {
        Ok(unchanged) => unchanged,
        Err(reason) => {
            failed("at the strips' own cut-off".into(), reason);
            return Ok((None, output));
        }
    };
    let anchor = Anchor::of(lead);
    let point = |cutoff_m: f64, found: &Solved| {
        let (mean, interval) = anchor.times(&Ratio::between(&found.means, &unchanged.means));
        CutoffPoint {
            cutoff_m,
            mean,
            mean_interval: interval.map(pair),
            rms_slope: found.rms_slope,
            plastic_fraction: found.plastic_fraction,
        }
    };
    let mut points = vec![point(2.0 * pitch_m, &unchanged)];
    for octave in 1..=plan.octaves {
        let cutoff_m = 2.0 * pitch_m * f64::from(1_u32 << octave);
        let smoothed = Respaced::smoothed(strips, edges, cutoff_m);
        match solve(&own, &smoothed, octave as usize)? {
            Ok(found) => points.push(point(cutoff_m, &found)),
            Err(reason) => failed(format!("at {}", sentence::si(cutoff_m, "m")), reason),
        }
    }
    let halved = Setup::new(&plan.section(section, true), material)?;
    let finer = Respaced::with_half_the_pitch(strips, edges)
        .map_err(|error| StudyError::Grid { section: "friction", error })?;
    let halved_pitch = match solve(&halved, &finer, total - 1)? {
        Ok(found) => {
            let ratio = Ratio::between(&found.means, &unchanged.means);
            let (mean, interval) = anchor.times(&ratio);
            let (change, half) = (mean - anchor.mean, anchor.mean * ratio.half);
            let change_interval = pair(Interval { low: change - half, high: change + half });
            let mean_interval = interval.map(pair);
            Some(HalvedPitch { pitch_m: 0.5 * pitch_m, mean, mean_interval, change, change_interval })
        }
        Err(reason) => {
            failed("at half the pitch".into(), reason);
            None
        }
    };
    let mut result = CutoffResult {
        mean_pressure_pa: lead.level.mean_pressure_pa,
        strips: STRIPS,
        strip_length_m: plan.length_m,
        pitch_m,
        cutoff_m: 2.0 * pitch_m,
        band_end_m: surface.measured.as_ref().and_then(ScannedSurface::band_end_m),
        plastic_floor: plastic_floor(section, material),
        points,
        halved_pitch,
        known: String::new(),
    };
    result.known = known(&result, &anchor);
    output.tables.push(("friction_cutoff", table(&result)));
    output.warnings.extend(unresolved(&result, &anchor, &lead.control.name()));
    output.warnings.extend(beyond_the_band(&result, &anchor));
    output.assumptions.push(result.known.clone());
    Ok((Some(result), output))
}

/// Mean friction of each strip under one control, or why there is none.
fn solved(
    setup: &Setup,
    surface: &dyn RandomSurface,
    control: Control,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Result<Solved, String>, StudyError> {
    let strips = setup.strips(surface, STRIPS, seed);
    let level = match strips.solve(&[control], monitor)?.remove(0) {
        Ok(level) => level,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let means: Vec<f64> = level.records.chunks(level.tracks).map(|strip| Record::at_mean_load(strip).0).collect();
    if means.iter().any(|mean| !mean.is_finite()) {
        return Ok(Err("a strip carries no load".into()));
    }
    let squares = (0..STRIPS).map(|index| {
        // Differences across the edges are not slopes of the surface.
        rms_gradient(strips.map(index).heights_m(), setup.grid, Boundary::Free).powi(2)
    });
    let rms_slope = (squares.sum::<f64>() / STRIPS as f64).sqrt();
    Ok(Ok(Solved { means, plastic_fraction: level.plastic_fraction, rms_slope }))
}

/// Friction of contacts that all have the hardness: τ_max/H, and α of a pressure-dependent shear strength.
fn plastic_floor(section: &FrictionSection, material: &MaterialSection) -> Option<f64> {
    let (hardness, shear) = (material.hardness?.0, material.shear_strength?.0);
    Some(
        shear / hardness
            + section.pressure_coefficient.filter(|_| section.law == FrictionLawKind::PressureDependent).unwrap_or(0.0),
    )
}

fn table(result: &CutoffResult) -> Table {
    let column = |value: &dyn Fn(&CutoffPoint) -> f64| result.points.iter().map(value).collect::<Vec<f64>>();
    let end = |point: &CutoffPoint, end: usize| point.mean_interval.map_or(f64::NAN, |interval| interval[end]);
    Table::new([
        ("cutoff_m", column(&|p| p.cutoff_m)),
        ("mean", column(&|p| p.mean)),
        ("mean_low", column(&|p| end(p, 0))),
        ("mean_high", column(&|p| end(p, 1))),
        ("rms_slope", column(&|p| p.rms_slope)),
        ("plastic_fraction", column(&|p| p.plastic_fraction)),
    ])
    .led_by("cutoff_m")
}

/// The mean at a cut-off between the points, linear in the logarithm of the wavelength; that of an end beyond it.
fn mean_at(points: &[CutoffPoint], cutoff_m: f64) -> f64 {
    let after = points.partition_point(|point| point.cutoff_m <= cutoff_m);
    match (after.checked_sub(1).map(|before| &points[before]), points.get(after)) {
        (Some(low), Some(high)) => {
            let share = (cutoff_m / low.cutoff_m).ln() / (high.cutoff_m / low.cutoff_m).ln();
            low.mean + share * (high.mean - low.mean)
        }
        (Some(end), None) | (None, Some(end)) => end.mean,
        (None, None) => f64::NAN,
    }
}

/// What is known of the mean as a function of the shortest waves.
fn known(result: &CutoffResult, anchor: &Anchor) -> String {
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

/// A warning where half the pitch changes the mean.
fn unresolved(result: &CutoffResult, anchor: &Anchor, level: &str) -> Option<String> {
    let halved = result.halved_pitch.as_ref()?;
    let [low, high] = halved.change_interval;
    let differs = low > 0.0 || high < 0.0;
    (differs && halved.change.abs() > anchor.material()).then(|| {
        format!(
            "at {level}, the pitch {} does not resolve the shortest waves of the strips, {}: half the pitch changes μ from {} by {} \
             (95 %: {} to {}); take more points in [friction], or take these waves out of the surface",
            sentence::si(result.pitch_m, "m"),
            sentence::si(result.cutoff_m, "m"),
            sentence::digits(anchor.mean),
            sentence::digits(halved.change),
            sentence::digits(low),
            sentence::digits(high),
        )
    })
}

/// A warning where waves that the scan does not know change the mean.
fn beyond_the_band(result: &CutoffResult, anchor: &Anchor) -> Option<String> {
    let (band_m, own) = (result.band_end_m?, result.points.first()?);
    let there = mean_at(&result.points, band_m);
    (band_m > own.cutoff_m && (there - own.mean).abs() > anchor.material()).then(|| {
        format!(
            "the strips hold waves down to {}, but the scan is reliable down to {} only: μ is {} without the shorter waves, which are \
             the model's alone, and {} with them; take them out by `s_filter`, or measure with smaller pixels",
            sentence::si(own.cutoff_m, "m"),
            sentence::si(band_m, "m"),
            sentence::digits(there),
            sentence::digits(own.mean),
        )
    })
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
            halved_pitch: None,
            known: String::new(),
        }
    }

    #[test]
    fn the_sentence_says_what_limits_the_knowledge() {
        let anchor = Anchor { mean: 0.2, half: Some(0.01) };
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
        // The scan does not know the waves that make the difference.
        assert!(beyond_the_band(&elastic, &anchor).unwrap().contains("μ is 0.25 without the shorter waves"));
        assert_eq!(beyond_the_band(&result([0.2, 0.205, 0.3], 0.1, None), &anchor), None);
        assert_eq!(beyond_the_band(&CutoffResult { band_end_m: Some(1e-6), ..elastic }, &anchor), None);
    }

    #[test]
    fn a_mean_between_cutoffs_is_linear_in_the_logarithm_of_the_wavelength() {
        let points = result([0.2, 0.25, 0.3], 0.0, None).points;
        for (cutoff_m, wanted) in [(1e-6, 0.2), (2e-6, 0.2), (4e-6 * 2_f64.sqrt(), 0.275), (8e-6, 0.3), (1.0, 0.3)] {
            assert!((mean_at(&points, cutoff_m) - wanted).abs() < 1e-12, "{cutoff_m:e}");
        }
    }

    #[test]
    fn common_factors_have_a_ratio_without_an_interval_and_others_students() {
        let exact = Ratio::between(&[0.11, 0.22, 0.33], &[0.1, 0.2, 0.3]);
        assert!((exact.value - 1.1).abs() < 1e-12 && exact.half < 1e-12);
        // Residuals ∓1 about the ratio 1: s² = 2/(2·1), over the mean 10, times t = 12.706 of one degree of freedom.
        let two = Ratio::between(&[9.0, 11.0], &[10.0, 10.0]);
        assert!((two.value - 1.0).abs() < 1e-12 && (two.half - 12.706_205 * 0.1).abs() < 1e-6, "{}", two.half);
    }

    #[test]
    fn the_strips_cost_less_than_a_third_of_the_levels() {
        let usual = FrictionSection::default();
        for levels in [5, 6] {
            let plan = Plan::new(&usual, levels).unwrap();
            let share = plan.work(&usual) / (levels * usual.realisations) as f64;
            assert!(share <= WORK && share > 0.1, "{share}");
        }
        let fine = FrictionSection { points: [4096, 64], ..usual.clone() };
        assert_eq!(Plan::new(&fine, 6).unwrap(), Plan { points: [2048, 64], length_m: 3e-3, octaves: 4 });
        // One level of few strips: the shortest strips, at least four widths and 64 points.
        let few = FrictionSection { realisations: 2, ..fine };
        assert_eq!(Plan::new(&few, 1).unwrap().points, [256, 64]);
        assert_eq!(Plan::new(&FrictionSection { law: FrictionLawKind::Coulomb, ..usual }, 5), None);
    }
}
