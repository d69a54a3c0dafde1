//! Study files that come with the code.

use std::fs;
use std::path::PathBuf;

use asperity::friction::Upscaling;
use asperity::map::BoundaryKind;
use asperity::study::Study;
use asperity::study::file::Stribeck;
use asperity::surface::{CovarianceSource, SurfaceGenerator};

fn studies() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../studies")
}

fn study(name: &str) -> Study {
    Study::parse(&fs::read_to_string(studies().join(name)).unwrap(), name).unwrap()
}

/// Returns the binomial coefficient.
fn choose(n: usize, k: usize) -> usize {
    (1..=k).fold(1, |product, i| product * (n - k + i) / i)
}

#[test]
fn the_paper_s_study_has_the_paper_s_numbers() {
    let study = study("paper.toml");
    let surface = study.file().surface.as_ref().unwrap();
    assert_eq!((&surface.file, surface.generator, surface.modes), (&None, SurfaceGenerator::KarhunenLoeve, Some(101)));
    assert_eq!((surface.covariance, surface.marginal.as_str()), (CovarianceSource::SquaredExponential, "normal"));
    let pressure = study.file().pressure.as_ref().unwrap();
    assert_eq!(choose(pressure.variables + pressure.degree, pressure.degree), 165);
    assert_eq!((pressure.percentile, pressure.boundary), (Some(50.0), BoundaryKind::Free));
    // ℓ = L/10.
    let [x, y] = surface.correlation_length.unwrap();
    assert!((pressure.size[0].0 / x.0 - 10.0).abs() < 1e-12 && (pressure.size[1].0 / y.0 - 10.0).abs() < 1e-12);
    let friction = study.file().friction.as_ref().unwrap();
    assert_eq!((friction.window.unwrap().0, friction.strip.unwrap()[1].0), (600e-6, 75e-6));
    let material = study.file().material.as_ref().unwrap();
    let shear = material.hardness.unwrap().0 / (3.0 * 3_f64.sqrt());
    assert!((material.shear_strength.unwrap().0 / shear - 1.0).abs() < 1e-3);
    let vibration = study.file().vibration.as_ref().unwrap();
    assert_eq!(
        (vibration.damping_ratio, vibration.stribeck, vibration.normal_force.0),
        (0.17, Some(Stribeck::Dimensionless(4.2)), 2500.0)
    );
    assert_eq!((vibration.natural_frequency.0, vibration.dimensionless_belt_velocity), (316.0, Some(0.003)));
    assert_eq!((vibration.upscaling, vibration.level), (Upscaling::Paper, Some(50.0)));
}

#[test]
fn the_quickstart_measures_everything_and_uses_the_area_upscaling() {
    let study = study("quickstart.toml");
    assert!(study.file().keys_without_effect().is_empty(), "{:?}", study.file().keys_without_effect());
    let surface = study.file().surface.as_ref().unwrap();
    assert!(study.scan_paths(&studies())[0].is_file());
    assert_eq!((surface.covariance, surface.marginal.as_str()), (CovarianceSource::Measured, "measured"));
    assert_eq!((surface.rms_height, surface.correlation_length), (None, None));
    let vibration = study.file().vibration.as_ref().unwrap();
    assert_eq!((vibration.upscaling, vibration.level), (Upscaling::Area, None));
    // A pad under 2 MPa: between a hundredth and a tenth of it is in contact.
    assert!((vibration.normal_force.0 / vibration.nominal_area.0 / 2e6 - 1.0).abs() < 1e-12);
    let material = study.file().material.as_ref().unwrap();
    assert!(material.shear_strength.unwrap().0 < material.hardness.unwrap().0);
    assert!(material.youngs_modulus.0 > 10.0 * material.hardness.unwrap().0);
    // The friction law belongs to the machine and does not change with the load.
    assert!(matches!(vibration.stribeck, Some(Stribeck::Physical(_))), "{:?}", vibration.stribeck);
}
