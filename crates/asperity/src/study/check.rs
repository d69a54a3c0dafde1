//! Whether the values of a study can be right, beyond their types.

mod vibration;

use std::str::FromStr;

use asperity_formats::LengthUnit;
use thiserror::Error;

use crate::chaos::{MAX_TERMS, Propagation, number_of_terms};
use crate::distribution::Marginal;
use crate::map::PITCH_RANGE_M;
use crate::study::config::{
    BoundaryChoice, CovarianceChoice, DistributionChoice, FrictionSection, GeneratorChoice, Study, SurfaceSection,
};
use crate::study::scatter::{LengthScatter, NumberScatter};

/// A value that is well-formed but cannot be right.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("[{section}] {key}: {message}")]
pub(super) struct Problem {
    pub(super) section: &'static str,
    pub(super) key: &'static str,
    message: String,
}

fn problem(section: &'static str, key: &'static str, message: impl Into<String>) -> Problem {
    Problem { section, key, message: message.into() }
}

/// `Err` unless `value` lies in the stated range.
fn within(
    section: &'static str,
    key: &'static str,
    value: f64,
    fits: impl Fn(f64) -> bool,
    wanted: &str,
) -> Result<(), Problem> {
    if value.is_finite() && fits(value) {
        Ok(())
    } else {
        Err(problem(section, key, format!("found {value}, wanted {wanted}")))
    }
}

fn at_least(section: &'static str, key: &'static str, value: usize, least: usize) -> Result<(), Problem> {
    if value >= least { Ok(()) } else { Err(problem(section, key, format!("found {value}, wanted at least {least}"))) }
}

/// `Err` if a value of a list comes twice.
fn once<T: PartialEq + std::fmt::Display>(
    section: &'static str,
    key: &'static str,
    values: &[T],
) -> Result<(), Problem> {
    let repeated = values.iter().enumerate().find(|(index, value)| values[..*index].contains(value));
    repeated.map_or(Ok(()), |(_, value)| Err(problem(section, key, format!("found {value} twice"))))
}

const POSITIVE: &str = "a positive value";
const PERCENT: &str = "a percentage strictly between 0 and 100";

fn positive(value: f64) -> bool {
    value > 0.0
}

impl Study {
    pub(super) fn check(&self) -> Result<(), Problem> {
        self.check_surface()?;
        self.check_material()?;
        self.check_pressure()?;
        self.check_friction()?;
        self.check_uncertainty()?;
        self.check_vibration()
    }

