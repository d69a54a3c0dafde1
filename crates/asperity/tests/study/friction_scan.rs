//! Friction of the scan itself beside the random strips, and the whole error of the friction coefficient.

use std::f64::consts::{LN_2, PI, TAU};

use asperity::map::{Grid, HeightMap};
use asperity::study::result::{OperatingPoint, ScanFriction};
use asperity::study::{Outcome, Study};
use asperity::surface::RandomSurface;
use asperity::surface::filter::{Edges, Respaced};
use asperity_testing::filtered_noise;
use ndarray::Array2;

use crate::support::{folder_with, run_in};

const POINTS: usize = 160;
const PIXEL_M: f64 = 1e-6;

/// A scan of rms height 0.5 µm with a self-affine spectrum of H = 0.8 from 25 µm down to `shortest_m`.
fn scan(shortest_m: f64) -> Array2<f64> {
    let grid = Grid::new(POINTS, POINTS, PIXEL_M, PIXEL_M).unwrap();
    let (rolls_off, most) = (TAU / 25e-6, TAU / shortest_m * (1.0 + 1e-9));
    let amplitude = |cycles_x: f64, cycles_y: f64| {
        let q = TAU * cycles_x.hypot(cycles_y) / grid.width_m();
        if q > most { 0.0 } else { (1.0 + (q / rolls_off).powi(2)).powf(-0.9) }
    };
    let noise = filtered_noise(grid, &mut asperity::random::stream(4, "scan", 0), amplitude);
    let rms = (noise.iter().map(|z| z * z).sum::<f64>() / noise.len() as f64).sqrt();
    Array2::from_shape_vec(grid.shape(), noise).unwrap() * (0.5e-6 / rms)
}

/// An elastic study of such a scan on strips that resolve its waves.
fn study(more: &str) -> String {
    format!(
        "seed = 5\n[surface]\nfile = \"scan.npy\"\npixel_size = \"1 um\"\nheight_unit = \"m\"\nlevel = \"mean\"\ngenerator = \"spectral\"\n\
         {more}[material]\nyoungs_modulus = \"1 GPa\"\npoisson_ratio = 0.4\nshear_strength = \"10 MPa\"\n[friction]\n\
         strip = [\"640 um\", \"128 um\"]\npoints = [960, 192]\nwindow = \"64 um\"\nboundary = \"periodic\"\nmean_pressures = [\"10 MPa\"]\n\
         realisations = 4\n"
    )
}

#[test]
fn strips_and_windows_that_a_study_leaves_out_suit_its_scan() {
    let folder = folder_with(scan(2.0 * PIXEL_M));
    let file = folder.path().join("study.toml").display().to_string();
    let sizes_of = |text: &str| {
        let study = Study::parse(text, &file).unwrap();
        let friction = study.file().friction.clone().unwrap();
        let sides = friction.strip.unwrap().map(|side| side.0);
        (study.scan_sizes(folder.path()).ok(), sides, friction.points.unwrap(), friction.window.unwrap().0)
    };
    let (strip, points, window) =
        ("strip = [\"640 um\", \"128 um\"]\n", "points = [960, 192]\n", "window = \"64 um\"\n");
    let text = study("");
    let without = |keys: &[&str]| keys.iter().fold(text.clone(), |text, key| text.replace(key, ""));
    let (of_scan, sides, count, window_m) = sizes_of(&without(&[strip, points, window]));
    let of_scan = of_scan.unwrap();
    assert_eq!((sides, count), (of_scan.strip_m, of_scan.strip_points));
    assert!((window_m / (0.1 * sides[0]) - 1.0).abs() < 1e-12);
    // A stated size is kept, and the others suit it: four points to a wave of 4 µm.
    let (_, sides, count, window_m) = sizes_of(&without(&[points, window]));
    assert!((sides[0] / 640e-6 - 1.0).abs() < 1e-12 && (window_m / 64e-6 - 1.0).abs() < 1e-12);
    assert_eq!(count, [640, 128]);
    assert_eq!(sizes_of(&text).2, [960, 192]);
    // Without a scan, or without one that can be read, the usual ones remain.
    let missing = without(&[strip, points, window]).replace("scan.npy", "missing.npy");
    for text in [
        missing.clone(),
        missing.replace("file = \"missing.npy\"\n", "covariance = \"exponential\"\nrms_height = \"1 um\"\ncorrelation_length = [\"20 um\", \"20 um\"]\nmarginal = \"normal\"\n")
            .replace("pixel_size = \"1 um\"\nheight_unit = \"m\"\nlevel = \"mean\"\n", ""),
    ] {
        let (_, sides, count, window_m) = sizes_of(&text);
        assert_eq!((sides, count, window_m), ([6e-3, 75e-6], [2048, 32], 600e-6));
    }
}

