//! Studies of a profile, heights along one line of a surface without lay.

use std::fs;

use asperity::correlation::{CorrelationModel, Covariance};
use asperity::map::Grid;
use asperity::random;
use asperity::study::{Stage, Study};
use asperity::surface::{RandomSurface, SpectralField};
use tempfile::TempDir;

use crate::support::run_in;

const POINTS: usize = 8192;
const LENGTH_M: f64 = 1e-5;

/// Writes a line of a surface of covariance σ²e^{−r/ℓ}, σ = 0.5 µm and ℓ = 10 µm, as a stylus records it.
fn folder_with_profile() -> TempDir {
    let grid = Grid::new(POINTS, 64, 1e-6, 1e-6).unwrap();
    let covariance = Covariance::isotropic(CorrelationModel::Exponential, 0.5e-6, LENGTH_M).unwrap();
    let field = SpectralField::periodic(&covariance, grid);
    let map = field.generate(&random::standard_normal(&mut random::stream(8, "profile", 0), field.xi_len()));
    let mut text = "Lateral(µm),Total Profile(nm),,\n".to_owned();
    for (place, z) in map.values_m()[..POINTS].iter().enumerate() {
        text += &format!("{place},{:.3},,\n", z * 1e9);
    }
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("stylus.csv"), text).unwrap();
    folder
}

fn text(surface: &str) -> String {
    format!(
        "seed = 5\n[surface]\nlevel = \"mean\"\ngenerator = \"spectral\"\n{surface}[material]\nyoungs_modulus = \"1 GPa\"\n\
         poisson_ratio = 0.4\nshear_strength = \"10 MPa\"\n[friction]\nstrip = [\"640 um\", \"80 um\"]\npoints = [512, 64]\n\
         window = \"64 um\"\nboundary = \"periodic\"\nmean_pressures = [\"10 MPa\"]\nrealisations = 4\n"
    )
}

#[test]
fn a_profile_gives_the_surface_of_which_it_is_a_line() {
    let folder = folder_with_profile();
    let found =
        run_in(folder.path(), &text("file = \"stylus.csv\"\nisotropic = true\n"), Some(Stage::Friction)).unwrap();
    let surface = found.results.surface.unwrap();
    let covariance = surface.covariance.unwrap();
    // 820 correlation lengths: the variance is known to some 5 %, and the length of e^{−r/ℓ} to 10 %.
    assert!((covariance.std_m / 0.5e-6 - 1.0).abs() < 0.1, "{covariance:?}");
    assert!((covariance.decay_length_x_m / LENGTH_M - 1.0).abs() < 0.25, "{covariance:?}");
    assert_eq!(covariance.decay_length_x_m, covariance.decay_length_y_m);
    assert_eq!(surface.marginal.name, "normal");
    let said = [found.results.assumptions.concat(), found.results.warnings.concat()].concat();
    for words in ["stylus.csv of 8192 points", "stands for a surface without lay", "cannot show a lay", "down to 4 µm"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }
    // Friction is that of the surface, stated.
    let stated = "covariance = \"exponential\"\ncorrelation_length = \"10 um\"\nrms_height = \"0.5 um\"\nmarginal = \"normal\"\ncut_off = \"4 um\"\n";
    let truth = run_in(folder.path(), &text(stated), Some(Stage::Friction)).unwrap();
    let [own, truth] =
        [found.results.friction, truth.results.friction].map(|found| found.unwrap().levels[0].mean.unwrap());
    assert!((own / truth - 1.0).abs() < 0.15, "{own} {truth}");
}

#[test]
fn a_profile_needs_the_statement_that_the_surface_has_no_lay() {
    let folder = folder_with_profile();
    let study = Study::parse(&text("file = \"stylus.csv\"\n"), "study.toml").unwrap();
    let error = study.check_scans(folder.path()).unwrap_err().to_string();
    assert!(error.contains("a profile of 8192 points") && error.contains("isotropic = true"), "{error}");
    let stated = text(
        "covariance = \"exponential\"\ncorrelation_length = \"10 um\"\nrms_height = \"0.5 um\"\nmarginal = \"normal\"\nisotropic = true\n",
    );
    let study = Study::parse(&stated, "study.toml").unwrap();
    assert!(study.warnings().concat().contains("isotropic has no effect without `file`"), "{:?}", study.warnings());
}

#[test]
fn sizes_of_a_study_follow_from_its_profile() {
    let folder = folder_with_profile();
    let study = Study::parse(&text("file = \"stylus.csv\"\nisotropic = true\n"), "study.toml").unwrap();
    let sizes = study.scan_sizes(folder.path()).unwrap();
    assert!((sizes.shortest_wave_m / 4e-6 - 1.0).abs() < 0.01, "{sizes:?}");
    let coarse = text("file = \"stylus.csv\"\nisotropic = true\ncut_off = \"20 um\"\n");
    let coarse = Study::parse(&coarse, "study.toml").unwrap().scan_sizes(folder.path()).unwrap();
    assert!(coarse.shortest_wave_m == 20e-6 && coarse.strip_points[0] < sizes.strip_points[0], "{coarse:?}");
    for (more, words) in [
        ("covariance = \"empirical\"\n", "the covariance in all directions"),
        ("generator = \"weierstrass_mandelbrot\"\n", "the fractal dimension"),
    ] {
        let changed = text("file = \"stylus.csv\"\nisotropic = true\n").replace("generator = \"spectral\"\n", more);
        let study = Study::parse(&changed, "study.toml").unwrap();
        let error = study.check_scans(folder.path()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    assert!(sizes.correlation_length_m.iter().all(|length_m| (length_m / LENGTH_M - 1.0).abs() < 0.25), "{sizes:?}");
}
