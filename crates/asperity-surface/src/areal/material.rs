//! Material ratio (Abbott–Firestone) curve and the parameters derived from it.

use asperity_base::stats::blocks::{self, BLOCK};
use asperity_base::stats::{Order, sorted};

/// Fraction of the curve that the equivalent line of the core spans.
const CORE: f64 = 0.4;

/// Height as a function of the material ratio, the fraction of the surface at or above it.
///
/// The i-th highest of n heights is at the ratio (i + ½)/n; the curve is linear between heights and constant at its
/// ends.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialRatio {
    /// Heights in metre, highest first.
    descending_m: Vec<f64>,
    /// Sums of the heights before every block of [`BLOCK`], in metre, and of all.
    sums_m: Vec<f64>,
}

/// Straight line that represents the core of a material ratio curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EquivalentLine {
    /// The line of least squared deviations in height from the curve over the 40 % where its secant falls least (the
    /// first if there are several): ISO 25178-2 and ISO 13565-2.
    LeastSquares,
    /// The secant itself. For normal heights its Sk is 2 % larger. If the curve bends within the 40 %, the two differ by
    /// tens of per cent.
    Secant,
}

/// Core of a material ratio curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Core {
    /// Core height Sk in metre.
    pub sk_m: f64,
    /// Reduced peak height Spk in metre.
    pub spk_m: f64,
    /// Reduced dale height Svk in metre.
    pub svk_m: f64,
    /// Material ratio at the upper end of the core, a fraction.
    pub smrk1: f64,
    /// Material ratio at the lower end of the core, a fraction.
    pub smrk2: f64,
    /// Height of the highest peak above the core, in metre; negative where the line ends above it.
    pub spkx_m: f64,
    /// Depth of the deepest dale below the core, in metre; negative where the line ends below it.
    pub svkx_m: f64,
}

/// Volumes per area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Volumes {
    pub(super) peak_material_m: f64,
    pub(super) core_material_m: f64,
    pub(super) core_void_m: f64,
    pub(super) dale_void_m: f64,
}

impl MaterialRatio {
    /// Creates the curve of heights in metre, in any order; NaN are missing.
    ///
    /// # Panics
    /// If no height is present.
    pub fn of(heights_m: &[f64]) -> Self {
        Self::about(heights_m, 0.0)
    }

    /// Creates the curve of heights counted from `origin_m`.
    pub(super) fn about(heights_m: &[f64], origin_m: f64) -> Self {
        let descending_m = sorted(heights_m, origin_m, Order::Descending);
        assert!(!descending_m.is_empty(), "a material ratio curve needs heights");
        let mut sums_m = vec![0.0];
        let mut reached = 0.0;
        for sum in blocks::map(&descending_m, |block| blocks::sum_present(block).0) {
            reached += sum;
            sums_m.push(reached);
        }
        Self { descending_m, sums_m }
    }

    /// Returns the height in metre at a material ratio from 0 to 1.
    pub fn height_m(&self, ratio: f64) -> f64 {
        let (left, along) = self.place(ratio);
        let right = (left + 1).min(self.descending_m.len() - 1);
        self.descending_m[left] + along * (self.descending_m[right] - self.descending_m[left])
    }

    /// Returns the material ratio at a height in metre: the fraction of the surface at or above it, from 0 to 1.
    pub fn ratio(&self, height_m: f64) -> f64 {
        self.ratio_of_count(self.descending_m.partition_point(|z| *z >= height_m), height_m)
    }

    /// Returns the fraction of the surface strictly above a height, which differs from [`MaterialRatio::ratio`] on a
    /// plateau.
    fn ratio_above(&self, height_m: f64) -> f64 {
        self.ratio_of_count(self.descending_m.partition_point(|z| *z > height_m), height_m)
    }

    fn ratio_of_count(&self, above: usize, height_m: f64) -> f64 {
        let n = self.descending_m.len();
        if above == 0 || above == n {
            return above as f64 / n as f64;
        }
        let (upper, lower) = (self.descending_m[above - 1], self.descending_m[above]);
        (above as f64 - 0.5 + (upper - height_m) / (upper - lower)) / n as f64
    }

    /// Returns the nearest height on the left of a ratio, and the fraction of the distance to the next height.
    fn place(&self, ratio: f64) -> (usize, f64) {
        let last = self.descending_m.len() - 1;
        let position = (ratio * self.descending_m.len() as f64 - 0.5).clamp(0.0, last as f64);
        let left = position.floor() as usize;
        (left, position - left as f64)
    }

