//! The whole error of the friction coefficient at the operating point.
//!
//! Errors of the sampling of strips and of the scan are independent and add in quadrature. The error of the pitch and the difference
//! between random and scanned surface are biases, which extend the interval to one side.

use super::pitch::Pitch;
use crate::friction::{CutOff, MeanErrors, SolvedLevel};
use crate::stats::NORMAL_95;
use crate::study::check::FrictionStudy;
use crate::study::result::{ErrorCause, OperatingPoint, Pair, ScanCutoff, ScanFriction};
use crate::study::sentence;
use crate::study::surface_stage::SurfaceStage;

/// Largest relative difference of slopes and friction between strips and scan.
const LIKE_THE_SCAN: f64 = 0.15;
/// Change of μ by the shortest waves that is negligible, and the one from which on there is a warning.
const NEGLIGIBLE: f64 = 0.005;
const LARGE: f64 = 0.03;

/// Errors of the mean friction coefficient of a level.
pub(super) struct WholeError {
    pub(super) errors: MeanErrors,
    /// Operating point with its intervals.
    pub(super) point: OperatingPoint,
    pub(super) warnings: Vec<String>,
    /// Sentences on the pitch, and on the scan beside the strips if it was pressed.
    pub(super) sentences: Vec<String>,
}

impl WholeError {
    /// Combines the errors of the mean of `lead`, of which `point` has the sampling interval.
    pub(super) fn new(
        friction: &FrictionStudy,
        surface: &SurfaceStage,
        lead: &SolvedLevel,
        point: OperatingPoint,
        (pitch, scan): (Option<&Pitch>, Option<&ScanFriction>),
    ) -> Self {
        let mean = lead.mean;
        let floor = friction.plastic_floor();
        // No error leads below the plastic floor.
        let least = floor.map_or(0.0, |floor| (floor / mean).min(1.0));
        let factor = |value: f64| (value / mean).max(least);
        let half = |interval: Pair| 0.5 * (interval[1] - interval[0]);
        let sampling = point.mean_interval.map(half);
        let sampling = if lead.process.moments.std > 0.0 { sampling } else { Some(0.0) };
        let strips = sampling.map_or(0.0, |half| half / (NORMAL_95 * mean));
        let mut errors = MeanErrors { strips, ..MeanErrors::default() };
        let (mut warnings, mut noise) = (Vec::new(), 0.0);
        let mut sentences: Vec<String> = pitch.and_then(Pitch::sentence).into_iter().collect();
        if let Some(pitch) = pitch {
            (errors.pitch_factor, errors.grid, noise) = (pitch.factor, pitch.range.map(factor), pitch.noise);
            errors.halved_strips = noise / (NORMAL_95 * mean);
            if let Some(points) = pitch.wanted_points() {
                errors.unresolved.push(ErrorCause::Grid);
                warnings.push(unresolved(friction, pitch.error() / mean, points));
            }
        }
        let computational = sampling.map(|sampling| sampling.hypot(noise));
        let biased = errors.grid.map(|factor| factor * mean);
        let [mut low, mut high] = biased;
        let (mut scan_sampling, mut mean_of_scan) = (0.0, None);
        if let Some((first, last)) = scan.and_then(|scan| scan.cut_offs.first().zip(scan.cut_offs.last())) {
            mean_of_scan = Some(last.mean);
            // Shorter waves than the scan has are the model's alone.
            let is_of_the_scan = surface.is_of_the_scan
                && surface.model.surface.shortest_wave_m.is_none_or(|m| m >= last.cutoff_m * (1.0 - 1e-9));
            if is_of_the_scan {
                let at = |of: &ScanCutoff| {
                    let mean = factor(mean * of.mean / first.mean);
                    // Constant friction stays constant.
                    let std = if first.std > 0.0 && of.std > 0.0 { of.std / first.std } else { mean };
                    CutOff { shortest_m: of.cutoff_m, mean, std }
                };
                errors.cut_off = scan.iter().flat_map(|scan| &scan.cut_offs).map(at).collect();
                if errors.cut_off_range().iter().all(|factor| (factor - 1.0).abs() < NEGLIGIBLE) {
                    errors.cut_off.clear();
                }
                // Waves that hardly matter are no unknown value. Their effect belongs to the difference from the scan.
                let compared = if errors.cut_off.is_empty() { last } else { first };
                let ends = |of: fn(f64, f64) -> f64| factor(of(mean, of(first.mean, compared.mean)));
                errors.model = [ends(f64::min), ends(f64::max)];
                for of in [first, last] {
                    let grid = of.grid_error.unwrap_or(0.0);
                    (low, high) = (low.min(of.mean - grid), high.max(of.mean + grid));
                }
                scan_sampling = half(last.mean_interval);
                errors.scan = scan_sampling / (NORMAL_95 * last.mean);
                let differences = differences(first, mean, scan.and_then(|scan| scan.slope_ratio));
                errors.unresolved.extend((!differences.is_empty()).then_some(ErrorCause::Model));
                warnings.extend(differences);
                warnings.extend(shorter_waves(first, last));
            }
            sentences.push(side_by_side(first, last, mean));
        }
        let least = floor.unwrap_or(0.0).min(mean);
        let widened = |[low, high]: Pair, half: f64| [low - half, high + half].map(|end| end.max(least));
        let point = OperatingPoint {
            mean_sampling_interval: point.mean_interval,
            mean_computational_interval: computational.map(|half| widened(biased, half)),
            mean_interval: computational.map(|half| widened([low, high], half.hypot(scan_sampling))),
            mean_of_scan,
            grid_error: pitch.map(Pitch::error),
            saturation: floor.map(|floor| (1.0 - floor / mean).max(0.0)),
            resolved: errors.unresolved.is_empty(),
            ..point
        };
        errors.whole = point.mean_interval.map_or([1.0; 2], |interval| interval.map(|end| end / mean));
        Self { errors, point, warnings, sentences }
    }
}

