//! Realisations of a random friction process.

use rand_distr::{Distribution, StandardNormal};

use super::jacobi::JacobiStep;
use super::moving_average::MovingAverage;
use super::renewal::Renewal;
use super::spectral::Harmonics;
use super::table::TranslationTable;
use super::{Cell, CorrelationShape, EqualCells, Fluctuation, FrictionProcess, Generator};
use asperity_base::random::{self, Stream};

/// Name of the random stream of friction processes.
const STAGE: &str = "friction process";

/// Realisation of a [`FrictionProcess`], generated while it is read, without end.
///
/// Use either [`Path::next_value`], point by point, or [`Fluctuation`], cell by cell, but not both.
#[derive(Debug, Clone)]
pub struct Path<'a> {
    rng: Stream,
    source: Source<'a>,
    cells: EqualCells,
    limited: Limited<'a>,
}

#[derive(Debug, Clone)]
enum Source<'a> {
    Autoregressive(Recursion),
    Other(OtherSource<'a>),
}

/// Sources that are rare and whose code is long.
#[derive(Debug, Clone)]
enum OtherSource<'a> {
    Averaged(MovingAverage),
    Spectral(Harmonics),
    Jacobi { g: f64, step: &'a JacobiStep },
    Renewal(Renewal),
}

/// Recursion g_{i+1} = φg_i + √(1 − φ²)ξ.
#[derive(Debug, Clone, Copy)]
struct Recursion {
    g: f64,
    coefficient: f64,
    innovation: f64,
}

impl Recursion {
    /// Returns the value at this grid point and moves to the next.
    #[inline]
    fn advance(&mut self, xi: f64) -> f64 {
        let next = self.coefficient * self.g + self.innovation * xi;
        std::mem::replace(&mut self.g, next)
    }
}

/// Translation of normal values to m, with clipping at the least value, if there is one.
#[derive(Debug, Clone, Copy)]
struct Limited<'a> {
    table: &'a TranslationTable,
    /// Least value; −∞ without clipping.
    least: f64,
    clipped: u64,
}

impl Limited<'_> {
    #[inline]
    fn value(&mut self, normal: f64) -> f64 {
        let m = self.table.value(normal);
        if m < self.least {
            self.clipped += 1;
            return self.least;
        }
        m
    }
}

impl FrictionProcess {
    /// Returns realisation `index` under `seed`.
    pub fn path(&self, seed: u64, index: u64) -> Path<'_> {
        Path::new(self, random::stream(seed, STAGE, index))
    }
}

impl<'a> Path<'a> {
    fn new(process: &'a FrictionProcess, mut rng: Stream) -> Self {
        let (model, parts) = (process.model(), process.parts());
        let step_fraction = process.step() / parts.length;
        let source = match (model.generator, model.shape, parts.jacobi) {
            (Generator::Renewal, ..) => Source::Other(OtherSource::Renewal(Renewal::new(parts.length, process.step()))),
            (Generator::Jacobi, _, Some(step)) => {
                Source::Other(OtherSource::Jacobi { g: StandardNormal.sample(&mut rng), step })
            }
            (Generator::Spectral { harmonics }, shape, _) => {
                let quantile = |probability| shape.spectral_quantile(probability).unwrap_or(f64::NAN);
                Source::Other(OtherSource::Spectral(Harmonics::draw(harmonics, step_fraction, quantile, &mut rng)))
            }
            (_, CorrelationShape::WindowedExponential { window }, _) => {
                let steps = (window / process.step()).round() as usize;
                Source::Other(OtherSource::Averaged(MovingAverage::draw(steps, step_fraction, &mut rng)))
            }
            _ => {
                let coefficient = process.normal_step_correlation();
                // Computes 1 − φ² without cancellation.
                let innovation = (-(-2.0 * step_fraction).exp_m1()).sqrt();
                Source::Autoregressive(Recursion { g: StandardNormal.sample(&mut rng), coefficient, innovation })
            }
        };
        let least = model.least.unwrap_or(f64::NEG_INFINITY);
        let limited = Limited { table: parts.table, least, clipped: 0 };
        Self { rng, source, cells: EqualCells::new(process.step()), limited }
    }