    /// Returns ∫ height from ratio 0 to `ratio`, in metre.
    fn integral_to(&self, ratio: f64) -> f64 {
        let n = self.descending_m.len() as f64;
        let first = 0.5 / n;
        if ratio <= first {
            return ratio * self.descending_m[0];
        }
        let (left, along) = self.place(ratio);
        // Trapezoids from the highest height to the one on the left: all heights in full, except half of the last.
        let block = left / BLOCK;
        let heights = self.sums_m[block] + self.descending_m[block * BLOCK..=left].iter().sum::<f64>();
        let trapezoids = (heights - 0.5 * self.descending_m[left]) / n;
        let trapezoid = 0.5 * (self.descending_m[left] + self.height_m(ratio)) * along / n;
        let beyond = (ratio - (1.0 - first)).max(0.0) * self.descending_m[self.descending_m.len() - 1];
        trapezoids + trapezoid + beyond
    }

    /// Returns the starting ratio of the secant over 40 % that falls least, the first if there are several.
    ///
    /// The fall is piecewise linear in the start, so its least value occurs where either end coincides with a height.
    /// The constant ends of the curve, half a step long, do not belong to the shape of the surface and are left out.
    fn flattest_secant(&self) -> f64 {
        let z = self.descending_m.as_slice();
        let n = z.len();
        // 40 % are `whole` steps and a `part`, so all ends have the same position between two heights.
        let (whole, part) = ((CORE * n as f64).floor() as usize, (CORE * n as f64).fract());
        let between = usize::from(part > 0.0);
        let count = n.saturating_sub(whole + between);
        // Secants that start at a height end a part of a step after the height `whole` further on.
        let of_starts = |first: usize| {
            let (starts, ends, next) = (&z[first..count], &z[first + whole..], &z[first + whole + between..]);
            let falls =
                starts.iter().zip(ends).zip(next).map(|((start, end), next)| start - (end + part * (next - end)));
            least(falls.take(BLOCK)).map(|(place, fall)| (fall, (first + place) as f64))
        };
        // Secants that end at a height, if these are different, start the same distance before a height.
        let of_ends = |first: usize| {
            let (before, starts, ends) = (&z[first..count], &z[first + between..], &z[first + whole + between..]);
            let falls =
                before.iter().zip(starts).zip(ends).map(|((before, start), end)| start + part * (before - start) - end);
            least(falls.take(BLOCK)).map(|(place, fall)| (fall, (first + place + between) as f64 - part))
        };
        let both = |block: usize| [of_starts(block * BLOCK), of_ends(block * BLOCK)];
        let indices = 0..count.div_ceil(BLOCK);
        let found: Vec<[Option<(f64, f64)>; 2]> = if n < blocks::SHARED_FROM {
            indices.map(both).collect()
        } else {
            asperity_base::blocks::map(indices, both)
        };
        let first = found.into_iter().flatten().flatten().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        first.map_or(0.5 * (1.0 - CORE), |(_, steps)| (steps + 0.5) / n as f64)
    }

    /// Computes Sk, Spk, Svk, Smrk1 and Smrk2. The equivalent line, continued to the ratios 0 and 1, bounds the core;
    /// the peaks above and the dales below are replaced by triangles of equal area (ISO 13565-2).
    pub fn core(&self, line: EquivalentLine) -> Core {
        let [core] = self.cores([line]);
        core
    }

    /// Computes the cores of several lines through the same part of the curve.
    pub(super) fn cores<const N: usize>(&self, lines: [EquivalentLine; N]) -> [Core; N] {
        let start = self.flattest_secant();
        lines.map(|line| {
            let (slope_m, upper_m) = match line {
                EquivalentLine::LeastSquares => self.least_squares(start),
                EquivalentLine::Secant => {
                    let slope_m = (self.height_m(start) - self.height_m(start + CORE)) / CORE;
                    (slope_m, self.height_m(start) + slope_m * start)
                }
            };
            self.core_between(upper_m, upper_m - slope_m)
        })
    }