/// Returns warnings if friction or slopes of the strips are not those of the scan. `slope_ratio` is the rms slope of the strips over that of the
/// scan.
fn differences(scan: &ScanCutoff, mean: f64, slope_ratio: Option<f64>) -> Vec<String> {
    let [low, high] = scan.mean_interval;
    let of_friction = Some(scan.mean / mean - 1.0).filter(|difference| difference.abs() > 0.5 * (high - low) / mean);
    let of_slope = slope_ratio.filter(|ratio| (ratio - 1.0).abs() > LIKE_THE_SCAN).map(|ratio| 1.0 / ratio - 1.0);
    let of_friction = of_friction.filter(|difference| difference.abs() > LIKE_THE_SCAN);
    let of_friction = of_friction.map(|difference| unlike("friction coefficient", difference));
    of_friction.into_iter().chain(of_slope.map(|difference| unlike("rms slope", difference))).collect()
}

/// Returns a sentence on the friction of the scan, without and with the waves beyond those of the strips, beside that of the strips.
fn side_by_side(first: &ScanCutoff, last: &ScanCutoff, mean: f64) -> String {
    let [first_mean, last_mean, mean] = [first.mean, last.mean, mean].map(sentence::digits);
    let without = if last.cutoff_m < first.cutoff_m {
        format!(" ({first_mean} without waves below {})", sentence::si(first.cutoff_m, "m"))
    } else {
        String::new()
    };
    format!(
        "The scan itself, pressed at the same mean pressure, has the friction coefficient {last_mean}{without}; the random strips have {mean}."
    )
}

/// Returns a warning if the waves beyond those that the scan resolves change its friction.
fn shorter_waves(first: &ScanCutoff, last: &ScanCutoff) -> Option<String> {
    let ratio = last.mean / first.mean;
    ((ratio - 1.0).abs() > LARGE).then(|| {
        format!(
            "the scan resolves waves down to {}; with its shorter waves, down to twice the pixel, μ is {} times as large: only smaller pixels \
             tell which is right",
            sentence::si(first.cutoff_m, "m"),
            sentence::digits(ratio),
        )
    })
}

/// Returns the warning that the pitch is too large, with its error relative to the mean and the wanted factor of the points.
fn unresolved(friction: &FrictionStudy, error: f64, factor: f64) -> String {
    let [nx, ny] = friction.points.map(|points| (points as f64 * factor) as usize);
    format!(
        "the friction coefficient is not resolved: its pitch leaves an error of {} %; about points = [{nx}, {ny}] in [friction] resolve it",
        sentence::digits(100.0 * error),
    )
}

/// Returns the warning that a quantity of the scan differs from that of the strips.
fn unlike(quantity: &str, difference: f64) -> String {
    format!(
        "the random strips do not stand for the scan: its {quantity} is {} % {}; a form of higher degree to remove (`level`), the rejection \
         of outliers or a larger scan may help",
        sentence::digits(100.0 * difference.abs()),
        if difference < 0.0 { "smaller" } else { "larger" },
    )
}
