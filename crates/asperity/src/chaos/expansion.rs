//! Functions of a germ as sums of orthonormal polynomials.

use rayon::prelude::*;

use super::{Basis, Fit, LeastSquares, RegressionError};

/// f(ξ) = Σ_α c_α Ψ_α(ξ) with orthonormal Ψ_α.
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    basis: Basis,
    coefficients: Vec<f64>,
}

impl Expansion {
    /// An expansion with given coefficients, in the order of the basis.
    ///
    /// # Panics
    /// If the numbers of coefficients and functions differ.
    pub fn new(basis: Basis, coefficients: Vec<f64>) -> Self {
        assert_eq!(basis.len(), coefficients.len(), "coefficients of another basis");
        Self { basis, coefficients }
    }

    /// The least-squares expansion of the values `response` at `germs`, and its fit.
    ///
    /// # Errors
    /// As [`LeastSquares::new`] and [`LeastSquares::fit`].
    pub fn fit<G: AsRef<[f64]>>(basis: Basis, germs: &[G], response: &[f64]) -> Result<(Self, Fit), RegressionError> {
        if germs.len() <= basis.len() {
            return Err(RegressionError::TooFewSamples { samples: germs.len(), coefficients: basis.len() });
        }
        let fit = LeastSquares::new(basis.design_matrix(germs).view())?.fit(response)?;
        Ok((Self::new(basis, fit.coefficients.clone()), fit))
    }

    /// The basis.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Coefficients in the order of the basis.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// f(ξ); germ values beyond the variables of the basis are ignored.
    pub fn evaluate(&self, germ: &[f64]) -> f64 {
        self.evaluate_with(germ, &mut Vec::new(), &mut vec![0.0; self.basis.len()])
    }

    /// f at each germ, in order.
    pub fn evaluate_many<G: AsRef<[f64]> + Sync>(&self, germs: &[G]) -> Vec<f64> {
        germs
            .par_iter()
            .map_init(
                || (Vec::new(), vec![0.0; self.basis.len()]),
                |(univariate, values), germ| self.evaluate_with(germ.as_ref(), univariate, values),
            )
            .collect()
    }

    fn evaluate_with(&self, germ: &[f64], univariate: &mut Vec<f64>, values: &mut [f64]) -> f64 {
        self.basis.fill(germ, univariate, values);
        values.iter().zip(&self.coefficients).map(|(psi, c)| psi * c).sum()
    }

    /// E f = c₀.
    pub fn mean(&self) -> f64 {
        self.coefficients[0]
    }

    /// Var f = Σ_{α≠0} c_α².
    pub fn variance(&self) -> f64 {
        self.coefficients[1..].iter().map(|c| c * c).sum()
    }

    /// First-order Sobol' index of each variable: the variance share of the terms in that variable alone. NaN when the
    /// variance is zero.
    ///
    /// # References
    /// Sudret, *Reliab. Eng. Syst. Saf.* **93** (2008) 964, <https://doi.org/10.1016/j.ress.2007.04.002>.
    pub fn first_order_indices(&self) -> Vec<f64> {
        (0..self.basis.set().variables()).map(|variable| self.subset_index(&[variable])).collect()
    }

    /// Total Sobol' index of each variable: the variance share of all terms that hold it. NaN when the variance is zero.
    pub fn total_indices(&self) -> Vec<f64> {
        (0..self.basis.set().variables()).map(|variable| self.share(|alpha| alpha[variable] > 0)).collect()
    }

    /// Variance share of the terms that hold exactly the variables of `subset`. NaN when the variance is zero.
    pub fn subset_index(&self, subset: &[usize]) -> f64 {
        self.share(|alpha| alpha.iter().enumerate().all(|(i, &degree)| (degree > 0) == subset.contains(&i)))
    }