    fn core_between(&self, upper_m: f64, lower_m: f64) -> Core {
        let (smrk1, smrk2) = (self.ratio_above(upper_m), self.ratio(lower_m));
        let peaks_m = self.integral_to(smrk1) - upper_m * smrk1;
        let dales_m = lower_m * (1.0 - smrk2) - (self.integral_to(1.0) - self.integral_to(smrk2));
        let triangle = |area_m: f64, base: f64| if base > 0.0 { (2.0 * area_m / base).max(0.0) } else { 0.0 };
        Core {
            sk_m: upper_m - lower_m,
            spk_m: triangle(peaks_m, smrk1),
            svk_m: triangle(dales_m, 1.0 - smrk2),
            smrk1,
            smrk2,
            spkx_m: self.descending_m[0] - upper_m,
            svkx_m: lower_m - self.descending_m[self.descending_m.len() - 1],
        }
    }

    /// Returns the fall per unit of ratio, and the height at ratio 0, of the least-squares line in height over the
    /// ratios from `start` to `start` + 40 %: slope 12 ∫ (r − r̄) z dr/w³ about the mean height ∫ z dr/w, w = 40 %.
    fn least_squares(&self, start: f64) -> (f64, f64) {
        // Counted from its first height, a constant stretch has no rounding error, and its line no slope.
        let (middle, level_m) = (start + 0.5 * CORE, self.height_m(start));
        let (area_m, moment_m) = self.integrals(start, start + CORE, middle, level_m);
        let slope_m = -12.0 * moment_m / CORE.powi(3);
        (slope_m, level_m + area_m / CORE + slope_m * middle)
    }

    /// Returns ∫ (z − `level_m`) dr and ∫ (r − `centre`)(z − `level_m`) dr from one ratio to another.
    ///
    /// For a straight piece of width h the second integral is the trapezoid of the product, minus h²/6 times the rise
    /// of z.
    fn integrals(&self, from: f64, to: f64, centre: f64, level_m: f64) -> (f64, f64) {
        let n = self.descending_m.len() as f64;
        let trapezoid = |(r0, z0): (f64, f64), (r1, z1): (f64, f64)| {
            let (width, product) = (r1 - r0, (r0 - centre) * z0 + (r1 - centre) * z1);
            (0.5 * width * (z0 + z1), 0.5 * width * product - width * width * (z1 - z0) / 6.0)
        };
        let point = |i: usize| ((i as f64 + 0.5) / n, self.descending_m[i] - level_m);
        let [start, end] = [from, to].map(|ratio| (ratio, self.height_m(ratio) - level_m));
        // Heights strictly between the ends.
        let first = (from * n - 0.5).floor() as usize + 1;
        let last = ((to * n - 0.5).ceil() as usize).min(self.descending_m.len());
        if first >= last {
            return trapezoid(start, end);
        }
        let inner = &self.descending_m[first..last];
        // Sums of z and of z times its place, block by block; half of the first and the last belong to the ends.
        let sums: Vec<(f64, f64)> = blocks::map(inner, |block| {
            let terms = block.iter().zip(0..).map(|(z, place)| (z - level_m, f64::from(place)));
            terms.fold((0.0, 0.0), |(sum, moment), (z, place)| (sum + z, moment + place * z))
        });
        let (mut area, mut moment) = (0.0, 0.0);
        for (block, (sum, own)) in sums.into_iter().enumerate() {
            area += sum / n;
            moment += ((point(first + block * BLOCK).0 - centre) * sum + own / n) / n;
        }
        let (head, tail) = (point(first), point(last - 1));
        area -= 0.5 * (head.1 + tail.1) / n;
        moment -=
            0.5 * ((head.0 - centre) * head.1 + (tail.0 - centre) * tail.1) / n + (tail.1 - head.1) / (6.0 * n * n);
        let ends = [trapezoid(start, head), trapezoid(tail, end)];
        (area + ends[0].0 + ends[1].0, moment + ends[0].1 + ends[1].1)
    }

    /// Returns the material above and the void below the heights at two ratios, p < q.
    pub(super) fn volumes(&self, p: f64, q: f64) -> Volumes {
        let material = |ratio: f64| self.integral_to(ratio) - ratio * self.height_m(ratio);
        let void =
            |ratio: f64| (1.0 - ratio) * self.height_m(ratio) - (self.integral_to(1.0) - self.integral_to(ratio));
        Volumes {
            peak_material_m: material(p),
            core_material_m: material(q) - material(p),
            core_void_m: void(p) - void(q),
            dale_void_m: void(q),
        }
    }
}

/// Returns the first of the least values and its place.
fn least(values: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    let mut found: Option<(usize, f64)> = None;
    for (place, value) in values.enumerate() {
        if found.is_none_or(|(_, least)| value < least) {
            found = Some((place, value));
        }
    }
    found
}

#[cfg(test)]
mod tests;