    fn check_surface(&self) -> Result<(), Problem> {
        const SECTION: &str = "surface";
        let Some(s) = &self.surface else {
            return match (self.pressure.is_some() || self.friction.is_some(), self.vibration.is_some()) {
                (true, _) => Err(problem(SECTION, "file", "[pressure] and [friction] need a [surface] section")),
                (false, false) => {
                    Err(problem(SECTION, "file", "the study has no stage; begin with a [surface] section"))
                }
                (false, true) => Ok(()),
            };
        };
        if let Some(pixel) = s.pixel_size {
            for side in pixel {
                let (low, high) = (PITCH_RANGE_M.start(), PITCH_RANGE_M.end());
                let wanted = format!("a size between {low:e} m and {high:e} m");
                within(SECTION, "pixel_size", side.0, |side| PITCH_RANGE_M.contains(&side), &wanted)?;
            }
        }
        if let Some(Err(error)) = s.height_unit.as_deref().map(str::parse::<LengthUnit>) {
            return Err(problem(SECTION, "height_unit", error.to_string()));
        }
        if let Some(outliers) = s.outliers {
            within(SECTION, "outliers", outliers, |k| k >= 1.0, "at least 1 standard deviation")?;
        }
        for (key, cutoff) in [("s_filter", s.s_filter), ("l_filter", s.l_filter)] {
            if let Some(cutoff) = cutoff {
                within(SECTION, key, cutoff.0, positive, POSITIVE)?;
            }
        }
        if let (Some(short), Some(long)) = (s.s_filter, s.l_filter) {
            let wanted = "longer than `s_filter`, so that scales are left between";
            within(SECTION, "l_filter", long.0, |cutoff| cutoff > short.0, wanted)?;
        }
        if let Some(rms) = s.rms_height {
            within(SECTION, "rms_height", rms.0, positive, POSITIVE)?;
        }
        for length in s.correlation_length.into_iter().flatten() {
            within(SECTION, "correlation_length", length.0, positive, POSITIVE)?;
        }
        if let Some(hurst) = s.hurst {
            within(SECTION, "hurst", hurst, |h| h > 0.0 && h < 1.0, "a Hurst exponent strictly between 0 and 1")?;
        }
        if let Some(smoothness) = s.smoothness {
            within(SECTION, "smoothness", smoothness, positive, POSITIVE)?;
        }
        if let Some(dimension) = s.fractal_dimension {
            within(
                SECTION,
                "fractal_dimension",
                dimension,
                |d| d > 2.0 && d < 3.0,
                "a value strictly between 2 and 3",
            )?;
        }
        at_least(SECTION, "modes", s.modes.unwrap_or(1), 1)?;
        if s.marginal != "measured" {
            Marginal::from_str(&s.marginal).map_err(|error| problem(SECTION, "marginal", error.to_string()))?;
        }
        let gaussian = s.generator != GeneratorChoice::WeierstrassMandelbrot;
        let expanded = s.generator == GeneratorChoice::KarhunenLoeve;
        for (key, stated) in [("mean_mode", !s.mean_mode), ("rescale", s.rescale.is_some())] {
            if stated && !expanded {
                return Err(problem(SECTION, key, "this belongs to the generator karhunen_loeve"));
            }
        }
        if !s.mean_mode && self.pressure.as_ref().is_some_and(|p| p.boundary == BoundaryChoice::Free) {
            let message = "only periodic patches have a constant Fourier mode to leave out; set boundary = \"periodic\" in \
                           [pressure]";
            return Err(problem(SECTION, "mean_mode", message));
        }
        if s.rescale.is_some() && s.marginal != "normal" {
            let message = "this belongs to marginal = \"normal\"; any other law is imposed at every point";
            return Err(problem(SECTION, "rescale", message));
        }
        if s.file.is_some() && s.files().is_empty() {
            return Err(problem(SECTION, "file", "the list of scans is empty; name at least one, or leave `file` out"));
        }
        if s.file.is_none() {
            let missing =
                |key, what: &str| problem(SECTION, key, format!("{what} cannot be measured without `file`; state it"));
            if gaussian && s.covariance.is_of_the_scan() {
                return Err(missing("covariance", "the covariance"));
            }
            if gaussian && s.marginal == "measured" {
                return Err(missing("marginal", "the marginal law"));
            }
            if s.rms_height.is_none() {
                return Err(missing("rms_height", "the rms height"));
            }
        }
        if !s.covariance.is_of_the_scan() && s.correlation_length.is_none() {
            return Err(problem(SECTION, "correlation_length", "a stated covariance needs its lengths along x and y"));
        }
        if s.covariance == CovarianceChoice::SelfAffine && s.hurst.is_none() {
            return Err(problem(SECTION, "hurst", "a self-affine covariance needs its Hurst exponent"));
        }
        if s.covariance == CovarianceChoice::Matern && s.smoothness.is_none() {
            return Err(problem(SECTION, "smoothness", "a Matérn covariance needs its smoothness ν"));
        }
        if !gaussian && s.fractal_dimension.is_none() && s.file.is_none() {
            let message = "the Weierstrass–Mandelbrot generator needs it when there is no scan to measure it on";
            return Err(problem(SECTION, "fractal_dimension", message));
        }
        Ok(())
    }

    fn check_material(&self) -> Result<(), Problem> {
        const SECTION: &str = "material";
        let Some(material) = &self.material else {
            for (section, present) in [("pressure", self.pressure.is_some()), ("friction", self.friction.is_some())] {
                if present {
                    return Err(problem(SECTION, "youngs_modulus", format!("[{section}] needs a [material] section")));
                }
            }
            return Ok(());
        };
        within(SECTION, "youngs_modulus", material.youngs_modulus.0, positive, POSITIVE)?;
        let ratio = "a Poisson ratio above -1 and at most 0.5";
        within(SECTION, "poisson_ratio", material.poisson_ratio, |nu| nu > -1.0 && nu <= 0.5, ratio)?;
        if let Some(hardness) = material.hardness {
            within(SECTION, "hardness", hardness.0, positive, POSITIVE)?;
        }
        if let Some(shear) = material.shear_strength {
            within(SECTION, "shear_strength", shear.0, positive, POSITIVE)?;
        }
        Ok(())
    }

