//! Fast paths compared with slow, direct implementations.

use ndarray::Axis;

use super::*;
use crate::LeastSquares;
use asperity_base::numeric::{inverse, solution};

#[test]
fn few_terms_of_very_many_are_recovered_exactly() {
    let truth = [(0, -1.0), (7, 2.0), (201, 0.5), (2999, -3.0), (1500, 1.0)];
    for constant in [true, false] {
        let mut design = normal_design(1, 60, 3000);
        if !constant {
            design.column_mut(0).assign(&ndarray::Array1::from(standard_normal(&mut stream(1, "first", 0), 60)));
        }
        let response = combination(&design, &truth);
        for (method, size) in METHODS.into_iter().flat_map(|method| CRITERIA.map(|size| (method, size))) {
            let fit = SparseRegression { method, size, ..SparseRegression::default() }
                .select(&Candidates::new(design.view()).unwrap(), &response)
                .unwrap();
            let dense = fit.dense(3000);
            for (column, coefficient) in truth {
                assert!((dense[column] - coefficient).abs() < 1e-12, "{method:?}, {size:?}: {}", dense[column]);
            }
            assert_eq!(fit.stop_reason, StopReason::Exact, "{method:?}, {size:?}");
            if method == SparseMethod::OrthogonalMatchingPursuit {
                assert_eq!(fit.terms.len(), truth.len(), "{method:?}, {size:?}");
            }
        }
    }
}

#[test]
fn errors_are_those_of_refitting_without_each_sample() {
    let design = normal_design(2, 40, 60);
    let response = noisy_response(&design, 0.3);
    let candidates = Candidates::new(design.view()).unwrap();
    for method in METHODS {
        let regression = SparseRegression { max_terms: Some(12), ..whole(method) };
        let fit = regression.select(&candidates, &response).unwrap();
        let chosen = design.select(Axis(1), &fit.terms);
        let mut sum = 0.0;
        for left_out in 0..40 {
            let kept: Vec<usize> = (0..40).filter(|&i| i != left_out).collect();
            let values: Vec<f64> = kept.iter().map(|&i| response[i]).collect();
            let refit = LeastSquares::new(chosen.select(Axis(0), &kept)).unwrap().fit(&values).unwrap();
            let prediction: f64 = chosen.row(left_out).iter().zip(&refit.coefficients).map(|(a, c)| a * c).sum();
            let error = response[left_out] - prediction;
            assert!((fit.leave_one_out.errors[left_out].unwrap() - error).abs() < 1e-12, "{method:?}");
            sum += error * error;
        }
        let mean = response.iter().sum::<f64>() / 40.0;
        let variance = response.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 39.0;
        let wanted = sum / 40.0 / variance;
        assert!((fit.leave_one_out.relative_error.unwrap() / wanted - 1.0).abs() < 1e-11);
        // tr (AᵀA)⁻¹ from the explicit inverse.
        let terms = fit.terms.len();
        let gram = chosen.t().dot(&chosen).rows().into_iter().map(|row| row.to_vec()).collect();
        let trace: f64 = inverse(gram).unwrap().iter().enumerate().map(|(i, row)| row[i]).sum();
        let corrected = wanted * 40.0 / (40.0 - terms as f64) * (1.0 + trace);
        assert!((fit.chosen.corrected.unwrap() / corrected - 1.0).abs() < 1e-10, "{method:?}");
        // The chosen model is the minimum of the path.
        let least = fit.path.iter().map(|attempt| attempt.corrected.unwrap()).fold(f64::INFINITY, f64::min);
        assert_eq!(fit.chosen.corrected, Some(least));
    }
}

#[test]
fn coefficients_and_condition_are_those_of_least_squares() {
    let design = normal_design(2, 40, 60);
    let response = noisy_response(&design, 0.3);
    for method in METHODS {
        let fit = whole(method).select(&Candidates::new(design.view()).unwrap(), &response).unwrap();
        let least_squares = LeastSquares::new(design.select(Axis(1), &fit.terms)).unwrap();
        let wanted = least_squares.fit(&response).unwrap();
        for (found, wanted) in fit.coefficients.iter().zip(&wanted.coefficients) {
            assert!((found - wanted).abs() < 1e-11 * least_squares.condition());
        }
        assert!((fit.condition / least_squares.condition() - 1.0).abs() < 1e-9);
    }
}

