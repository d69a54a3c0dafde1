//! Invented results with every key of `results.json` and `comparison.json`.
#![allow(dead_code, unused_imports, reason = "each test that includes this file uses a part of it")]

mod friction;
mod pressure;
mod surface;
pub(crate) mod verdict;
mod vibration;

use asperity_results::{
    BandMethod, Comparison, CurveComparison, DistributionResult, MeasuredSurface, Results, StatisticComparison,
    TwinModel,
};

pub(crate) use friction::{
    CUTOFFS_M, PENETRATIONS_M, PLASTIC_FRACTIONS, RMS_SLOPES, cutoff_mean, level_mean, level_std, uncertainty,
};
pub(crate) use surface::{part, scan};
pub(crate) use vibration::{cycles, damping_ratios, mode_coupling};

/// Results of a study with one scan and all stages.
pub(crate) fn results() -> Results {
    Results {
        seed: 2016,
        surface: Some(surface::surface(MeasuredSurface::Scan(Box::new(scan())))),
        pressure: Some(pressure::pressure()),
        friction: Some(friction::friction()),
        vibration: Some(vibration::vibration()),
        assumptions: vec!["The boundary of the pressure patches is free.".into()],
        warnings: vec![
            "At the level of 3 MPa the windows hold 21 contact cells on average; about 30 are needed.".into(),
        ],
        ..Results::default()
    }
}

/// A distribution with its parameters.
pub(crate) fn law(name: &str, parameters: &[(&str, f64)]) -> DistributionResult {
    DistributionResult {
        name: name.into(),
        parameters: parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
    }
}

fn statistic(target: f64, inside: bool) -> StatisticComparison {
    StatisticComparison {
        target: Some(target),
        mean: Some(0.2),
        std: Some(0.02),
        band: Some([0.16, 0.24]),
        inside: Some(inside),
        defined: 10,
    }
}

/// Returns a comparison of a scan with ten twins.
pub(crate) fn comparison() -> Comparison {
    let curve = |inside| CurveComparison { inside_share: Some(inside as f64 / 20.0), inside, points: 20 };
    Comparison {
        file: "scan.x3p".into(),
        count: 10,
        seed: 4,
        points: [40, 30],
        pitch_m: [1e-6; 2],
        band_method: BandMethod::StudentT,
        band_level: 0.95,
        inside: 1,
        compared: 2,
        curves_inside: 36,
        curves_compared: 40,
        model: TwinModel {
            generator: "spectral".into(),
            boundary: "free".into(),
            translation: Some("corrected".into()),
            rms_height_m: 5.1e-7,
            form_share: Some(0.03),
            covariance: results().surface.and_then(|surface| surface.covariance),
            marginal: law("beta", &[("a", 2.1)]),
        },
        target: scan(),
        twins: vec![("Ssk".into(), statistic(0.2, true)), ("Sdq".into(), statistic(0.3, false))],
        curves: vec![("acf_x".into(), curve(19)), ("acf_y".into(), curve(17))],
        limits: vec!["Twins are stationary.".into()],
        assumptions: vec!["The plane was removed.".into()],
        warnings: vec!["1 of 2 statistics lies outside.".into()],
    }
}
