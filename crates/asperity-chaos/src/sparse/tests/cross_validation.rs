//! Cross-validation errors that account for the selection of terms.

use ndarray::Axis;

use super::*;

#[test]
fn cross_validation_rejects_noise() {
    let (sets, mut refused, mut sum) = (20, 0, 0.0);
    for seed in 0..sets {
        let design = normal_design(seed, 80, 400);
        match select(&design, &standard_normal(&mut stream(seed, "pure noise", 0), 80)) {
            Ok(fit) => {
                assert!(fit.cross_validated > 0.75, "{:.3}", fit.cross_validated);
                sum += fit.cross_validated;
            }
            Err(SparseError::NothingPredicts { attempts, .. }) => {
                refused += 1;
                sum += attempts[0].error;
            }
            Err(error) => panic!("{error}"),
        }
    }
    let mean = sum / f64::from(sets as u32);
    // By chance the minimum of a curve may be below the error of the mean; its expectation exceeds 1 everywhere.
    assert!(2 * refused > sets && mean > 0.95, "{refused} of {sets} refused, error {mean:.3}");
}

#[test]
fn cross_validation_gives_about_the_error_at_fresh_samples() {
    let columns = 150;
    let (mut estimated, mut true_error) = (0.0, 0.0);
    for seed in 0..10 {
        let design = normal_design(seed, 100, columns);
        let noise = standard_normal(&mut stream(seed, "noise", 0), 100);
        let signal = [(0, 1.0), (3, 1.0), (40, -1.0), (90, 0.8)];
        let response: Vec<f64> = combination(&design, &signal).iter().zip(&noise).map(|(y, e)| y + 0.5 * e).collect();
        let fit = select(&design, &response).unwrap();
        estimated += fit.cross_validated / 10.0;
        // The columns are independent: E (ŷ − y)² = |ĉ − c|² + σ², relative to the variance |c|² + σ².
        let mut error = fit.dense(columns);
        signal.iter().for_each(|&(j, c)| error[j] -= c);
        true_error += (error.iter().map(|e| e * e).sum::<f64>() + 0.25) / (2.64 + 0.25) / 10.0;
    }
    // Ten variances of 100 samples each: 5 %. The minimum of a curve is biased downwards.
    assert!((0.75..1.25).contains(&(estimated / true_error)), "{estimated:.4}, {true_error:.4}");
}

#[test]
fn errors_at_rows_left_out_are_those_of_the_coefficients() {
    let design = normal_design(8, 50, 70);
    let response = noisy_response(&design, 0.3);
    let kept: Vec<usize> = (0..40).collect();
    let fewer = design.select(Axis(0), &kept);
    let candidates = Candidates::new(fewer.view()).unwrap();
    let fit = pursue(GrowingFit::new(&candidates, &response[..40]), 25);
    for left_out in 40..50 {
        let errors = fit.errors_at(design.row(left_out), response[left_out]);
        assert_eq!(errors.len(), 25);
        for (number, error) in errors.iter().enumerate() {
            let coefficients = fit.coefficients(number + 1);
            let predicted: f64 = fit.terms().iter().zip(&coefficients).map(|(&j, c)| c * design[[left_out, j]]).sum();
            assert!((response[left_out] - predicted - error).abs() < 1e-12);
        }
    }
}
