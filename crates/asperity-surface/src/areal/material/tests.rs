use super::*;
use asperity_base::distribution::standard_normal_quantile;
use asperity_base::random;

#[test]
fn the_curve_and_its_integral_by_hand() {
    let curve = MaterialRatio::of(&[1.0, 4.0, f64::NAN, 2.0, 3.0]);
    assert_eq!([0.0, 0.125, 0.5, 0.875, 1.0].map(|r| curve.height_m(r)), [4.0, 4.0, 2.5, 1.0, 1.0]);
    assert_eq!([5.0, 4.0, 2.5, 1.0, 0.0].map(|z| curve.ratio(z)), [0.0, 0.125, 0.5, 1.0, 1.0]);
    assert!((curve.integral_to(1.0) - 2.5).abs() < 1e-15, "the mean height");
    assert!((curve.integral_to(0.5) - (0.125 * 4.0 + 0.375 * 3.25)).abs() < 1e-15);
    assert!((curve.integral_to(0.0625) - 0.25).abs() < 1e-15);
}

/// Returns `n` heights of the standard normal distribution, one in the middle of each of `n` equal fractions.
fn normal(n: usize) -> Vec<f64> {
    (0..n).map(|i| standard_normal_quantile((i as f64 + 0.5) / n as f64)).collect()
}

/// For normal heights the flattest secant spans 30 % to 70 %, and all parameters follow from φ and Φ in closed form.
///
/// Its fall is 2 z₇₀ over 40 %, and Sk = 5 z₇₀. The least-squares slope is ∫(p − ½) z dp/∫(p − ½)² dp over 30 % to 70 %.
/// With ∫ z Φ φ dz = −φΦ + Φ(√2 z)/(2√π) the numerator is −0.4 φ(z₇₀) + (2Φ(√2 z₇₀) − 1)/(2√π) and the denominator
/// 2·0.2³/3. Peaks start at z = Sk/2, Smrk1 = Φ(−z), their area is φ(z) − z Φ(−z), and Spk is twice that over Smrk1.
#[test]
fn normal_heights_have_the_closed_form_sk_family_and_volumes() {
    let (pdf, cdf) =
        (asperity_base::distribution::standard_normal_pdf, asperity_base::distribution::standard_normal_cdf);
    let z = standard_normal_quantile(0.7);
    let moment = -0.4 * pdf(z) + (2.0 * cdf(2.0_f64.sqrt() * z) - 1.0) / (2.0 * std::f64::consts::PI.sqrt());
    let sk = moment / (2.0 * 0.2_f64.powi(3) / 3.0);
    assert!((sk - 2.573_956_107_954_25).abs() < 1e-9, "{sk}");
    assert!((5.0 * z - 2.622_002_563_540_203_6).abs() < 1e-9);
    let curve = MaterialRatio::of(&normal(400_000));
    let [core, secant] = curve.cores([EquivalentLine::LeastSquares, EquivalentLine::Secant]);
    let volumes = curve.volumes(0.1, 0.8);
    // The flattest secant is flat to second order in its start, so interpolation has an error of about 1e-6.
    for (found, sk) in [(core, sk), (secant, 5.0 * z)] {
        let fraction = cdf(-0.5 * sk);
        let peak = 2.0 * (pdf(0.5 * sk) - 0.5 * sk * fraction) / fraction;
        for (name, found, wanted) in [
            ("Sk", found.sk_m, sk),
            ("Spk", found.spk_m, peak),
            ("Svk", found.svk_m, peak),
            ("Smrk1", found.smrk1, fraction),
            ("Smrk2", found.smrk2, 1.0 - fraction),
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

/// Computes the flattest secant, the least-squares line and the integral from their definitions, on the heights of the
/// curve.
#[test]
fn the_fast_searches_and_sums_equal_direct_ones() {
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

        // Shifting or rotating the line does not lower its mean square deviation.
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
            let sum: f64 = (0..steps).map(|i| curve.height_m(ratio * (f64::from(i) + 0.5) / f64::from(steps))).sum();
            let wanted = sum * ratio / f64::from(steps);
            assert!((curve.integral_to(ratio) - wanted).abs() < 1e-5, "{n} at {ratio}");
        }
    }
}

#[test]
fn of_equal_secants_the_first_is_taken() {
    // Two constant stretches of half the surface each, both longer than 40 %. The upper one is first.
    let heights: Vec<f64> = (0..1000).map(|i| if i < 500 { 1.0 } else { 0.0 }).collect();
    let curve = MaterialRatio::of(&heights);
    assert_eq!(curve.flattest_secant(), 0.5 / 1000.0);
    let core = curve.core(EquivalentLine::LeastSquares);
    assert_eq!((core.sk_m, core.spk_m, core.spkx_m), (0.0, 0.0, 0.0));
    assert!((core.svkx_m - 1.0).abs() < 1e-12 && (core.smrk2 - 0.5).abs() < 2e-3, "{core:?}");
}

/// Programs that resample the curve to some thousand ratios lose rarer spikes.
#[test]
fn peaks_rarer_than_a_resampled_curve_keep_their_volume() {
    // One point in 50,000 is a spike 1,000 standard deviations high. It adds 1000/50,000 = 0.02 to Vmp = 0.0473 of the
    // normal rest. On a linearly interpolated curve of 10,000 ratios it is a triangle between the first two, of volume
    // ½·1000/10,000 = 0.05, for any width of the spike.
    let n = 400_000;
    let mut heights = normal(n);
    heights[..n / 50_000].fill(1000.0);
    let curve = MaterialRatio::of(&heights);
    let found = curve.volumes(0.1, 0.8).peak_material_m;
    // The volume of a spike counts from the height at 10 %, 1.28; the difference is less than 2e-5·5.
    assert!((found - 0.04734317537802668 - 0.02).abs() < 1e-4, "{found}");
    let resampled = |ratios: usize| {
        let heights: Vec<f64> = (0..ratios).map(|i| curve.height_m(i as f64 / (ratios - 1) as f64)).collect();
        let trapezoids = heights.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) / (ratios - 1) as f64);
        let above: f64 = trapezoids.take(ratios / 10).sum();
        above - 0.1 * curve.height_m(0.1)
    };
    // The result converges with the number of ratios and is far off until they are as dense as the spikes.
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
    // Three quarters at height 0, the rest falling to −1: the flattest secant is horizontal.
    let heights: Vec<f64> = (0..1000).map(|i| if i < 750 { 0.0 } else { f64::from(749 - i) / 250.0 }).collect();
    let core = MaterialRatio::of(&heights).core(EquivalentLine::LeastSquares);
    assert_eq!((core.sk_m, core.spk_m), (0.0, 0.0));
    assert!((core.smrk2 - 0.75).abs() < 2e-3 && (core.svk_m - 1.0).abs() < 0.01, "{core:?}");
}
