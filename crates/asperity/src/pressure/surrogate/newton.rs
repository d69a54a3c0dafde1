//! Newton's method for concave functions.

use faer::Mat;
use faer::linalg::solvers::Solve;
use ndarray::Array2;

/// Steps at most, and halvings of one.
const STEPS: usize = 100;
const HALVINGS: usize = 40;
/// Rise that a step has to promise, as a share of the value.
const TOLERANCE: f64 = 1e-12;
/// What is added to the curvature, as a share of its largest diagonal entry: it keeps steps finite where functions cannot be told apart.
const DAMPING: f64 = 1e-12;

/// A function at a point: its value, its gradient, and the negative of its second derivatives.
pub(crate) struct Local {
    pub(crate) value: f64,
    pub(crate) gradient: Vec<f64>,
    pub(crate) curvature: Array2<f64>,
}

/// The place of the maximum of a concave function, `None` outside of whose domain; where it has none, the farthest place
/// reached.
pub(crate) fn maximise(start: Vec<f64>, function: impl Fn(&[f64]) -> Option<Local>) -> Vec<f64> {
    let mut place = start;
    let Some(mut here) = function(&place) else { return place };
    for _ in 0..STEPS {
        let n = place.len();
        let damping = DAMPING * (0..n).map(|i| here.curvature[[i, i]]).fold(0.0, f64::max);
        let curvature = Mat::from_fn(n, n, |i, j| here.curvature[[i, j]] + if i == j { damping } else { 0.0 });
        let step = curvature.partial_piv_lu().solve(Mat::from_fn(n, 1, |i, _| here.gradient[i]));
        let rise: f64 = (0..n).map(|i| step[(i, 0)] * here.gradient[i]).sum();
        if rise.is_nan() || rise <= TOLERANCE * (1.0 + here.value.abs()) {
            break;
        }
        let tried = (0..HALVINGS).find_map(|halvings| {
            let share = 0.5_f64.powi(halvings as i32);
            let there: Vec<f64> = place.iter().enumerate().map(|(i, x)| x + share * step[(i, 0)]).collect();
            let local = function(&there)?;
            (local.value > here.value).then_some((there, local))
        });
        let Some((there, local)) = tried else { break };
        (place, here) = (there, local);
    }
    place
}