    fn check_pressure(&self) -> Result<(), Problem> {
        const SECTION: &str = "pressure";
        let Some(p) = &self.pressure else { return Ok(()) };
        for side in p.size {
            within(SECTION, "size", side.0, positive, POSITIVE)?;
        }
        for n in p.points {
            at_least(SECTION, "points", n, 2)?;
        }
        if let Some([row, column]) = p.cell {
            let [nx, ny] = p.points;
            if row >= ny || column >= nx {
                let message = format!("found [{row}, {column}], wanted [row, column] below [{ny}, {nx}]");
                return Err(problem(SECTION, "cell", message));
            }
        }
        if let Some(compliance) = p.mean_compliance {
            within(SECTION, "mean_compliance", compliance.0, positive, POSITIVE)?;
        }
        let stated = [p.percentile.is_some(), p.penetration.is_some(), p.mean_pressure.is_some()];
        if stated.iter().filter(|s| **s).count() != 1 {
            let message = "state exactly one of percentile, penetration and mean_pressure";
            return Err(problem(SECTION, "percentile", message));
        }
        if let Some(percentile) = p.percentile {
            within(SECTION, "percentile", percentile, |x| x > 0.0 && x < 100.0, PERCENT)?;
        }
        if let Some(penetration) = p.penetration {
            within(SECTION, "penetration", penetration.0, positive, POSITIVE)?;
        }
        if let Some(pressure) = p.mean_pressure {
            within(SECTION, "mean_pressure", pressure.0, positive, POSITIVE)?;
            let hardness = self.material.as_ref().and_then(|m| m.hardness);
            if let Some(hardness) = hardness.filter(|h| pressure.0 >= h.0) {
                let message = format!("found {pressure}, which is not below the hardness {hardness}");
                return Err(problem(SECTION, "mean_pressure", message));
            }
        }
        at_least(SECTION, "fine_solves", p.fine_solves, 10)?;
        at_least(SECTION, "reference_samples", p.reference_samples, 10)?;
        at_least(SECTION, "variables", p.variables, 1)?;
        if number_of_terms(p.variables, p.degree).is_none_or(|terms| terms > MAX_TERMS) {
            let message =
                format!("found {}, but in {} variables that is more than {MAX_TERMS} terms", p.degree, p.variables);
            return Err(problem(SECTION, "degree", message));
        }
        within(SECTION, "tolerance", p.tolerance, |t| t > 0.0 && t < 0.1, "a relative tolerance between 0 and 0.1")
    }

    fn check_friction(&self) -> Result<(), Problem> {
        const SECTION: &str = "friction";
        let Some(f) = &self.friction else { return Ok(()) };
        self.check_friction_law(f)?;
        for side in f.strip {
            within(SECTION, "strip", side.0, positive, POSITIVE)?;
        }
        for n in f.points {
            at_least(SECTION, "points", n, 2)?;
        }
        within(SECTION, "window", f.window.0, positive, POSITIVE)?;
        if f.window.0 < 1.5 * f.strip[0].0 / f.points[0] as f64 {
            let message = format!("found {}, but a window holds at least two cells of the strip", f.window);
            return Err(problem(SECTION, "window", message));
        }
        if f.window.0 * 10.0 > f.strip[0].0 * (1.0 + 1e-9) {
            let message = format!("found {}, but the strip of {} must hold at least ten windows", f.window, f.strip[0]);
            return Err(problem(SECTION, "window", message));
        }
        if let Some(width) = f.window_width {
            within(SECTION, "window_width", width.0, positive, POSITIVE)?;
            if width.0 > f.strip[1].0 * (1.0 + 1e-9) || width.0 < 1.5 * f.strip[1].0 / f.points[1] as f64 {
                let message = format!(
                    "found {width}, wanted at least two cells of the strip and at most its width of {}",
                    f.strip[1]
                );
                return Err(problem(SECTION, "window_width", message));
            }
        }
        let (least, inner) = (f.window.0, f.strip[0].0 - 2.0 * f.strip[1].0);
        if f.boundary == BoundaryChoice::Free && inner < least {
            let message = "the ends of a free strip, as long as it is wide, are left out; no window fits between them";
            return Err(problem(SECTION, "strip", message));
        }
        if let Some(compliance) = f.mean_compliance {
            within(SECTION, "mean_compliance", compliance.0, positive, POSITIVE)?;
        }
        self.check_levels(f)?;
        if let Some(area) = f.nominal_area {
            within(SECTION, "nominal_area", area.0, positive, POSITIVE)?;
            if let Some(other) = self.vibration.as_ref().map(|v| v.nominal_area).filter(|other| *other != area) {
                let message = format!("found {area}, but [vibration] states {other}; leave one of them out");
                return Err(problem(SECTION, "nominal_area", message));
            }
        }
        at_least(SECTION, "realisations", f.realisations, 2)?;
        within(SECTION, "tolerance", f.tolerance, |t| t > 0.0 && t < 0.1, "a relative tolerance between 0 and 0.1")
    }

