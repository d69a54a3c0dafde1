//! Curves through a record with gaps: polynomials and the Gaussian mean line.

use asperity_base::fourier::{RealFft2, good_length};

/// Constant α of the Gaussian filter of ISO 16610-21: √(ln 2/π); a wave of the cutoff length is halved.
const ALPHA: f64 = 0.469_718_639_349_825_56;

/// Returns the least-squares polynomial through the present values, at all positions.
///
/// Uses discrete orthogonal polynomials by their three-term recurrence (Forsythe, *J. SIAM* **5** (1957) 74), so that
/// no degree is ill-conditioned. The degree is reduced to the highest one that the present values determine.
pub(super) fn polynomial(values: &[f64], degree: usize) -> Vec<f64> {
    let n = values.len();
    let present: Vec<usize> = (0..n).filter(|i| !values[*i].is_nan()).collect();
    let x: Vec<f64> = (0..n).map(|i| 2.0 * i as f64 / (n.max(2) - 1) as f64 - 1.0).collect();
    let dot = |f: &dyn Fn(usize) -> f64| present.iter().map(|i| f(*i)).sum::<f64>();
    let (mut before, mut here) = (vec![0.0; n], vec![1.0; n]);
    let mut curve = vec![0.0; n];
    let mut square_before = 1.0;
    for k in 0..=degree.min(present.len().saturating_sub(1)) {
        let square = dot(&|i| here[i] * here[i]);
        // Remaining error of the curve: later terms correct the rounding of earlier terms.
        let fraction = dot(&|i| here[i] * (values[i] - curve[i])) / square;
        for (value, term) in curve.iter_mut().zip(&here) {
            *value += fraction * term;
        }
        let middle = dot(&|i| x[i] * here[i] * here[i]) / square;
        let back = if k == 0 { 0.0 } else { square / square_before };
        let next = (0..n).map(|i| (x[i] - middle) * here[i] - back * before[i]).collect();
        before = std::mem::replace(&mut here, next);
        square_before = square;
    }
    curve
}

/// Returns the Gaussian weighted mean of the present values around every position; NaN if none is within reach.
///
/// Weights are e^{−π(x/(αλ))²} with the cutoff λ = `cutoff_steps`, as in ISO 16610-21, divided by their sum over the
/// present values, so that ends and gaps need no continuation.
pub(super) fn gaussian(values: &[f64], cutoff_steps: f64) -> Vec<f64> {
    let n = values.len();
    let weight = |distance: usize| (-std::f64::consts::PI * (distance as f64 / (ALPHA * cutoff_steps)).powi(2)).exp();
    let reach = ((1.5 * cutoff_steps).ceil() as usize).min(n.saturating_sub(1));
    let fft = RealFft2::new(good_length(n + reach + 1), 1);
    let (mut kernel, mut spectrum, mut work) = (fft.spectrum(), fft.spectrum(), fft.workspace());
    let mut weights = vec![0.0; fft.nx()];
    for distance in 0..=reach {
        weights[distance] = weight(distance);
        if distance > 0 {
            weights[fft.nx() - distance] = weight(distance);
        }
    }
    fft.forward(&weights, &mut kernel, &mut work);
    let mut smoothed = |values: Vec<f64>| {
        fft.forward_padded(&values, 1, n, &mut spectrum, &mut work);
        for (coefficient, weight) in spectrum.iter_mut().zip(&kernel) {
            *coefficient *= weight;
        }
        let mut means = vec![0.0; n];
        fft.inverse_cropped(&mut spectrum, &mut means, 1, n, &mut work);
        means
    };
    let sums = smoothed(values.iter().map(|value| if value.is_nan() { 0.0 } else { *value }).collect());
    let weights = smoothed(values.iter().map(|value| if value.is_nan() { 0.0 } else { 1.0 }).collect());
    // A weight of the order of rounding counts as zero.
    let mean = |(sum, weight): (f64, f64)| if weight > 1e-9 { sum / weight } else { f64::NAN };
    sums.into_iter().zip(weights).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_recovered_for_any_degree_and_gaps() {
        let exact = |x: f64| 0.2 + 0.1 * x - 0.3 * x.powi(2) + 0.05 * x.powi(7);
        let x = |i: usize| 2.0 * i as f64 / 500.0 - 1.0;
        let values: Vec<f64> = (0..501).map(|i| if (100..180).contains(&i) { f64::NAN } else { exact(x(i)) }).collect();
        for degree in [7, 12, 30] {
            let curve = polynomial(&values, degree);
            // Inside the gap a high degree amplifies rounding.
            let worst = (0..501).filter(|i| !values[*i].is_nan()).map(|i| (curve[i] - exact(x(i))).abs());
            assert!(worst.fold(0.0, f64::max) < 1e-12, "{degree}");
        }
        assert!(polynomial(&values, 3).iter().zip(&values).any(|(a, b)| (a - b).abs() > 1e-4));
        assert_eq!(polynomial(&[f64::NAN, 2.0, f64::NAN], 3), [2.0; 3]);
    }

    #[test]
    fn the_gaussian_mean_is_the_direct_sum_and_halves_a_wave_of_the_cutoff() {
        let n = 400;
        let mut values: Vec<f64> = (0..n).map(|i| (0.37 * f64::from(i)).sin() + 1e-3 * f64::from(i)).collect();
        values[50..90].fill(f64::NAN);
        let cutoff = 30.0;
        let smoothed = gaussian(&values, cutoff);
        for place in [0, 3, 55, 70, 200, 399] {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (i, value) in values.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
                let x = (i as f64 - place as f64) / (ALPHA * cutoff);
                let weight = (-std::f64::consts::PI * x * x).exp();
                (sum, weights) = (sum + weight * value, weights + weight);
            }
            assert!((smoothed[place] - sum / weights).abs() < 1e-9, "{place}");
        }
        let wave: Vec<f64> = (0..6000).map(|i| (std::f64::consts::TAU * f64::from(i) / 60.0).cos()).collect();
        assert!((gaussian(&wave, 60.0)[3000] - 0.5).abs() < 1e-6);
        assert!(gaussian(&[1.0, f64::NAN, f64::NAN, f64::NAN, f64::NAN, f64::NAN], 1.0)[5].is_nan());
    }
}
