//! Tests of records for drift that account for their correlation.

use super::checked_moments;
use crate::correlation::estimate::EstimateError;
use crate::numeric::dot;
use crate::random;
use crate::stats::{Moments, correlation_time, student_two_sided};

/// Number of records from which each is one independent observation; fewer are divided into blocks.
const MANY: usize = 10;
/// Length of a block in integrated correlation times; means of neighbouring blocks then have a correlation of about
/// 1/40.
const BLOCK: f64 = 10.0;
/// Least length of a block if a record would otherwise have fewer than four.
const SHORTEST_BLOCK: f64 = 5.0;
/// Largest number of blocks of a record.
const MOST_BLOCKS: usize = 32;
/// Number of samples of the null distribution of the wander statistic.
const DRAWS: usize = 4000;

/// Two-sided Student test of a drift common to all records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftTest {
    /// Estimate; see [`Stationarity`].
    pub estimate: f64,
    /// Standard error.
    pub standard_error: f64,
    /// Degrees of freedom.
    pub degrees_of_freedom: f64,
    /// p-value.
    pub p_value: f64,
}

/// Test for a wandering mean: the mean square of the cumulative sums of block means within the records over their
/// variance, after Kwiatkowski, Phillips, Schmidt & Shin, *J. Econometrics* **54** (1992) 159,
/// <https://doi.org/10.1016/0304-4076(92)90104-Y>. Blocks replace their correction for correlation, and the null
/// distribution is simulated with the same number of independent normal blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wander {
    /// η = Σ S²/(records · blocks² · variance).
    pub statistic: f64,
    /// p-value.
    pub p_value: f64,
}

/// Tests of records for drifts along them from a common initial position, such as edge effects on free strips or the
/// running-in of measured records.
///
/// With ten or more records, each record is one observation of each drift, and the correlation is not needed. Fewer
/// records are divided into blocks of ten integrated correlation times (at least five), whose means are nearly
/// independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stationarity {
    /// Slope per metre.
    pub trend: DriftTest,
    /// Difference of the means of the second and the first half.
    pub mean_change: DriftTest,
    /// Difference of the means of the outer quarters and the inner half.
    pub ends: DriftTest,
    /// Logarithm of the variance ratio of the second to the first half.
    pub variance_change: DriftTest,
    /// Test of the mean of each record; absent with ten or more records.
    pub wander: Option<Wander>,
    /// Number of blocks per record; 1 if whole records are compared.
    pub blocks: usize,
}

impl Stationarity {
    /// Tests records of equal step with `tracks` records per strip; the blocks of parallel tracks are averaged. Values
    /// beyond the shortest record are ignored, and NaN is a missing value.
    ///
    /// # Errors
    /// A step that is not positive, values that do not vary, or fewer than ten records shorter than twenty correlation
    /// times.
    pub fn new(records: &[&[f64]], tracks: usize, step_m: f64) -> Result<Self, EstimateError> {
        let n = records.iter().map(|record| record.len()).min().unwrap_or(0);
        let records: Vec<&[f64]> = records.iter().map(|record| &record[..n]).collect();
        let moments = checked_moments(records.iter().flat_map(|record| record.iter().copied()), step_m, 8)?;
        if n < 8 {
            return Err(EstimateError::TooFew { present: moments.n, wanted: 8 });
        }
        let times: Vec<f64> = records
            .iter()
            .filter_map(|record| correlation_time(&without_drift(record)).ok())
            .map(|time| time.steps)
            .collect();
        let found = times.iter().sum::<f64>() / times.len().max(1) as f64;
        // Removing three degrees of freedom from every record reduces the correlation time by about 3τ/n.
        let time = found / (1.0 - 3.0 * found / n as f64).max(0.1);
        let within = blocks_within(n, time);
        let many = records.len().div_ceil(tracks) >= MANY;
        let wander =
            within.filter(|_| !many).and_then(|blocks| Wander::new(&means(&records, tracks, blocks, |value| value)));
        let blocks = match within {
            _ if many => 4 * (n / 8).clamp(1, 4),
            Some(blocks) => blocks,
            None => return Err(EstimateError::TooFew { present: n, wanted: (4.0 * SHORTEST_BLOCK * time) as usize }),
        };
        let values = means(&records, tracks, blocks, |value| value);
        let variance = moments.std * moments.std;
        // Mean squares of blocks are skewed; their logarithms hardly are.
        let mut squares = means(&records, tracks, blocks, |value| (value - moments.mean).powi(2) / variance);
        squares.iter_mut().flatten().for_each(|square| *square = square.max(f64::MIN_POSITIVE).ln());
        let middle = 0.5 * (blocks as f64 - 1.0);
        let block_m = n as f64 * step_m / blocks as f64;
        let line: Vec<f64> = (0..blocks).map(|b| b as f64 - middle).collect();
        let halves: Vec<f64> = (0..blocks).map(|b| if 2 * b < blocks { -0.5 } else { 0.5 }).collect();
        let outer: Vec<f64> =
            (0..blocks).map(|b| if 4 * b < blocks || 4 * b >= 3 * blocks { 0.5 } else { -0.5 }).collect();
        let test = |values: &[Vec<f64>], contrast: &[f64]| DriftTest::new(values, contrast, many);
        let slope = test(&values, &line);
        Ok(Self {
            trend: DriftTest {
                estimate: slope.estimate / block_m,
                standard_error: slope.standard_error / block_m,
                ..slope
            },
            mean_change: test(&values, &halves),
            ends: test(&values, &outer),
            variance_change: test(&squares, &halves),
            wander,
            blocks: if many { 1 } else { blocks },
        })
    }
}

