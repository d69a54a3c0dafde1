//! Correlation families of records, with or without a sliding window.

/// Windows shorter than this fraction of ℓ are ignored; second differences would be dominated by rounding.
const NO_WINDOW: f64 = 1e-5;

/// Family of the correlation ρ_0(s; ℓ) of a stationary record: a rough and a smooth one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordModel {
    /// Rough: e^{−s/ℓ}.
    Exponential,
    /// Smooth: the Matérn correlation of ν = 5/2, (1 + y + y²/3) e^{−y} with y = √5 s/ℓ.
    Smooth,
}

impl RecordModel {
    /// Both families, the exponential first.
    pub const BOTH: [Self; 2] = [Self::Exponential, Self::Smooth];
    /// Smoothness ν of the smooth family.
    pub const SMOOTHNESS: f64 = 2.5;

    /// Returns the name of the family as in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Exponential => "exponential",
            Self::Smooth => "matern",
        }
    }

    /// Returns ρ_0 at a lag s ≥ 0, for the length ℓ > 0, both in metre.
    pub fn correlation(&self, lag_m: f64, length_m: f64) -> f64 {
        self.scaled(lag_m / length_m)
    }

    /// Returns the integral scale ∫₀^∞ ρ_0 ds in metre, the common measure of length of both families.
    pub fn integral_scale_m(&self, length_m: f64) -> f64 {
        self.integral() * length_m
    }

    /// Returns ρ_0 at r = s/ℓ.
    fn scaled(&self, r: f64) -> f64 {
        match self {
            Self::Exponential => (-r).exp(),
            Self::Smooth => {
                let y = 5.0_f64.sqrt() * r;
                (1.0 + y + y * y / 3.0) * (-y).exp()
            }
        }
    }

    /// Returns ∫₀^∞ ρ_0 dr.
    fn integral(&self) -> f64 {
        match self {
            Self::Exponential => 1.0,
            Self::Smooth => 8.0 / (3.0 * 5.0_f64.sqrt()),
        }
    }

    /// Returns T(x) = ∫_x^∞ (u − x) ρ_0(u) du.
    fn tail(&self, x: f64) -> f64 {
        match self {
            Self::Exponential => (-x).exp(),
            Self::Smooth => {
                let y = 5.0_f64.sqrt() * x;
                (1.0 + 7.0 / 15.0 * y + y * y / 15.0) * (-y).exp()
            }
        }
    }
}

/// Correlation under a sliding window W: triangle_W ⊛ ρ_0, the covariance of the moving average over W of a process of
/// unit variance.
///
/// With a = W/ℓ, t = |s|/ℓ and the twice integrated tail T(x) = ∫_x^∞ (u − x) ρ_0(u) du it is
///
/// > [2 max(0, a − t) ∫₀^∞ρ_0 du + T(t + a) + T(|t − a|) − 2 T(t)]/a².
///
/// A length that the window does not resolve has the limit ℓ = 0, the triangle of the window.
///
/// A window of few cells is a mean of n values at distance Δ rather than an integral over W
/// ([`WindowedModel::with_cells`]); its power transfer is sin²(πfnΔ)/(n sin(πfΔ))² at the frequency f instead of
/// sinc²(fW). The covariance at a lag of whole cells is then Σ_{|k| < n} (n − |k|)/n² ρ_0(s + kΔ): three terms as above with
/// sums for integrals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowedModel {
    model: RecordModel,
    window_m: f64,
    /// Cell in metre; 0 if the window is an integral.
    cell_m: f64,
}

impl WindowedModel {
    /// Creates a model under a window W ≥ 0 in metre; 0 for none.
    ///
    /// # Panics
    /// If the window is negative or infinite.
    pub fn new(model: RecordModel, window_m: f64) -> Self {
        assert!(window_m >= 0.0 && window_m.is_finite(), "window {window_m} m");
        Self { model, window_m, cell_m: 0.0 }
    }