    fn check_uncertainty(&self) -> Result<(), Problem> {
        const SECTION: &str = "friction.uncertainty";
        let (Some(surface), Some(friction)) = (&self.surface, &self.friction) else { return Ok(()) };
        let Some(u) = &friction.uncertainty else { return Ok(()) };
        if u.parameters() == 0 {
            let message = "nothing is uncertain; state rms_height, correlation_length or skewness";
            return Err(problem(SECTION, "rms_height", message));
        }
        for (key, scatter) in [("rms_height", u.rms_height), ("correlation_length", u.correlation_length)] {
            match scatter {
                Some(LengthScatter::Relative(share)) => {
                    let wanted = "a standard deviation above 0 % and of at most 100 %";
                    within(SECTION, key, 100.0 * share, |percent| percent > 0.0 && percent <= 100.0, wanted)?;
                }
                Some(LengthScatter::Absolute(length)) => within(SECTION, key, length.0, positive, POSITIVE)?,
                Some(LengthScatter::Measured) | None => {}
            }
        }
        if let Some(NumberScatter::Absolute(std)) = u.skewness {
            within(SECTION, "skewness", std, |s| s > 0.0 && s <= 2.0, "a standard deviation above 0 and of at most 2")?;
        }
        let fractal = surface.generator == GeneratorChoice::WeierstrassMandelbrot;
        for (key, stated) in
            [("correlation_length", u.correlation_length.is_some()), ("skewness", u.skewness.is_some())]
        {
            if stated && fractal {
                return Err(problem(SECTION, key, "Weierstrass–Mandelbrot surfaces have none; leave it out"));
            }
        }
        // An interval of the scan is about what the scan says, so the study must take that from it too.
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
                    "found \"measured\", but [surface] does not take it from a scan; state a standard deviation";
                return Err(problem(SECTION, key, message));
            }
        }
        at_least(SECTION, "points", u.points, Propagation::least_points(u.parameters()))?;
        within(SECTION, "points", u.points as f64, |points| points <= 2000.0, "at most 2000")?;
        at_least(SECTION, "realisations", friction.uncertainty_realisations(), 4)
    }

    fn check_friction_law(&self, f: &FrictionSection) -> Result<(), Problem> {
        const SECTION: &str = "friction";
        let material = self.material.as_ref();
        if f.law != DistributionChoice::Coulomb && material.is_none_or(|m| m.shear_strength.is_none()) {
            return Err(problem("material", "shear_strength", "[friction] needs the shear strength of the contacts"));
        }
        if f.law == DistributionChoice::AdhesionPloughing && material.is_none_or(|m| m.hardness.is_none()) {
            let message = "nothing ploughs that does not yield; law = \"adhesion_ploughing\" needs the hardness";
            return Err(problem("material", "hardness", message));
        }
        let missing = |key, message: &str| Err(problem(SECTION, key, message));
        match (f.law, f.pressure_coefficient, f.coefficient) {
            (DistributionChoice::PressureDependent, None, _) => {
                missing("pressure_coefficient", "law = \"pressure_dependent\" needs its α, such as 0.05")
            }
            (DistributionChoice::PressureDependent, Some(alpha), _) => {
                within(SECTION, "pressure_coefficient", alpha, |a| a >= 0.0, "zero or a positive value")
            }
            (DistributionChoice::Coulomb, _, None) => {
                missing("coefficient", "law = \"coulomb\" needs its μ, such as 0.2")
            }
            (DistributionChoice::Coulomb, _, Some(mu)) => within(SECTION, "coefficient", mu, positive, POSITIVE),
            _ => Ok(()),
        }
    }

    fn check_levels(&self, f: &FrictionSection) -> Result<(), Problem> {
        const SECTION: &str = "friction";
        if f.levels() == 0 {
            return Err(problem(SECTION, "percentiles", "found none, wanted at least one level"));
        }
        for percentile in f.percentiles() {
            within(SECTION, "percentiles", *percentile, |x| x > 0.0 && x < 100.0, PERCENT)?;
        }
        let hardness = self.material.as_ref().and_then(|m| m.hardness);
        for pressure in &f.mean_pressures {
            within(SECTION, "mean_pressures", pressure.0, positive, POSITIVE)?;
            if let Some(hardness) = hardness.filter(|h| pressure.0 >= h.0) {
                let message = format!("found {pressure}, which is not below the hardness {hardness}");
                return Err(problem(SECTION, "mean_pressures", message));
            }
        }
        for penetration in &f.penetrations {
            within(SECTION, "penetrations", penetration.0, positive, POSITIVE)?;
        }
        once(SECTION, "percentiles", f.percentiles())?;
        once(SECTION, "mean_pressures", &f.mean_pressures)?;
        once(SECTION, "penetrations", &f.penetrations)
    }
}

