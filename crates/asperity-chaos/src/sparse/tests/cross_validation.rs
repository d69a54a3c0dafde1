//! Cross-validation errors that account for the selection of terms.

use ndarray::Axis;

use super::*;

#[test]
fn cross_validation_rejects_noise_that_leave_one_out_fits() {
    let sets = 20;
    for method in METHODS {
        let (mut refused, mut believed, mut sum) = (0, 0, 0.0);
        for seed in 0..sets {
            let design = normal_design(seed, 80, 400);
            let response = standard_normal(&mut stream(seed, "pure noise", 0), 80);
            let candidates = Candidates::new(design.view()).unwrap();
            believed += usize::from(by_leave_one_out(method).select(&candidates, &response).is_ok());
            match by_cross_validation(method).select(&candidates, &response) {
                Ok(fit) => {
                    let error = fit.chosen.cross_validated.unwrap();
                    assert!(error > 0.75, "{method:?}: {error:.3}");
                    sum += error;
                }
                Err(SparseError::NothingPredicts { attempts, .. }) => {
                    refused += 1;
                    sum += attempts[0].cross_validated.unwrap();
                }
                Err(error) => panic!("{error}"),
            }
        }
        let mean = sum / f64::from(sets as u32);
        println!("{method:?}: refused {refused} of {sets}, leave-one-out believes {believed}; error {mean:.3}");
        assert_eq!(believed, 20, "{method:?}");
        // By chance the minimum of a curve may be below the error of the mean; its expectation exceeds 1 everywhere.
        assert!(2 * refused > sets && mean > 0.95, "{method:?}: {refused} of {sets} refused, error {mean:.3}");
    }
}

#[test]
fn cross_validation_gives_about_the_error_at_fresh_samples() {
    let columns = 150;
    for method in METHODS {
        let (mut estimated, mut true_error) = (0.0, 0.0);
        for seed in 0..10 {
            let design = normal_design(seed, 100, columns);
            let noise = standard_normal(&mut stream(seed, "noise", 0), 100);
            let signal = [(0, 1.0), (3, 1.0), (40, -1.0), (90, 0.8)];
            let response: Vec<f64> =
                combination(&design, &signal).iter().zip(&noise).map(|(y, e)| y + 0.5 * e).collect();
            let fit = by_cross_validation(method).select(&Candidates::new(design.view()).unwrap(), &response).unwrap();
            estimated += fit.chosen.cross_validated.unwrap() / 10.0;
            // The columns are independent: E (ŷ − y)² = |ĉ − c|² + σ², relative to the variance |c|² + σ².
            let mut error = fit.dense(columns);
            signal.iter().for_each(|&(j, c)| error[j] -= c);
            true_error += (error.iter().map(|e| e * e).sum::<f64>() + 0.25) / (2.64 + 0.25) / 10.0;
        }
        println!("{method:?}: {estimated:.4} estimated, {true_error:.4} at fresh samples");
        // Ten variances of 100 samples each: 5 %. The minimum of a curve is biased downwards.
        assert!((0.75..1.25).contains(&(estimated / true_error)), "{method:?}: {estimated:.4}, {true_error:.4}");
    }
}

#[test]
fn errors_at_rows_left_out_are_those_of_the_coefficients() {
    let design = normal_design(8, 50, 70);
    let response = noisy_response(&design, 0.3);
    let kept: Vec<usize> = (0..40).collect();
    let fewer = design.select(Axis(0), &kept);
    let candidates = Candidates::new(fewer.view()).unwrap();
    let search = matching_pursuit::search(GrowingFit::new(&candidates, &response[..40]), 25, 99);
    for left_out in 40..50 {
        let errors = search.fit.errors_at(design.row(left_out), response[left_out]);
        assert_eq!(errors.len(), 25);
        for (number, error) in errors.iter().enumerate() {
            let coefficients = search.fit.coefficients(number + 1);
            let predicted: f64 =
                search.fit.terms().iter().zip(&coefficients).map(|(&j, c)| c * design[[left_out, j]]).sum();
            assert!((response[left_out] - predicted - error).abs() < 1e-12);
        }
    }
}
