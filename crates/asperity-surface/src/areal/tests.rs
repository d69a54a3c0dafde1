use super::*;
use crate::level::{Level, remove_form};
use crate::{RandomSurface, SpectralField, fractal};
use asperity_base::correlation::{Axis, CorrelationModel, Covariance, profile_spectrum};
use asperity_base::map::Grid;
use asperity_base::random;
use ndarray::Array2;
use std::f64::consts::{PI, SQRT_2, TAU};

fn close(name: &str, found: f64, wanted: f64, tolerance: f64) {
    assert!((found / wanted - 1.0).abs() < tolerance, "{name} = {found}, not {wanted}");
}

/// Returns z = A sin(2πx/P) with `n` points per period and `periods` periods.
fn sinusoid(amplitude: f64, period: f64, n: usize, periods: usize) -> HeightMap {
    let grid = Grid::new(n * periods, 16, period / n as f64, period / n as f64).unwrap();
    HeightMap::from_function(grid, |x, _| amplitude * (TAU * x / period).sin()).unwrap()
}

#[test]
fn a_sinusoid_has_its_closed_forms() {
    let (amplitude, period, n) = (2e-6, 50e-6, 200);
    let p = parameters(&sinusoid(amplitude, period, n, 8)).unwrap();
    // Sums over whole periods are exact, except for |sin|, whose midpoint rule has an error of π²/(6n²)·… < 1e-4.
    close("Sa", p.sa_m, 2.0 * amplitude / PI, 1e-4);
    close("Sq", p.sq_m, amplitude / SQRT_2, 1e-12);
    assert!(p.ssk.abs() < 1e-12);
    close("Sku", p.sku, 1.5, 1e-12);
    close("Sz", p.sz_m, 2.0 * amplitude, 1e-3);
    let slope = SQRT_2 * PI * amplitude / period;
    let sinc = (PI / n as f64).sin() / (PI / n as f64);
    // One point of 1,600 along a row has no right neighbour.
    close("Sdq", p.sdq.unwrap(), slope * sinc, 1e-3);
    close("Sdq_7point", p.sdq_7point.unwrap(), slope, 3e-3);
    // The correlation along x is cos(2πτ/P) up to the different phases at each lag; along y it does not decay.
    close("Sal", p.sal_m.unwrap(), 0.217_952_891_575_525_6 * period, 0.02);
    assert_eq!(p.str_ratio, None);
}

#[test]
fn rays_end_on_pixels_of_any_ratio() {
    // White noise is uncorrelated from one pixel to the next, so Sal is 0.8 of the shorter side if the level is 0.2.
    let white = random::standard_normal(&mut random::stream(9, "ratio", 0), 48 * 32);
    for (dx, dy) in [(1e-15, 1e3), (1e3, 1e-15), (1e-6, 1e-6), (1e-6, 1e-3), (1e-3, 1e-6)] {
        let heights = Array2::from_shape_vec((32, 48), white.clone()).unwrap();
        let sal = parameters(&HeightMap::new(Grid::new(48, 32, dx, dy).unwrap(), heights).unwrap()).unwrap().sal_m;
        close("Sal", sal.unwrap(), 0.8 * dx.min(dy), 0.1);
    }
}

#[test]
fn the_developed_area_of_a_sinusoid_converges_to_its_elliptic_integral_at_second_order() {
    // (2/π) E(−k²) − 1 at k = 2πA/P.
    for (k, wanted) in [(0.1, 0.0024953319251068695), (0.5, 0.05983938018764845), (1.0, 0.21600672342497984)] {
        let error = |n: usize| {
            // One point more than a period, so that the cells cover the period exactly.
            let grid = Grid::new(n + 1, 2, 1.0 / n as f64, 1.0 / n as f64).unwrap();
            let map = HeightMap::from_function(grid, |x, _| k / TAU * (TAU * x).sin()).unwrap();
            (parameters(&map).unwrap().sdr.unwrap() / wanted - 1.0).abs()
        };
        let order = (error(50) / error(100)).log2();
        assert!((order - 2.0).abs() < 0.05, "k = {k}: observed order {order:.3}");
        assert!(error(1000) < 1e-5);
    }
}

