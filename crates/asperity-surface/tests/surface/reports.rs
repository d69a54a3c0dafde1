//! Cases that users of other programs reported; docs/validation/reports.md lists them.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use asperity_base::correlation::{
    Autocorrelation, Axis, RadialSpectrum, axis_correlation_length_m, profile_spectrum, radial_spectrum,
};
use asperity_base::map::{Grid, HeightMap};
use asperity_surface::areal::{self, decay};
use asperity_surface::level::{Level, LevelError, remove_form};
use ndarray::Array2;

/// Returns a map with voids where `is_void` is true of row and column.
fn with_voids(map: &HeightMap, is_void: impl Fn(usize, usize) -> bool) -> HeightMap {
    let mut heights_m = map.heights_m().clone();
    heights_m.indexed_iter_mut().filter(|((row, column), _)| is_void(*row, *column)).for_each(|(_, z)| *z = f64::NAN);
    HeightMap::new(map.grid(), heights_m).unwrap()
}

#[test]
fn a_plane_is_fitted_to_the_points_beside_a_missing_row_and_not_to_a_single_row() {
    // TopoStats #381.
    let grid = Grid::new(5, 4, 1.0, 2.0).unwrap();
    let plane = HeightMap::from_function(grid, |x, y| 0.1 * x + 0.2 * y).unwrap();
    let levelled = remove_form(&with_voids(&plane, |row, _| row == 2), Level::Plane).unwrap();
    let form_m = &levelled.form_m;
    assert!((form_m[[0, 1]] - form_m[[0, 0]] - 0.1).abs() < 1e-15);
    assert!((form_m[[1, 0]] - form_m[[0, 0]] - 0.4).abs() < 1e-15);
    for ((row, _), z) in levelled.map.heights_m().indexed_iter() {
        assert!(if row == 2 { z.is_nan() } else { *z == 0.0 }, "{row}: {z}");
    }
    let refused = remove_form(&with_voids(&plane, |row, _| row != 1), Level::Plane).unwrap_err();
    assert_eq!(refused, LevelError::Undetermined { level: Level::Plane, present: 5 });
}

#[test]
fn one_void_leaves_the_correlation_of_all_pairs_beside_it() {
    // GSTools #83.
    let grid = Grid::new(64, 64, 1.0, 1.0).unwrap();
    let sine = HeightMap::from_function(grid, |x, y| (TAU * (5.0 * x + 2.0 * y) / 64.0).sin()).unwrap();
    let map = with_voids(&sine, |row, column| (row, column) == (20, 31));
    let mean = map.present_m().sum::<f64>() / 4095.0;
    let heights = map.heights_m();
    let found = Autocorrelation::estimate(&map).unwrap();
    for lag_y in 0..=32_usize {
        for lag_x in -32..=32_isize {
            let mut sum = (0.0, 0.0);
            for row in 0..64 - lag_y {
                for column in 0..64_usize {
                    let Some(other) = column.checked_add_signed(lag_x).filter(|other| *other < 64) else { continue };
                    let product = (heights[[row, column]] - mean) * (heights[[row + lag_y, other]] - mean);
                    if product.is_finite() {
                        sum = (sum.0 + product, sum.1 + 1.0);
                    }
                }
            }
            let covariance = found.covariance_m2(lag_x, lag_y as isize);
            assert!((covariance - sum.0 / sum.1).abs() < 1e-12, "{lag_x} {lag_y}: {covariance} {}", sum.0 / sum.1);
        }
    }
    let radial = radial_spectrum(&map).unwrap();
    assert!(radial.psd_m4.iter().all(|psd| psd.is_finite()));
}

