//! The material ratio (Abbott–Firestone) curve and what is read off it.

/// Share of the curve that the secant of the core spans.
const SECANT: f64 = 0.4;

/// Height as a function of the material ratio, the share of the surface at or above it.
///
/// The i-th highest of n heights lies at the ratio (i + ½)/n, with straight lines between and level ends.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialRatio {
    /// Heights in metre, highest first.
    descending_m: Vec<f64>,
    /// Integral of the height from ratio 0 to the i-th highest.
    integral_m: Vec<f64>,
}

/// The straight line that stands for the core of a material ratio curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EquivalentLine {
    /// The secant over 40 % of the curve that falls least.
    Secant,
    /// The least-squares line through the heights on that secant, as in ISO 13565-2:1996. Of normal heights its Sk is 2 %
    /// smaller; where the secant spans two bends the two differ by tens of per cent.
    LeastSquares,
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
    /// The curve of heights in metre, in any order, none of them NaN.
    ///
    /// # Panics
    /// If there is no height.
    pub fn of(heights_m: impl Iterator<Item = f64>) -> Self {
        let mut descending_m: Vec<f64> = heights_m.collect();
        descending_m.sort_unstable_by(|a, b| b.total_cmp(a));
        assert!(!descending_m.is_empty(), "a material ratio curve needs heights");
        let n = descending_m.len() as f64;
        let mut integral_m = Vec::with_capacity(descending_m.len());
        let mut reached = 0.5 * descending_m[0] / n;
        integral_m.push(reached);
        for pair in descending_m.windows(2) {
            reached += 0.5 * (pair[0] + pair[1]) / n;
            integral_m.push(reached);
        }
        Self { descending_m, integral_m }
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
        let trapezoid = 0.5 * (self.descending_m[left] + self.height_m(ratio)) * along / n;
        let beyond = (ratio - (1.0 - first)).max(0.0) * self.descending_m[self.descending_m.len() - 1];
        self.integral_m[left] + trapezoid + beyond
    }

    /// The ratio at which the secant over 40 % starts that falls least.
    ///
    /// The fall is piecewise linear in the start, so its least value lies where either end meets a height. The level ends
    /// of the curve, half a step long, are no part of the surface's shape and are kept out.
    fn flattest_secant(&self) -> f64 {
        let n = self.descending_m.len();
        let ratio = |i: usize| (i as f64 + 0.5) / n as f64;
        let (first, last) = (ratio(0), ratio(n - 1) - SECANT);
        let starts = (0..n).map(ratio).chain((0..n).map(|i| ratio(i) - SECANT));
        let fall = |start: f64| self.height_m(start) - self.height_m(start + SECANT);
        starts
            .filter(|start| (first..=last).contains(start))
            .map(|start| (start, fall(start)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(0.5 * (1.0 - SECANT), |(start, _)| start)
    }

    /// Sk, Spk, Svk, Smrk1 and Smrk2: the equivalent line, continued to the ratios 0 and 1, bounds the core; the peaks
    /// above and the dales below are turned into triangles of equal area (ISO 13565-2).
    pub fn core(&self, line: EquivalentLine) -> Core {
        let start = self.flattest_secant();
        let (slope_m, upper_m) = match line {
            EquivalentLine::Secant => {
                let slope_m = (self.height_m(start) - self.height_m(start + SECANT)) / SECANT;
                (slope_m, self.height_m(start) + slope_m * start)
            }
            EquivalentLine::LeastSquares => self.least_squares(start),
        };
        let lower_m = upper_m - slope_m;
        let (smrk1, smrk2) = (self.ratio_above(upper_m), self.ratio(lower_m));
        let peaks_m = self.integral_to(smrk1) - upper_m * smrk1;
        let dales_m = lower_m * (1.0 - smrk2) - (self.integral_to(1.0) - self.integral_to(smrk2));
        let triangle = |area_m: f64, base: f64| if base > 0.0 { (2.0 * area_m / base).max(0.0) } else { 0.0 };
        Core { sk_m: slope_m, spk_m: triangle(peaks_m, smrk1), svk_m: triangle(dales_m, 1.0 - smrk2), smrk1, smrk2 }
    }

    /// Fall per unit of ratio, and height at ratio 0, of the least-squares line over 40 % from `start`. At least the two
    /// ends of the secant are fitted.
    fn least_squares(&self, start: f64) -> (f64, f64) {
        let n = self.descending_m.len() as f64;
        let ends = [start, start + SECANT].map(|ratio| (ratio, self.height_m(ratio)));
        let ratios = self.descending_m.iter().enumerate().map(|(i, z)| ((i as f64 + 0.5) / n, *z));
        let points: Vec<(f64, f64)> =
            ratios.filter(|(ratio, _)| *ratio > ends[0].0 && *ratio < ends[1].0).chain(ends).collect();
        let count = points.len() as f64;
        let (ratio, height) = points.iter().fold((0.0, 0.0), |(r, z), p| (r + p.0 / count, z + p.1 / count));
        let (both, square) = points.iter().fold((0.0, 0.0), |(both, square), p| {
            (both + (p.0 - ratio) * (p.1 - height), square + (p.0 - ratio).powi(2))
        });
        let slope_m = -both / square;
        (slope_m, height + slope_m * ratio)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::standard_normal_quantile;

    #[test]
    fn the_curve_and_its_integral_by_hand() {
        let curve = MaterialRatio::of([1.0, 4.0, 2.0, 3.0].into_iter());
        assert_eq!([0.0, 0.125, 0.5, 0.875, 1.0].map(|r| curve.height_m(r)), [4.0, 4.0, 2.5, 1.0, 1.0]);
        assert_eq!([5.0, 4.0, 2.5, 1.0, 0.0].map(|z| curve.ratio(z)), [0.0, 0.125, 0.5, 1.0, 1.0]);
        assert!((curve.integral_to(1.0) - 2.5).abs() < 1e-15, "the mean height");
        assert!((curve.integral_to(0.5) - (0.125 * 4.0 + 0.375 * 3.25)).abs() < 1e-15);
        assert!((curve.integral_to(0.0625) - 0.25).abs() < 1e-15);
    }

    /// Of normal heights the flattest secant spans 30 % to 70 %; all else follows from φ and Φ in closed form.
    #[test]
    fn normal_heights_have_the_closed_form_sk_family_and_volumes() {
        let n = 400_000;
        let curve = MaterialRatio::of((0..n).map(|i| standard_normal_quantile((f64::from(i) + 0.5) / f64::from(n))));
        let (core, volumes) = (curve.core(EquivalentLine::Secant), curve.volumes(0.1, 0.8));
        // The flattest secant is flat to second order in its start, so interpolation leaves about 1e-6 of the ends'.
        for (name, found, wanted) in [
            ("Sk", core.sk_m, 2.6220025635402036),
            ("Spk", core.spk_m, 0.9369847010811971),
            ("Svk", core.svk_m, 0.9369847010811971),
            ("Smrk1", core.smrk1, 0.09492866528212707),
            ("Smrk2", core.smrk2, 1.0 - 0.09492866528212707),
            ("Vmp", volumes.peak_material_m, 0.04734317537802668),
            ("Vmc", volumes.core_material_m, 0.9059157318881131),
            ("Vvc", volumes.core_void_m, 1.2172570672294016),
            ("Vvv", volumes.dale_void_m, 0.11163767369322544),
            ("Sxp", curve.height_m(0.025) - curve.height_m(0.5), 1.9599639845400545),
        ] {
            assert!((found / wanted - 1.0).abs() < 1e-4, "{name} = {found}, not {wanted}");
        }
    }

    #[test]
    fn the_least_squares_line_of_normal_heights_has_its_closed_form() {
        // Slope ∫(p − ½) z dp / ∫(p − ½)² dp over 30 % to 70 %, by ∫ z Φ φ dz = −φΦ + Φ(√2 z)/(2√π).
        let z = standard_normal_quantile(0.7);
        let phi = |z: f64| crate::law::standard_normal_pdf(z);
        let cdf = crate::law::standard_normal_cdf;
        let above = -0.4 * phi(z) + (2.0 * cdf(2.0_f64.sqrt() * z) - 1.0) / (2.0 * std::f64::consts::PI.sqrt());
        let wanted = above / (2.0 * 0.2_f64.powi(3) / 3.0);
        let n = 100_000;
        let curve = MaterialRatio::of((0..n).map(|i| standard_normal_quantile((f64::from(i) + 0.5) / f64::from(n))));
        let found = curve.core(EquivalentLine::LeastSquares).sk_m;
        assert!((found / wanted - 1.0).abs() < 1e-4, "{found}, not {wanted}");
        assert!((wanted / 2.6220025635402036 - 0.98).abs() < 0.005, "2 % below the secant");
    }

    #[test]
    fn a_ramp_is_all_core() {
        let core = MaterialRatio::of((0..1000).map(f64::from)).core(EquivalentLine::Secant);
        assert!((core.sk_m - 1000.0).abs() < 1e-9);
        assert!(core.spk_m < 1e-9 && core.svk_m < 1e-9 && core.smrk1 < 1e-9 && core.smrk2 > 1.0 - 1e-9);
    }

    #[test]
    fn a_plateau_with_dales_has_no_core_height() {
        // Three quarters at height 0, the rest falling to −1: the flattest secant is level.
        let core = MaterialRatio::of((0..1000).map(|i| if i < 750 { 0.0 } else { f64::from(749 - i) / 250.0 }));
        let core = core.core(EquivalentLine::Secant);
        assert_eq!((core.sk_m, core.spk_m), (0.0, 0.0));
        assert!((core.smrk2 - 0.75).abs() < 2e-3 && (core.svk_m - 1.0).abs() < 0.01, "{core:?}");
    }
}