#[test]
fn an_egg_box_has_its_closed_forms() {
    let (amplitude, period, n) = (3e-6, 20e-6, 40);
    let pitch = period / n as f64;
    let grid = Grid::new(400, 400, pitch, pitch).unwrap();
    let map = HeightMap::from_function(grid, |x, y| amplitude * (TAU * x / period).cos() * (TAU * y / period).cos());
    let p = parameters(&map.unwrap()).unwrap();
    close("Sa", p.sa_m, 4.0 * amplitude / (PI * PI), 3e-3);
    close("Sq", p.sq_m, amplitude / 2.0, 1e-12);
    close("Sku", p.sku, 2.25, 1e-12);
    close("Sdq_7point", p.sdq_7point.unwrap(), SQRT_2 * PI * amplitude / period, 5e-3);
    // ρ = cos(2πx/P) cos(2πy/P): shortest along the axes, longest along the diagonals, where cos² = 0.2. A lag
    // leaves 10 periods minus a fraction, whose incomplete phases shift ρ by up to 1/(4π·10) along x and y each.
    let shortest = 0.2_f64.acos() / TAU * period;
    let longest = SQRT_2 * 0.2_f64.sqrt().acos() / TAU * period;
    close("Sal", p.sal_m.unwrap(), shortest, 0.02);
    close("Str", p.str_ratio.unwrap(), shortest / longest, 0.02);
}

#[test]
fn a_tilted_plane_with_missing_points_has_the_slope_and_area_of_a_plane() {
    let grid = Grid::new(40, 30, 1e-6, 2e-6).unwrap();
    let mut heights = HeightMap::from_function(grid, |x, y| 0.3 * x - 0.4 * y).unwrap().heights_m().clone();
    let mut stream = random::stream(11, "holes", 0);
    for z in &mut heights {
        if random::standard_normal(&mut stream, 1)[0] > 1.5 {
            *z = f64::NAN;
        }
    }
    let map = HeightMap::new(grid, heights).unwrap();
    let p = parameters(&map).unwrap();
    assert!(p.missing > 40 && p.present + p.missing == 1200);
    close("Sdq", p.sdq.unwrap(), 0.5, 1e-9);
    close("Sdq_7point", p.sdq_7point.unwrap(), 0.5, 1e-9);
    close("Sdr", p.sdr.unwrap(), 1.25_f64.sqrt() - 1.0, 1e-9);
}

#[test]
fn statistics_skip_missing_points() {
    // A map of n rows, and the same map with as many missing rows below, have the same height statistics and slopes.
    let rough = random::standard_normal(&mut random::stream(11, "rows", 0), 32 * 32);
    let full =
        HeightMap::new(Grid::new(32, 32, 1.0, 1.0).unwrap(), Array2::from_shape_vec((32, 32), rough.clone()).unwrap());
    let half = HeightMap::new(
        Grid::new(32, 64, 1.0, 1.0).unwrap(),
        Array2::from_shape_fn((64, 32), |(row, column)| if row < 32 { rough[row * 32 + column] } else { f64::NAN }),
    );
    let (full, half) = (parameters(&full.unwrap()).unwrap(), parameters(&half.unwrap()).unwrap());
    assert_eq!(half.missing, 32 * 32);
    // Lags along y are longer on the taller map, and the spectrum of a map with missing points has another resolution.
    let ArealParameters { sal_m, str_ratio, std_rad, ssw_m, .. } = full;
    assert_eq!(ArealParameters { missing: 0, sal_m, str_ratio, std_rad, ssw_m, ..half }, full);
    close("Sal", half.sal_m.unwrap(), full.sal_m.unwrap(), 1e-12);
}

