//! The material ratio (Abbott–Firestone) curve and what is read off it.

use rayon::prelude::*;

use crate::stats::blocks::{self, BLOCK};
use crate::stats::{Order, sorted};

/// Share of the curve that the equivalent line of the core is laid through.
const CORE: f64 = 0.4;

/// Height as a function of the material ratio, the share of the surface at or above it.
///
/// The i-th highest of n heights lies at the ratio (i + ½)/n, with straight lines between and level ends.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialRatio {
    /// Heights in metre, highest first.
    descending_m: Vec<f64>,
    /// Sums of the heights before every block of [`BLOCK`], in metre, and of all.
    sums_m: Vec<f64>,
}

/// The straight line that stands for the core of a material ratio curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EquivalentLine {
    /// The line of least squared deviations in height from the curve over the 40 % where its secant falls least, the first
    /// of them where there are several: ISO 25178-2 and ISO 13565-2.
    LeastSquares,
    /// That secant itself. Of normal heights its Sk is 2 % larger; where the curve bends within the 40 % the two differ by
    /// tens of per cent.
    Secant,
}

/// The core of a material ratio curve.
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
    /// The curve of heights in metre, in any order; NaN are missing.
    ///
    /// # Panics
    /// If no height is present.
    pub fn of(heights_m: &[f64]) -> Self {
        Self::about(heights_m, 0.0)
    }

    /// The curve of heights counted from `origin_m`.
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

    /// Height in metre at a material ratio from 0 to 1.
    pub fn height_m(&self, ratio: f64) -> f64 {
        let (left, along) = self.place(ratio);
        let right = (left + 1).min(self.descending_m.len() - 1);
        self.descending_m[left] + along * (self.descending_m[right] - self.descending_m[left])
    }

    /// Material ratio at a height in metre: the share of the surface at or above it, from 0 to 1.
    pub fn ratio(&self, height_m: f64) -> f64 {
        self.ratio_of_count(self.descending_m.partition_point(|z| *z >= height_m), height_m)
    }

    /// The share of the surface strictly above a height, which differs from [`MaterialRatio::ratio`] on a plateau.
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

    /// The nearest height on the left of a ratio, and how far the ratio is on the way to the next.
    fn place(&self, ratio: f64) -> (usize, f64) {
        let last = self.descending_m.len() - 1;
        let position = (ratio * self.descending_m.len() as f64 - 0.5).clamp(0.0, last as f64);
        let left = position.floor() as usize;
        (left, position - left as f64)
    }

    /// ∫ height from ratio 0 to `ratio`, in metre.
    fn integral_to(&self, ratio: f64) -> f64 {
        let n = self.descending_m.len() as f64;
        let first = 0.5 / n;
        if ratio <= first {
            return ratio * self.descending_m[0];
        }
        let (left, along) = self.place(ratio);
        // Trapezoids from the highest to the one on the left: all heights in full, but half of the last.
        let block = left / BLOCK;
        let heights = self.sums_m[block] + self.descending_m[block * BLOCK..=left].iter().sum::<f64>();
        let trapezoids = (heights - 0.5 * self.descending_m[left]) / n;
        let trapezoid = 0.5 * (self.descending_m[left] + self.height_m(ratio)) * along / n;
        let beyond = (ratio - (1.0 - first)).max(0.0) * self.descending_m[self.descending_m.len() - 1];
        trapezoids + trapezoid + beyond
    }

    /// The ratio at which the secant over 40 % starts that falls least, the first where there are several.
    ///
    /// The fall is piecewise linear in the start, so its least value lies where either end meets a height. The level ends
    /// of the curve, half a step long, are no part of the surface's shape and are kept out.
    fn flattest_secant(&self) -> f64 {
        let z = self.descending_m.as_slice();
        let n = z.len();
        // 40 % are `whole` steps and a `part`: ends lie between heights at the same place everywhere.
        let (whole, part) = ((CORE * n as f64).floor() as usize, (CORE * n as f64).fract());
        let between = usize::from(part > 0.0);
        let count = n.saturating_sub(whole + between);
        // Secants that start at a height: their end lies a part of a step after the height `whole` further on.
        let of_starts = |first: usize| {
            let (starts, ends, next) = (&z[first..count], &z[first + whole..], &z[first + whole + between..]);
            let falls =
                starts.iter().zip(ends).zip(next).map(|((start, end), next)| start - (end + part * (next - end)));
            least(falls.take(BLOCK)).map(|(place, fall)| (fall, (first + place) as f64))
        };
        // Secants that end at a height, where that is not the same: their start lies as far before one.
        let of_ends = |first: usize| {
            let (before, starts, ends) = (&z[first..count], &z[first + between..], &z[first + whole + between..]);
            let falls =
                before.iter().zip(starts).zip(ends).map(|((before, start), end)| start + part * (before - start) - end);
            least(falls.take(BLOCK)).map(|(place, fall)| (fall, (first + place + between) as f64 - part))
        };
        let both = |first: usize| [of_starts(first), of_ends(first)];
        let found: Vec<[Option<(f64, f64)>; 2]> = if n < blocks::SHARED_FROM {
            (0..count).step_by(BLOCK).map(both).collect()
        } else {
            (0..count.div_ceil(BLOCK)).into_par_iter().map(|block| both(block * BLOCK)).collect()
        };
        let first = found.into_iter().flatten().flatten().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        first.map_or(0.5 * (1.0 - CORE), |(_, steps)| (steps + 0.5) / n as f64)
    }

    /// Sk, Spk, Svk, Smrk1 and Smrk2: the equivalent line, continued to the ratios 0 and 1, bounds the core; the peaks
    /// above and the dales below are turned into triangles of equal area (ISO 13565-2).
    pub fn core(&self, line: EquivalentLine) -> Core {
        let [core] = self.cores([line]);
        core
    }

    /// The cores of several lines through the same part of the curve.
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

    /// Fall per unit of ratio, and height at ratio 0, of the line that deviates least in height, in the mean square over the
    /// ratios from `start` to `start` + 40 %: slope 12 ∫ (r − r̄) z dr/w³ about the mean height ∫ z dr/w, w = 40 %.
    fn least_squares(&self, start: f64) -> (f64, f64) {
        // Counted from its first height, a level stretch has no rounding, and its line no slope.
        let (middle, level_m) = (start + 0.5 * CORE, self.height_m(start));
        let (area_m, moment_m) = self.integrals(start, start + CORE, middle, level_m);
        let slope_m = -12.0 * moment_m / CORE.powi(3);
        (slope_m, level_m + area_m / CORE + slope_m * middle)
    }

    /// ∫ (z − `level_m`) dr and ∫ (r − `centre`)(z − `level_m`) dr from one ratio to another.
    ///
    /// Of a straight piece of width h the second is the trapezoid of the product, less h²/6 times the rise of z.
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

    /// Material above and void below the heights at two ratios, p < q.
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

