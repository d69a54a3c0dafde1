//! Fast paths compared with slow, direct implementations.

use ndarray::Axis;

use super::*;
use crate::LeastSquares;
use asperity_base::numeric::solution;

#[test]
fn few_terms_of_very_many_are_recovered_exactly() {
    let truth = [(0, -1.0), (7, 2.0), (201, 0.5), (2999, -3.0), (1500, 1.0)];
    for constant in [true, false] {
        let mut design = normal_design(1, 60, 3000);
        if !constant {
            design.column_mut(0).assign(&ndarray::Array1::from(standard_normal(&mut stream(1, "first", 0), 60)));
        }
        let response = combination(&design, &truth);
        let fit = select(&design, &response).unwrap();
        let dense = fit.dense(3000);
        for (column, coefficient) in truth {
            assert!((dense[column] - coefficient).abs() < 1e-12, "{}", dense[column]);
        }
        assert_eq!(fit.terms.len(), truth.len());
    }
}

#[test]
fn errors_are_those_of_refitting_without_each_sample() {
    let design = normal_design(2, 40, 60);
    let response = noisy_response(&design, 0.3);
    let fit = select(&design, &response).unwrap();
    let chosen = design.select(Axis(1), &fit.terms);
    let mut sum = 0.0;
    for left_out in 0..40 {
        let kept: Vec<usize> = (0..40).filter(|&i| i != left_out).collect();
        let values: Vec<f64> = kept.iter().map(|&i| response[i]).collect();
        let fewer = LeastSquares::new(chosen.select(Axis(0), &kept)).unwrap().fit(&values).unwrap();
        let predicted: f64 = fewer.coefficients.iter().zip(chosen.row(left_out)).map(|(c, a)| c * a).sum();
        sum += (response[left_out] - predicted).powi(2);
    }
    let (_, spread) = mean_and_spread(&response);
    let wanted = sum / 40.0 / (spread * spread / 39.0);
    assert!((fit.leave_one_out.relative_error.unwrap() / wanted - 1.0).abs() < 1e-10);
}

#[test]
fn coefficients_and_condition_are_those_of_least_squares() {
    let design = normal_design(2, 40, 60);
    let response = noisy_response(&design, 0.3);
    let fit = select(&design, &response).unwrap();
    let least_squares = LeastSquares::new(design.select(Axis(1), &fit.terms)).unwrap();
    let wanted = least_squares.fit(&response).unwrap();
    for (found, wanted) in fit.coefficients.iter().zip(&wanted.coefficients) {
        assert!((found - wanted).abs() < 1e-11 * least_squares.condition());
    }
    assert!((fit.condition / least_squares.condition() - 1.0).abs() < 1e-9);
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

#[test]
fn matching_pursuit_takes_the_column_most_correlated_with_the_residual_of_a_fresh_fit() {
    for seed in 0..4 {
        let design = normal_design(seed, 50, 120);
        let response = noisy_response(&design, 0.5);
        let (columns, centred) = standardised(&design, &response);
        let candidates = Candidates::new(design.view()).unwrap();
        let fit = pursue(GrowingFit::new(&candidates, &response), 45);
        let found = &fit.terms()[1..];
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
    let [by_rows, by_columns] = [changed.view(), transposed.t()]
        .map(|matrix| SparseRegression::default().select(&Candidates::new(matrix).unwrap(), &response).unwrap());
    assert_eq!(by_rows, by_columns);
    assert_eq!(by_rows.terms, select(&design, &response).unwrap().terms);
}

#[test]
fn a_fit_has_the_same_bits_on_any_number_of_threads() {
    let design = normal_design(7, 40, 5000);
    let response = noisy_response(&design, 0.2);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| select(&design, &response).unwrap())
    };
    assert_eq!(on(1), on(3));
}