#[test]
fn parameters_follow_the_unit_and_ignore_the_offset() {
    let rough = random::standard_normal(&mut random::stream(11, "unit", 0), 24 * 24);
    let of = |unit: f64, offset: f64| {
        let heights = rough.iter().map(|z| unit * z + offset).collect();
        let grid = Grid::new(24, 24, unit, unit).unwrap();
        parameters(&HeightMap::new(grid, Array2::from_shape_vec((24, 24), heights).unwrap()).unwrap()).unwrap()
    };
    let (metre, micro) = (of(1.0, 0.0), of(1e-6, 1e-3));
    for (name, a, b) in [
        ("Sq", metre.sq_m * 1e-6, micro.sq_m),
        ("Spk", metre.core.spk_m * 1e-6, micro.core.spk_m),
        ("Std", metre.std_rad.unwrap(), micro.std_rad.unwrap()),
        ("Ssw", metre.ssw_m.unwrap() * 1e-6, micro.ssw_m.unwrap()),
        ("Vvc", metre.vvc_m * 1e-6, micro.vvc_m),
        ("Ssk", metre.ssk, micro.ssk),
        ("Sdr", metre.sdr.unwrap(), micro.sdr.unwrap()),
        ("Sal", metre.sal_m.unwrap() * 1e-6, micro.sal_m.unwrap()),
    ] {
        close(name, b, a, 1e-9);
    }
}

#[test]
fn a_surface_without_roughness_is_an_error() {
    let grid = Grid::new(8, 8, 1.0, 1.0).unwrap();
    for height in [0.0, 0.1] {
        let map = HeightMap::new(grid, Array2::from_elem((8, 8), height)).unwrap();
        assert_eq!(parameters(&map), Err(ArealError::Flat { present: 64 }));
    }
    let tilted = HeightMap::from_function(grid, |x, y| 1e-3 + 0.3 * x - 0.7 * y).unwrap();
    let levelled = remove_form(&tilted, Level::Plane).unwrap().map;
    assert_eq!(parameters(&levelled), Err(ArealError::Flat { present: 64 }));
}

#[test]
fn parameters_are_none_on_a_map_smaller_than_the_stencil() {
    let grid = Grid::new(5, 5, 1.0, 1.0).unwrap();
    let p = parameters(&HeightMap::from_function(grid, |x, y| (x * y).sin()).unwrap()).unwrap();
    assert!(p.sdq.is_some() && p.sdq_7point.is_none());
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let grid = Grid::new(300, 240, 1.0, 1.0).unwrap();
    let covariance = Covariance::new(CorrelationModel::Exponential, 1.0, 6.0, 3.0).unwrap();
    let field = SpectralField::periodic(&covariance, grid);
    let xi = random::standard_normal(&mut random::stream(11, "threads", 0), field.xi_len());
    let full = field.generate(&xi);
    let mut heights = full.heights_m().clone();
    heights.iter_mut().step_by(13).for_each(|z| *z = f64::NAN);
    let holes = HeightMap::new(grid, heights).unwrap();
    for map in [full, holes] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let Analysis { parameters, correlation, spectrum } = analyse(&map).unwrap();
                let profiles = [Axis::X, Axis::Y].map(|axis| profile_spectrum(&map, axis).unwrap());
                (parameters, correlation, spectrum, profiles, fractal::scaling(&map, None).unwrap())
            })
        };
        let alone = with(1);
        assert_eq!(alone, with(2));
        assert_eq!(alone, with(3));
    }
}