/// Returns the standardised columns other than the constant, and the response less its mean.
fn standardised(design: &Array2<f64>, response: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let n = response.len() as f64;
    let columns = design
        .columns()
        .into_iter()
        .map(|column| {
            let mean = column.sum() / n;
            let norm = column.iter().map(|a| (a - mean).powi(2)).sum::<f64>().sqrt();
            column.iter().map(|a| if norm > 1e-12 { (a - mean) / norm } else { 0.0 }).collect()
        })
        .collect();
    let mean = response.iter().sum::<f64>() / n;
    (columns, response.iter().map(|y| y - mean).collect())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves G x = b with the Gram matrix G of some columns.
fn solve_gram(columns: &[Vec<f64>], active: &[usize], right: &[f64]) -> Vec<f64> {
    let row = |i: &usize| active.iter().map(|j| dot(&columns[*i], &columns[*j])).collect();
    solution(active.iter().map(row).collect(), right)
}

/// Computes least-angle regression as Efron et al. define it (equations 2.4 to 2.13), recomputed in every step.
fn textbook_least_angle(columns: &[Vec<f64>], response: &[f64], steps: usize) -> Vec<usize> {
    let mut fitted = vec![0.0; response.len()];
    let mut active: Vec<usize> = Vec::new();
    for _ in 0..steps {
        let residual: Vec<f64> = response.iter().zip(&fitted).map(|(y, f)| y - f).collect();
        let c: Vec<f64> = columns.iter().map(|x| dot(x, &residual)).collect();
        let inactive: Vec<usize> = (1..columns.len()).filter(|j| !active.contains(j)).collect();
        let entering = *inactive.iter().max_by(|&&a, &&b| c[a].abs().total_cmp(&c[b].abs())).unwrap();
        active.push(entering);
        let level = c[entering].abs();
        let signs: Vec<f64> = active.iter().map(|&j| c[j].signum()).collect();
        let raw = solve_gram(columns, &active, &signs);
        let scale = 1.0 / dot(&raw, &signs).sqrt();
        let mut direction = vec![0.0; response.len()];
        for (&j, w) in active.iter().zip(&raw) {
            direction.iter_mut().zip(&columns[j]).for_each(|(u, x)| *u += scale * w * x);
        }
        let mut distance = level / scale;
        for j in (1..columns.len()).filter(|j| !active.contains(j)) {
            let a = dot(&columns[j], &direction);
            for candidate in [(level - c[j]) / (scale - a), (level + c[j]) / (scale + a)] {
                if candidate > 1e-14 && candidate < distance {
                    distance = candidate;
                }
            }
        }
        fitted.iter_mut().zip(&direction).for_each(|(f, u)| *f += distance * u);
    }
    active
}

#[test]
fn least_angle_regression_is_that_of_the_textbook() {
    for seed in 0..4 {
        let design = normal_design(seed, 50, 120);
        let response = noisy_response(&design, 0.5);
        let (columns, centred) = standardised(&design, &response);
        let wanted = textbook_least_angle(&columns, &centred, 40);
        for terms in [5, 20, 41] {
            let candidates = Candidates::new(design.view()).unwrap();
            let search = least_angle::search(GrowingFit::new(&candidates, &response), terms, 200);
            assert_eq!(search.fit.terms()[1..], wanted[..terms - 1], "seed {seed}");
        }
    }
}

#[test]
fn matching_pursuit_takes_the_column_most_correlated_with_the_residual_of_a_fresh_fit() {
    for seed in 0..4 {
        let design = normal_design(seed, 50, 120);
        let response = noisy_response(&design, 0.5);
        let (columns, centred) = standardised(&design, &response);
        let candidates = Candidates::new(design.view()).unwrap();
        let search = matching_pursuit::search(GrowingFit::new(&candidates, &response), 45, 200);
        let found = &search.fit.terms()[1..];
        assert_eq!(found.len(), 44);
        for step in 0..found.len() {
            let active = &found[..step];
            let right: Vec<f64> = active.iter().map(|&j| dot(&columns[j], &centred)).collect();
            let weights = if step == 0 { Vec::new() } else { solve_gram(&columns, active, &right) };
            let mut residual = centred.clone();
            for (&j, w) in active.iter().zip(&weights) {
                residual.iter_mut().zip(&columns[j]).for_each(|(r, x)| *r -= w * x);
            }
            let wanted = (1..120)
                .filter(|j| !active.contains(j))
                .max_by(|&a, &b| dot(&columns[a], &residual).abs().total_cmp(&dot(&columns[b], &residual).abs()));
            assert_eq!(Some(found[step]), wanted, "seed {seed}, step {step}");
        }
    }
}

#[test]
fn scale_shift_and_layout_of_the_matrix_do_not_change_the_choice() {
    let design = normal_design(6, 50, 80);
    let response = noisy_response(&design, 0.4);
    let mut changed = design.clone();
    for (j, mut column) in changed.columns_mut().into_iter().enumerate().skip(1) {
        column.mapv_inplace(|a| if j % 3 == 0 { 1e3 * a } else { a });
    }
    let transposed = changed.t().as_standard_layout().into_owned();
    for method in METHODS {
        // The corrected error assumes functions of unit mean square, so only the order of entry is compared.
        let terms = |view| {
            let candidates = Candidates::new(view).unwrap();
            let start = GrowingFit::new(&candidates, &response);
            method.search(start, 30, 99).fit.terms().to_vec()
        };
        assert_eq!(terms(design.view()), terms(changed.view()), "{method:?}");
        let by_rows = whole(method).select(&Candidates::new(changed.view()).unwrap(), &response);
        let by_columns = whole(method).select(&Candidates::new(transposed.t()).unwrap(), &response);
        assert_eq!(by_rows, by_columns, "{method:?}");
    }
}

#[test]
fn a_fit_has_the_same_bits_on_any_number_of_threads() {
    let design = normal_design(7, 40, 5000);
    let response = noisy_response(&design, 0.2);
    for regression in METHODS.map(whole).into_iter().chain(METHODS.map(by_cross_validation)) {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| regression.select(&Candidates::new(design.view()).unwrap(), &response).unwrap())
        };
        assert_eq!(on(1), on(3), "{regression:?}");
    }
}
