//! Mean friction as a function of the shortest wavelength kept, in whole studies.

use std::f64::consts::{LN_2, PI};
use std::sync::LazyLock;

use asperity::study::result::{CutoffResult, FrictionResult};
use asperity_testing::StudyText;

use crate::support::run_all;

/// A smooth surface of rms height 0.1 µm on strips that resolve it with a pitch of 2 µm, under a light load without a
/// hardness.
static ELASTIC: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(3, &["surface", "material", "friction"])
        .with("surface", "covariance = \"squared_exponential\"\nrms_height = \"0.1 um\"")
        .with("surface", "correlation_length = \"12 um\"")
        .with("friction", "strip = [\"1.024 mm\", \"64 um\"]\npoints = [512, 32]\nwindow = \"64 um\"")
        .with("friction", "mean_pressures = [\"60 MPa\"]")
        .without("material", &["hardness"])
        .to_string()
});
const PITCH_M: f64 = 2e-6;
const MODULUS_PA: f64 = 210e9 / (1.0 - 0.09);
const SHEAR_PA: f64 = 385e6;

fn cutoff(friction: &FrictionResult) -> &CutoffResult {
    friction.cutoff.as_ref().unwrap()
}

/// Returns the rms gradient, by differences over the pitch, of a surface of covariance σ² e^{−r²/ℓ²} after a Gaussian
/// filter.
///
/// The filter's weights are exp(−πr²/a²) with a² = λ² ln 2/π. Convolution with their autocorrelation keeps the form of
/// the covariance: ℓ² grows by 2a²/π, and σ² shrinks by the factor by which ℓ² grows, in two dimensions.
fn filtered_slope(cutoff_m: Option<f64>) -> f64 {
    let (variance, length2) = (1e-14, 144e-12);
    let filtered2 = length2 + cutoff_m.map_or(0.0, |m| 2.0 * m * m * LN_2 / (PI * PI));
    let differences = -(-PITCH_M * PITCH_M / filtered2).exp_m1();
    (4.0 * variance * length2 / filtered2 * differences).sqrt() / PITCH_M
}