/// Compares instrument files with plain NumPy, if the folder named by ASPERITY_REFERENCE contains them.
#[test]
fn instrument_files_have_the_parameters_of_an_independent_program() {
    let Some(folder) = std::env::var_os("ASPERITY_REFERENCE") else {
        println!("skipped: ASPERITY_REFERENCE names no folder");
        return;
    };
    let folder = std::path::Path::new(&folder).join("surfaces");
    let text = std::fs::read_to_string(folder.join("reference.json")).unwrap();
    let reference: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut compared = 0;
    for (file, expected) in reference.as_object().unwrap() {
        let wanted = &expected["own_numpy_after_LS_plane"];
        if !wanted["Sq_m"].is_f64() {
            continue;
        }
        let scan = asperity_formats::read(&folder.join(file)).unwrap();
        let map = remove_form(&HeightMap::try_from(scan).unwrap(), Level::Plane).unwrap().map;
        let p = parameters(&map).unwrap();
        assert_eq!(Some(p.missing as u64), expected["n_missing"].as_u64(), "{file}");
        for (name, found) in [
            ("Sq_m", Some(p.sq_m)),
            ("Sa_m", Some(p.sa_m)),
            ("Ssk", Some(p.ssk)),
            ("Sku", Some(p.sku)),
            ("Sp_m", Some(p.sp_m)),
            ("Sv_m", Some(p.sv_m)),
            ("Sz_m", Some(p.sz_m)),
            ("Sdq_forward_diff", p.sdq),
            ("Sdq_iso7pt", p.sdq_7point),
            ("Sdr_triangulated", p.sdr),
        ] {
            // A map with fewer rows than the stencil has no such gradient; programs with other edge rules may differ.
            let Some(found) = found else {
                assert!(name == "Sdq_iso7pt" && map.grid().ny() < 7, "{file}: {name}");
                continue;
            };
            // The reference corrects the heights of one file, which its loader scaled by 65535/65534, but not the slopes.
            let order = match (file.as_str(), name) {
                ("st_nms-1.nms", "Sdr_triangulated") => 2,
                ("st_nms-1.nms", _) if name.starts_with("Sdq") => 1,
                _ => 0,
            };
            let scale = (65535.0_f64 / 65534.0).powi(order);
            close(&format!("{file}: {name}"), scale * found, wanted[name].as_f64().unwrap(), 1e-6);
        }
        let pixel_m = map.grid().dx_m();
        // On the smallest map the reference returns nothing; here one ray decays within half the field.
        if let Some(sal_m) = wanted["Sal_rays_s0.2_m"].as_f64() {
            let sal_m = sal_m * pixel_m / expected["dx_m"].as_f64().unwrap();
            assert!((p.sal_m.unwrap() - sal_m).abs() < pixel_m, "{file}: Sal {:?}, not {sal_m}", p.sal_m);
        }
        assert_eq!(p.str_ratio.is_some(), wanted["Str_rays_s0.2"].is_f64(), "{file}: Str");
        // Another package fits the same least-squares line to a curve resampled to 10,000 ratios, which misrepresents
        // rarer spikes. With a million ratios its Svk of such a map changes by 1 % towards ours. Reduced heights and
        // volumes of peaks and dales are not compared if the highest or deepest point is an extreme outlier.
        let peer = &expected["surfalize_0.19.2_um_on_same_levelled_array"];
        if peer["Sk"].is_f64() {
            let spiky = p.sp_m.max(p.sv_m) > 20.0 * p.sq_m;
            // The peer read the millimetres of one file as micrometres.
            let um = if file == "st_tmd-1.tmd" { 1e-3 } else { 1e-6 };
            for (name, found, unit, tolerance) in [
                ("Sk", p.core.sk_m, um, 1e-3),
                ("Spk", p.core.spk_m, um, if spiky { f64::INFINITY } else { 5e-3 }),
                ("Svk", p.core.svk_m, um, if spiky { f64::INFINITY } else { 5e-3 }),
                ("Smrk1", p.core.smrk1, 1e-2, 1e-2),
                ("Smrk2", p.core.smrk2, 1e-2, 1e-3),
                ("Vmp", p.vmp_m, um, if spiky { f64::INFINITY } else { 1e-2 }),
                ("Vmc", p.vmc_m, um, 1e-3),
                ("Vvc", p.vvc_m, um, 1e-3),
                ("Vvv", p.vvv_m, um, if spiky { f64::INFINITY } else { 5e-3 }),
            ] {
                close(&format!("{file}: {name}"), found, peer[name].as_f64().unwrap() * unit, tolerance);
            }
        }
        compared += 1;
    }
    assert!(compared >= 3, "only {compared} files could be compared");
}
