//! Newton's method for concave functions.

use asperity_base::numeric::dense_solution;
use ndarray::{Array2, s};

/// Largest number of steps.
const STEPS: usize = 100;
/// Largest number of halvings of a step.
const HALVINGS: i32 = 40;
/// Smallest predicted rise of a step, relative to the value.
const TOLERANCE: f64 = 1e-12;
/// Damping of the curvature, relative to its largest diagonal entry. It keeps steps finite if functions are linearly dependent.
const DAMPING: f64 = 1e-12;

/// Value, gradient, and negative second derivatives of a function at a point.
pub(crate) struct Local {
    pub(crate) value: f64,
    pub(crate) gradient: Vec<f64>,
    pub(crate) curvature: Array2<f64>,
}

/// Returns the maximum of a concave function whose last variable is kept within `bounds`, or the last point reached if there is no
/// maximum.
pub(crate) fn maximise(start: Vec<f64>, bounds: [f64; 2], function: impl Fn(&[f64]) -> Local) -> Vec<f64> {
    let mut place = start;
    let mut here = function(&place);
    for _ in 0..STEPS {
        let step = step(&here, place[place.len() - 1], bounds);
        let rise: f64 = step.iter().zip(&here.gradient).map(|(step, slope)| step * slope).sum();
        if rise.is_nan() || rise <= TOLERANCE * (1.0 + here.value.abs()) {
            break;
        }
        let tried = (0..HALVINGS).find_map(|halvings| {
            let fraction = 0.5_f64.powi(halvings);
            let there: Vec<f64> = place.iter().zip(&step).map(|(x, step)| x + fraction * step).collect();
            let local = function(&there);
            (local.value > here.value).then_some((there, local))
        });
        let Some((there, local)) = tried else { break };
        (place, here) = (there, local);
    }
    place
}

/// Returns the step to the maximum of the local quadratic approximation. If the last variable would leave its bounds, the maximum on
/// the bound is used.
fn step(here: &Local, last: f64, [least, largest]: [f64; 2]) -> Vec<f64> {
    let n = here.gradient.len();
    let damping = DAMPING * (0..n).map(|i| here.curvature[[i, i]]).fold(0.0, f64::max);
    let solve = |free: usize, along_last: f64| -> Vec<f64> {
        let mut curvature = here.curvature.slice(s![..free, ..free]).to_owned();
        curvature.diag_mut().mapv_inplace(|entry| entry + damping);
        let known = |i: usize| if free < n { here.curvature[[i, free]] * along_last } else { 0.0 };
        let right: Vec<f64> = (0..free).map(|i| here.gradient[i] - known(i)).collect();
        dense_solution(curvature.view(), &right)
    };
    let whole = solve(n, 0.0);
    let end = last + whole[n - 1];
    if (least..=largest).contains(&end) || end.is_nan() {
        return whole;
    }
    let along_last = end.clamp(least, largest) - last;
    let mut step = solve(n - 1, along_last);
    step.push(along_last);
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_maximum_beyond_a_bound_is_found_on_it() {
        // −(x − 1)⁴ − x² − (y − x)² is largest where y = x and 4 (x − 1)³ = −2 x; with y ≤ 0, where y = 0.
        let function = |place: &[f64]| {
            let (x, y) = (place[0], place[1]);
            let gradient = vec![-4.0 * (x - 1.0).powi(3) - 2.0 * x + 2.0 * (y - x), -2.0 * (y - x)];
            let curvature = [[12.0 * (x - 1.0).powi(2) + 4.0, -2.0], [-2.0, 2.0]];
            let curvature = Array2::from_shape_fn((2, 2), |(i, j)| curvature[i][j]);
            Local { value: -(x - 1.0).powi(4) - x * x - (y - x).powi(2), gradient, curvature }
        };
        let free = maximise(vec![-3.0, -5.0], [-9.0, 9.0], function);
        assert!(
            (free[0] - free[1]).abs() < 1e-6 && (4.0 * (free[0] - 1.0).powi(3) + 2.0 * free[0]).abs() < 1e-5,
            "{free:?}"
        );
        let bounded = maximise(vec![-3.0, -5.0], [-9.0, 0.0], function);
        assert_eq!(bounded[1], 0.0);
        assert!((4.0 * (bounded[0] - 1.0).powi(3) + 4.0 * bounded[0]).abs() < 1e-5, "{bounded:?}");
    }
}