    /// Returns the model with windows that average values at distance `cell_m`; 0 for integrals. Lags are then rounded
    /// to whole cells.
    ///
    /// # Panics
    /// If the cell is negative or infinite.
    #[must_use]
    pub fn with_cells(self, cell_m: f64) -> Self {
        assert!(cell_m >= 0.0 && cell_m.is_finite(), "cell {cell_m} m");
        Self { cell_m, ..self }
    }

    /// Returns the window W in metre.
    pub fn window_m(&self) -> f64 {
        self.window_m
    }

    /// Returns the correlation at a lag for the length ℓ ≥ 0, both in metre. For ℓ = 0 it is the triangle of the
    /// window, or zero without a window.
    pub fn correlation(&self, lag_m: f64, length_m: f64) -> f64 {
        let lag_m = lag_m.abs();
        if length_m <= 1e-9 * self.window_m || length_m == 0.0 {
            let alone =
                if self.window_m > 0.0 { 1.0 - lag_m / self.window_m } else { f64::from(u8::from(lag_m == 0.0)) };
            return alone.max(0.0);
        }
        self.covariance(lag_m, length_m) / self.covariance(0.0, length_m)
    }

    /// Returns the covariance under the window at a lag for ℓ > 0, both in metre, for unit variance of the process. At
    /// lag 0 it is the fraction of the variance that the window transmits.
    pub fn covariance(&self, lag_m: f64, length_m: f64) -> f64 {
        if self.cell_m > 0.0 && self.window_m > 0.0 {
            let cells = (self.window_m / self.cell_m).round().max(1.0);
            return self.mean_of_cells((lag_m.abs() / self.cell_m).round(), cells, self.cell_m / length_m);
        }
        let (a, t) = (self.window_m / length_m, lag_m.abs() / length_m);
        if a < NO_WINDOW {
            return self.model.scaled(t);
        }
        let (kink, tail) = (2.0 * self.model.integral() * (a - t).max(0.0), |x: f64| self.model.tail(x));
        (kink + tail(t + a) + tail((t - a).abs()) - 2.0 * tail(t)) / (a * a)
    }

    /// Returns the covariance of two means of n values at steps of δ lengths, t steps apart.
    ///
    /// ρ_0 at u steps is (1 + au + bu²)φ^u. With the sums s_m = Σ_{j > 0} j^m φ^j it has T(x) = Σ_{u > x} (u − x) ρ_0(u) =
    /// φ^x [(1 + ax + bx²)s_1 + (a + 2bx)s_2 + bs_3] and, over all u, Σ ρ_0 = 1 + 2(s_0 + as_1 + bs_2).
    fn mean_of_cells(&self, t: f64, n: f64, step: f64) -> f64 {
        if n * step < NO_WINDOW {
            return self.model.scaled(t * step);
        }
        let (rate, a, b) = match self.model {
            RecordModel::Exponential => (step, 0.0, 0.0),
            RecordModel::Smooth => (5.0_f64.sqrt() * step, 5.0_f64.sqrt() * step, 5.0 / 3.0 * step * step),
        };
        let (phi, rest) = ((-rate).exp(), -(-rate).exp_m1());
        let s = [
            phi / rest,
            phi / rest.powi(2),
            phi * (1.0 + phi) / rest.powi(3),
            phi * (1.0 + phi * (4.0 + phi)) / rest.powi(4),
        ];
        let tail = |x: f64| (-x * rate).exp() * ((1.0 + x * (a + b * x)) * s[1] + (a + 2.0 * b * x) * s[2] + b * s[3]);
        let kink = (n - t).max(0.0) * (1.0 + 2.0 * (s[0] + a * s[1] + b * s[2]));
        (kink + tail(t + n) + tail((t - n).abs()) - 2.0 * tail(t)) / (n * n)
    }
}