/// Returns the residuals of the record about its best-fitting parabola, so that a drift is not mistaken for
/// correlation.
fn without_drift(record: &[f64]) -> Vec<f64> {
    let n = record.len() as f64;
    let at = |i: usize| (2.0 * i as f64 + 1.0) / n - 1.0;
    let mean = Moments::new(record).mean;
    let mut left: Vec<f64> = record.iter().map(|value| value - mean).collect();
    // Legendre polynomials are nearly orthogonal on the points.
    for polynomial in [|x: f64| x, |x: f64| 1.5 * x * x - 0.5] {
        let present = || left.iter().enumerate().filter(|(_, value)| value.is_finite());
        let square: f64 = present().map(|(i, _)| polynomial(at(i)).powi(2)).sum();
        let fraction = present().map(|(i, value)| polynomial(at(i)) * value).sum::<f64>() / square;
        left.iter_mut().enumerate().for_each(|(i, value)| *value -= fraction * polynomial(at(i)));
    }
    left
}

/// Returns the blocks of a record, a multiple of four; empty with fewer than four.
fn blocks_within(n: usize, time: f64) -> Option<usize> {
    let of = |times: f64| (n as f64 / (times * time)) as usize / 4 * 4;
    let blocks = if of(BLOCK) >= 4 { of(BLOCK) } else { of(SHORTEST_BLOCK).min(4) };
    (blocks >= 4).then_some(blocks.min(MOST_BLOCKS))
}

/// Returns the means of a function of the values over equal blocks of every strip; an empty block takes the mean of the
/// record.
fn means(records: &[&[f64]], tracks: usize, blocks: usize, of: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
    let mean = |values: &[f64]| Moments::from_values(values.iter().map(|value| of(*value))).mean;
    let of_records: Vec<Vec<f64>> = records
        .iter()
        .map(|record| {
            let all = mean(record);
            let block = |b: usize| mean(&record[b * record.len() / blocks..(b + 1) * record.len() / blocks]);
            (0..blocks).map(block).map(|value| if value.is_nan() { all } else { value }).collect()
        })
        .collect();
    of_records
        .chunks(tracks)
        .map(|strip| {
            let block = |b: usize| strip.iter().map(|means| means[b]).sum::<f64>() / strip.len() as f64;
            (0..blocks).map(block).collect()
        })
        .filter(|means: &Vec<f64>| means.iter().all(|value| value.is_finite()))
        .collect()
}

impl DriftTest {
    /// Estimates the coefficient of a contrast of sum zero in block means: from one value per record, or from the
    /// residuals of all blocks about the mean of their record and the contrast.
    fn new(values: &[Vec<f64>], contrast: &[f64], by_record: bool) -> Self {
        let records = values.len() as f64;
        let norm = dot(contrast, contrast);
        let coefficients: Vec<f64> = values.iter().map(|means| dot(means, contrast) / norm).collect();
        let estimate = coefficients.iter().sum::<f64>() / records;
        let (standard_error, degrees_of_freedom) = if by_record {
            (Moments::new(&coefficients).standard_error(), records - 1.0)
        } else {
            let residual = |means: &Vec<f64>| {
                let mean = means.iter().sum::<f64>() / means.len() as f64;
                means.iter().zip(contrast).map(|(y, c)| (y - mean - estimate * c).powi(2)).sum::<f64>()
            };
            let freedom = records * (contrast.len() as f64 - 1.0) - 1.0;
            let variance = values.iter().map(residual).sum::<f64>() / freedom;
            ((variance / (records * norm)).sqrt(), freedom)
        };
        let t = estimate.abs() / standard_error;
        let p_value = student_two_sided(t, degrees_of_freedom);
        Self { estimate, standard_error, degrees_of_freedom, p_value }
    }

    /// Returns whether the drift is significant at 5 %.
    pub fn significant(&self) -> bool {
        self.p_value < 0.05
    }
}