/// The first of the least values and its place.
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
mod tests {
    use super::*;
    use crate::law::standard_normal_quantile;
    use crate::random;

    #[test]
    fn the_curve_and_its_integral_by_hand() {
        let curve = MaterialRatio::of(&[1.0, 4.0, f64::NAN, 2.0, 3.0]);
        assert_eq!([0.0, 0.125, 0.5, 0.875, 1.0].map(|r| curve.height_m(r)), [4.0, 4.0, 2.5, 1.0, 1.0]);
        assert_eq!([5.0, 4.0, 2.5, 1.0, 0.0].map(|z| curve.ratio(z)), [0.0, 0.125, 0.5, 1.0, 1.0]);
        assert!((curve.integral_to(1.0) - 2.5).abs() < 1e-15, "the mean height");
        assert!((curve.integral_to(0.5) - (0.125 * 4.0 + 0.375 * 3.25)).abs() < 1e-15);
        assert!((curve.integral_to(0.0625) - 0.25).abs() < 1e-15);
    }

    /// `n` heights of the standard normal law, one in the middle of each of `n` equal shares.
    fn normal(n: usize) -> Vec<f64> {
        (0..n).map(|i| standard_normal_quantile((i as f64 + 0.5) / n as f64)).collect()
    }

    /// Of normal heights the flattest secant spans 30 % to 70 %; all else follows from φ and Φ in closed form.
    ///
    /// Its fall is 2 z₇₀ over 40 %, and Sk = 5 z₇₀. The least-squares slope is ∫(p − ½) z dp/∫(p − ½)² dp over 30 % to 70 %;
    /// with ∫ z Φ φ dz = −φΦ + Φ(√2 z)/(2√π) the numerator is −0.4 φ(z₇₀) + (2Φ(√2 z₇₀) − 1)/(2√π), the denominator
    /// 2·0.2³/3. Peaks begin at z = Sk/2, Smrk1 = Φ(−z), their area is φ(z) − z Φ(−z), and Spk twice that over Smrk1.
    #[test]
    fn normal_heights_have_the_closed_form_sk_family_and_volumes() {
        let (pdf, cdf) = (crate::law::standard_normal_pdf, crate::law::standard_normal_cdf);
        let z = standard_normal_quantile(0.7);
        let moment = -0.4 * pdf(z) + (2.0 * cdf(2.0_f64.sqrt() * z) - 1.0) / (2.0 * std::f64::consts::PI.sqrt());
        let sk = moment / (2.0 * 0.2_f64.powi(3) / 3.0);
        assert!((sk - 2.573_956_107_954_25).abs() < 1e-9, "{sk}");
        assert!((5.0 * z - 2.622_002_563_540_203_6).abs() < 1e-9);
        let curve = MaterialRatio::of(&normal(400_000));
        let [core, secant] = curve.cores([EquivalentLine::LeastSquares, EquivalentLine::Secant]);
        let volumes = curve.volumes(0.1, 0.8);
        // The flattest secant is flat to second order in its start, so interpolation leaves about 1e-6 of the ends'.
        for (found, sk) in [(core, sk), (secant, 5.0 * z)] {
            let share = cdf(-0.5 * sk);
            let peak = 2.0 * (pdf(0.5 * sk) - 0.5 * sk * share) / share;
            for (name, found, wanted) in [
                ("Sk", found.sk_m, sk),
                ("Spk", found.spk_m, peak),
                ("Svk", found.svk_m, peak),
                ("Smrk1", found.smrk1, share),
                ("Smrk2", found.smrk2, 1.0 - share),
            ] {
                assert!((found / wanted - 1.0).abs() < 1e-4, "{name} = {found}, not {wanted}");
            }
        }
        for (name, found, wanted) in [
            ("Spk of the secant", secant.spk_m, 0.9369847010811971),
            ("Smrk1 of the secant", secant.smrk1, 0.09492866528212707),
            ("Vmp", volumes.peak_material_m, 0.04734317537802668),
            ("Vmc", volumes.core_material_m, 0.9059157318881131),
            ("Vvc", volumes.core_void_m, 1.2172570672294016),
            ("Vvv", volumes.dale_void_m, 0.11163767369322544),
            ("Sxp", curve.height_m(0.025) - curve.height_m(0.5), 1.9599639845400545),
        ] {
            assert!((found / wanted - 1.0).abs() < 1e-4, "{name} = {found}, not {wanted}");
        }
    }

