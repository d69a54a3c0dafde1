//! Correlation of translated normal variables, and its inverse.
//!
//! With x = F⁻¹(Φ(g)) = Σ c_n h_n(g) and the orthonormal Hermite polynomials h_n, translation maps the correlation ρ_G
//! of two standard normal variables to ρ_X = Σ_{n≥1} s_n ρ_Gⁿ with the fractions s_n = c_n²/σ² ≥ 0 of the variance.
//!
//! # References
//! Lancaster, *Biometrika* **44** (1957) 289, <https://doi.org/10.1093/biomet/44.1-2.289>; Grigoriu, *Applied
//! Non-Gaussian Processes*, Prentice Hall 1995, ch. 3.

use super::{DistributionError, Marginal, standard_normal_pdf};

/// Highest order of the Hermite series.
const ORDER: usize = 120;
/// Half width and step of the trapezoidal rule over g; beyond ±20 the tails of x² φ are negligible for every lognormal
/// σ up to 6.
const REACH: i32 = 20 * STEPS_PER_UNIT;
const STEPS_PER_UNIT: i32 = 64;
/// Nodes that are computed at once.
const LANES: usize = 8;
/// Tail of the series below which it is rounding error.
const NEGLIGIBLE: f64 = 1e-15;

/// Correlation of variables of one distribution that are translated standard normal variables.
#[derive(Debug, Clone, PartialEq)]
pub struct Translation {
    marginal: &'static str,
    /// s_1, s_2, …, s_ORDER and last the remainder of the variance, so that the sum is one.
    fractions: Vec<f64>,
    /// The fractions without a negligible tail, which is added to the last of them.
    summed: Vec<f64>,
}

impl Translation {
    /// Computes the expansion for a distribution.
    ///
    /// The coefficients are integrals over g by the trapezoidal rule, which converges faster than any power for smooth
    /// translations; the kinks of an empirical distribution leave an error of order h², 2e-4 of its steps.
    ///
    /// # Errors
    /// Parameters of the distribution out of range.
    pub fn new(marginal: &Marginal) -> Result<Self, DistributionError> {
        marginal.check()?;
        let (mean, std) = (marginal.mean(), marginal.std());
        let step = 1.0 / f64::from(STEPS_PER_UNIT);
        let mut coefficients = vec![0.0; ORDER + 1];
        let roots: Vec<f64> = (0..=ORDER + 1).map(|n| (n as f64).sqrt()).collect();
        let nodes: Vec<i32> = (-REACH..=REACH).collect();
        // The recurrences of several nodes at once hide their latency; the terms are added in the order of the nodes.
        for nodes in nodes.chunks(LANES) {
            let (mut g, mut weighted, mut before, mut here) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for (lane, node) in nodes.iter().enumerate() {
                g[lane] = f64::from(*node) * step;
                here[lane] = standard_normal_pdf(g[lane]).sqrt();
                weighted[lane] = step * here[lane] * (marginal.translate(g[lane]) - mean) / std;
            }
            // h_{n+1} = (g h_n − √n h_{n−1})/√(n+1), times √φ so that high orders stay bounded.
            for (coefficient, root) in coefficients.iter_mut().zip(roots.windows(2)) {
                for lane in 0..LANES {
                    *coefficient += weighted[lane] * here[lane];
                    let next = (g[lane] * here[lane] - root[0] * before[lane]) / root[1];
                    (before[lane], here[lane]) = (here[lane], next);
                }
            }
        }
        let mut fractions: Vec<f64> = coefficients[1..].iter().map(|c| c * c).collect();
        // Quadrature errors may make the sum exceed the variance; correlations are at most one.
        let excess = fractions.iter().sum::<f64>().max(1.0);
        fractions.iter_mut().for_each(|fraction| *fraction /= excess);
        let rest = 1.0 - fractions.iter().sum::<f64>();
        fractions.push(rest.max(0.0));
        let mut summed = fractions.clone();
        while let [.., before, last] = &mut summed[..]
            && *last < NEGLIGIBLE
        {
            *before += *last;
            summed.pop();
        }
        Ok(Self { marginal: marginal.name(), fractions, summed })
    }

