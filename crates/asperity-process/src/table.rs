//! Tabulated translation of standard normal values.

use asperity_base::distribution::{Marginal, standard_normal_pdf};
use asperity_base::numeric::cubic;

/// Largest |g| of the table. Beyond, where the fraction 1.2e-15 of the values lies, the translation is computed
/// directly.
const REACH: f64 = 8.0;
/// Initial number of intervals per unit of g, doubled until the error is small, at most to [`MAX_DENSITY`].
const FIRST_DENSITY: usize = 32;
const MAX_DENSITY: usize = 1024;
/// Required largest error, in standard deviations.
const WANTED_ERROR: f64 = 1e-10;

/// Map g ↦ (F⁻¹(Φ(g)) − mean)·σ/std.
#[derive(Debug, Clone)]
pub(super) struct TranslationTable {
    marginal: Marginal,
    mean: f64,
    /// Factor σ/std.
    gain: f64,
    route: Route,
}

#[derive(Debug, Clone)]
enum Route {
    /// Direct evaluation: closed forms, and distributions with kinks, which cubics would smooth.
    Direct,
    /// Cubic Hermite interpolation between (value, slope·spacing) at equal distances.
    Cubic { density: f64, nodes: Vec<[f64; 2]> },
}

impl TranslationTable {
    pub(super) fn new(marginal: &Marginal, sigma: f64) -> Self {
        let mut table = Self {
            marginal: marginal.clone(),
            mean: marginal.mean(),
            gain: sigma / marginal.std(),
            route: Route::Direct,
        };
        if matches!(marginal, Marginal::Beta { .. } | Marginal::Weibull { .. } | Marginal::Gamma { .. }) {
            let mut density = FIRST_DENSITY;
            loop {
                let nodes = table.nodes(density);
                let error = table.largest_error(&nodes, density, sigma);
                if error <= WANTED_ERROR || density >= MAX_DENSITY {
                    table.route = Route::Cubic { density: density as f64, nodes };
                    break;
                }
                density *= 2;
            }
        }
        table
    }

    /// Returns m at g.
    #[inline]
    pub(super) fn value(&self, g: f64) -> f64 {
        if let Route::Cubic { density, nodes } = &self.route {
            let position = (g + REACH) * density;
            let index = position as usize;
            if position >= 0.0 && index + 1 < nodes.len() {
                return cubic(nodes[index], nodes[index + 1], position - index as f64);
            }
        }
        self.direct(g)
    }

    /// Returns m at g by direct evaluation.
    pub(super) fn direct(&self, g: f64) -> f64 {
        (self.marginal.translate(g) - self.mean) * self.gain
    }

    /// Returns m at a given probability.
    pub(super) fn at_probability(&self, probability: f64) -> f64 {
        (self.marginal.quantile(probability) - self.mean) * self.gain
    }

    fn nodes(&self, density: usize) -> Vec<[f64; 2]> {
        let spacing = 1.0 / density as f64;
        let count = 2 * REACH as usize * density + 1;
        (0..count)
            .map(|i| {
                let g = i as f64 * spacing - REACH;
                let x = self.marginal.translate(g);
                // dx/dg = φ(g)/f(x).
                let slope = standard_normal_pdf(g) / self.marginal.pdf(x);
                let slope = if slope.is_finite() { slope } else { 0.0 };
                [(x - self.mean) * self.gain, slope * self.gain * spacing]
            })
            .collect()
    }

    /// Returns the largest difference of the interpolation from the direct translation, in units of σ, measured where it is worst.
    fn largest_error(&self, nodes: &[[f64; 2]], density: usize, sigma: f64) -> f64 {
        let midpoint = |i: usize| (i as f64 + 0.5) / density as f64 - REACH;
        let pairs = nodes.windows(2).enumerate();
        pairs.map(|(i, pair)| (cubic(pair[0], pair[1], 0.5) - self.direct(midpoint(i))).abs()).fold(0.0, f64::max)
            / sigma
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_matches_the_direct_translation_within_its_measured_error() {
        for text in ["beta:2.1,5", "beta:0.8,0.9", "weibull:1.5,2", "gamma:1.5,2", "normal", "lognormal:0,0.4"] {
            let marginal: Marginal = text.parse().unwrap();
            let sigma = 0.003;
            let table = TranslationTable::new(&marginal, sigma);
            let error = match &table.route {
                Route::Direct => 0.0,
                Route::Cubic { density, nodes } => table.largest_error(nodes, *density as usize, sigma),
            };
            assert!(error <= 1e-9, "{text}: {error:e}");
            let worst = (0..40_000)
                .map(|i| f64::from(i) * 4.7e-4 - 9.4)
                .map(|g| (table.value(g) - table.direct(g)).abs() / sigma)
                .fold(0.0, f64::max);
            assert!(worst <= 1.1 * error + 1e-14, "{text}: {worst:e} beyond {error:e}");
        }
    }

    #[test]
    fn beta_fluctuations_stay_inside_their_published_support() {
        let table = TranslationTable::new(&"beta:2.1,5".parse().unwrap(), 1.0);
        for (g, probability, wanted) in [(-30.0, 0.0, -1.844), (30.0, 1.0, 4.392)] {
            assert!((table.at_probability(probability) - wanted).abs() < 5e-4);
            assert!((table.value(g) - table.at_probability(probability)).abs() < 1e-9);
        }
    }
}
