//! Separation of the variance of friction between two rough bodies into differences between parts and the fluctuation along the
//! path.
//!
//! The difference of the friction of one window at two sliding distances contains neither its constant part nor the mean. Its
//! semivariance ½E[(F(x, s + h) − F(x, s))²] = φ(1 − ρ(h)) is free of bias; far apart it is φ.

use asperity_base::correlation::{RecordCorrelation, RecordModel, fit_record};
use asperity_base::stats::{Interval, jackknife_reach};

use super::distances::Distances;

/// Smallest number of strips with a jackknife interval.
const LEAST_STRIPS: usize = 4;

/// Friction of a window between two rough bodies at the mean load ([`Record::at_mean_load`](crate::strip::Record::at_mean_load)).
///
/// The squares of `between_parts_std` and `path_std` add up to the variance of all windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoBodyFriction {
    /// Standard deviation between parts of the slider.
    pub between_parts_std: f64,
    /// 95 % interval of `between_parts_std` by the jackknife over strips; `None` with fewer than four strips.
    pub between_parts_interval: Option<Interval>,
    /// Standard deviation of the fluctuation along the path.
    pub path_std: f64,
    /// Correlation length in metre of e^{−h/ℓ} fitted to the correlation of the fluctuation over the sliding distance; it contains
    /// the effect of the window. At least half of the shortest distance, and the length of the window if nothing fluctuates.
    pub path_length_m: f64,
    /// 95 % interval of `path_length_m` by the jackknife over strips; `None` with fewer than four strips.
    pub path_length_interval_m: Option<Interval>,
}

/// Separates the variance `std`² of friction. `values` are the deviations of friction of each strip from the common mean, by
/// sliding distance and then by window.
pub(super) fn split(values: &[Vec<Vec<f64>>], distances: &Distances, std: f64, window_m: f64) -> TwoBodyFriction {
    let strips: Vec<Sums> = values.iter().map(|values| Sums::of_strip(values, distances)).collect();
    let whole = Sums::mean(&strips, None);
    if !(whole.far > 0.0 && whole.variance() > 0.0) {
        return TwoBodyFriction {
            between_parts_std: std,
            between_parts_interval: None,
            path_std: 0.0,
            path_length_m: window_m,
            path_length_interval_m: None,
        };
    }
    // The variance at all distances differs from that at rest by chance.
    let scale = std * std / whole.variance();
    let between_parts = |sums: &Sums| scale * (sums.variance() - sums.far);
    let length_m = |sums: &Sums| sums.length_m(distances).unwrap_or(window_m);
    let left: Vec<Sums> = (0..strips.len()).map(|left_out| Sums::mean(&strips, Some(left_out))).collect();
    let interval = |statistic: &dyn Fn(&Sums) -> f64| {
        let reach = jackknife_reach(&left.iter().map(statistic).collect::<Vec<_>>());
        let value = statistic(&whole);
        (left.len() >= LEAST_STRIPS).then(|| Interval { low: (value - reach).max(0.0), high: (value + reach).max(0.0) })
    };
    let variance = between_parts(&whole).max(0.0);
    TwoBodyFriction {
        between_parts_std: variance.sqrt(),
        between_parts_interval: interval(&between_parts)
            .map(|squared| Interval { low: squared.low.sqrt(), high: squared.high.sqrt() }),
        path_std: (std * std - variance).max(0.0).sqrt(),
        path_length_m: length_m(&whole),
        path_length_interval_m: interval(&length_m),
    }
}

/// Mean squares over the windows of one strip or of several.
#[derive(Debug, Clone)]
struct Sums {
    /// Mean deviation.
    mean: f64,
    /// Mean square of the deviation.
    square: f64,
    /// Squared standard error of the mean; 0 for one strip.
    error: f64,
    /// Semivariance at each of the near distances.
    near: Vec<f64>,
    /// Semivariance far apart.
    far: f64,
}

impl Sums {
    fn of_strip(values: &[Vec<f64>], distances: &Distances) -> Self {
        let semivariance = |pairs: &[[usize; 2]]| {
            let of_pair =
                |[a, b]: &[usize; 2]| mean(values[*a].iter().zip(&values[*b]).map(|(a, b)| 0.5 * (a - b).powi(2)));
            mean(pairs.iter().map(of_pair))
        };
        Self {
            mean: mean(values.iter().flatten().copied()),
            square: mean(values.iter().flatten().map(|value| value * value)),
            error: 0.0,
            near: distances.near.values().map(|pairs| semivariance(pairs)).collect(),
            far: semivariance(&distances.far),
        }
    }

    /// Averages strips, except one.
    fn mean(strips: &[Self], left_out: Option<usize>) -> Self {
        let kept: Vec<&Self> =
            strips.iter().enumerate().filter(|(strip, _)| Some(*strip) != left_out).map(|(_, sums)| sums).collect();
        let average = |value: &dyn Fn(&Self) -> f64| mean(kept.iter().map(|sums| value(sums)));
        let centre = average(&|sums| sums.mean);
        let freedom = kept.len().saturating_sub(1).max(1) as f64;
        Self {
            mean: centre,
            square: average(&|sums| sums.square),
            error: average(&|sums| (sums.mean - centre).powi(2)) / freedom,
            near: (0..strips[0].near.len()).map(|place| average(&|sums| sums.near[place])).collect(),
            far: average(&|sums| sums.far),
        }
    }

    /// Returns the variance without bias: the mean square about the estimated mean lacks the variance of that mean.
    fn variance(&self) -> f64 {
        self.square - self.mean * self.mean + self.error
    }