impl Wander {
    fn new(values: &[Vec<f64>]) -> Option<Self> {
        let (records, blocks) = (values.len(), values.first()?.len());
        let statistic = wander(values);
        let mut stream = random::stream(0, "stationarity/wander", 0);
        let above = (0..DRAWS)
            .filter(|_| {
                let drawn: Vec<Vec<f64>> = (0..records).map(|_| random::standard_normal(&mut stream, blocks)).collect();
                wander(&drawn) >= statistic
            })
            .count();
        Some(Self { statistic, p_value: (above + 1) as f64 / (DRAWS + 1) as f64 })
    }

    /// Returns whether the wandering is significant at 5 %.
    pub fn significant(&self) -> bool {
        self.p_value < 0.05
    }
}

fn wander(values: &[Vec<f64>]) -> f64 {
    let (mut cumulative, mut squares) = (0.0, 0.0);
    for means in values {
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let mut sum = 0.0;
        for value in means {
            sum += value - mean;
            cumulative += sum * sum;
            squares += (value - mean).powi(2);
        }
    }
    let (records, blocks) = (values.len() as f64, values.first().map_or(0, Vec::len) as f64);
    cumulative / (records * blocks * blocks * (squares / (records * (blocks - 1.0))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a stationary record with correlation φ^lag plus `drift` of the position along the record, from 0 to 1.
    fn record(phi: f64, n: usize, index: u64, drift: impl Fn(f64) -> (f64, f64)) -> Vec<f64> {
        let noise = random::standard_normal(&mut random::stream(47, "stationarity", index), n);
        let mut last = noise[0];
        let at = |(i, e): (usize, &f64)| {
            last = phi * last + (1.0 - phi * phi).sqrt() * e;
            let (mean, scale) = drift(i as f64 / n as f64);
            mean + scale * last
        };
        noise.iter().enumerate().map(at).collect()
    }

    fn fractions(records: usize, n: usize, drift: impl Fn(f64) -> (f64, f64) + Copy) -> [f64; 5] {
        let runs = 150_u64;
        let mut counts = [0.0; 5];
        for run in 0..runs {
            let drawn: Vec<Vec<f64>> =
                (0..records as u64).map(|r| record(0.9, n, run * records as u64 + r, drift)).collect();
            let views: Vec<&[f64]> = drawn.iter().map(Vec::as_slice).collect();
            let found = Stationarity::new(&views, 1, 1.0).unwrap();
            let wander = found.wander.is_some_and(|wander| wander.significant());
            let flags = [
                found.trend.significant(),
                found.mean_change.significant(),
                found.ends.significant(),
                found.variance_change.significant(),
                wander,
            ];
            counts.iter_mut().zip(flags).for_each(|(count, flag)| *count += f64::from(u8::from(flag)) / runs as f64);
        }
        counts
    }

    #[test]
    fn records_with_equal_block_means_have_no_significance() {
        let records = vec![[1.0, -1.0].repeat(200); 12];
        let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
        let found = Stationarity::new(&views, 1, 1.0).unwrap();
        let change = found.mean_change;
        assert!(change.estimate == 0.0 && change.p_value.is_nan() && !change.significant(), "{found:?}");
    }

    #[test]
    fn stationary_records_are_called_so() {
        // 5 % of 150 runs ± 1.8 %: three standard errors and some per cent for the correlation of the blocks.
        for (records, n) in [(1, 4000), (3, 1500), (20, 200)] {
            for (test, fraction) in fractions(records, n, |_| (0.0, 1.0)).into_iter().enumerate() {
                assert!(
                    fraction < 0.115 && (fraction > 0.0 || test == 4),
                    "{records} records, test {test}: {fraction}"
                );
            }
        }
    }

    #[test]
    fn planted_drifts_are_seen() {
        // A rise by one standard deviation along 200 correlation lengths: the mean of a half has the standard error
        // √(2·2/200)/… ≈ .14.
        let trend = fractions(1, 4000, |x| (1.5 * x, 1.0));
        assert!(trend[0] > 0.9 && trend[1] > 0.8, "{trend:?}");
        let ends = fractions(20, 200, |x| (if !(0.25..0.75).contains(&x) { 0.5 } else { 0.0 }, 1.0));
        assert!(ends[2] > 0.8 && ends[0] < 0.15, "{ends:?}");
        let louder = fractions(3, 1500, |x| (0.0, 1.0 + x));
        assert!(louder[3] > 0.8, "{louder:?}");
    }

    #[test]
    fn short_records_are_rejected() {
        // Four blocks of five correlation times, each at least one step, require twenty values.
        let short = record(0.9, 16, 1, |_| (0.0, 1.0));
        assert!(matches!(Stationarity::new(&[&short], 1, 1.0), Err(EstimateError::TooFew { present: 16, .. })));
        assert!(matches!(Stationarity::new(&[&[1.0; 20]], 1, 1.0), Err(EstimateError::Constant { .. })));
    }
}
