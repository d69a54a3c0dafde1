//! Estimates of Sk, Spk and Svk by a block bootstrap. They depend on the flattest part of the material ratio curve, not
//! on means.

use rand::RngExt;

use super::cells::Cells;
use super::estimate::{Estimate, Values, estimate};
use super::heights::{FITTED, HeightSums, total};
use super::window::Window;
use crate::areal::{EquivalentLine, MaterialRatio};
use asperity_base::blocks;
use asperity_base::random;
use asperity_base::stats::{Interval, Moments, Spread};

/// Number of height classes of equal frequency.
const CLASSES: usize = 256;
/// Number of heights that determine the bounds of the classes.
const SAMPLE: usize = 1 << 16;
/// Largest number of blocks per draw.
const MOST_BLOCKS: usize = 256;
/// Side of a block in correlation lengths.
const BLOCK_LENGTHS: f64 = 3.5;

/// Estimates of Sk, Spk and Svk.
pub(super) type Core = [Option<Estimate>; 3];

/// Draws square blocks of the map with replacement, and computes the curve of each draw. Blocks cut correlations, so
/// their spread is too small. The ratio of the known spread of Sa to its bootstrap spread corrects this.
pub(super) fn core(
    cells: &Cells,
    window: &Window,
    sums: &HeightSums,
    values: &Values,
    removed: f64,
    draws: &Draws,
) -> Core {
    let Some(spread) = window.spread(&sums.mean_size_influence(), FITTED) else { return [None; 3] };
    let classes = Classes::of(cells);
    let replicates = classes.replicates(cells, draws);
    let std = |k: usize| {
        let values: Vec<f64> = replicates.iter().map(|r| r[k]).collect();
        Moments::new(&values).sample_std()
    };
    let wider = spread.variance.sqrt() / (std(3) / classes.mean_size(&total_of(&classes.counts)));
    let of = |k: usize, value: f64| {
        // The draws use heights over their standard deviation.
        let se = std(k) * values.sq_m * wider;
        scaled(value, se, removed, &spread, draws.tail)
    };
    [of(0, values.sk_m), of(1, values.spk_m), of(2, values.svk_m)]
}

/// Settings of the draws.
pub(super) struct Draws {
    pub(super) seed: u64,
    pub(super) resamples: usize,
    pub(super) tail: f64,
}

fn scaled(value: f64, se: f64, removed: f64, spread: &Spread, tail: f64) -> Option<Estimate> {
    let centre = value / (1.0 - removed).sqrt();
    let half = spread.student(tail) * se / centre;
    let interval = Interval { low: centre * (-half).exp(), high: centre * half.exp() };
    estimate(value, centre, se, interval, spread.blocks)
}

/// Number of heights of each cell in each class.
struct Classes {
    /// Bounds of the classes, ascending.
    bounds: Vec<f64>,
    /// Counts, cell after cell.
    counts: Vec<f64>,
}

impl Classes {
    fn of(cells: &Cells) -> Self {
        let points = cells.grid().points();
        let stride = points.div_ceil(SAMPLE);
        let sampled = (0..points).step_by(stride).filter(|point| cells.is_present(*point));
        let mut sample: Vec<f64> = sampled.map(|point| cells.value(point)).collect();
        sample.sort_unstable_by(f64::total_cmp);
        let last = sample.len() - 1;
        let mut bounds: Vec<f64> = (0..=CLASSES).map(|k| sample[k * last / CLASSES]).collect();
        // The sample may miss the extremes.
        let (low, high) = (0..points)
            .map(|point| cells.value(point))
            .fold((bounds[0], bounds[CLASSES]), |(l, h), v| (f64::min(l, v), f64::max(h, v)));
        (bounds[0], bounds[CLASSES]) = (low, high);
        let inner = &bounds[1..CLASSES];
        let counts = cells.histogram(CLASSES, |v| inner.partition_point(|bound| *bound <= v));
        Self { bounds, counts }
    }

