//! Eigenproblem of a stationary covariance on an interval.

use ndarray::{Array2, ArrayViewMut1, s};

use super::parity::Class;
use crate::GeneratorError;
use asperity_base::numeric::symmetric_eigen;

/// Eigenpairs of ∫₀^L ρ(x − y) φ(y) dy = λ φ(x), of unit variance.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileModes {
    /// Eigenvalues in metre, falling; values below rounding are zero.
    pub eigenvalues_m: Vec<f64>,
    /// Eigenfunctions at the cell centres in m^{−1/2}, shape `[modes, points]`, with Σ φ_j² Δ = 1.
    pub functions: Array2<f64>,
    /// Fraction Σλ/L of the variance.
    pub captured_variance: f64,
}

/// Computes the first `modes` eigenpairs on `points` cells of `pitch_m`, by Nyström's method with the midpoint rule.
///
/// The matrix is ρ(x_i − x_j)Δ at the cell centres. So all modes together reproduce the covariance of the map's points
/// exactly, and eigenvalues converge to those of the interval with order Δ² (for a kernel with a kink or smoother).
/// Functions have a fixed sign: the first value of at least half the largest magnitude is positive. Even and odd
/// functions are two dense problems of half the size, which cost about 2.5 n³ operations.
///
/// # Errors
/// No mode or more modes than points; a correlation that is not finite.
pub fn profile_modes(
    correlation: impl Fn(f64) -> f64,
    points: usize,
    pitch_m: f64,
    modes: usize,
) -> Result<ProfileModes, GeneratorError> {
    if modes == 0 || modes > points {
        return Err(GeneratorError::Modes { wanted: modes, points });
    }
    let row: Vec<f64> = (0..points).map(|lag| pitch_m * correlation(lag as f64 * pitch_m)).collect();
    if row.iter().any(|value| !value.is_finite()) {
        return Err(GeneratorError::Eigen { points });
    }
    let mut pairs: Vec<(f64, Vec<f64>)> = Vec::new();
    for class in Class::of_profile(points) {
        let (values, vectors) = class_eigenpairs(&class, |p, q| row[p.abs_diff(q)])?;
        for (value, vector) in values.into_iter().zip(vectors.rows()).take(modes) {
            let mut function = vec![0.0; points];
            class.add_to(&vector.to_vec(), &mut function);
            pairs.push((value, function));
        }
    }
    // The sort is stable: of equal eigenvalues, the even function comes first.
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    pairs.truncate(modes);
    let mut functions = Array2::from_shape_fn((modes, points), |(j, i)| pairs[j].1[i] / pitch_m.sqrt());
    functions.rows_mut().into_iter().for_each(fix_sign);
    let eigenvalues_m: Vec<f64> = pairs.into_iter().map(|(value, _)| value).collect();
    let captured_variance = eigenvalues_m.iter().sum::<f64>() / (points as f64 * pitch_m);
    Ok(ProfileModes { eigenvalues_m, functions, captured_variance })
}

/// Computes all eigenpairs of one class of parity of a symmetric matrix that commutes with the reflections, by its
/// entries between points of the map: values, falling, and coordinates as rows.
pub(super) fn class_eigenpairs(
    class: &Class,
    entry: impl Fn(usize, usize) -> f64,
) -> Result<(Vec<f64>, Array2<f64>), GeneratorError> {
    dense_eigenpairs(class.len(), |i, j| {
        let here = class.images(i)[0].0;
        let sum: f64 = class.images(j).iter().map(|(place, sign)| sign * entry(here, *place)).sum();
        class.middle_weight(i) * class.middle_weight(j) * sum
    })
}

/// Computes all eigenpairs of a dense symmetric matrix, falling: values (zero below rounding) and unit vectors as rows.
pub(super) fn dense_eigenpairs(
    n: usize,
    entry: impl Fn(usize, usize) -> f64,
) -> Result<(Vec<f64>, Array2<f64>), GeneratorError> {
    let matrix = Array2::from_shape_fn((n, n), |(i, j)| if j <= i { entry(i, j) } else { 0.0 });
    let eigen = symmetric_eigen(matrix).map_err(|_| GeneratorError::Eigen { points: n })?;
    let ascending = eigen.values;
    let largest = ascending[n - 1].abs();
    let floor = largest * f64::EPSILON * n as f64;
    let values = (0..n).rev().map(|j| if ascending[j] > floor { ascending[j] } else { 0.0 }).collect();
    Ok((values, eigen.vectors.slice(s![..;-1, ..]).as_standard_layout().into_owned()))
}