    /// Returns m at the next grid point, the first at s = 0. A renewal process is sampled there.
    #[inline]
    pub fn next_value(&mut self) -> f64 {
        match &mut self.source {
            Source::Autoregressive(recursion) => {
                let normal = recursion.advance(StandardNormal.sample(&mut self.rng));
                self.limited.value(normal)
            }
            Source::Other(other) => other.next_value(&mut self.rng, &mut self.limited),
        }
    }

    /// Returns the number of values so far that were raised to the least one: grid points, or intervals of a renewal
    /// process.
    pub fn clipped(&self) -> u64 {
        self.limited.clipped
    }
}

impl OtherSource<'_> {
    /// Returns m at the next grid point. The loops over paths call it, because inlined it would slow down the common source.
    #[inline(never)]
    fn next_value(&mut self, rng: &mut Stream, limited: &mut Limited<'_>) -> f64 {
        let normal = match self {
            Self::Averaged(average) => average.advance(rng),
            Self::Spectral(harmonics) => harmonics.advance(),
            Self::Jacobi { g, step } => {
                let next = step.next(*g, StandardNormal.sample(rng));
                std::mem::replace(g, next)
            }
            Self::Renewal(renewal) => return renewal.next_value(rng, |normal| limited.value(normal)),
        };
        limited.value(normal)
    }
}