fn found(outcome: &Outcome) -> (&OperatingPoint, &ScanFriction) {
    let friction = outcome.results.friction.as_ref().unwrap();
    (&friction.operating_point, friction.scan.as_ref().unwrap())
}

/// Returns μ = τA/N, with τ = p̄ the area fraction in contact, of a periodic map on an eighth of its pitch.
fn refined(heights_m: &Array2<f64>) -> f64 {
    use asperity::contact::{Boundary, ContactProblem, Control, HalfSpace, Solver};
    let grid = Grid::new(POINTS, POINTS, PIXEL_M, PIXEL_M).unwrap();
    let mut map = HeightMap::new(grid, heights_m.clone()).unwrap();
    for _ in 0..3 {
        map = Respaced::with_half_the_pitch(&map, Edges::Periodic).unwrap().generate(&[]);
    }
    let half_space =
        HalfSpace::new(map.grid(), 1e9 / (1.0 - 0.16), Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }).unwrap();
    let control = Control::MeanPressure { pascal: 1e7 };
    let problem = ContactProblem::new(&half_space, map.heights_m(), control, None).unwrap();
    let solution = Solver::default().solve(&problem).unwrap();
    // Yastrebov's correction, A − (π − 1 + ln 2)/24 · S Δx, with S the length of the edges between contact and gap.
    let touches = solution.pressure_pa().mapv(|p| p > 0.0);
    let (ny, nx) = touches.dim();
    let count = touches.iter().filter(|touches| **touches).count() as f64;
    let edges = touches.indexed_iter().fold(0.0, |sum, ((row, column), own)| {
        let others = [touches[[row, (column + 1) % nx]], touches[[(row + 1) % ny, column]]];
        sum + others.into_iter().filter(|other| other != own).count() as f64
    });
    (count - (PI - 1.0 + LN_2) / 24.0 * edges) / (nx * ny) as f64
}

#[test]
#[ignore = "slow"]
fn strips_of_a_scan_without_short_waves_have_none_and_their_interval_covers_its_friction() {
    let heights_m = scan(4.0 * PIXEL_M);
    let folder = folder_with(heights_m.clone());
    let outcome = run_in(folder.path(), &study(""), None).unwrap();
    let (point, scan) = found(&outcome);
    // Waves from 4 µm down to 2 µm, which a fitted model would continue, add a fifth to the slopes and take a fifth from μ.
    assert!((scan.slope_ratio.unwrap() - 1.0).abs() < 0.08, "{scan:?}");
    let [first, .., last] = &scan.cut_offs[..] else { panic!("{scan:?}") };
    // Cutting the waves of a map of eight correlation lengths changes those of its edges.
    assert!((last.mean / first.mean - 1.0).abs() < 0.02 && (last.cutoff_m / 2e-6 - 1.0).abs() < 1e-9, "{scan:?}");
    assert!(point.mean_of_scan == Some(last.mean) && point.resolved, "{point:?}");
    let truth = refined(&heights_m);
    assert!((last.mean / truth - 1.0).abs() < 0.02, "{} instead of {truth}", last.mean);
    let [low, high] = point.mean_interval.unwrap();
    assert!(low < truth && truth < high && high - low < 0.25 * truth, "{truth}: {point:?}");
    let [inner_low, inner_high] = point.mean_computational_interval.unwrap();
    let [least_low, least_high] = point.mean_sampling_interval.unwrap();
    assert!(low < inner_low && inner_low <= least_low && least_high <= inner_high && inner_high < high, "{point:?}");
    assert!(!outcome.results.warnings.iter().any(|warning| warning.contains("the scan resolves")), "{outcome:?}");
}

