use super::*;
use asperity_base::correlation::{Axis, profile_spectrum, radial_spectrum};
use asperity_base::random;

/// Returns the remainder of the sum over j = −60 … 60 against all j, at lags of order 1. Power falls with γ^{−2Hj}
/// upwards and γ^{2(1−H)j} downwards.
fn left_out(gamma: f64, hurst: f64) -> f64 {
    10.0 * (gamma.powf(-120.0 * hurst) + gamma.powf(-120.0 * (1.0 - hurst)))
}

/// Returns the structure function E (z(s + (x, y)) − z(s))² in m².
fn structure_function_m2(surface: &WeierstrassMandelbrot, x: f64, y: f64) -> f64 {
    // 1 − cos by the half angle, which is accurate for small values.
    let term = |wave: &Wave| 2.0 * (wave.amplitude * (0.5 * (wave.qx * x + wave.qy * y)).sin()).powi(2);
    surface.scale.powi(2) * surface.waves.iter().map(term).sum::<f64>()
}

/// Returns the sum over the wavenumbers γ^j.
fn sum_over(exponents: impl Iterator<Item = i32>, angles: &[f64], dimension: f64, gamma: f64) -> WeierstrassMandelbrot {
    let grid = Grid::new(2, 2, 1.0, 1.0).unwrap();
    let waves = waves(exponents.map(|j| gamma.powi(j)), angles, dimension, gamma);
    WeierstrassMandelbrot { grid, scale: 0.3_f64.powf(dimension - 2.0), waves }
}

#[test]
fn the_structure_function_of_a_two_sided_surface_is_self_affine_in_every_direction() {
    let angles: Vec<f64> = (1..=7).map(|m| PI * f64::from(m) / 7.0).collect();
    for dimension in [2.2, 2.5, 2.8] {
        let gamma: f64 = 1.5;
        let surface = sum_over(-60..=60, &angles, dimension, gamma);
        for (x, y) in [(1.0, 0.0), (0.0, 1.0), (0.4, -0.3), (-1.1, 1.7)] {
            let ratio = structure_function_m2(&surface, gamma * x, gamma * y) / structure_function_m2(&surface, x, y);
            let wanted = gamma.powf(2.0 * (3.0 - dimension));
            assert!((ratio / wanted - 1.0).abs() < left_out(gamma, 3.0 - dimension), "D {dimension}: {ratio} {wanted}");
        }
    }
}

#[test]
fn the_variance_of_the_truncated_sum_is_the_published_number() {
    // One ridge is the profile times √(ln γ) at G = 1.
    let profile = WeierstrassMandelbrot { scale: 1.0, ..sum_over(0..=20, &[0.0], 2.5, 1.5) };
    assert!((profile.variance_m2() / 1.5_f64.ln() - 1.499_699_271).abs() < 5e-10);
}