#[test]
fn elastic_friction_is_inversely_proportional_to_the_slope_after_the_cutoff() {
    let friction = run_all(&ELASTIC).results.friction.unwrap();
    let found = cutoff(&friction);
    assert_eq!((found.pitch_m, found.cutoff_m, found.strips), (PITCH_M, 2.0 * PITCH_M, 4));
    assert_eq!((found.plastic_floor, found.band_end_m), (None, None));
    let cutoffs: Vec<f64> = found.points.iter().map(|point| point.cutoff_m / PITCH_M).collect();
    assert_eq!(cutoffs.len(), 5);
    assert!(cutoffs.iter().zip([2.0, 4.0, 8.0, 16.0, 32.0]).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{cutoffs:?}");
    // The point without cutoff has the mean of the study.
    assert_eq!(found.points[0].mean, friction.levels[0].process.at_mean_load.mean);
    let (own, wanted) =
        (found.points[0].mean_interval.unwrap(), friction.levels[0].process.at_mean_load.mean_interval.unwrap());
    assert!(own.iter().zip(wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{own:?} {wanted:?}");
    for (index, point) in found.points.iter().enumerate() {
        let slope = filtered_slope((index > 0).then_some(point.cutoff_m));
        // About a hundred squares of side ℓ: a standard error of 5 %.
        assert!((point.rms_slope / slope - 1.0).abs() < 0.15, "{point:?}, slope {slope}");
        // A_c/A_0 = κ p̄/(E* h'), with κ between Persson's √(8/π) = 1.6 and √(2π) = 2.5 for independent asperities, at
        // light load.
        let kappa = point.mean * MODULUS_PA * point.rms_slope / SHEAR_PA;
        assert!((1.4..2.6).contains(&kappa), "κ = {kappa} at {:e}", point.cutoff_m);
        assert_eq!(point.plastic_fraction, 0.0);
    }
    let (own, longest) = (&found.points[0], &found.points[4]);
    assert!(longest.mean > 1.8 * own.mean, "{} after {}", longest.mean, own.mean);
}

#[test]
#[ignore = "slow"]
fn a_coarse_pitch_is_halved_while_its_error_matters_and_a_warning_tells_what_is_left() {
    let unresolved = |outcome: &asperity::study::Outcome| {
        outcome.results.warnings.iter().any(|w| w.contains("the friction coefficient is not resolved"))
    };
    let resolved = run_all(&ELASTIC);
    let found = resolved.results.friction.as_ref().unwrap();
    let halved = &cutoff(found).finer_pitches[0];
    assert_eq!(halved.pitch_m, 0.5 * PITCH_M);
    // The area of a contact of so few cells has an error of a few percent.
    assert!((halved.change / halved.mean).abs() < 0.06, "{halved:?}");
    // e^{−r/ℓ} contains waves of all lengths, so contacts are single cells.
    let rough = ELASTIC.replace("squared_exponential", "exponential");
    let outcome = run_all(&rough);
    let found = outcome.results.friction.as_ref().unwrap();
    let [halved, quarter, ..] = &cutoff(found).finer_pitches[..] else { panic!("the pitch was halved once") };
    let [low, high] = halved.change_interval;
    assert!(low <= halved.change && halved.change <= high && (low > 0.0 || high < 0.0), "{halved:?}");
    assert_eq!(quarter.pitch_m, 0.25 * PITCH_M);
    // The limit of three terms of a geometric series; without a scan its order is that of the strips.
    let finer = &cutoff(found).finer_pitches;
    let at_pitch = halved.mean - halved.change;
    let means: Vec<f64> = std::iter::once(at_pitch).chain(finer.iter().map(|finer| finer.mean)).collect();
    let &[.., a, b, c] = &means[..] else { panic!("too few pitches: {means:?}") };
    let order = ((b - a) / (c - b)).log2().clamp(0.7, 2.0);
    let mean = found.operating_point.mean;
    assert!((mean - (c + (c - b) / (order.exp2() - 1.0))).abs() < 1e-12, "order {order}: {mean} of {means:?}");
    assert!((found.operating_point.grid_error.unwrap() - (c - mean)).abs() < 1e-12, "{means:?}");
    assert_eq!(found.levels[0].process.at_mean_load.mean, mean);
    assert!(!unresolved(&outcome) && found.operating_point.grid_error.unwrap() < 0.03 * mean);
    assert!(cutoff(found).known.contains("known only as far as"), "{}", cutoff(found).known);
    assert!(outcome.results.assumptions.contains(&cutoff(found).known));
    // Under a light load contacts are smaller than any affordable cell.
    let light = run_all(&rough.replace("60 MPa", "1 MPa"));
    assert!(unresolved(&light), "{:?}", light.results.friction.unwrap().cutoff);
}

#[test]
fn under_a_small_hardness_friction_is_the_plastic_floor_at_every_cutoff() {
    let soft = ELASTIC
        .replace("[material]", "[material]\nhardness = \"100 MPa\"")
        .replace("60 MPa", "5 MPa")
        .replace("385 MPa", "40 MPa");
    let outcome = run_all(&soft);
    let friction = outcome.results.friction.as_ref().unwrap();
    let found = cutoff(friction);
    assert_eq!(found.plastic_floor, Some(0.4));
    for point in &found.points {
        assert!(point.mean >= 0.4 * (1.0 - 1e-9) && point.mean < 0.4 * 1.3, "{point:?}");
        assert!(point.plastic_fraction > 0.5, "{point:?}");
    }
    assert!(found.known.contains("Yielding makes") && found.known.contains("H = 0.4"), "{}", found.known);
    // The table agrees with the results.
    let table = &outcome.tables["friction_cutoff"];
    assert_eq!(table.column("mean").unwrap().len(), found.points.len());
    assert_eq!(table.column("cutoff_m").unwrap()[1], found.points[1].cutoff_m);
}

#[test]
#[ignore = "slow"]
fn free_and_fractal_strips_have_a_cutoff_analysis_and_coulombs_law_has_none() {
    let free = ELASTIC.replace("[friction]", "[friction]\nboundary = \"free\"");
    let fractal = ELASTIC.replace(
        "covariance = \"squared_exponential\"\nmarginal = \"normal\"",
        "generator = \"weierstrass_mandelbrot\"\nfractal_dimension = 2.3",
    );
    for text in [free, fractal.replace("correlation_length = \"12 um\"\n", "")] {
        let friction = run_all(&text).results.friction.unwrap();
        let found = cutoff(&friction);
        let falls = |pair: &[asperity::study::result::CutoffPoint]| pair[1].rms_slope < pair[0].rms_slope;
        assert!(found.points.len() == 5 && found.points.windows(2).all(falls), "{:?}", found.points);
        assert!(found.points[4].mean > found.points[0].mean && !found.finer_pitches.is_empty());
    }
    let coulomb = ELASTIC.replace("[friction]", "[friction]\nlaw = \"coulomb\"\ncoefficient = 0.2");
    assert!(run_all(&coulomb.replace("shear_strength = \"385 MPa\"\n", "")).results.friction.unwrap().cutoff.is_none());
}