    /// The flattest secant, the least-squares line and the integral by their definitions, on the curve's own heights.
    #[test]
    fn the_fast_searches_and_sums_are_the_plain_ones() {
        for (n, kind) in [(7, 0), (10, 1), (1000, 0), (4097, 1), (9000, 2), (70_000, 0), (70_001, 2)] {
            let rough = random::standard_normal(&mut random::stream(18, "material", n as u64), n);
            let heights: Vec<f64> = rough
                .iter()
                .map(|z| match kind {
                    0 => *z,
                    1 => (3.0 * z).round() / 3.0,
                    _ => z.exp(),
                })
                .collect();
            let curve = MaterialRatio::of(&heights);
            let at = |i: usize| (i as f64 + 0.5) / n as f64;
            let starts = (0..n).flat_map(|i| [at(i), at(i) - CORE]);
            let fall = |start: f64| curve.height_m(start) - curve.height_m(start + CORE);
            let inside = starts.filter(|start| *start >= at(0) - 1e-12 && *start <= at(n - 1) - CORE + 1e-12);
            let wanted = inside.map(fall).fold(f64::INFINITY, f64::min);
            let start = curve.flattest_secant();
            assert!((fall(start) - wanted).abs() < 1e-9, "{n}: {} {wanted}", fall(start));

            // The mean square deviation of the line does not fall when the line is moved or turned.
            let (slope, upper) = curve.least_squares(start);
            let fine = 40_000;
            let cost = |slope: f64, upper: f64| {
                (0..fine)
                    .map(|i| start + CORE * (f64::from(i) + 0.5) / f64::from(fine))
                    .map(|r| (curve.height_m(r) - upper + slope * r).powi(2))
                    .sum::<f64>()
            };
            let best = cost(slope, upper);
            for (ds, du) in [(0.01, 0.0), (-0.01, 0.0), (0.0, 0.005), (0.0, -0.005), (0.02, 0.01), (-0.02, -0.01)] {
                assert!(cost(slope + ds, upper + du) > best, "{n}: {ds} {du}");
            }
            for ratio in [0.0, 0.3 / n as f64, 0.2137, 0.5, 0.99, 1.0] {
                let steps = 200_000;
                let sum: f64 =
                    (0..steps).map(|i| curve.height_m(ratio * (f64::from(i) + 0.5) / f64::from(steps))).sum();
                let wanted = sum * ratio / f64::from(steps);
                assert!((curve.integral_to(ratio) - wanted).abs() < 1e-5, "{n} at {ratio}");
            }
        }
    }

