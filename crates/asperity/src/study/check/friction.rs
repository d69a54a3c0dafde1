//! Checks of `[friction]`.

use std::sync::Arc;

use super::pressure::Material;
use super::{InvalidValue, PERCENT, POSITIVE, at_least, invalid, once, positive, within};
use crate::chaos::Propagation;
use crate::friction::law::{AdhesionPloughing, BowdenTabor, Coulomb, PressureDependent, WindowLaw};
use crate::map::BoundaryKind;
use crate::study::file::{FrictionSection, StudyFile, WindowLawKind};
use crate::study::scatter::{LengthScatter, NumberScatter};
use crate::surface::SurfaceGenerator;

/// Friction of windows on solved strips.
#[derive(Debug, Clone)]
pub(in crate::study) struct FrictionStudy {
    /// Strips, window and levels.
    pub(in crate::study) section: FrictionSection,
    pub(in crate::study) material: Material,
    pub(in crate::study) law: Arc<dyn WindowLaw>,
}

impl StudyFile {
    pub(super) fn check_friction(&self, material: Option<&Material>) -> Result<Option<FrictionStudy>, InvalidValue> {
        const SECTION: &str = "friction";
        let (Some(f), Some(&material)) = (&self.friction, material) else { return Ok(None) };
        let law = self.check_window_law(f)?;
        for side in f.strip {
            within(SECTION, "strip", side.0, positive, POSITIVE)?;
        }
        for n in f.points {
            at_least(SECTION, "points", n, 2)?;
        }
        within(SECTION, "window", f.window.0, positive, POSITIVE)?;
        if f.window.0 < 1.5 * f.strip[0].0 / f.points[0] as f64 {
            let message = format!("found {}, but a window must span at least two cells of the strip", f.window);
            return Err(invalid(SECTION, "window", message));
        }
        if f.window.0 * 10.0 > f.strip[0].0 * (1.0 + 1e-9) {
            let message = format!("found {}, but the strip of {} must span at least ten windows", f.window, f.strip[0]);
            return Err(invalid(SECTION, "window", message));
        }
        if let Some(width) = f.window_width {
            within(SECTION, "window_width", width.0, positive, POSITIVE)?;
            if width.0 > f.strip[1].0 * (1.0 + 1e-9) || width.0 < 1.5 * f.strip[1].0 / f.points[1] as f64 {
                let message = format!(
                    "found {width}, expected at least two cells of the strip and at most its width of {}",
                    f.strip[1]
                );
                return Err(invalid(SECTION, "window_width", message));
            }
        }
        let (least, inner) = (f.window.0, f.strip[0].0 - 2.0 * f.strip[1].0);
        if f.boundary == BoundaryKind::Free && inner < least {
            let message = "the analysis omits both ends of a free strip, each as long as the strip is wide; no window fits between them";
            return Err(invalid(SECTION, "strip", message));
        }
        if let Some(compliance) = f.mean_compliance {
            within(SECTION, "mean_compliance", compliance.0, positive, POSITIVE)?;
        }
        check_levels(f, &material)?;
        if let Some(area) = f.nominal_area {
            within(SECTION, "nominal_area", area.0, positive, POSITIVE)?;
            if let Some(other) = self.vibration.as_ref().map(|v| v.nominal_area).filter(|other| *other != area) {
                let message = format!("found {area}, but [vibration] states {other}; remove one of them");
                return Err(invalid(SECTION, "nominal_area", message));
            }
        }
        at_least(SECTION, "realisations", f.realisations, 2)?;
        within(SECTION, "tolerance", f.tolerance, |t| t > 0.0 && t < 0.1, "a relative tolerance between 0 and 0.1")?;
        Ok(Some(FrictionStudy { section: f.clone(), material, law }))
    }

