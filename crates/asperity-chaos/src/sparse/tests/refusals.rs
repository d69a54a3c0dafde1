//! Refused inputs and nearly degenerate data.

use super::*;

#[test]
fn data_that_are_no_data_are_refused() {
    let design = normal_design(1, 20, 30);
    let candidates = Candidates::new(design.view()).unwrap();
    let refused = |response: &[f64]| SparseRegression::default().select(&candidates, response).unwrap_err();
    assert_eq!(refused(&[1.0; 19]), SparseError::Length { values: 19, samples: 20 });
    let mut response = noisy_response(&design.clone().select(ndarray::Axis(1), &[0; 31]), 1.0);
    response[3] = f64::NAN;
    assert_eq!(refused(&response), SparseError::NotFinite { sample: 3 });
    assert!(matches!(refused(&[0.1; 20]), SparseError::ConstantResponse { .. }));
    assert!(matches!(refused(&[0.0; 20]), SparseError::ConstantResponse { .. }));
    let mut holed = design.clone();
    holed[[7, 2]] = f64::INFINITY;
    assert_eq!(Candidates::new(holed.view()).unwrap_err(), SparseError::NotFinite { sample: 7 });
    for samples in 0..3 {
        let few = Array2::ones((samples, 4));
        assert_eq!(Candidates::new(few.view()).unwrap_err(), SparseError::TooFewSamples { samples });
    }
    let flat = Array2::from_elem((20, 3), 0.3);
    let candidates = Candidates::new(flat.view()).unwrap();
    let error = SparseRegression::default().select(&candidates, &standard_normal(&mut stream(1, "y", 0), 20));
    assert_eq!(error.unwrap_err(), SparseError::NoCandidates { columns: 3 });
    let none = Array2::zeros((20, 0));
    let candidates = Candidates::new(none.view()).unwrap();
    let error = SparseRegression::default().select(&candidates, &standard_normal(&mut stream(1, "y", 0), 20));
    assert_eq!(error.unwrap_err(), SparseError::NoCandidates { columns: 0 });
}

#[test]
fn without_predictive_terms_the_error_lists_the_candidates() {
    // A response that is orthogonal to every candidate: any term only adds variance.
    let mut design = Array2::zeros((16, 4));
    let mut response = vec![0.0; 16];
    for sample in 0..16_usize {
        let sign = |bit: usize| if sample >> bit & 1 == 0 { 1.0 } else { -1.0 };
        design[[sample, 0]] = 1.0;
        (1..4).for_each(|j| design[[sample, j]] = sign(j - 1) * if j == 2 { sign(0) } else { 1.0 });
        response[sample] = sign(3);
    }
    let error = select(&design, &response).unwrap_err();
    let SparseError::NothingPredicts { tried, of_the_mean, attempts } = &error else { panic!("{error:?}") };
    assert!(*tried >= attempts.len() && error.to_string().starts_with("no model predicts"));
    assert!(attempts.len() > 1 && attempts.iter().all(|attempt| attempt.error >= *of_the_mean), "{error:?}");
    assert!(attempts.windows(2).all(|pair| pair[0].error <= pair[1].error), "{error:?}");
}

#[test]
fn linearly_dependent_columns_enter_once() {
    let mut design = normal_design(2, 40, 60);
    for (copy, original, factor) in [(40, 4, 1.0), (41, 9, -2.0), (42, 0, 5.0)] {
        let column = design.column(original).mapv(|a| factor * a);
        design.column_mut(copy).assign(&column);
    }
    design.column_mut(43).fill(0.0);
    let sum = &design.column(4) + &design.column(9);
    design.column_mut(44).assign(&sum);
    let response = noisy_response(&design, 0.1);
    let fit = select(&design, &response).unwrap();
    let spanned = |group: &[usize]| fit.terms.iter().filter(|term| group.contains(term)).count();
    assert_eq!(spanned(&[4, 40]).min(1), 1);
    assert!(spanned(&[4, 40]) <= 1 && spanned(&[9, 41]) <= 1 && spanned(&[4, 40, 9, 41, 44]) <= 2);
    assert_eq!(spanned(&[42, 43]), 0);
    assert!(fit.condition < 1e3, "{}", fit.condition);
}

#[test]
fn repeated_samples_end_the_path_where_the_columns_are_spanned() {
    let few = normal_design(3, 12, 50);
    let twice: Vec<usize> = (0..24).map(|i| i % 12).collect();
    let design = few.select(ndarray::Axis(0), &twice);
    let response = noisy_response(&few, 0.5);
    let response: Vec<f64> = twice.iter().map(|&i| response[i]).collect();
    let fit = select(&design, &response).unwrap();
    assert!(fit.terms.len() <= 12);
    assert!(fit.coefficients.iter().all(|c| c.is_finite()));
}

#[test]
fn a_sample_that_alone_determines_a_term_has_no_leave_one_out_error() {
    let mut design = normal_design(4, 30, 40);
    design.column_mut(5).fill(0.0);
    design[[11, 5]] = 1.0;
    let mut response = noisy_response(&design, 0.1);
    // The term that explains a single sample is the most correlated one.
    response[11] += 300.0;
    let fit = select(&design, &response).unwrap();
    assert!(fit.terms.contains(&5) && fit.leave_one_out.errors[11].is_none());
    assert_eq!(fit.leave_one_out.relative_error, None);
}

#[test]
fn the_limit_of_terms_is_kept() {
    let design = normal_design(5, 40, 60);
    let response = noisy_response(&design, 0.1);
    let candidates = Candidates::new(design.view()).unwrap();
    for limit in [2, 4, 9] {
        let regression = SparseRegression { max_terms: Some(limit), ..SparseRegression::default() };
        let fit = regression.select(&candidates, &response).unwrap();
        assert!(fit.terms.len() <= limit && fit.path.iter().all(|attempt| attempt.terms <= limit));
    }
    for limit in [0, 1] {
        let regression = SparseRegression { max_terms: Some(limit), ..SparseRegression::default() };
        let error = regression.select(&candidates, &response).unwrap_err();
        assert!(matches!(error, SparseError::NothingPredicts { tried: 0, .. }));
    }
}

#[test]
fn a_model_has_fewer_terms_than_samples() {
    let design = normal_design(5, 12, 40);
    let candidates = Candidates::new(design.view()).unwrap();
    assert_eq!(SparseRegression::default().term_limit(&candidates), 11);
    assert_eq!(SparseRegression { max_terms: Some(4), ..SparseRegression::default() }.term_limit(&candidates), 4);
    // All candidates where there are more samples.
    let design = normal_design(5, 60, 40);
    let candidates = Candidates::new(design.view()).unwrap();
    assert_eq!(SparseRegression::default().term_limit(&candidates), 40);
}

#[test]
fn a_constant_column_is_recognised_at_any_number_of_samples() {
    for samples in [1025, 1500, 3000, 10_001] {
        let mut design = normal_design(5, samples, 3);
        design.column_mut(0).fill(0.1);
        let candidates = Candidates::new(design.view()).unwrap();
        // The mean of the response is almost zero, so only a recognised constant is selected.
        let chosen = SparseRegression::default().select(&candidates, &combination(&design, &[(2, 1.0)])).unwrap();
        assert!(chosen.terms.starts_with(&[0, 2]), "{samples}: {:?}", chosen.terms);
    }
}
