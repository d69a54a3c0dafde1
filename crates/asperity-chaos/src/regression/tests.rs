use super::*;
use asperity_base::random::{standard_normal, stream};
use ndarray::Array2;

fn random_design(samples: usize, coefficients: usize) -> Array2<f64> {
    let values = standard_normal(&mut stream(4, "design", 0), samples * coefficients);
    Array2::from_shape_vec((samples, coefficients), values).unwrap()
}

#[test]
fn an_exact_linear_response_is_recovered() {
    let design = random_design(40, 7);
    let truth: Vec<f64> = (0..7).map(|j| f64::from(j) - 2.5).collect();
    let response: Vec<f64> =
        design.rows().into_iter().map(|row| row.iter().zip(&truth).map(|(a, c)| a * c).sum()).collect();
    let fit = LeastSquares::new(design).unwrap().fit(&response).unwrap();
    for (found, wanted) in fit.coefficients.iter().zip(&truth) {
        assert!((found - wanted).abs() < 1e-12);
    }
    assert!(fit.leave_one_out.relative_error.unwrap() < 1e-24);
}

#[test]
fn residuals_are_orthogonal_to_every_column_and_leverages_sum_to_the_rank() {
    let design = random_design(60, 9);
    let response = standard_normal(&mut stream(4, "response", 0), 60);
    let least_squares = LeastSquares::new(design.clone()).unwrap();
    let fit = least_squares.fit(&response).unwrap();
    for column in design.columns() {
        let inner: f64 = column.iter().zip(&fit.residuals).map(|(a, r)| a * r).sum();
        assert!(inner.abs() < 1e-12);
    }
    assert!((least_squares.leverages().iter().sum::<f64>() - 9.0).abs() < 1e-12);
}

#[test]
fn leave_one_out_errors_and_coefficients_are_those_of_refitting_without_each_sample() {
    let design = random_design(25, 4);
    let response = standard_normal(&mut stream(4, "response", 1), 25);
    let problem = LeastSquares::new(design.clone()).unwrap();
    let fit = problem.fit(&response).unwrap();
    let without = problem.without_each(&fit).unwrap();
    for left_out in 0..25 {
        let kept: Vec<usize> = (0..25).filter(|&i| i != left_out).collect();
        let fewer = design.select(ndarray::Axis(0), &kept);
        let values: Vec<f64> = kept.iter().map(|&i| response[i]).collect();
        let refit = LeastSquares::new(fewer).unwrap().fit(&values).unwrap();
        let prediction: f64 = design.row(left_out).iter().zip(&refit.coefficients).map(|(a, c)| a * c).sum();
        let error = fit.leave_one_out.errors[left_out].unwrap();
        assert!((error - (response[left_out] - prediction)).abs() < 1e-12);
        for (found, wanted) in without.column(left_out).iter().zip(&refit.coefficients) {
            assert!((found - wanted).abs() < 1e-12);
        }
    }
}

#[test]
fn a_sample_that_alone_determines_a_coefficient_has_no_leave_one_out_error() {
    let mut design = random_design(12, 3);
    design.column_mut(2).fill(0.0);
    design[[5, 2]] = 1.0;
    let response = standard_normal(&mut stream(4, "response", 2), 12);
    let fit = LeastSquares::new(design).unwrap().fit(&response).unwrap();
    assert_eq!(fit.leave_one_out.undetermined(), 1);
    assert_eq!(fit.leave_one_out.errors[5], None);
    assert_eq!(fit.leave_one_out.relative_error, None);
}

#[test]
fn the_condition_number_of_scaled_orthogonal_columns_is_their_ratio() {
    let mut design = Array2::zeros((8, 2));
    for i in 0..8 {
        design[[i, 0]] = 1.0;
        design[[i, 1]] = if i % 2 == 0 { 1e-6 } else { -1e-6 };
    }
    let condition = LeastSquares::new(design).unwrap().condition();
    assert!((condition / 1e6 - 1.0).abs() < 1e-9, "condition {condition}");
}

#[test]
fn hopeless_problems_are_refused() {
    let error = LeastSquares::new(random_design(5, 5)).unwrap_err();
    assert_eq!(error, RegressionError::TooFewSamples { samples: 5, coefficients: 5 });
    let mut twins = random_design(20, 3);
    let first = twins.column(0).to_owned();
    twins.column_mut(2).assign(&first);
    assert!(matches!(LeastSquares::new(twins), Err(RegressionError::RankDeficient { .. })));
    let mut holed = random_design(20, 3);
    holed[[7, 1]] = f64::NAN;
    assert_eq!(LeastSquares::new(holed).unwrap_err(), RegressionError::NotFinite { sample: 7 });
}

#[test]
fn many_right_hand_sides_are_solved_as_one_by_one() {
    // More than one block, in three layouts.
    let count = 515;
    let (samples, coefficients) = (31, 5);
    let least_squares = LeastSquares::new(random_design(samples, coefficients)).unwrap();
    let values = standard_normal(&mut stream(4, "responses", 0), samples * count);
    let rows = Array2::from_shape_vec((samples, count), values).unwrap();
    let columns = rows.t().as_standard_layout().into_owned();
    let mut spread = Array2::zeros((samples, 2 * count));
    spread.slice_mut(ndarray::s![.., ..;2]).assign(&rows);
    for view in [rows.view(), columns.t(), spread.slice(ndarray::s![.., ..;2])] {
        let fits = least_squares.fit_many(view).unwrap();
        assert_eq!(fits.coefficients, least_squares.solve_many(view).unwrap());
        for j in [0, 1, 255, 256, 511, 512, 514] {
            let fit = least_squares.fit(&rows.column(j).to_vec()).unwrap();
            for (found, wanted) in fits.coefficients.column(j).iter().zip(&fit.coefficients) {
                assert!((found - wanted).abs() < 1e-13);
            }
            let (found, wanted) = (fits.relative_errors[j].unwrap(), fit.leave_one_out.relative_error.unwrap());
            assert!((found / wanted - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn many_right_hand_sides_give_the_same_bits_on_any_number_of_threads() {
    let least_squares = LeastSquares::new(random_design(40, 6)).unwrap();
    let values = standard_normal(&mut stream(4, "responses", 1), 40 * 1100);
    let responses = Array2::from_shape_vec((40, 1100), values).unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| least_squares.fit_many(responses.view()).unwrap())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn many_right_hand_sides_are_refused_where_one_would_be() {
    let least_squares = LeastSquares::new(random_design(20, 3)).unwrap();
    let mut responses = random_design(20, 4);
    responses[[13, 2]] = f64::INFINITY;
    assert_eq!(least_squares.solve_many(responses.view()), Err(RegressionError::NotFinite { sample: 13 }));
    let short = random_design(19, 4);
    assert_eq!(least_squares.solve_many(short.view()), Err(RegressionError::Length { values: 19, samples: 20 }));
    assert_eq!(least_squares.solve_many(Array2::zeros((20, 0)).view()).unwrap().dim(), (3, 0));
    let constant = least_squares.fit_many(Array2::zeros((20, 2)).view()).unwrap();
    assert_eq!(constant.relative_errors, vec![None, None]);
}