impl Fluctuation for Path<'_> {
    // As in [`Cancellable`](super::Cancellable).
    #[inline(always)]
    fn next_cell(&mut self) -> Option<Cell> {
        if let Source::Other(OtherSource::Renewal(renewal)) = &mut self.source {
            return Some(renewal.cell(&mut self.rng, |normal| self.limited.value(normal)));
        }
        let left = match self.cells.last {
            Some(left) => left,
            None => self.next_value(),
        };
        let right = self.next_value();
        Some(self.cells.close(left, right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ProcessError, ProcessModel, TranslationKind};
    use asperity_base::choice::Choice;
    use asperity_base::distribution::goodness::kolmogorov_smirnov;
    use asperity_base::stats::Moments;

    fn model(marginal: &str, generator: Generator) -> ProcessModel {
        ProcessModel { generator, ..ProcessModel::new(marginal.parse().unwrap(), 0.002, 3.0) }
    }

    #[test]
    fn diffusion_and_renewal_are_stationary_with_exponential_correlation() {
        for (marginal, generator, skewness) in [
            ("beta:2.1,5", Generator::Jacobi, 0.5598),
            ("beta:0.5,0.5", Generator::Jacobi, 0.0),
            ("beta:2.1,5", Generator::Renewal, 0.5598),
            ("gamma:4,1", Generator::Renewal, 1.0),
        ] {
            // The correction has no effect.
            let model = ProcessModel { correlation: TranslationKind::Corrected, ..model(marginal, generator) };
            let process = FrictionProcess::new(model.clone()).unwrap();
            let paths: Vec<Vec<f64>> = (0..20_000)
                .map(|i| {
                    let mut path = process.path(7, i);
                    (0..61).map(|_| path.next_value() / 0.002).collect()
                })
                .collect();
            let mean_of = |f: &dyn Fn(&[f64]) -> f64| {
                let moments = Moments::new(&paths.iter().map(|m| f(m)).collect::<Vec<f64>>());
                (moments.mean, 4.0 * moments.standard_error())
            };
            for (power, wanted) in [(1, 0.0), (2, 1.0), (3, skewness)] {
                let (found, margin) = mean_of(&|m| m[60].powi(power));
                assert!((found - wanted).abs() < margin, "{marginal} {generator:?}: mean of m^{power} is {found}");
            }
            for lag in [1, 10, 20, 60] {
                let wanted = (-0.05 * lag as f64).exp();
                assert!((process.correlation_at(0.15 * lag as f64) - wanted).abs() < 1e-14);
                let (found, margin) = mean_of(&|m| m[0] * m[lag]);
                assert!((found - wanted).abs() < margin, "{marginal} {generator:?}: {found} at {lag}, not {wanted}");
            }
            // Distribution after sixty steps.
            let standard = model.marginal.standardised(0.0, 1.0).unwrap();
            let last: Vec<f64> = paths.iter().map(|m| m[60]).collect();
            let p = kolmogorov_smirnov(&last, &standard, None).unwrap().p_value;
            assert!(p > 0.001, "{marginal} {generator:?}: p = {p}");
        }
    }

    #[test]
    fn a_diffusion_slows_down_at_its_bounds_according_to_its_variance() {
        // Var[X_h | x] from the second eigenfunction, binned by x, compared with the squared changes of many steps.
        let process = FrictionProcess::new(model("beta:2.1,5", Generator::Jacobi)).unwrap();
        let mut path = process.path(3, 0);
        let points: Vec<f64> = (0..400_000).map(|_| path.next_value()).collect();
        let (a, b, h) = (2.1, 5.0, 0.05_f64);
        let (mean, std) = (0.295_775, 0.025_715_f64.sqrt());
        let x: Vec<f64> = points.iter().map(|m| mean + m / 0.002 * std).collect();
        let mut errors = [(0.0, 0.0, 0.0); 5];
        for pair in x.windows(2) {
            // E[X] and E[X²] after h solve two linear equations.
            let first = mean + (pair[0] - mean) * (-h).exp();
            let fast = 2.0 * (1.0 + a + b) / (a + b);
            let forced = 2.0 * mean + 2.0 / (a + b);
            // d E[X²]/ds = −fast E[X²] + forced E[X].
            let settled = forced * mean / fast;
            let slow = forced * (pair[0] - mean) / (fast - 1.0);
            let second = settled + slow * (-h).exp() + (pair[0] * pair[0] - settled - slow) * (-fast * h).exp();
            let deviation = (pair[1] - first).powi(2) - (second - first * first);
            let (count, sum, squares) = &mut errors[((pair[0] * 6.0) as usize).min(4)];
            (*count, *sum, *squares) = (*count + 1.0, *sum + deviation, *squares + deviation * deviation);
        }
        for (count, sum, squares) in errors {
            assert!(count > 1000.0 && f64::abs(sum) < 4.0 * f64::sqrt(squares), "{count} {sum} {squares}");
        }
    }

    #[test]
    fn cells_join_the_grid_points_and_cells_of_a_renewal_process_jump() {
        let process = FrictionProcess::new(model("beta:2.1,5", Generator::Jacobi)).unwrap();
        let (mut points, mut cells) = (process.path(5, 2), process.path(5, 2));
        let mut left = points.next_value();
        for i in 1..200 {
            let right = points.next_value();
            let cell = Cell { end: f64::from(i) * process.step(), length: process.step(), left, right };
            assert_eq!(cells.next_cell(), Some(cell));
            left = right;
        }
        let process = FrictionProcess::new(model("beta:2.1,5", Generator::Renewal)).unwrap();
        let (mut points, mut path) = (process.path(5, 2), process.path(5, 2));
        let cells: Vec<Cell> = (0..2000).map(|_| path.next_cell().unwrap()).collect();
        assert!(cells.iter().all(|cell| cell.left == cell.right && cell.length > 0.0));
        let mean = cells[1999].end / 2000.0;
        assert!((mean - 3.0).abs() < 4.0 * 3.0 / 2000.0_f64.sqrt(), "{mean}");
        for i in 0..20_000 {
            let place = f64::from(i) * process.step();
            assert_eq!(cells.iter().find(|cell| place < cell.end).map(|cell| cell.left), Some(points.next_value()));
        }
    }

    #[test]
    fn unsupported_distributions_and_correlations_are_refused_by_name() {
        let refused = |marginal: &str, generator, shape| {
            FrictionProcess::new(ProcessModel { shape, ..model(marginal, generator) }).unwrap_err()
        };
        let error = refused("gamma:2,1", Generator::Jacobi, CorrelationShape::Exponential);
        assert_eq!(error, ProcessError::Marginal { generator: "jacobi", distribution: "gamma", wanted: "beta" });
        assert!(error.to_string().contains("beta distributions, not gamma"), "{error}");
        for generator in [Generator::Jacobi, Generator::Renewal] {
            let error = refused("beta:2.1,5", generator, CorrelationShape::SquaredExponential).to_string();
            assert!(error.contains(generator.name()) && error.contains("spectral"), "{error}");
        }
        let fine = ProcessModel { steps_per_length: 2000, ..model("beta:2.1,5", Generator::Jacobi) };
        assert!(FrictionProcess::new(fine).is_err());
    }
}
