//! Checks of `[friction]`.

use serde::Serialize;

use std::sync::Arc;

use super::invalid_value::{InvalidValue, PERCENT, POSITIVE, at_least, invalid, once, positive, within};
use super::pressure::Material;
use crate::chaos::Propagation;
use crate::friction::cutoff::CutoffPlan;
use crate::friction::law::{WindowLaw, WindowLawKind};
use crate::friction::window::{Window, WindowError};
use crate::friction::{LevelControl, RoughBody};
use crate::map::{BoundaryKind, Grid};
use crate::quantity::{Area, Compliance};
use crate::study::file::{FrictionSection, StudyFile, SurfaceSection, UncertaintySection, WindowShape};
use crate::study::standard_deviation::{LengthStd, NumberStd};
use crate::surface::SurfaceGenerator;

const SECTION: &str = "friction";
const UNCERTAINTY: &str = "friction.uncertainty";

/// Settings of the friction stage: friction of windows on solved strips.
#[derive(Debug, Clone, Serialize)]
pub(in crate::study) struct FrictionStudy {
    /// Least fraction of valid samples.
    pub(in crate::study) valid_fraction: f64,
    pub(in crate::study) material: Material,
    #[serde(skip)]
    pub(in crate::study) law: Arc<dyn WindowLaw>,
    /// Kind and inputs of the law, which determine it.
    pub(in crate::study) law_inputs: (WindowLawKind, Vec<(&'static str, Option<f64>)>),
    /// Bodies that are rough.
    pub(in crate::study) body: RoughBody,
    /// Points (x, y) of a strip.
    pub(in crate::study) points: [usize; 2],
    /// Size (x, y) of a strip in metre; it slides along x.
    pub(in crate::study) size_m: [f64; 2],
    pub(in crate::study) boundary: BoundaryKind,
    /// Mean compliance of a periodic strip; `None` for the default.
    pub(in crate::study) mean_compliance: Option<Compliance>,
    /// Length and width of the window in metre.
    pub(in crate::study) window_m: [f64; 2],
    pub(in crate::study) window_shape: WindowShape,
    pub(in crate::study) levels: Vec<LevelControl>,
    /// Area over which windows average, if `[friction]` states it.
    pub(in crate::study) nominal_area: Option<Area>,
    /// Number of strips per level.
    pub(in crate::study) realisations: usize,
    /// Relative tolerance of a contact solution.
    pub(in crate::study) tolerance: f64,
    pub(in crate::study) uncertainty: Option<UncertaintyStudy>,
}

impl FrictionStudy {
    /// Returns the grid of a strip and its window.
    pub(in crate::study) fn strip(&self) -> Result<(Grid, Window), InvalidValue> {
        let ([nx, ny], [length_m, width_m]) = (self.points, self.size_m);
        let grid = Grid::with_size(nx, ny, length_m, width_m)
            .map_err(|error| invalid(SECTION, "points", error.to_string()))?;
        let [length_m, width_m] = self.window_m;
        let window = match self.window_shape {
            WindowShape::Rectangle => Window::rectangle(length_m, width_m, grid),
            WindowShape::Ellipse => Window::ellipse(length_m, width_m, grid),
        };
        let window = window.map_err(|error| {
            let key = match error {
                WindowError::TooNarrow { .. } | WindowError::TooWide { .. } => "window_width",
                WindowError::TooManyCells { .. } => "points",
                _ => "window",
            };
            invalid(SECTION, key, error.to_string())
        })?;
        Ok((grid, window))
    }

    /// Returns whether the friction law depends on the contact.
    pub(in crate::study) fn depends_on_contact(&self) -> bool {
        // Laws that depend on the contact have a plastic floor at any hardness.
        self.law.plastic_floor(1.0).is_some()
    }

    /// Returns the friction coefficient of complete plastic contact; `None` without a hardness or if friction does not depend on the contact.
    pub(in crate::study) fn plastic_floor(&self) -> Option<f64> {
        self.material.hardness_pa.and_then(|pascal| self.law.plastic_floor(pascal))
    }

    /// Returns the plan of the study of the cut-off with a number of levels, on a surface without waves shorter than
    /// `shortest_m`; `None` for Coulomb's law, which does not depend on the contact.
    pub(in crate::study) fn cutoff_plan(&self, levels: usize, shortest_m: f64) -> Option<CutoffPlan> {
        self.depends_on_contact()
            .then(|| CutoffPlan::new(self.points, self.size_m, levels * self.realisations, shortest_m))
    }
}

/// Standard deviations of the uncertain parameters of the surface; `None` for parameters that are certain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(in crate::study) struct UncertaintyStudy {
    pub(in crate::study) rms_height: Option<LengthStd>,
    pub(in crate::study) correlation_length: Option<LengthStd>,
    pub(in crate::study) skewness: Option<NumberStd>,
    /// Number of surfaces, each with other parameters.
    pub(in crate::study) points: usize,
    /// Number of strips of each surface.
    pub(in crate::study) realisations: usize,
}

impl StudyFile {
    pub(super) fn check_friction(&self, material: Option<&Material>) -> Result<Option<FrictionStudy>, InvalidValue> {
        let (Some(f), Some(&material), Some(surface)) = (&self.friction, material, &self.surface) else {
            return Ok(None);
        };
        let law = self.stated_law(f.law.statement(), None)?;
        let law_inputs = (f.law, self.stated_numbers(f.law.statement().inputs));
        let (strip, points, window) = f.sizes(None);
        for side in strip {
            within(SECTION, "strip", side, positive, POSITIVE)?;
        }
        for n in points {
            at_least(SECTION, "points", n, 2)?;
        }
        let (least, inner) = (window.0, strip[0].0 - 2.0 * strip[1].0);
        if f.boundary == BoundaryKind::Free && inner < least {
            let message = "the analysis omits both ends of a free strip, each as long as the strip is wide; no window fits between them";
            return Err(invalid(SECTION, "strip", message));
        }
        if let Some(compliance) = f.mean_compliance {
            within(SECTION, "mean_compliance", compliance, positive, POSITIVE)?;
        }
        let levels = check_levels(f, &material)?;
        let machine = self.vibration.as_ref().map(|vibration| vibration.nominal_area);
        if let Some((area, other)) = f.nominal_area.zip(machine).filter(|(area, other)| area != other) {
            let message = format!("found {area}, but [vibration] states {other}; remove one of them");
            return Err(invalid(SECTION, "nominal_area", message));
        }
        at_least(SECTION, "realisations", f.realisations, 2)?;
        within(SECTION, "tolerance", f.tolerance, |t| t > 0.0 && t < 0.1, "a relative tolerance between 0 and 0.1")?;
        let uncertainty = f.uncertainty.as_ref().map(|u| check_uncertainty(u, surface, f.realisations)).transpose()?;
        let study = FrictionStudy {
            valid_fraction: self.valid_share,
            material,
            law,
            law_inputs,
            body: RoughBody::default(),
            points,
            size_m: strip.map(|side| side.0),
            boundary: f.boundary,
            mean_compliance: f.mean_compliance,
            window_m: [window.0, f.window_width.unwrap_or(strip[1]).0],
            window_shape: f.window_shape,
            levels,
            nominal_area: f.nominal_area,
            realisations: f.realisations,
            tolerance: f.tolerance,
            uncertainty,
        };
        study.strip()?;
        Ok(Some(study))
    }
}

/// Checks the levels and returns them: percentiles, mean pressures and penetrations.
fn check_levels(f: &FrictionSection, material: &Material) -> Result<Vec<LevelControl>, InvalidValue> {
    for percentile in f.percentiles() {
        within(SECTION, "percentiles", *percentile, |x| x > 0.0 && x < 100.0, PERCENT)?;
    }
    for pressure in &f.mean_pressures {
        material.check_mean_pressure(SECTION, "mean_pressures", *pressure)?;
    }
    for penetration in &f.penetrations {
        within(SECTION, "penetrations", *penetration, positive, POSITIVE)?;
    }
    once(SECTION, "percentiles", f.percentiles())?;
    once(SECTION, "mean_pressures", &f.mean_pressures)?;
    once(SECTION, "penetrations", &f.penetrations)?;
    let percentiles = f.percentiles().iter().map(|percent| LevelControl::Percentile(*percent));
    let pressures = f.mean_pressures.iter().map(|pressure| LevelControl::MeanPressure(pressure.0));
    let penetrations = f.penetrations.iter().map(|depth| LevelControl::Penetration(depth.0));
    let levels: Vec<LevelControl> = percentiles.chain(pressures).chain(penetrations).collect();
    if levels.is_empty() {
        return Err(invalid(SECTION, "percentiles", "found none, expected at least one level"));
    }
    Ok(levels)
}

/// Checks the section `[friction.uncertainty]`; `level_realisations` is the number of strips per level.
fn check_uncertainty(
    u: &UncertaintySection,
    surface: &SurfaceSection,
    level_realisations: usize,
) -> Result<UncertaintyStudy, InvalidValue> {
    let parameters = [u.rms_height.is_some(), u.correlation_length.is_some(), u.skewness.is_some()];
    let parameters = parameters.into_iter().filter(|stated| *stated).count();
    if parameters == 0 {
        let message = "no parameter is uncertain; state rms_height, correlation_length or skewness";
        return Err(invalid(UNCERTAINTY, "rms_height", message));
    }
    for (key, std) in [("rms_height", u.rms_height), ("correlation_length", u.correlation_length)] {
        match std {
            Some(std @ LengthStd::Relative(fraction)) if !(f64::MIN_POSITIVE..=1.0).contains(&fraction) => {
                let message = format!("found {std}, expected a standard deviation above 0 % and of at most 100 %");
                return Err(invalid(UNCERTAINTY, key, message));
            }
            Some(LengthStd::Absolute(length)) => within(UNCERTAINTY, key, length, positive, POSITIVE)?,
            Some(LengthStd::Relative(_) | LengthStd::Measured) | None => {}
        }
    }
    if let Some(NumberStd::Absolute(std)) = u.skewness {
        within(UNCERTAINTY, "skewness", std, |s| s > 0.0 && s <= 2.0, "a standard deviation above 0 and of at most 2")?;
    }
    let fractal = surface.generator == SurfaceGenerator::WeierstrassMandelbrot;
    for (key, stated) in [("correlation_length", u.correlation_length.is_some()), ("skewness", u.skewness.is_some())] {
        if stated && fractal {
            return Err(invalid(UNCERTAINTY, key, "Weierstrass–Mandelbrot surfaces lack it; remove the key"));
        }
    }
    // A measured interval describes the estimate of the scan, so the study must use that estimate.
    let measured = [
        ("rms_height", u.rms_height == Some(LengthStd::Measured), surface.rms_height.is_none()),
        ("correlation_length", u.correlation_length == Some(LengthStd::Measured), surface.covariance.is_of_the_scan()),
        ("skewness", u.skewness == Some(NumberStd::Measured), surface.stated_marginal().is_none()),
    ];
    for (key, asked, of_the_scan) in measured {
        if asked && !(of_the_scan && surface.file.is_some()) {
            let message =
                "found \"measured\", but [surface] does not measure this parameter; state a standard deviation";
            return Err(invalid(UNCERTAINTY, key, message));
        }
    }
    at_least(UNCERTAINTY, "points", u.points, Propagation::least_points(parameters))?;
    within(UNCERTAINTY, "points", u.points as f64, |points| points <= 2000.0, "at most 2000")?;
    let realisations = u.realisations.unwrap_or((level_realisations / 2).max(4));
    at_least(UNCERTAINTY, "realisations", realisations, 4)?;
    let &UncertaintySection { rms_height, correlation_length, skewness, points, .. } = u;
    Ok(UncertaintyStudy { rms_height, correlation_length, skewness, points, realisations })
}

#[cfg(test)]
mod tests {
    use crate::study::Study;

    #[test]
    fn coulombs_law_has_no_plan_of_the_cut_off() {
        let text = "seed = 1\n[surface]\ncovariance = \"exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                    correlation_length = \"20 um\"\n[material]\nyoungs_modulus = \"210 GPa\"\n\
                    shear_strength = \"385 MPa\"\n[friction]\n";
        let study = |law: &str| Study::parse(&format!("{text}{law}"), "study.toml").unwrap().friction.unwrap();
        assert!(study("").cutoff_plan(5, 0.0).is_some());
        assert_eq!(study("law = \"coulomb\"\ncoefficient = 0.2\n").cutoff_plan(5, 0.0), None);
    }
}