    /// Returns the correlation ρ_X of translated variables whose normal variables have the correlation ρ_G.
    ///
    /// # Panics
    /// If ρ_G lies outside [−1, 1].
    pub fn correlation(&self, normal_correlation: f64) -> f64 {
        assert!(normal_correlation.abs() <= 1.0, "a correlation of {normal_correlation} is none");
        self.summed.iter().rev().fold(0.0, |sum, fraction| (sum + fraction) * normal_correlation)
    }

    /// Returns the least correlation of two variables of this distribution under translation, ρ_X at ρ_G = −1.
    pub fn least_correlation(&self) -> f64 {
        self.correlation(-1.0)
    }

    /// Returns the normal correlation ρ_G that translates to ρ_X.
    ///
    /// ρ_X increases with ρ_G because x increases with g, so the root is unique; it is found by Newton's method within
    /// a bracket.
    ///
    /// # Errors
    /// [`DistributionError::Correlation`] for a target that is not a correlation or is below
    /// [`Translation::least_correlation`].
    pub fn normal_correlation(&self, target: f64) -> Result<f64, DistributionError> {
        let least = self.least_correlation();
        if !(least..=1.0).contains(&target) {
            return Err(DistributionError::Correlation { distribution: self.marginal, target, least });
        }
        let (mut low, mut high) = (-1.0, 1.0);
        let mut rho = target;
        for _ in 0..200 {
            let excess = self.correlation(rho) - target;
            if excess == 0.0 {
                break;
            }
            if excess < 0.0 {
                low = rho;
            } else {
                high = rho;
            }
            let newton = rho - excess / self.slope(rho);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - rho).abs() <= f64::EPSILON {
                break;
            }
            rho = next;
        }
        Ok(rho)
    }

    /// Returns the slope dρ_X/dρ_G at ρ_G.
    pub fn slope(&self, rho: f64) -> f64 {
        self.summed.iter().enumerate().rev().fold(0.0, |sum, (i, fraction)| sum * rho + fraction * (i as f64 + 1.0))
    }

    /// Computes [`Translation::correlation`] and [`Translation::slope`] at many normal correlations, bitwise equal.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn correlations(&self, normal: &[f64], correlations: &mut [f64], slopes: &mut [f64]) {
        /// Number of sums computed in parallel, since each term depends on the previous one.
        const LANES: usize = 8;

        assert!(normal.len() == correlations.len() && normal.len() == slopes.len(), "one of each at every lag");
        let outputs = correlations.chunks_mut(LANES).zip(slopes.chunks_mut(LANES));
        for (normal, (correlations, slopes)) in normal.chunks(LANES).zip(outputs) {
            let mut rho = [0.0; LANES];
            rho[..normal.len()].copy_from_slice(normal);
            let (mut sums, mut rises) = ([0.0; LANES], [0.0; LANES]);
            for (i, fraction) in self.summed.iter().enumerate().rev() {
                let rise = fraction * (i as f64 + 1.0);
                for lane in 0..LANES {
                    sums[lane] = (sums[lane] + fraction) * rho[lane];
                    rises[lane] = rises[lane] * rho[lane] + rise;
                }
            }
            correlations.copy_from_slice(&sums[..normal.len()]);
            slopes.copy_from_slice(&rises[..normal.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use crate::stats::Moments;

    fn translation(text: &str) -> Translation {
        Translation::new(&text.parse().unwrap()).unwrap()
    }

    #[test]
    fn many_correlations_are_the_single_ones() {
        let translation = translation("beta:2.1,5");
        let normal: Vec<f64> = (0..=20).map(|i| -1.0 + 0.1 * f64::from(i)).map(|rho| rho.min(1.0)).collect();
        let (mut correlations, mut slopes) = (vec![0.0; 21], vec![0.0; 21]);
        translation.correlations(&normal, &mut correlations, &mut slopes);
        for (place, &rho) in normal.iter().enumerate() {
            assert_eq!(correlations[place].to_bits(), translation.correlation(rho).to_bits());
            assert_eq!(slopes[place].to_bits(), translation.slope(rho).to_bits());
        }
    }

    #[test]
    fn the_friction_distribution_of_the_paper_needs_these_normal_correlations() {
        let friction = translation("beta:2.1,5");
        for (target, wanted) in
            [((-1.0_f64).exp(), 0.375_013_83), ((-0.1_f64).exp(), 0.907_643_18), ((-2.0_f64).exp(), 0.138_828_91)]
        {
            let rho = friction.normal_correlation(target).unwrap();
            assert!((rho - wanted).abs() < 1e-8, "ρ_G for {target}: {rho}");
            assert!((friction.correlation(rho) - target).abs() < 1e-14);
        }
        assert!((friction.least_correlation() + 0.951_586_25).abs() < 1e-8, "{}", friction.least_correlation());
        assert!(friction.fractions[ORDER] < 1e-12);
        let error = friction.normal_correlation(-0.99).unwrap_err();
        assert!(matches!(error, DistributionError::Correlation { least, .. } if (least + 0.9516).abs() < 1e-4));
    }

    #[test]
    fn translated_exponential_variables_have_the_correlation_of_the_double_integral() {
        // E[−ln Φ(−g)·−ln Φ(−h)] − 1 by adaptive quadrature in another program.
        let exponential = translation("weibull:1,1");
        for (rho, wanted) in [
            (-0.5, -0.3643625571398277),
            (0.2, 0.17030240128819496),
            (0.5, 0.4530750202060876),
            (0.8, 0.7696275735133434),
            (0.95, 0.9409318593089159),
        ] {
            assert!((exponential.correlation(rho) - wanted).abs() < 1e-10, "{rho}: {}", exponential.correlation(rho));
        }
        // E ln U ln(1 − U) = 2 − π²/6, so the least correlation is 1 − π²/6.
        let least = 1.0 - std::f64::consts::PI.powi(2) / 6.0;
        assert!((exponential.least_correlation() - least).abs() < 1e-10);
    }

    #[test]
    fn normal_lognormal_and_uniform_distributions_have_closed_forms() {
        let (normal, lognormal, uniform) =
            (translation("normal:3,2"), translation("lognormal:-1,0.8,2"), translation("beta:1,1,-3,5"));
        for rho in [-1.0_f64, -0.6, 0.0, 0.3, 0.9, 1.0] {
            assert!((normal.correlation(rho) - rho).abs() < 1e-13);
            let closed = (0.64 * rho).exp_m1() / 0.64_f64.exp_m1();
            assert!((lognormal.correlation(rho) - closed).abs() < 1e-12, "{rho}");
            let closed = 6.0 / std::f64::consts::PI * (0.5 * rho).asin();
            assert!((uniform.correlation(rho) - closed).abs() < 1e-12, "{rho}: {}", uniform.correlation(rho) - closed);
        }
    }

    #[test]
    fn the_inverse_meets_every_reachable_correlation() {
        for text in ["beta:0.4,0.3", "lognormal:0,1.5", "weibull:0.7,1", "normal"] {
            let translation = translation(text);
            for fraction in [0.0, 0.1, 0.4, 0.7, 0.999, 1.0] {
                let target = translation.least_correlation() * (1.0 - fraction) + fraction;
                let rho = translation.normal_correlation(target).unwrap();
                assert!((translation.correlation(rho) - target).abs() < 1e-13, "{text} at {target}");
            }
        }
    }

    #[test]
    fn an_empirical_distribution_correlates_as_its_simulated_pairs() {
        let values = random::standard_normal(&mut random::stream(4, "translation", 0), 400);
        let marginal = Marginal::empirical(values.iter().map(|g| g.exp()).collect()).unwrap();
        let translation = Translation::new(&marginal).unwrap();
        let (mean, std) = (marginal.mean(), marginal.std());
        let (rho, n) = (0.7_f64, 200_000);
        let mut stream = random::stream(4, "translation", 1);
        let products: Vec<f64> = (0..n)
            .map(|_| {
                let pair = random::standard_normal(&mut stream, 2);
                let (g, h) = (pair[0], rho * pair[0] + (1.0 - rho * rho).sqrt() * pair[1]);
                (marginal.translate(g) - mean) * (marginal.translate(h) - mean) / std.powi(2)
            })
            .collect();
        let simulated = Moments::new(&products);
        let error = (simulated.mean - translation.correlation(rho)).abs();
        assert!(error < 4.0 * simulated.standard_error(), "{error} with standard error {}", simulated.standard_error());
    }
}