    /// Fits the correlation length of the fluctuation in metre.
    ///
    /// The correlation at equal steps is interpolated between the solved distances, so the fit is that of a track.
    fn length_m(&self, distances: &Distances) -> Option<f64> {
        let solved = distances.near.keys().zip(&self.near).map(|(cells, near)| (*cells, 1.0 - near / self.far));
        let points: Vec<(usize, f64)> = std::iter::once((0, 1.0)).chain(solved).collect();
        let step = points.get(1)?.0;
        let at = |cells: usize| {
            let after = points.partition_point(|point| point.0 < cells).max(1);
            let ((low, before), (high, behind)) = (points[after - 1], points[after]);
            before + (behind - before) * (cells - low) as f64 / (high - low) as f64
        };
        let correlation: Vec<f64> = (0..=points[points.len() - 1].0 / step).map(|place| at(place * step)).collect();
        let record = RecordCorrelation {
            step_m: step as f64 * distances.cell_m,
            pairs: vec![1.0; correlation.len()],
            correlation,
            mean: 0.0,
            variance: self.far,
        };
        // A correlation that falls to zero within one step, linearly, has the integral of e^{−h/ℓ} with half a step.
        let least_m = 0.5 * record.step_m;
        fit_record(&record, RecordModel::Exponential).ok().map(|fit| fit.length_m.max(least_m))
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    sum / count as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::map::Grid;
    use asperity_base::random;
    use asperity_base::stats::Moments;
    use asperity_testing::{covered, repetitions};

    const CELLS: usize = 400;
    const WINDOW: usize = 20;

    fn distances() -> Distances {
        Distances::new(Grid::new(CELLS, 2, 1e-6, 1e-6).unwrap(), WINDOW as f64 * 1e-6, Some(2e-6))
    }

    /// Moving averages of white noise over a window, times a factor; neighbours by h have the correlation 1 − h/W.
    fn averages(factor: f64, run: u64) -> Vec<f64> {
        let noise = random::standard_normal(&mut random::stream(5, "two bodies", run), CELLS);
        let over = |first: usize| (0..WINDOW).map(|cell| noise[(first + cell) % CELLS]).sum::<f64>();
        (0..CELLS).map(|first| factor * over(first) / (WINDOW as f64).sqrt()).collect()
    }

    /// Strips of windows of F(x, s) = T(x + s) + C(x) with these standard deviations of T and C.
    fn strips([track, slider]: [f64; 2], count: u64, run: u64) -> Vec<Vec<Vec<f64>>> {
        let distances = distances();
        (0..count)
            .map(|strip| {
                let own = |body: u64| 2 * (1000 * run + strip) + body;
                let (track, slider) = (averages(track, own(0)), averages(slider, own(1)));
                let after = |s: usize| (0..CELLS).step_by(2).map(|x| track[(x + s) % CELLS] + slider[x]).collect();
                std::iter::once(0).chain(distances.moved().iter().copied()).map(after).collect()
            })
            .collect()
    }

    #[test]
    fn a_sum_of_the_two_bodies_is_separated_without_bias_and_the_intervals_cover_it() {
        let (runs, wanted) = (repetitions(200), [1.0, 0.6]);
        let (mut squares, mut lengths, mut held) = ([0.0; 2], Vec::new(), 0);
        for run in 0..runs as u64 {
            let values = strips(wanted, 10, run);
            let resting: Vec<f64> = values.iter().flat_map(|strip| strip[0].iter().copied()).collect();
            let found = split(&values, &distances(), Moments::new(&resting).std, 20e-6);
            for (square, std) in squares.iter_mut().zip([found.path_std, found.between_parts_std]) {
                *square += std * std / runs as f64;
            }
            let interval = found.between_parts_interval.unwrap();
            assert!(interval.contains(found.between_parts_std));
            held += usize::from(interval.contains(wanted[1]));
            lengths.push(found.path_length_m);
        }
        // The standard error over all runs is 0.01 of the variance; the mean square about the mean of 200 windows that are worth one
        // lacks 1/200.
        for (square, std) in squares.into_iter().zip(wanted) {
            assert!((square - std * std).abs() < 0.03 * 1.36, "{square}");
        }
        let fraction = covered("variability between two bodies", "two rough bodies, ten strips", held, runs);
        assert!((0.9..=0.995).contains(&fraction), "{fraction}");
        // Least squares over the cells of the triangle 1 − h/W give ℓ = 0.605 W.
        let length = Moments::new(&lengths).mean / 20e-6;
        assert!((length / 0.605 - 1.0).abs() < 0.06, "{length}");
    }

    #[test]
    fn one_rough_body_leaves_no_variance_to_the_other() {
        let of = |std: [f64; 2]| split(&strips(std, 10, 0), &distances(), 1.0, 20e-6);
        let slider = of([0.0, 1.0]);
        assert_eq!([slider.between_parts_std, slider.path_std], [1.0, 0.0]);
        // Windows that have nothing in common after a cell have a length of half a cell.
        let noise = |stream: u64| random::standard_normal(&mut random::stream(6, "two bodies", stream), CELLS);
        let white: Vec<Vec<Vec<f64>>> = (0..10).map(|strip| (0..8).map(|s| noise(8 * strip + s)).collect()).collect();
        let found = split(&white, &distances(), 1.0, 20e-6);
        assert!(found.path_std > 0.95 && (found.path_length_m - 0.5e-6).abs() < 0.1e-6, "{found:?}");
        let track = of([1.0, 0.0]);
        assert!(track.between_parts_interval.unwrap().low == 0.0 && track.path_std > 0.9, "{track:?}");
    }
}