    #[test]
    fn of_equal_secants_the_first_is_taken() {
        // Two level stretches of half the surface each, both 40 % long at least: the upper one is first.
        let heights: Vec<f64> = (0..1000).map(|i| if i < 500 { 1.0 } else { 0.0 }).collect();
        let curve = MaterialRatio::of(&heights);
        assert_eq!(curve.flattest_secant(), 0.5 / 1000.0);
        let core = curve.core(EquivalentLine::LeastSquares);
        assert_eq!((core.sk_m, core.spk_m, core.spkx_m), (0.0, 0.0, 0.0));
        assert!((core.svkx_m - 1.0).abs() < 1e-12 && (core.smrk2 - 0.5).abs() < 2e-3, "{core:?}");
    }

    /// Programs that resample the curve to some thousand ratios lose spikes that are rarer than that.
    #[test]
    fn peaks_rarer_than_a_resampled_curve_keep_their_volume() {
        // One point in 50,000 is a spike 1,000 standard deviations high: it adds 1000/50,000 = 0.02 to Vmp = 0.0473 of the
        // normal rest. On a curve of 10,000 ratios, linear between them, it is a triangle between the first two, of volume
        // ½·1000/10,000 = 0.05, whatever its own width.
        let n = 400_000;
        let mut heights = normal(n);
        heights[..n / 50_000].fill(1000.0);
        let curve = MaterialRatio::of(&heights);
        let found = curve.volumes(0.1, 0.8).peak_material_m;
        // The volume of a spike counts from the height at 10 %, 1.28: less than 2e-5·5.
        assert!((found - 0.04734317537802668 - 0.02).abs() < 1e-4, "{found}");
        let resampled = |ratios: usize| {
            let heights: Vec<f64> = (0..ratios).map(|i| curve.height_m(i as f64 / (ratios - 1) as f64)).collect();
            let trapezoids = heights.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) / (ratios - 1) as f64);
            let above: f64 = trapezoids.take(ratios / 10).sum();
            above - 0.1 * curve.height_m(0.1)
        };
        // Converging with the number of ratios, and far off before they are as dense as the spikes.
        let errors = [1_000, 10_000, 100_000, 1_000_000].map(|ratios| (resampled(ratios) / found - 1.0).abs());
        assert!(errors[0] > 5.0 && errors[1] > 0.3 && errors[2] < 0.05 && errors[3] < 0.01, "{errors:?}");
    }

    #[test]
    fn a_ramp_is_all_core() {
        let ramp: Vec<f64> = (0..1000).map(f64::from).collect();
        let curve = MaterialRatio::of(&ramp);
        for core in curve.cores([EquivalentLine::LeastSquares, EquivalentLine::Secant]) {
            assert!((core.sk_m - 1000.0).abs() < 1e-9);
            assert!(core.spk_m < 1e-9 && core.svk_m < 1e-9 && core.smrk1 < 1e-9 && core.smrk2 > 1.0 - 1e-9);
        }
    }

    #[test]
    fn a_plateau_with_dales_has_no_core_height() {
        // Three quarters at height 0, the rest falling to −1: the flattest secant is level.
        let heights: Vec<f64> = (0..1000).map(|i| if i < 750 { 0.0 } else { f64::from(749 - i) / 250.0 }).collect();
        let core = MaterialRatio::of(&heights).core(EquivalentLine::LeastSquares);
        assert_eq!((core.sk_m, core.spk_m), (0.0, 0.0));
        assert!((core.smrk2 - 0.75).abs() < 2e-3 && (core.svk_m - 1.0).abs() < 0.01, "{core:?}");
    }
}