#[test]
fn grooves_of_any_direction_have_the_lengths_of_a_cosine_across_and_none_along() {
    // surfalize 0.17.1; SurfaceRoughnessStatistics #4. The correlation is cos(2π lag/P) up to the ends of the field, which change it by
    // 1/(4π·10.37) = 0.008 at most, and the lag by 0.0013 P at 0.2. Linear interpolation between lags adds (pixel/P)²·π/4 at most.
    let period = 1.0 / 10.37;
    for (angle, points) in [(0.0, 128), (0.0, 512), (FRAC_PI_4, 128), (FRAC_PI_4, 512)] {
        let pitch = 1.0 / f64::from(points);
        let grid = Grid::new(points as usize, points as usize, pitch, pitch).unwrap();
        let q = TAU / period;
        let map =
            HeightMap::from_function(grid, |x, y| (q * (x * f64::cos(angle) + y * f64::sin(angle))).cos()).unwrap();
        let bound = 0.0014 + (pitch / period).powi(2);
        let parameters = areal::parameters(&map).unwrap();
        let close = |name: &str, found: Option<f64>, wanted: f64, bound: f64| {
            let found = found.unwrap() / period;
            assert!((found - wanted).abs() < bound, "{name} at {angle}, {points}: {found} {wanted}");
        };
        close("Sal", parameters.sal_m, 0.217_953, bound);
        close("1/e", decay(&map, (-1.0_f64).exp()).unwrap().shortest_m, 0.190_042, bound);
        // No decay along the lay.
        assert_eq!(parameters.str_ratio, None);
        let axes = [Axis::X, Axis::Y].map(|axis| axis_correlation_length_m(&map, axis).unwrap());
        if angle == 0.0 {
            close("1/e along x", axes[0], 0.190_042, bound);
            assert_eq!(axes[1], None);
        } else {
            // Along the axes the period is P√2.
            axes.into_iter().for_each(|length_m| close("1/e", length_m, 0.190_042 * 2.0_f64.sqrt(), 1.5 * bound));
        }
    }
}

/// Returns the variance in m² of the rings of a spectrum with wavenumbers from `low` to below `high`.
fn variance(grid: Grid, spectrum: &RadialSpectrum, low: f64, high: f64) -> f64 {
    let rings = spectrum.q_rad_per_m.iter().zip(&spectrum.psd_m4).zip(&spectrum.wavevectors);
    let within = rings.filter(|((q, _), _)| (low..high).contains(*q));
    within.map(|((_, psd), wavevectors)| psd * *wavevectors as f64).sum::<f64>() / grid.area_m2()
}

#[test]
fn spectra_of_unequal_pitches_contain_the_variance_of_every_wave() {
    // xrft #219, pylinac #516: a cosine of amplitude 0.5 has the variance 0.125.
    let grid = Grid::new(64, 32, 1.0, 3.0).unwrap();
    let tone = |cycles: f64, place: f64, points: f64| 0.5 * (TAU * cycles * place / points + 0.3).cos();
    let of = |tones: [f64; 4]| {
        let [a, b, c, d] = tones;
        HeightMap::from_function(grid, move |x, y| {
            a * tone(4.0, x, 64.0) + b * tone(11.0, x, 64.0) + c * tone(3.0, y, 96.0) + d * tone(9.0, y, 96.0)
        })
        .unwrap()
    };
    let everything = |map: &HeightMap| {
        let spectrum = radial_spectrum(map).unwrap();
        (variance(grid, &spectrum, 0.0, f64::INFINITY), spectrum.corners_m2)
    };
    for place in 0..4 {
        let mut tones = [0.0; 4];
        tones[place] = 1.0;
        let (rings, corners) = everything(&of(tones));
        assert!((rings + corners - 0.125).abs() < 1e-14, "tone {place}: {rings} + {corners}");
    }
    let map = of([1.0; 4]);
    let (rings, corners) = everything(&map);
    assert!((rings + corners - 0.5).abs() < 1e-14, "{rings} + {corners}");
    // The smaller Nyquist wavenumber is π/3 rad/m, so the wave of 11 cycles in 64 m, 1.08 rad/m, is in the corners.
    assert!(rings < 0.45 && corners > 0.05);

    // Along x every wave across it is a mean of profiles: in the first bins.
    for (axis, points, tones, means) in [(Axis::X, 64, [4, 11], 0.25), (Axis::Y, 32, [3, 9], 0.25)] {
        let spectrum = profile_spectrum(&map, axis).unwrap();
        let step = spectrum.q_rad_per_m[1] / TAU;
        let within = |range: std::ops::RangeInclusive<usize>| {
            let signs = |k: usize| if k == 0 || 2 * k == points { 1.0 } else { 2.0 };
            range.map(|k| signs(k) * spectrum.psd_m3[k] * step).sum::<f64>()
        };
        assert!((within(0..=points / 2) - 0.5).abs() < 1e-14);
        assert!((within(0..=1) - means).abs() < 1e-14);
        for cycles in tones {
            assert!((within(cycles - 1..=cycles + 1) - 0.125).abs() < 1e-14, "{axis:?}, {cycles} cycles");
        }
    }
}