/// Returns the slope of a least-squares line through (ln x, ln y).
fn slope(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let points: Vec<(f64, f64)> = points.map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// Three lines per octave, at 2^m, 2^{m+1/3} and 2^{m+2/3} times the first.
const THIRD: f64 = 1.259_921_049_894_873_2;

/// Returns the mean density in octaves 2^m of `first`, m in `octaves`, whose edges are midway between lines. `power`
/// maps a value of the spectrum to the power at its wavenumber, `extent` a wavenumber to the measure of wavevectors up
/// to it.
fn in_octaves(
    first: f64,
    octaves: std::ops::Range<i32>,
    spectrum: &[(f64, f64)],
    extent: impl Fn(f64) -> f64,
) -> Vec<(f64, f64)> {
    octaves
        .map(|m| {
            let low = first * 2_f64.powf(f64::from(m) - 1.0 / 6.0);
            let inside = spectrum.iter().filter(|(q, _)| *q >= low && *q < 2.0 * low);
            (low, inside.map(|(_, power)| power).sum::<f64>() / (extent(2.0 * low) - extent(low)))
        })
        .collect()
}

#[test]
fn the_spectrum_of_a_profile_falls_with_the_power_five_minus_two_d_in_octaves_and_not_line_by_line() {
    for dimension in [1.2, 1.5, 1.8] {
        let grid = Grid::new(16384, 2, 1.0, 1.0).unwrap();
        // The wavenumbers 2π γ^j over the width, up to Nyquist's: γ³⁹ = 8192.
        let surface = WeierstrassMandelbrot::new(grid, dimension + 1.0, THIRD, 1, 1.0).unwrap();
        let xi = random::standard_normal(&mut random::stream(6, "slope", 0), 40);
        let spectrum = profile_spectrum(&surface.generate(&xi), Axis::X).unwrap();
        let first = TAU / 16384.0;
        // From the fifth octave on lines are eight bins apart, so the window's lobes do not overlap.
        let all: Vec<(f64, f64)> = spectrum.q_rad_per_m.iter().copied().zip(spectrum.psd_m3.iter().copied()).collect();
        let octaves = slope(in_octaves(first, 5..12, &all, |q| q).into_iter());
        let wanted = -(5.0 - 2.0 * dimension);
        assert!((octaves - wanted).abs() < 0.01, "D {dimension}: slope {octaves}, wanted {wanted}");
        // Between the lines there is only leakage, which a fit to every frequency would follow.
        let (low, high) = (first * 2_f64.powi(5), first * 2_f64.powi(12));
        let naive = slope(all.iter().copied().filter(|(q, _)| *q >= low && *q < high));
        assert!((naive - wanted).abs() > 1.0, "D {dimension}: {naive} by every frequency, {wanted}");
    }
}

#[test]
fn the_spectra_of_a_surface_fall_with_its_dimension_along_profiles_and_radially() {
    let n = 1024;
    for dimension in [2.2, 2.5, 2.8] {
        let grid = Grid::new(n, n, 1.0, 1.0).unwrap();
        let surface = WeierstrassMandelbrot::new(grid, dimension, THIRD, 4, 1.0).unwrap();
        let xi = random::standard_normal(&mut random::stream(6, "slope", 1), surface.xi_len());
        let map = surface.generate(&xi);
        let first = TAU / n as f64;
        // Profiles have dimension D − 1, hence −(5 − 2(D − 1)). The ridges of π/4 have lines at 1/√2 = 2^{−1/2}, on the
        // edges of the octaves of the others. Shifting the edges by 1/12 avoids both.
        let profile = profile_spectrum(&map, Axis::X).unwrap();
        let all: Vec<(f64, f64)> = profile.q_rad_per_m.iter().copied().zip(profile.psd_m3.iter().copied()).collect();
        let along = slope(in_octaves(first * 2_f64.powf(1.0 / 12.0), 4..8, &all, |q| q).into_iter());
        // In the plane the density falls faster by one power.
        let radial = radial_spectrum(&map).unwrap();
        let width = radial.q_rad_per_m[1] - radial.q_rad_per_m[0];
        let all: Vec<(f64, f64)> =
            radial.q_rad_per_m.iter().zip(&radial.psd_m4).map(|(q, psd)| (*q, psd * TAU * q * width)).collect();
        let around = slope(in_octaves(first, 4..8, &all, |q| PI * q * q).into_iter());
        let wanted = -(5.0 - 2.0 * (dimension - 1.0));
        assert!((along - wanted).abs() < 0.03, "D {dimension}: slope {along} of profiles, wanted {wanted}");
        assert!(
            (around - (wanted - 1.0)).abs() < 0.05,
            "D {dimension}: slope {around} in the plane, wanted {}",
            wanted - 1.0
        );
    }
}

#[test]
fn a_map_is_the_sum_of_its_cosines() {
    let grid = Grid::new(9, 7, 0.5, 0.8).unwrap();
    let surface = WeierstrassMandelbrot::new(grid, 2.4, 1.6, 5, 0.2).unwrap();
    let xi = random::standard_normal(&mut random::stream(7, "cosines", 0), surface.xi_len());
    let phases: Vec<f64> = xi.iter().map(|xi| TAU * standard_normal_cdf(*xi)).collect();
    let map = surface.generate(&xi);
    for ((row, column), z) in map.heights_m().indexed_iter() {
        let (x, y) = (0.5 * column as f64, 0.8 * row as f64);
        let mut sum = 0.0;
        for k in 0..surface.xi_len() / 5 {
            let q = TAU / 5.6 * 1.6_f64.powi(k as i32);
            for m in 1..=5 {
                let angle = PI * m as f64 / 5.0;
                let wave = (q * (x * angle.cos() + y * angle.sin()) + phases[5 * k + m - 1]).cos();
                sum += 0.2_f64.powf(0.4) * (1.6_f64.ln() / 5.0).sqrt() * q.powf(-0.6) * wave;
            }
        }
        assert!((z - sum).abs() < 1e-13);
    }
}

#[test]
fn the_rms_height_can_be_set() {
    let grid = Grid::new(64, 64, 1e-6, 1e-6).unwrap();
    let surface = WeierstrassMandelbrot::new(grid, 2.3, 1.5, 10, 1e-12).unwrap();
    let surface = surface.with_rms_height(1e-6).unwrap();
    assert!((surface.variance_m2().sqrt() / 1e-6 - 1.0).abs() < 1e-12);
    let powers: Vec<f64> = (0..400)
        .map(|index| {
            let xi = random::standard_normal(&mut random::stream(8, "rms", index), surface.xi_len());
            surface.generate(&xi).present_m().map(|z| z * z).sum::<f64>() / grid.points() as f64
        })
        .collect();
    let mean = powers.iter().sum::<f64>() / 400.0;
    let error = powers.iter().map(|p| (p - mean).powi(2)).sum::<f64>().sqrt() / 400.0;
    assert!((mean - 1e-12).abs() < 4.0 * error, "{mean:e} ± {error:e}");
}

#[test]
fn parameters_outside_their_ranges_are_refused() {
    let grid = Grid::new(8, 8, 1.0, 1.0).unwrap();
    assert!(WeierstrassMandelbrot::new(grid, 1.5, 1.5, 4, 1.0).is_err());
    assert!(WeierstrassMandelbrot::new(grid, 2.5, 1.5, 0, 1.0).is_err());
    assert!(WeierstrassMandelbrot::new(grid, 2.5, f64::NAN, 4, 1.0).is_err());
}

#[test]
fn the_rms_height_is_reached_at_every_dimension() {
    let grid = Grid::new(16, 16, 1e-5, 1e-5).unwrap();
    for dimension in [2.0 + 1e-9, 2.001, 2.01, 2.5, 2.999] {
        let surface = WeierstrassMandelbrot::new(grid, dimension, 1.5, 10, 1.0).unwrap().with_rms_height(1e-6).unwrap();
        assert!((surface.variance_m2().sqrt() / 1e-6 - 1.0).abs() < 1e-12, "{dimension}");
    }
}
