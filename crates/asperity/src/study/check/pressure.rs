//! Checks of `[material]` and `[pressure]`.

use serde::Serialize;

use super::invalid_value::{InvalidValue, PERCENT, POSITIVE, at_least, invalid, positive, within};
use crate::chaos::{MAX_TERMS, number_of_terms};
use crate::contact::{Elastic, ElasticPair, contact_modulus_pa};
use crate::friction::LevelControl;
use crate::map::{BoundaryKind, Grid};
use crate::pressure::PressureMethod;
use crate::quantity::{Compliance, Pressure};
use crate::study::file::{CounterfaceSection, StudyFile};

const PRESSURE: &str = "pressure";
/// Contact solutions of the reference if a study does not state them.
const REFERENCE_SAMPLES: usize = 5000;

/// Elastic and plastic properties.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(in crate::study) struct Material {
    /// Contact modulus E/(1 − ν²) in pascal.
    pub(in crate::study) contact_modulus_pa: f64,
    /// Hardness in pascal, the upper bound of the pressure; `None` is elastic.
    pub(in crate::study) hardness_pa: Option<f64>,
}

impl Material {
    /// Fails if a mean pressure is not positive or not below the hardness.
    pub(super) fn check_mean_pressure(
        &self,
        section: &'static str,
        key: &'static str,
        pressure: Pressure,
    ) -> Result<(), InvalidValue> {
        within(section, key, pressure, positive, POSITIVE)?;
        self.hardness_pa.filter(|pascal| pressure.0 >= *pascal).map_or(Ok(()), |pascal| {
            let message = format!("found {pressure}, which is not below the hardness {}", Pressure(pascal));
            Err(invalid(section, key, message))
        })
    }
}

/// Settings of the pressure stage: the pressure at one cell of random patches.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(in crate::study) struct PressureStudy {
    /// Least fraction of valid samples.
    pub(in crate::study) valid_fraction: f64,
    pub(in crate::study) material: Material,
    pub(in crate::study) grid: Grid,
    pub(in crate::study) boundary: BoundaryKind,
    /// Mean compliance of a periodic patch; `None` for the default.
    pub(in crate::study) mean_compliance: Option<Compliance>,
    /// Row and column of the cell.
    pub(in crate::study) cell: (usize, usize),
    pub(in crate::study) control: LevelControl,
    pub(in crate::study) methods: Vec<PressureMethod>,
    pub(in crate::study) fine_solves: usize,
    pub(in crate::study) reference_samples: usize,
    /// Number of leading variables, and total degree, of the chaos expansion.
    pub(in crate::study) variables: usize,
    pub(in crate::study) degree: usize,
    /// Whether the normal stiffness is estimated.
    pub(in crate::study) stiffness: bool,
    /// Relative tolerance of a contact solution.
    pub(in crate::study) tolerance: f64,
}

impl StudyFile {
    pub(super) fn check_material(&self) -> Result<Option<Material>, InvalidValue> {
        const SECTION: &str = "material";
        let Some(material) = &self.material else {
            for (section, present) in [(PRESSURE, self.pressure.is_some()), ("friction", self.friction.is_some())] {
                if present {
                    return Err(invalid(SECTION, "youngs_modulus", format!("[{section}] needs a [material] section")));
                }
            }
            return Ok(None);
        };
        let own_pa = contact_modulus_pa(material.youngs_modulus.0, material.poisson_ratio);
        let contact_modulus_pa = match self.counterface.as_ref().and_then(CounterfaceSection::elastic) {
            None => own_pa,
            Some(counterface) => {
                let own =
                    Elastic { youngs_modulus_pa: material.youngs_modulus.0, poisson_ratio: material.poisson_ratio };
                let pair = ElasticPair::new(own, counterface);
                pair.map_err(|error| invalid("counterface", "youngs_modulus", error.to_string()))?.contact_modulus_pa()
            }
        };
        Ok(Some(Material { contact_modulus_pa, hardness_pa: self.hardness().map(|hardness| hardness.0) }))
    }

    /// Returns the hardness of the contact, the lower one of both bodies; `None` is elastic.
    pub(in crate::study) fn hardness(&self) -> Option<Pressure> {
        let stated = [
            self.material.as_ref().and_then(|material| material.hardness),
            self.counterface.as_ref().and_then(|counterface| counterface.hardness),
        ];
        stated.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))
    }

    pub(super) fn check_pressure(&self, material: Option<&Material>) -> Result<Option<PressureStudy>, InvalidValue> {
        let (Some(p), Some(&material)) = (&self.pressure, material) else { return Ok(None) };
        for side in p.size {
            within(PRESSURE, "size", side, positive, POSITIVE)?;
        }
        for n in p.points {
            at_least(PRESSURE, "points", n, 2)?;
        }
        let [nx, ny] = p.points;
        let grid = Grid::with_size(nx, ny, p.size[0].0, p.size[1].0)
            .map_err(|error| invalid(PRESSURE, "points", error.to_string()))?;
        let [row, column] = p.cell.unwrap_or([ny / 2, nx / 2]);
        if row >= ny || column >= nx {
            let message = format!("found [{row}, {column}], expected [row, column] below [{ny}, {nx}]");
            return Err(invalid(PRESSURE, "cell", message));
        }
        if let Some(compliance) = p.mean_compliance {
            within(PRESSURE, "mean_compliance", compliance, positive, POSITIVE)?;
        }
        let control = match (p.percentile, p.penetration, p.mean_pressure) {
            (Some(percentile), None, None) => {
                within(PRESSURE, "percentile", percentile, |x| x > 0.0 && x < 100.0, PERCENT)?;
                LevelControl::Percentile(percentile)
            }
            (None, Some(penetration), None) => {
                within(PRESSURE, "penetration", penetration, positive, POSITIVE)?;
                LevelControl::Penetration(penetration.0)
            }
            (None, None, Some(pressure)) => {
                material.check_mean_pressure(PRESSURE, "mean_pressure", pressure)?;
                LevelControl::MeanPressure(pressure.0)
            }
            _ => {
                let message = "state exactly one of percentile, penetration and mean_pressure";
                return Err(invalid(PRESSURE, "percentile", message));
            }
        };
        at_least(PRESSURE, "fine_solves", p.fine_solves, 10)?;
        let reference_samples = p.reference_samples.unwrap_or(REFERENCE_SAMPLES);
        at_least(PRESSURE, "reference_samples", reference_samples, 10)?;
        at_least(PRESSURE, "variables", p.variables, 1)?;
        if number_of_terms(p.variables, p.degree).is_none_or(|terms| terms > MAX_TERMS) {
            let message =
                format!("found {}, which gives more than {MAX_TERMS} terms in {} variables", p.degree, p.variables);
            return Err(invalid(PRESSURE, "degree", message));
        }
        let expected = "a relative tolerance between 0 and 0.1";
        within(PRESSURE, "tolerance", p.tolerance, |t| t > 0.0 && t < 0.1, expected)?;
        Ok(Some(PressureStudy {
            valid_fraction: self.valid_share,
            material,
            grid,
            boundary: p.boundary,
            mean_compliance: p.mean_compliance,
            cell: (row, column),
            control,
            fine_solves: p.fine_solves,
            methods: PressureMethod::ALL.iter().copied().filter(|method| p.methods.contains(method)).collect(),
            reference_samples: if PressureMethod::are_compared(&p.methods) { reference_samples } else { 0 },
            variables: p.variables,
            degree: p.degree,
            stiffness: p.stiffness,
            tolerance: p.tolerance,
        }))
    }
}