/// Returns the correlation of the moving average over a window W of a process with correlation e^{−|s|/ℓ}: triangle_W ⊛
/// e^{−|s|/ℓ}, normalised to 1 at s = 0. For ℓ = 0 it is the triangle of the window, for W = 0 the exponential.
///
/// # Panics
/// If a length is negative, or both are zero.
pub fn windowed_exponential(lag_m: f64, window_m: f64, length_m: f64) -> f64 {
    assert!(
        window_m >= 0.0 && length_m >= 0.0 && window_m + length_m > 0.0,
        "window {window_m} m, length {length_m} m"
    );
    WindowedModel::new(RecordModel::Exponential, window_m).correlation(lag_m, length_m)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::correlation::CorrelationModel;

    const MODELS: [RecordModel; 2] = RecordModel::BOTH;

    /// Returns ∫ of (1 − |u|) ρ_0(s + uW) du over (−1, 1) by the midpoint rule with `n` cells of a variable that
    /// refines the kinks.
    fn direct(model: RecordModel, lag: f64, window: f64, length: f64) -> f64 {
        let mut kinks = vec![-1.0, 0.0, 1.0];
        for kink in [-lag / window, (length - lag) / window, (-length - lag) / window] {
            if kink > -1.0 && kink < 1.0 {
                kinks.push(kink);
            }
        }
        kinks.sort_by(f64::total_cmp);
        let n = 4000_i32;
        let mut sum = 0.0;
        for pair in kinks.windows(2) {
            let (low, width) = (pair[0], pair[1] - pair[0]);
            for i in 0..n {
                // x = v³(10 − 15v + 6v²) concentrates points at both ends, where the exponential has its cusp.
                let v = (f64::from(i) + 0.5) / f64::from(n);
                let (x, slope) = (v.powi(3) * (10.0 - 15.0 * v + 6.0 * v * v), 30.0 * (v * (1.0 - v)).powi(2));
                let u = low + width * x;
                sum += width * slope / f64::from(n)
                    * (1.0 - u.abs())
                    * model.correlation((lag + u * window).abs(), length);
            }
        }
        sum
    }

    #[test]
    fn models_under_a_window_are_the_average_over_the_window() {
        for model in MODELS {
            for (window, length) in [(600.0, 250.0), (600.0, 2000.0), (75.0, 250.0), (600.0, 60.0)] {
                let windowed = WindowedModel::new(model, window);
                for lag in [0.0, 20.0, 74.0, 300.0, 599.0, 601.0, 1500.0] {
                    let error = (windowed.covariance(lag, length) - direct(model, lag, window, length)).abs();
                    assert!(error < 2e-8, "{model:?} W {window} ℓ {length} lag {lag}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn windows_of_cells_equal_double_sums_and_the_discrete_transform() {
        for model in MODELS {
            for (cells, cell, length) in [(1_i32, 10.0, 250.0), (4, 10.0, 250.0), (4, 10.0, 3.0), (16, 5.0, 1000.0)] {
                let windowed = WindowedModel::new(model, f64::from(cells) * cell).with_cells(cell);
                for lag in [0, 1, 3, 4, 5, 40] {
                    let mut sum = 0.0;
                    for i in 0..cells {
                        for j in 0..cells {
                            sum += model.correlation(f64::from((lag + i - j).abs()) * cell, length);
                        }
                    }
                    let wanted = sum / f64::from(cells * cells);
                    let found = windowed.covariance(f64::from(lag) * cell, length);
                    assert!((found - wanted).abs() < 1e-11, "{model:?} {cells} ℓ {length} lag {lag}: {found} {wanted}");
                }
                assert_eq!(windowed.correlation(cell, 0.0), 1.0 - 1.0 / f64::from(cells));
            }
        }
        // Power at a frequency of the exponential on cells, (1 − φ²)/(1 − 2φ cos + φ²), times sin²(πfn)/(n sin(πf))².
        let (cells, length) = (4.0_f64, 25.0_f64);
        let windowed = WindowedModel::new(RecordModel::Exponential, cells).with_cells(1.0);
        let phi = (-1.0 / length).exp();
        for frequency in [0.003, 0.05, 0.125, 0.21] {
            let phase = 2.0 * PI * frequency;
            let lags = (1..2000_i32)
                .map(|lag| 2.0 * windowed.covariance(f64::from(lag), length) * (f64::from(lag) * phase).cos());
            let found = windowed.covariance(0.0, length) + lags.sum::<f64>();
            let passes = ((0.5 * cells * phase).sin() / (cells * (0.5 * phase).sin())).powi(2);
            let wanted = passes * (1.0 - phi * phi) / (1.0 - 2.0 * phi * phase.cos() + phi * phi);
            assert!((found / wanted - 1.0).abs() < 1e-9, "{frequency}: {found} {wanted}");
        }
    }

    #[test]
    fn windows_of_many_cells_are_integrals() {
        // The trapezoidal rule has the error Δ²/12 of the correlation: the test resolves its second order.
        for model in MODELS {
            let error = |cells: f64| {
                let windowed = WindowedModel::new(model, 600.0);
                (windowed.with_cells(600.0 / cells).covariance(0.0, 250.0) - windowed.covariance(0.0, 250.0)).abs()
            };
            let (coarse, fine) = (error(16.0), error(64.0));
            assert!(fine < 1e-3 && (coarse / fine / 16.0 - 1.0).abs() < 0.05, "{model:?}: {coarse:e} {fine:e}");
        }
    }

    #[test]
    fn the_window_limits_are_the_triangle_and_the_model() {
        for model in MODELS {
            for s in [0.0_f64, 0.3, 0.99, 1.7] {
                let windowed = WindowedModel::new(model, 1.0);
                assert!((windowed.correlation(s, 1e-7) - (1.0 - s).max(0.0)).abs() < 1e-6, "{model:?} {s}");
                assert_eq!(windowed.correlation(s, 0.0), (1.0 - s).max(0.0));
                // With the cusp of the exponential the effect of a window W decreases as W.
                for (window, error) in [(1e-4, 1e-4), (1e-6, 1e-9)] {
                    let found = WindowedModel::new(model, window).correlation(s, 1.0);
                    assert!((found - model.scaled(s)).abs() < error, "{model:?} {s} {window}");
                }
            }
        }
        // Its variance is the published factor 2ℓ/W[1 − (ℓ/W)(1 − e^{−W/ℓ})] = .51761 for W = 600, ℓ = 250.
        let factor = WindowedModel::new(RecordModel::Exponential, 600.0).covariance(0.0, 250.0);
        assert!((factor - 0.51761).abs() < 5e-6);
    }

    #[test]
    fn the_triangle_of_a_window_falls_to_one_over_e_at_its_known_fraction() {
        let at = 600.0 * (1.0 - (-1.0_f64).exp());
        assert!((at / 600.0 - 0.632_12).abs() < 1e-5);
        let windowed = WindowedModel::new(RecordModel::Exponential, 600.0);
        assert!((windowed.correlation(at, 0.0) - (-1.0_f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn the_smooth_family_is_the_matern_correlation() {
        let matern = CorrelationModel::Matern { nu: RecordModel::SMOOTHNESS };
        for r in [0.0, 1e-3, 0.4, 1.0, 3.0, 12.0] {
            assert!((RecordModel::Smooth.correlation(r, 1.0) - matern.correlation(r)).abs() < 1e-13, "{r}");
        }
    }

    #[test]
    fn integral_scales_are_the_integrals() {
        for model in MODELS {
            let n = 200_000_i32;
            let sum: f64 = (0..n).map(|i| model.scaled((f64::from(i) + 0.5) * 1e-3 * 0.5)).sum::<f64>() * 0.5e-3;
            // The midpoint rule has an error of about h²/12.
            assert!((sum - model.integral_scale_m(1.0)).abs() < 1e-5, "{model:?}");
        }
    }
}