/// Chooses the sign of a vector so that its first value of at least half the largest magnitude is positive.
fn fix_sign(mut vector: ArrayViewMut1<f64>) {
    let largest = vector.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let leading = vector.iter().copied().find(|v| v.abs() >= 0.5 * largest);
    if leading.is_some_and(|v| v < 0.0) {
        vector.mapv_inplace(|v| -v);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::convert::Infallible;

    use super::*;
    use asperity_base::numeric::bisect;

    /// Returns the closed-form eigenvalues of e^{−|x−y|/ℓ} on an interval of `size_m`, in metre, falling.
    ///
    /// λ = 2ℓ/(1 + (ℓω)²), where with half length a, ω solves 1/ℓ = ω tan ωa (even functions) or ω = −tan(ωa)/ℓ (odd ones),
    /// one root in each half period (Ghanem & Spanos 1991, §2.3.3).
    pub(in crate::karhunen_loeve) fn exponential_eigenvalues_m(
        correlation_length_m: f64,
        size_m: f64,
        count: usize,
    ) -> Vec<f64> {
        let half = 0.5 * size_m / correlation_length_m;
        (0..count)
            .map(|j| {
                // With u = ωa both equations, multiplied by cos u, are smooth with one sign change in (j, j + 1)·π/2.
                let residual = |u: f64| {
                    let (sin, cos) = u.sin_cos();
                    if j % 2 == 0 { half * cos - u * sin } else { u * cos + half * sin }
                };
                let quarter = std::f64::consts::FRAC_PI_2;
                let low = j as f64 * quarter;
                // The residual leaves each interval's start with the sign of the middle of its first part.
                let sign = residual(low + 1e-9 * quarter).signum();
                let keeps_sign = |u: f64| Ok::<_, Infallible>(residual(u).signum() == sign);
                let Ok([root, _]) = bisect(low, (j + 1) as f64 * quarter, 0.0, keeps_sign);
                2.0 * correlation_length_m / (1.0 + (root / half).powi(2))
            })
            .collect()
    }

    #[test]
    fn the_closed_form_gives_the_published_eigenvalues() {
        for (length, published) in [
            (1.0, [0.738_810_809_4, 0.138_003_775_4, 0.045_088_487_3, 0.021_328_931_3]),
            (0.1, [0.187_082_551_9, 0.156_045_560_2, 0.121_154_351_5, 0.091_324_242_8]),
        ] {
            for (root, value) in exponential_eigenvalues_m(length, 1.0, 4).into_iter().zip(published) {
                assert!((root - value).abs() < 1e-10, "{root} {value}");
            }
        }
    }

    #[test]
    fn the_closed_form_eigenvalues_sum_to_the_length_and_scale_with_it() {
        let sum: f64 = exponential_eigenvalues_m(0.3, 2.0, 20_000).iter().sum();
        // The rest is the tail of 2ℓ/(ℓω)² with ω = jπ/L.
        let tail = 2.0 * 4.0 / (0.3 * std::f64::consts::PI.powi(2) * 20_000.0);
        assert!((sum + tail - 2.0).abs() < 1e-6, "{sum}");
        let (small, large) = (exponential_eigenvalues_m(0.3, 2.0, 5), exponential_eigenvalues_m(3.0, 20.0, 5));
        assert!(small.iter().zip(large).all(|(s, l)| (l / s - 10.0).abs() < 1e-9));
    }

    #[test]
    fn eigenvalues_of_the_exponential_converge_with_order_two() {
        for length in [1.0, 0.1] {
            let wanted = exponential_eigenvalues_m(length, 1.0, 4);
            let errors = [64, 128, 256].map(|points| {
                let found = profile_modes(|x| (-x / length).exp(), points, 1.0 / points as f64, 4).unwrap();
                let errors: Vec<f64> =
                    found.eigenvalues_m.iter().zip(&wanted).map(|(f, w)| (f / w - 1.0).abs()).collect();
                errors
            });
            for mode in 0..4 {
                assert!(errors[2][mode] < 1e-3, "length {length} mode {mode}: {:e}", errors[2][mode]);
                let order = (errors[1][mode] / errors[2][mode]).log2();
                assert!((order - 2.0).abs() < 0.1, "length {length} mode {mode}: observed order {order:.3}");
            }
        }
    }

    #[test]
    fn a_thousand_cells_have_the_published_eigenvalues_of_the_unit_interval() {
        // e^{−5|x−y|} on the unit interval, from the roots of the transcendental equations in high precision.
        let published = [
            0.330_920_604_978_177_7,
            0.209_776_100_588_743,
            0.123_905_815_619_64,
            0.075_965_390_069_873_88,
            0.049_621_828_742_844_98,
            0.034_388_841_096_868_22,
            0.025_023_632_556_293_27,
            0.018_935_934_961_627_62,
            0.014_787_326_366_861_21,
            0.011_846_678_244_153_08,
            0.009_692_744_028_205_908,
            0.008_070_990_762_555_48,
        ];
        let solve = |points: usize| profile_modes(|x| (-5.0 * x).exp(), points, 1.0 / points as f64, 12).unwrap();
        let errors = [256, 1024].map(|points| -> Vec<f64> {
            let found = solve(points).eigenvalues_m;
            found.iter().zip(published).map(|(f, p)| (f / p - 1.0).abs()).collect()
        });
        for mode in 0..12 {
            let (coarse, fine) = (errors[0][mode], errors[1][mode]);
            assert!(fine < 2e-4, "mode {mode}: {fine:e}");
            let order = (coarse / fine).log2() / 2.0;
            assert!((order - 2.0).abs() < 0.05, "mode {mode}: observed order {order:.3}");
        }
    }

    #[test]
    fn functions_are_orthonormal_and_all_of_them_rebuild_the_covariance() {
        let rho = |x: f64| (-(x / 0.3).powi(2)).exp();
        let found = profile_modes(rho, 40, 0.025, 40).unwrap();
        let gram = found.functions.dot(&found.functions.t()) * 0.025;
        for ((i, j), value) in gram.indexed_iter() {
            assert!((value - f64::from(u8::from(i == j))).abs() < 1e-12);
        }
        for (i, j) in [(0, 0), (3, 17), (39, 20)] {
            let sum: f64 =
                (0..40).map(|k| found.eigenvalues_m[k] * found.functions[[k, i]] * found.functions[[k, j]]).sum();
            assert!((sum - rho(0.025 * (i as f64 - j as f64))).abs() < 1e-12);
        }
        assert!((found.captured_variance - 1.0).abs() < 1e-12);
    }
}