    pub(super) fn check_uncertainty(&self) -> Result<(), InvalidValue> {
        const SECTION: &str = "friction.uncertainty";
        let (Some(surface), Some(friction)) = (&self.surface, &self.friction) else { return Ok(()) };
        let Some(u) = &friction.uncertainty else { return Ok(()) };
        if u.parameters() == 0 {
            let message = "no parameter is uncertain; state rms_height, correlation_length or skewness";
            return Err(invalid(SECTION, "rms_height", message));
        }
        for (key, std) in [("rms_height", u.rms_height), ("correlation_length", u.correlation_length)] {
            match std {
                Some(LengthScatter::Relative(fraction)) => {
                    let expected = "a standard deviation above 0 % and of at most 100 %";
                    within(SECTION, key, 100.0 * fraction, |percent| percent > 0.0 && percent <= 100.0, expected)?;
                }
                Some(LengthScatter::Absolute(length)) => within(SECTION, key, length.0, positive, POSITIVE)?,
                Some(LengthScatter::Measured) | None => {}
            }
        }
        if let Some(NumberScatter::Absolute(std)) = u.skewness {
            within(SECTION, "skewness", std, |s| s > 0.0 && s <= 2.0, "a standard deviation above 0 and of at most 2")?;
        }
        let fractal = surface.generator == SurfaceGenerator::WeierstrassMandelbrot;
        for (key, stated) in
            [("correlation_length", u.correlation_length.is_some()), ("skewness", u.skewness.is_some())]
        {
            if stated && fractal {
                return Err(invalid(SECTION, key, "Weierstrass–Mandelbrot surfaces lack it; remove the key"));
            }
        }
        // A measured interval describes the estimate of the scan, so the study must use that estimate.
        let measured = [
            ("rms_height", u.rms_height == Some(LengthScatter::Measured), surface.rms_height.is_none()),
            (
                "correlation_length",
                u.correlation_length == Some(LengthScatter::Measured),
                surface.covariance.is_of_the_scan(),
            ),
            ("skewness", u.skewness == Some(NumberScatter::Measured), surface.marginal == "measured"),
        ];
        for (key, asked, of_the_scan) in measured {
            if asked && !(of_the_scan && surface.file.is_some()) {
                let message =
                    "found \"measured\", but [surface] does not measure this parameter; state a standard deviation";
                return Err(invalid(SECTION, key, message));
            }
        }
        at_least(SECTION, "points", u.points, Propagation::least_points(u.parameters()))?;
        within(SECTION, "points", u.points as f64, |points| points <= 2000.0, "at most 2000")?;
        at_least(SECTION, "realisations", friction.uncertainty_realisations(), 4)
    }

    fn check_window_law(&self, f: &FrictionSection) -> Result<Arc<dyn WindowLaw>, InvalidValue> {
        const SECTION: &str = "friction";
        let material = self.material.as_ref();
        let shear = || {
            let message = "[friction] needs the shear strength of the contacts";
            material.and_then(|m| m.shear_strength).ok_or_else(|| invalid("material", "shear_strength", message))
        };
        match f.law {
            WindowLawKind::BowdenTabor => Ok(Arc::new(BowdenTabor { shear_strength_pa: shear()?.0 })),
            WindowLawKind::AdhesionPloughing => {
                let shear_strength_pa = shear()?.0;
                if material.is_none_or(|m| m.hardness.is_none()) {
                    let message = "law = \"adhesion_ploughing\" needs the hardness: elastic contacts do not plough";
                    return Err(invalid("material", "hardness", message));
                }
                Ok(Arc::new(AdhesionPloughing { shear_strength_pa }))
            }
            WindowLawKind::PressureDependent => {
                let shear_strength_pa = shear()?.0;
                let message = "law = \"pressure_dependent\" needs its α, such as 0.05";
                let alpha = f.pressure_coefficient.ok_or_else(|| invalid(SECTION, "pressure_coefficient", message))?;
                within(SECTION, "pressure_coefficient", alpha, |a| a >= 0.0, "zero or a positive value")?;
                Ok(Arc::new(PressureDependent { shear_strength_pa, pressure_coefficient: alpha }))
            }
            WindowLawKind::Coulomb => {
                let message = "law = \"coulomb\" needs its μ, such as 0.2";
                let coefficient = f.coefficient.ok_or_else(|| invalid(SECTION, "coefficient", message))?;
                within(SECTION, "coefficient", coefficient, positive, POSITIVE)?;
                Ok(Arc::new(Coulomb { coefficient }))
            }
        }
    }
}

/// Checks the levels of contact.
fn check_levels(f: &FrictionSection, material: &Material) -> Result<(), InvalidValue> {
    const SECTION: &str = "friction";
    if f.levels() == 0 {
        return Err(invalid(SECTION, "percentiles", "found none, expected at least one level"));
    }
    for percentile in f.percentiles() {
        within(SECTION, "percentiles", *percentile, |x| x > 0.0 && x < 100.0, PERCENT)?;
    }
    for pressure in &f.mean_pressures {
        material.check_mean_pressure(SECTION, "mean_pressures", *pressure)?;
    }
    for penetration in &f.penetrations {
        within(SECTION, "penetrations", penetration.0, positive, POSITIVE)?;
    }
    once(SECTION, "percentiles", f.percentiles())?;
    once(SECTION, "mean_pressures", &f.mean_pressures)?;
    once(SECTION, "penetrations", &f.penetrations)
}