    fn replicates(&self, cells: &Cells, draws: &Draws) -> Vec<[f64; 4]> {
        let side = |step: f64, count: usize| ((BLOCK_LENGTHS * cells.length / step).round() as usize).clamp(1, count);
        let (right, down) = (side(cells.step.0, cells.columns), side(cells.step.1, cells.rows));
        let table = self.summed(cells);
        // With fewer blocks than the map has, draws spread more; so does Sa, which scales them.
        let drawn = (cells.rows * cells.columns).div_ceil(right * down).min(MOST_BLOCKS);
        let at = |row: usize, column: usize| &table[(row * (cells.columns + 1) + column) * CLASSES..][..CLASSES];
        let replicate = |index: usize| {
            let mut stream = random::stream(draws.seed, "surface uncertainty", index as u64);
            let mut counts = vec![0.0; CLASSES];
            for _ in 0..drawn {
                let row = stream.random_range(0..=cells.rows - down);
                let column = stream.random_range(0..=cells.columns - right);
                let (a, b) = (at(row, column), at(row, column + right));
                let (c, d) = (at(row + down, column), at(row + down, column + right));
                for k in 0..CLASSES {
                    counts[k] += d[k] - c[k] - b[k] + a[k];
                }
            }
            let core = MaterialRatio::of(&self.heights(&counts)).core(EquivalentLine::LeastSquares);
            [core.sk_m, core.spk_m, core.svk_m, self.mean_size(&counts)]
        };
        blocks::map(0..draws.resamples, replicate)
    }

    /// Returns the counts of the cells above and left of each corner.
    fn summed(&self, cells: &Cells) -> Vec<f64> {
        let width = cells.columns + 1;
        let mut table = vec![0.0; (cells.rows + 1) * width * CLASSES];
        for row in 0..cells.rows {
            let mut along = vec![0.0; CLASSES];
            for column in 0..cells.columns {
                for k in 0..CLASSES {
                    along[k] += self.counts[(row * cells.columns + column) * CLASSES + k];
                    table[((row + 1) * width + column + 1) * CLASSES + k] =
                        table[(row * width + column + 1) * CLASSES + k] + along[k];
                }
            }
        }
        table
    }

    /// Returns two heights for each class, at the quarters of its frequency.
    fn heights(&self, counts: &[f64]) -> Vec<f64> {
        let total = total(counts);
        let mut heights = Vec::with_capacity(2 * CLASSES);
        let (mut class, mut below) = (0, 0.0);
        for i in 0..2 * CLASSES {
            let wanted = (i as f64 + 0.5) / (2 * CLASSES) as f64 * total;
            while class + 1 < CLASSES && below + counts[class] < wanted {
                below += counts[class];
                class += 1;
            }
            let part = ((wanted - below) / counts[class].max(1.0)).clamp(0.0, 1.0);
            heights.push(self.bounds[class] + part * (self.bounds[class + 1] - self.bounds[class]));
        }
        heights
    }

    /// Returns ⟨|v − ⟨v⟩|⟩ with every height at the middle of its class.
    fn mean_size(&self, counts: &[f64]) -> f64 {
        let middle = |k: usize| 0.5 * (self.bounds[k] + self.bounds[k + 1]);
        let mean = |of: &dyn Fn(f64) -> f64| {
            counts.iter().enumerate().map(|(k, n)| n * of(middle(k))).sum::<f64>() / total(counts)
        };
        let centre = mean(&|v| v);
        mean(&|v| (v - centre).abs())
    }
}

/// Returns the counts of the whole map.
fn total_of(counts: &[f64]) -> Vec<f64> {
    let mut totals = vec![0.0; CLASSES];
    for cell in counts.chunks_exact(CLASSES) {
        for (total, count) in totals.iter_mut().zip(cell) {
            *total += count;
        }
    }
    totals
}
