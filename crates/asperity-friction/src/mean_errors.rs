//! Errors of the mean friction coefficient beside the sampling error of the strips.

use asperity_results::ErrorCause;
use serde::{Deserialize, Serialize};

/// Friction of surfaces with waves down to a length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CutOff {
    /// Length of the shortest wave in metre.
    pub shortest_m: f64,
    /// Factor of the mean friction.
    pub mean: f64,
    /// Factor of the standard deviation of friction.
    pub std: f64,
}

/// Errors of the mean friction coefficient that all machines share, as factors of the mean, and its dependence on the shortest waves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeanErrors {
    /// Relative standard error by the sampling of strips.
    pub strips: f64,
    /// Relative standard error of the extrapolation in the pitch, by the sampling of the few strips of half the pitch.
    pub halved_strips: f64,
    /// Relative standard error by the limited scan, from the differences between its parts; 0 without a pressed scan.
    pub scan: f64,
    /// Factor by which the mean was extrapolated in the pitch of the strips ([`Strips`](crate::strip::Strips)).
    pub pitch_factor: f64,
    /// Smallest and largest factor that the pitch of the strips leaves possible.
    pub grid: [f64; 2],
    /// Smallest and largest factor that the difference between random and scanned surface leaves possible.
    pub model: [f64; 2],
    /// 95 % interval of the mean by all errors together, over the mean.
    pub whole: [f64; 2],
    /// Factors of friction for surfaces with shorter waves, from the shortest wave of the strips to the pixel of the scan. Empty if the
    /// scan resolves all waves, and without a scan.
    pub cut_off: Vec<CutOff>,
    /// Why the mean is no answer: the pitch of the strips, or their difference from the scan. Empty where it is one.
    pub unresolved: Vec<ErrorCause>,
}

impl Default for MeanErrors {
    /// Returns the errors of an exact mean.
    fn default() -> Self {
        Self {
            strips: 0.0,
            halved_strips: 0.0,
            scan: 0.0,
            pitch_factor: 1.0,
            grid: [1.0; 2],
            model: [1.0; 2],
            whole: [1.0; 2],
            cut_off: Vec::new(),
            unresolved: Vec::new(),
        }
    }
}

impl MeanErrors {
    /// Returns the causes and factors of the errors of the computation.
    pub fn computational(&self) -> [(ErrorCause, [f64; 2]); 2] {
        [(ErrorCause::Grid, self.grid), (ErrorCause::Model, self.model)]
    }

    /// Returns the factors of friction on a surface whose shortest wave has a length in metre; `None` if it is known.
    pub fn at_cut_off(&self, shortest_m: f64) -> Option<CutOff> {
        let mut pairs = self.cut_off.windows(2);
        let segment = pairs.find(|pair| shortest_m >= pair[1].shortest_m).or(self.cut_off.windows(2).last())?;
        let [long, short] = [segment[0], segment[1]];
        let part = ((shortest_m / short.shortest_m).ln() / (long.shortest_m / short.shortest_m).ln()).clamp(0.0, 1.0);
        let between = |long: f64, short: f64| (part * long.ln() + (1.0 - part) * short.ln()).exp();
        Some(CutOff { shortest_m, mean: between(long.mean, short.mean), std: between(long.std, short.std) })
    }

    /// Returns the smallest and the largest factor over the cut-off.
    pub fn cut_off_range(&self) -> [f64; 2] {
        self.cut_off.iter().fold([1.0; 2], |[low, high], at| [low.min(at.mean), high.max(at.mean)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_linear_in_logarithms_between_the_solved_cut_offs() {
        let at = |shortest_m: f64, mean: f64| CutOff { shortest_m, mean, std: mean * mean };
        let errors = MeanErrors { cut_off: vec![at(8e-6, 1.0), at(4e-6, 0.9), at(2e-6, 0.6)], ..MeanErrors::default() };
        for (length_m, factor) in [
            (1e-6, 0.6),
            (2e-6, 0.6),
            (2e-6 * 2.0_f64.sqrt(), (0.9_f64 * 0.6).sqrt()),
            (4e-6, 0.9),
            (8e-6, 1.0),
            (1e-5, 1.0),
        ] {
            let found = errors.at_cut_off(length_m).unwrap();
            assert!((found.mean / factor - 1.0).abs() < 1e-12, "{length_m}: {found:?}");
            assert!((found.std / (factor * factor) - 1.0).abs() < 1e-12, "{length_m}: {found:?}");
        }
        assert_eq!((errors.cut_off_range(), MeanErrors::default().at_cut_off(1e-6)), ([0.6, 1.0], None));
    }
}
