//! Moments of μ with each strip left out, for the jackknife estimate of the noise of few strips.

use crate::statistics::{ROUNDING, correlate};
use crate::strip::{Record, SolvedStrips};
use asperity_base::blocks;
use asperity_base::stats::Moments;

/// Moments of μ that the study of an uncertain surface uses; NaN if undefined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelMoments {
    /// Mean: of the quotients, or ΣF/ΣN at the mean load.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Standard deviation over mean.
    pub coefficient_of_variation: f64,
    /// ℓ_μ in metre of the exponential fit; it contains the window.
    pub correlation_length_m: f64,
    /// Contact stiffness over area in Pa/m, at the mean load; NaN at other levels than [`crate::strip::Strips::stiff_level`].
    pub stiffness_pa_per_m: f64,
}

impl LevelMoments {
    /// Names in the order of [`LevelMoments::values`].
    pub const NAMES: [&'static str; 4] = ["mean", "std", "coefficient_of_variation", "correlation_length_m"];
    /// Moments of a level without a solution.
    pub const NONE: Self = Self {
        mean: f64::NAN,
        std: f64::NAN,
        coefficient_of_variation: f64::NAN,
        correlation_length_m: f64::NAN,
        stiffness_pa_per_m: f64::NAN,
    };

    /// Returns all moments of μ.
    pub fn values(&self) -> [f64; 4] {
        [self.mean, self.std, self.coefficient_of_variation, self.correlation_length_m]
    }

    /// Computes the moments of records with positions `step_m` apart and `tracks` records per strip.
    fn from_records(records: &[&[f64]], tracks: usize, step_m: f64) -> Self {
        let moments = Moments::from_values(records.iter().flat_map(|record| record.iter().copied()));
        if moments.n < 2 {
            return Self::NONE;
        }
        if moments.std <= ROUNDING * moments.mean.abs() {
            return Self { mean: moments.mean, std: 0.0, coefficient_of_variation: 0.0, ..Self::NONE };
        }
        Self {
            mean: moments.mean,
            std: moments.std,
            coefficient_of_variation: moments.std / moments.mean,
            correlation_length_m: correlate(records, tracks, step_m).map_or(f64::NAN, |c| c.exponential.length_m),
            ..Self::NONE
        }
    }
}

/// Moments of a level, and of the level without each of its strips.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentReplicates {
    /// Moments of all strips.
    pub all: LevelMoments,
    /// Moments without each of the realisations, in their order; for a strip that failed, the moments of all strips.
    pub without: Vec<LevelMoments>,
}

impl MomentReplicates {
    /// Computes the moments of the quotient F/N of each window.
    pub fn from_quotients(strips: &SolvedStrips, step_m: f64) -> Self {
        Self::by(strips, |records| {
            let series: Vec<&[f64]> = records.iter().map(|record| &record.friction[..]).collect();
            LevelMoments::from_records(&series, strips.tracks, step_m)
        })
    }

    /// Computes the moments of windows at the mean load ([`Record::at_mean_load`]) of the remaining strips.
    pub fn from_mean_load(strips: &SolvedStrips, step_m: f64) -> Self {
        let mut replicates = Self::by(strips, |records| {
            let (mean, records) = Record::at_mean_load(records);
            let series: Vec<&[f64]> = records.iter().map(|record| &record.friction[..]).collect();
            LevelMoments { mean, ..LevelMoments::from_records(&series, strips.tracks, step_m) }
        });
        let stiffnesses = &strips.strip_stiffnesses_pa_per_m;
        let all = Moments::new(stiffnesses).mean;
        replicates.all.stiffness_pa_per_m = all;
        replicates.without.iter_mut().for_each(|without| without.stiffness_pa_per_m = all);
        let solved = (0..replicates.without.len()).filter(|index| strips.failures.iter().all(|f| f.index != *index));
        for (index, own) in solved.zip(stiffnesses) {
            let count = stiffnesses.len() as f64;
            replicates.without[index].stiffness_pa_per_m = (count * all - own) / (count - 1.0);
        }
        replicates
    }

    fn by(strips: &SolvedStrips, moments: impl Fn(&[Record]) -> LevelMoments + Sync + Send) -> Self {
        let (all, tracks) = (moments(&strips.records), strips.tracks.max(1));
        let count = strips.records.len() / tracks + strips.failures.len();
        let without = |strip: usize| {
            if strips.failures.iter().any(|failure| failure.index == strip) {
                return all;
            }
            let failed_before = strips.failures.iter().filter(|failure| failure.index < strip).count();
            let first = (strip - failed_before) * tracks;
            moments(&[&strips.records[..first], &strips.records[first + tracks..]].concat())
        };
        Self { all, without: blocks::map(0..count, without) }
    }
}