    fn share(&self, belongs: impl Fn(&[u16]) -> bool) -> f64 {
        let part: f64 = self
            .basis
            .set()
            .iter()
            .zip(&self.coefficients)
            .skip(1)
            .filter(|(alpha, _)| belongs(alpha))
            .map(|(_, c)| c * c)
            .sum();
        part / self.variance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chaos::{Design, Family, MultiIndexSet, SamplingMethod};
    use std::f64::consts::PI;

    /// The expansion of f over a Sobol' design, f a function of the standard variables.
    fn expand(families: &[Family], degree: usize, samples: usize, f: impl Fn(&[f64]) -> f64) -> (Expansion, Fit) {
        let set = MultiIndexSet::total_degree(families.len(), degree).unwrap();
        let basis = Basis::new(set, families.to_vec()).unwrap();
        let design = Design::new(SamplingMethod::Sobol, 3, "expansion", samples, families.len()).unwrap();
        let germs: Vec<Vec<f64>> = (0..samples)
            .map(|i| design.unit(i).iter().zip(families).map(|(u, family)| family.from_unit(*u)).collect())
            .collect();
        let response: Vec<f64> = germs.iter().map(|xi| f(xi)).collect();
        Expansion::fit(basis, &germs, &response).unwrap()
    }

    #[test]
    fn a_polynomial_is_recovered_with_its_moments_and_indices() {
        // f = 2 + ξ₁ + 3 ξ₁ ξ₂ + (ξ₂² − 1): variance 1 + 9 + 2.
        let (expansion, _) =
            expand(&[Family::Hermite; 2], 3, 64, |x| 2.0 + x[0] + 3.0 * x[0] * x[1] + x[1] * x[1] - 1.0);
        assert!((expansion.mean() - 2.0).abs() < 1e-12);
        assert!((expansion.variance() - 12.0).abs() < 1e-11);
        let first = expansion.first_order_indices();
        let total = expansion.total_indices();
        for (found, wanted) in [(first[0], 1.0), (first[1], 2.0), (total[0], 10.0), (total[1], 11.0)] {
            assert!((found - wanted / 12.0).abs() < 1e-12);
        }
        assert!((expansion.evaluate(&[0.5, -1.5]) - (2.0 + 0.5 - 2.25 + 1.25)).abs() < 1e-12);
    }

    #[test]
    fn many_germs_give_what_each_gives_alone() {
        let (expansion, _) = expand(&[Family::Hermite; 3], 3, 80, |x| (x[0] + 0.3 * x[1]).sin() + x[2]);
        let germs: Vec<[f64; 3]> = (0..50).map(|i| [0.1 * f64::from(i), -0.03 * f64::from(i), 0.5]).collect();
        let alone: Vec<f64> = germs.iter().map(|g| expansion.evaluate(g)).collect();
        assert_eq!(expansion.evaluate_many(&germs), alone);
    }

    #[test]
    fn the_exponential_of_a_normal_variable_has_its_closed_coefficients() {
        let sigma = 0.5_f64;
        let (expansion, _) = expand(&[Family::Hermite], 12, 2048, |x| (sigma * x[0]).exp());
        // Orthonormal: c_n = e^{σ²/2} σⁿ/√n!. The first coefficient left out, c₁₃ = 1.8e-9, bounds the aliasing.
        let mut closed = (0.5 * sigma * sigma).exp();
        for n in 0..=6 {
            assert!((expansion.coefficients()[n] - closed).abs() < 1e-8, "c_{n}");
            closed *= sigma / ((n + 1) as f64).sqrt();
        }
    }

    #[test]
    fn ishigami_has_its_published_indices() {
        let (a, b) = (7.0, 0.1);
        let (expansion, fit) = expand(&[Family::Legendre; 3], 12, 1024, |x| {
            let [x1, x2, x3] = [x[0], x[1], x[2]].map(|x| PI * x);
            x1.sin() + a * x2.sin().powi(2) + b * x3.powi(4) * x1.sin()
        });
        // The least smooth part, 7 sin² πx = 3.5 − 3.5 cos 2πx, leaves a variance share of 2e-5 beyond degree 12.
        assert!(fit.leave_one_out.relative_error.unwrap() < 1e-3);
        assert!((expansion.variance() / 13.844_587_940_719_254 - 1.0).abs() < 1e-3, "{}", expansion.variance());
        let first = expansion.first_order_indices();
        assert!((first[0] - 0.313_905_19).abs() < 1e-3, "{first:?}");
        assert!((first[1] - 0.442_411_14).abs() < 1e-3, "{first:?}");
        assert!(first[2] < 1e-4);
        assert!((expansion.subset_index(&[0, 2]) - 0.243_683_66).abs() < 1e-3);
    }

    #[test]
    fn the_borehole_has_its_published_moments_and_indices() {
        let mut families = [Family::Legendre; 8];
        families[0] = Family::Hermite;
        families[1] = Family::Hermite;
        let (expansion, _) = expand(&families, 4, 1500, |x| {
            let between = |x: f64, low: f64, high: f64| low + (high - low) * (x + 1.0) / 2.0;
            let rw = 0.10 + 0.016_181_2 * x[0];
            let log_ratio = (7.71 + 1.0056 * x[1]) - rw.ln();
            let (tu, hu) = (between(x[2], 63_070.0, 115_600.0), between(x[3], 990.0, 1110.0));
            let (tl, hl) = (between(x[4], 63.1, 116.0), between(x[5], 700.0, 820.0));
            let (l, kw) = (between(x[6], 1120.0, 1680.0), between(x[7], 9855.0, 12_045.0));
            2.0 * PI * tu * (hu - hl) / (log_ratio * (1.0 + 2.0 * l * tu / (log_ratio * rw * rw * kw) + tu / tl))
        });
        assert!((expansion.mean() / 73.7389 - 1.0).abs() < 5e-4, "mean {}", expansion.mean());
        assert!((expansion.variance() / 817.69 - 1.0).abs() < 2e-3, "variance {}", expansion.variance());
        let first = [0.6637, 0.0, 0.0, 0.0949, 1e-5, 0.0949, 0.0907, 0.0219];
        let total = [0.6942, 0.0, 0.0, 0.1061, 1e-5, 0.1062, 0.1028, 0.0251];
        for (found, wanted) in expansion.first_order_indices().iter().zip(first) {
            assert!((found - wanted).abs() < 5e-4, "first {:?}", expansion.first_order_indices());
        }
        for (found, wanted) in expansion.total_indices().iter().zip(total) {
            assert!((found - wanted).abs() < 5e-4, "total {:?}", expansion.total_indices());
        }
    }

    #[test]
    fn the_sobol_g_function_comes_within_its_known_truncation() {
        // Degree 6 keeps 5/64 + 1/256 + 13/128² of the variance 1/12 of |x|, 99.4 %, and of products less; the variables
        // with a = 99 hold a share of 3e-4 and are left out.
        let a = [0.0, 1.0, 4.5, 9.0];
        let (expansion, _) = expand(&[Family::Legendre; 4], 6, 2000, |x| {
            x.iter().zip(a).map(|(x, a)| ((2.0 * x).abs() + a) / (1.0 + a)).product()
        });
        let published = [0.716_192_169, 0.179_048_042, 0.023_675_774_2, 0.007_161_921_69];
        for (found, wanted) in expansion.first_order_indices().iter().zip(published) {
            assert!((found - wanted).abs() < 0.01, "{:?}", expansion.first_order_indices());
        }
        assert!((expansion.variance() / 0.465_424_431_902_206_7 - 1.0).abs() < 0.03, "{}", expansion.variance());
    }

    #[test]
    fn fewer_samples_than_coefficients_are_refused() {
        let basis = Basis::hermite(8, 3).unwrap();
        let germs = vec![vec![0.0; 8]; 165];
        let error = Expansion::fit(basis, &germs, &[0.0; 165]).unwrap_err();
        assert_eq!(error, RegressionError::TooFewSamples { samples: 165, coefficients: 165 });
    }
}