#[test]
#[ignore = "slow"]
fn waves_beyond_the_resolved_ones_are_in_the_interval_and_in_a_warning_unless_the_cut_off_is_stated() {
    let heights_m = scan(2.0 * PIXEL_M);
    let folder = folder_with(heights_m.clone());
    let truth = refined(&heights_m);
    let outcome = run_in(folder.path(), &study(""), None).unwrap();
    let (point, scan) = found(&outcome);
    assert!(point.mean > 1.15 * truth, "{} against {truth}", point.mean);
    assert!((point.mean_of_scan.unwrap() / truth - 1.0).abs() < 0.02, "{point:?}, truth {truth}");
    let [low, high] = point.mean_interval.unwrap();
    assert!(low < truth && truth < high, "{truth}: {point:?}");
    assert!(scan.cut_offs.is_sorted_by(|a, b| a.cutoff_m > b.cutoff_m && a.mean > b.mean), "{scan:?}");
    assert!(outcome.results.warnings.iter().any(|warning| warning.contains("the scan resolves waves down to 4 µm")));
    // All waves of the grid: the strips are the scan's again.
    let stated = run_in(folder.path(), &study("cut_off = \"2 um\"\n"), None).unwrap();
    let (point, _) = found(&stated);
    assert!((point.mean / truth - 1.0).abs() < 0.1, "{} against {truth}", point.mean);
    let [low, high] = point.mean_interval.unwrap();
    assert!(low < truth && truth < high && high - low < 0.35 * truth, "{truth}: {point:?}");
    assert!(!stated.results.warnings.iter().any(|warning| warning.contains("the scan resolves")));
}

#[test]
#[ignore = "slow"]
fn a_verdict_has_an_unstated_cut_off_as_an_unknown_value() {
    let folder = folder_with(scan(2.0 * PIXEL_M));
    let machine = "[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"100 Hz\"\nnormal_force = \"100 N\"\nnominal_area = \"10 mm^2\"\n\
                   belt_velocity = \"20 mm/s\"\nstribeck = \"10 s/m\"\n";
    // ζ_v is proportional to μ: its limits at the ends of the cut-off lie on both sides of ζ.
    let with = |damping: &str, more: &str| {
        // A rough slider carries its contacts along: its friction is constant.
        let text = study(&format!("body = \"slider\"\n{more}")) + machine + &format!("damping_ratio = \"{damping}\"\n");
        run_in(folder.path(), &text, None).unwrap().results
    };
    let limit = with("0.1 ± 0.001", "").vibration.unwrap().limit_damping_ratio.unwrap();
    let results = with(&format!("{} ± {}", 0.87 * limit, 0.01 * limit), "");
    let verdict = results.verdict.unwrap();
    let range = verdict.probability_over_unknowns.unwrap();
    assert!(range.q05 < 0.02 && range.q95 > 0.98, "{range:?}");
    assert!(verdict.drivers.iter().any(|driver| driver.input == "surface.cut_off"), "{:?}", verdict.drivers);
    let stated = with(&format!("{} ± {}", 0.87 * limit, 0.01 * limit), "cut_off = \"4 um\"\n").verdict.unwrap();
    assert!(stated.drivers.iter().all(|driver| driver.input != "surface.cut_off"), "{:?}", stated.drivers);
}
