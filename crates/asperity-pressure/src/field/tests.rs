use super::*;
use crate::testing::{Shape, gaussian_surface};
use crate::{Problem, Sampling, solve};
use asperity_base::monitor::Silent;
use asperity_base::random::{standard_normal, stream};
use asperity_contact::{Boundary, Control, HalfSpace};

const COUNT: usize = 60;

fn samples(problem: &Problem<'_>, field_bytes: usize) -> Samples {
    let sampling = Sampling::monte_carlo(2, "fields", COUNT, 1.0);
    solve(problem, Sampling { site_stride: Some(1), field_bytes: Some(field_bytes), ..sampling }, &Silent).unwrap()
}

#[test]
fn maps_are_the_counts_means_and_quantiles_of_every_cell() {
    let (surface, half_space) = gaussian_surface(12, 20);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.3 }, None).unwrap();
    let samples = samples(&problem, FIELD_BYTES);
    let distributions = FieldDistributions::new(&samples, 2, 2, (12, 12)).unwrap();
    assert_eq!((distributions.samples, distributions.kept_samples), (COUNT, COUNT));
    // The sites are all cells, each with its own pressures.
    for (row, column) in [(0, 0), (6, 6), (3, 11)] {
        let mut pressures: Vec<f64> = samples.sites().iter().map(|site| f64::from(site[row * 12 + column])).collect();
        let in_contact = pressures.iter().filter(|p| **p > 0.0).count();
        let cell = [row, column];
        assert_eq!(distributions.contact_probability[cell], in_contact as f64 / COUNT as f64);
        let wilson = wilson_interval(in_contact, COUNT);
        assert_eq!(
            (distributions.contact_probability_low[cell], distributions.contact_probability_high[cell]),
            (wilson.low, wilson.high)
        );
        let mean = pressures.iter().sum::<f64>() / COUNT as f64;
        assert!(
            (distributions.mean_pa[cell] - mean).abs() < 1e-6 * mean.max(1e-3),
            "{} {mean}",
            distributions.mean_pa[cell]
        );
        let variance = pressures.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (COUNT - 1) as f64;
        assert!((distributions.mean_se_pa[cell] / (variance / COUNT as f64).sqrt() - 1.0).abs() < 1e-6);
        pressures.sort_by(f64::total_cmp);
        let wanted = [pressures[5], pressures[29], pressures[53]];
        assert_eq!([0, 1, 2].map(|k| distributions.quantiles[k].pressure_pa[cell]), wanted);
    }
}

#[test]
fn beyond_the_memory_maps_of_quantiles_rest_on_the_leading_samples() {
    let (surface, half_space) = gaussian_surface(12, 20);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.3 }, None).unwrap();
    let (all, few) = (samples(&problem, FIELD_BYTES), samples(&problem, 20 * 12 * 12 * 4 + 3));
    let (all, few) = (
        FieldDistributions::new(&all, 2, 2, (12, 12)).unwrap(),
        FieldDistributions::new(&few, 2, 2, (12, 12)).unwrap(),
    );
    assert_eq!((few.samples, few.kept_samples), (COUNT, 20));
    assert_eq!((&few.contact_probability, &few.mean_pa), (&all.contact_probability, &all.mean_pa));
    assert_ne!(few.quantiles, all.quantiles);
    let none = samples(&problem, 0);
    let none = FieldDistributions::new(&none, 2, 2, (12, 12)).unwrap();
    assert!(none.quantiles.is_empty() && none.global.is_err() && none.mean_se_pa[[0, 0]].is_nan());
}

#[test]
fn a_pressure_that_follows_one_global_variable_has_no_error_and_noise_has_all() {
    // Half of the cells follow ξ₀, half are noise.
    let grid = Grid::new(4, 2, 1.0, 1.0).unwrap();
    let shape = Shape::new(grid, 1.0, |x, _| x);
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let problem = Problem::new(&shape, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let samples = samples(&problem, FIELD_BYTES);
    let mut fields = samples.fields().unwrap().clone();
    let noise = standard_normal(&mut stream(1, "noise", 0), COUNT * 8);
    for (k, field) in fields.kept.iter_mut().enumerate() {
        let xi = samples.xi(k)[0];
        let value = |i: usize| if i < 4 { 9.0 + xi + xi * xi } else { 9.0 + noise[8 * k + i] };
        *field = (0..8).map(|i| value(i) as f32).collect();
    }
    let found = global(&samples, &fields, 1, 2).unwrap();
    assert_eq!((found.coefficients, found.leave_one_out_error.dim()), (3, (2, 4)));
    for column in 0..4 {
        assert!(found.leave_one_out_error[[0, column]] < 1e-9);
        assert!(
            (found.leave_one_out_error[[1, column]] - 1.0).abs() < 0.3,
            "{}",
            found.leave_one_out_error[[1, column]]
        );
    }
    // One cell is constant; then there are more coefficients than samples.
    fields.kept.iter_mut().for_each(|field| field[0] = 1.0);
    assert!(global(&samples, &fields, 1, 2).unwrap().leave_one_out_error[[0, 0]].is_nan());
    fields.kept.truncate(3);
    // Two functions require four samples.
    let wanted = RegressionError::TooFewSamples { samples: 3, coefficients: 2 };
    assert_eq!(global(&samples, &fields, 1, 2), Err(MethodError::Regression(wanted)));
}