impl Study {
    /// Keys that are stated and change nothing, each in a sentence.
    pub fn idle_keys(&self) -> Vec<String> {
        let mut idle: Vec<String> = self.surface.iter().flat_map(SurfaceSection::idle_keys).collect();
        if let Some(surface) = self.surface.as_ref().filter(|_| self.pressure.is_none() && self.friction.is_some()) {
            let patches_only = |key: &str| format!("[surface] {key} has no effect without [pressure]");
            idle.extend((!surface.mean_mode).then(|| patches_only("mean_mode")));
            idle.extend(surface.rescale.map(|_| patches_only("rescale")));
        }
        let periodic_only = |section: &str| format!("[{section}] mean_compliance has no effect on the free boundary");
        if self.pressure.as_ref().is_some_and(|p| p.boundary == BoundaryChoice::Free && p.mean_compliance.is_some()) {
            idle.push(periodic_only("pressure"));
        }
        if self.friction.as_ref().is_some_and(|f| f.boundary == BoundaryChoice::Free && f.mean_compliance.is_some()) {
            idle.push(periodic_only("friction"));
        }
        idle.extend(self.friction.iter().flat_map(FrictionSection::idle_keys));
        if self.friction.as_ref().is_some_and(|f| f.law == DistributionChoice::Coulomb)
            && self.material.as_ref().is_some_and(|m| m.shear_strength.is_some())
        {
            idle.push("[material] shear_strength has no effect with law = \"coulomb\"".into());
        }
        idle
    }
}

impl FrictionSection {
    /// Its keys that are stated and change nothing, each in a sentence.
    fn idle_keys(&self) -> Vec<String> {
        let pressure = self.pressure_coefficient.is_some() && self.law != DistributionChoice::PressureDependent;
        let coulomb = self.coefficient.is_some() && self.law != DistributionChoice::Coulomb;
        [("pressure_coefficient", pressure, "pressure_dependent"), ("coefficient", coulomb, "coulomb")]
            .into_iter()
            .filter(|(_, idle, _)| *idle)
            .map(|(key, _, law)| format!("[friction] {key} has no effect without law = \"{law}\""))
            .collect()
    }
}

impl SurfaceSection {
    /// Its keys that are stated and change nothing, each in a sentence.
    pub(super) fn idle_keys(&self) -> Vec<String> {
        let fractal = self.generator == GeneratorChoice::WeierstrassMandelbrot;
        let measured = self.covariance.is_of_the_scan();
        [
            ("correlation_length", self.correlation_length.is_some() && measured, "with a measured covariance"),
            ("hurst", self.hurst.is_some() && self.covariance != CovarianceChoice::SelfAffine, "without self_affine"),
            ("smoothness", self.smoothness.is_some() && self.covariance != CovarianceChoice::Matern, "without matern"),
            (
                "fractal_dimension",
                self.fractal_dimension.is_some() && !fractal,
                "without the generator weierstrass_mandelbrot",
            ),
            ("channel", self.channel.is_some() && self.file.is_none(), "without `file`"),
            ("pixel_size", self.pixel_size.is_some() && self.file.is_none(), "without `file`"),
            ("height_unit", self.height_unit.is_some() && self.file.is_none(), "without `file`"),
            ("outliers", self.outliers.is_some() && self.file.is_none(), "without `file`"),
            ("s_filter", self.s_filter.is_some() && self.file.is_none(), "without `file`"),
            ("l_filter", self.l_filter.is_some() && self.file.is_none(), "without `file`"),
            ("robust_filter", self.robust_filter && self.l_filter.is_none(), "without `l_filter`"),
        ]
        .into_iter()
        .filter(|(_, idle, _)| *idle)
        .map(|(key, _, why)| format!("[surface] {key} has no effect {why}"))
        .collect()
    }
}