#[test]
fn the_window_does_not_change_the_variance_of_a_sine() {
    // xrft #218: A²/2 = 1.445; 1.5 times as much would be a window that is normalised by its mean.
    let grid = Grid::new(64, 2, 1.0, 1.0).unwrap();
    let map = HeightMap::from_function(grid, |x, _| 1.7 * (TAU * 5.0 * x / 64.0).sin()).unwrap();
    let spectrum = profile_spectrum(&map, Axis::X).unwrap();
    let step = spectrum.q_rad_per_m[1] / TAU;
    let total = step * (spectrum.psd_m3[0] + 2.0 * spectrum.psd_m3[1..32].iter().sum::<f64>() + spectrum.psd_m3[32]);
    assert!((total - 1.445).abs() < 1e-13, "{total}");
    let square = Grid::new(64, 64, 1.0, 1.0).unwrap();
    let map = HeightMap::from_function(square, |x, _| 1.7 * (TAU * 5.0 * x / 64.0).sin()).unwrap();
    let spectrum = radial_spectrum(&map).unwrap();
    let total = variance(square, &spectrum, 0.0, f64::INFINITY) + spectrum.corners_m2;
    assert!((total - 1.445).abs() < 1e-13, "{total}");
}

#[test]
fn slopes_areas_and_directions_count_the_pitch_of_each_axis() {
    // TopoStats pull request 779, surfalize 0.17.
    let grid = Grid::new(12, 7, 1.0, 2.5).unwrap();
    let plane = HeightMap::from_function(grid, |x, y| 0.3 * x + 0.4 * y).unwrap();
    let parameters = areal::parameters(&plane).unwrap();
    assert!((parameters.sdq.unwrap() - 0.5).abs() < 1e-14);
    assert!((parameters.sdq_7point.unwrap() - 0.5).abs() < 1e-14);
    assert!((parameters.sdr.unwrap() - (1.25_f64.sqrt() - 1.0)).abs() < 1e-14);
    // A groove counter-clockwise from x, with row 0 at the top; 96 × 64 points of 1 × 2.5.
    let grid = Grid::new(96, 64, 1.0, 2.5).unwrap();
    let (sine, cosine) = (PI / 6.0).sin_cos();
    let groove = HeightMap::from_function(grid, |x, y| (TAU * (x * sine + y * cosine) / 12.0).cos()).unwrap();
    let direction = areal::parameters(&groove).unwrap().std_rad.unwrap().to_degrees();
    assert!((direction - 30.0).abs() < 0.5, "{direction}");
    assert_eq!(groove.heights_m().dim(), (64, 96));
}

#[test]
fn voids_keep_their_place_when_a_map_is_levelled() {
    // SurfaceTopography #126; conversions of the levelled map are tested with the formats.
    let grid = Grid::new(4, 4, 1.0, 1.0).unwrap();
    let is_void = |row: usize, column: usize| matches!((row, column), (1, 2) | (3, 0));
    let bump = |row: usize, column: usize| if (row, column) == (2, 2) { 1.0 } else { 0.0 };
    let heights_m = Array2::from_shape_fn((4, 4), |(row, column)| {
        3.0 + 0.5 * column as f64 - 0.25 * row as f64 + bump(row, column)
    });
    let map = with_voids(&HeightMap::new(grid, heights_m).unwrap(), is_void);
    let levelled = remove_form(&map, Level::Plane).unwrap().map;
    let left_m = levelled.heights_m();
    left_m.indexed_iter().for_each(|((row, column), z)| assert_eq!(z.is_nan(), is_void(row, column)));
    // Least squares over the fourteen present points: the rest is orthogonal to 1, x and y.
    for weight in [|_, _| 1.0, |_, column| column as f64, |row, _| row as f64] as [fn(usize, usize) -> f64; 3] {
        let present = left_m.indexed_iter().filter(|(_, z)| !z.is_nan());
        let sum: f64 = present.map(|((row, column), z)| weight(row, column) * z).sum();
        assert!(sum.abs() < 1e-13, "{sum}");
    }
}
