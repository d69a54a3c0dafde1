//! Warnings about values that are possible but implausible.

use crate::friction::law::WindowLawKind;
use crate::friction::process::IMPLAUSIBLE_FRICTION;
use crate::study::Study;
use crate::study::check::FrictionSource;
use crate::study::sentence::{digits, si};
use crate::surface::Filling;

/// Ratio of Young's modulus to hardness below which a material is implausible: metals have 50 to 300, ceramics and
/// polymers 10 to 30.
const LEAST_MODULUS_OVER_HARDNESS: f64 = 10.0;

/// Returns warnings about a material: a hardness above a tenth of Young's modulus, and a shear strength of the contacts
/// above the hardness or the shear modulus E/(2(1 + ν)).
pub fn implausible_material(
    youngs_modulus_pa: f64,
    poisson_ratio: f64,
    hardness_pa: Option<f64>,
    shear_strength_pa: Option<f64>,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let pascal = |value: f64| si(value, "Pa");
    if let Some(hardness_pa) =
        hardness_pa.filter(|hardness_pa| youngs_modulus_pa < LEAST_MODULUS_OVER_HARDNESS * hardness_pa)
    {
        warnings.push(format!(
            "Young's modulus {} is less than ten times the hardness {}; metals have 50 to 300 times, ceramics and polymers 10 \
             to 30 times",
            pascal(youngs_modulus_pa),
            pascal(hardness_pa)
        ));
    }
    let Some(shear_pa) = shear_strength_pa else { return warnings };
    if let Some(hardness_pa) = hardness_pa.filter(|hardness_pa| shear_pa > *hardness_pa) {
        warnings.push(format!(
            "the shear strength {} of the contacts is above the hardness {}: friction coefficients exceed their ratio {}; \
             metals have 0.1 to 0.2",
            pascal(shear_pa),
            pascal(hardness_pa),
            digits(shear_pa / hardness_pa)
        ));
    }
    let shear_modulus_pa = youngs_modulus_pa / (2.0 * (1.0 + poisson_ratio));
    if shear_pa > shear_modulus_pa {
        warnings.push(format!(
            "the shear strength {} of the contacts is above the shear modulus {}; no solid is sheared by more than about a \
             tenth of its modulus without flow",
            pascal(shear_pa),
            pascal(shear_modulus_pa)
        ));
    }
    warnings
}

/// Returns a warning if a friction coefficient exceeds [`IMPLAUSIBLE_FRICTION`].
pub fn implausible_friction(coefficient: f64) -> Option<String> {
    (coefficient > IMPLAUSIBLE_FRICTION).then(|| {
        format!(
            "the friction coefficient {} is above {IMPLAUSIBLE_FRICTION}; dry contacts have 0.05 to 1",
            digits(coefficient)
        )
    })
}

/// Returns a warning if a damping ratio exceeds 1.
pub fn implausible_damping(damping_ratio: f64) -> Option<String> {
    (damping_ratio > 1.0).then(|| {
        format!(
            "the damping ratio {} is above 1: the mass does not oscillate freely; machines have 0.001 to 0.2",
            digits(damping_ratio)
        )
    })
}

impl Study {
    /// Returns the warnings that follow from the study file alone: keys without effect and implausible values.
    pub fn warnings(&self) -> Vec<String> {
        let file = self.file();
        let mut warnings = file.keys_without_effect();
        if let Some(material) = &file.material {
            let [hardness, shear] = [material.hardness, material.shear_strength].map(|stated| stated.map(|q| q.0));
            let shear = shear.filter(|_| file.friction.as_ref().is_some_and(|f| f.law.is_sheared()));
            let found = implausible_material(material.youngs_modulus.0, material.poisson_ratio, hardness, shear);
            warnings.extend(found.into_iter().map(|warning| format!("[material] {warning}")));
            if let Some((counterface, body)) = file.counterface.as_ref().and_then(|c| Some((c, c.elastic()?))) {
                let hardness = counterface.hardness.map(|hardness| hardness.0);
                let found = implausible_material(body.youngs_modulus_pa, body.poisson_ratio, hardness, shear);
                warnings.extend(found.into_iter().map(|warning| format!("[counterface] {warning}")));
            }
        }
        let coulomb = file.friction.as_ref().filter(|f| f.law == WindowLawKind::Coulomb).and_then(|f| f.coefficient);
        warnings.extend(coulomb.and_then(implausible_friction).map(|warning| format!("[friction] {warning}")));
        if let Some(v) = &self.vibration {
            let stated = match &v.machine.friction {
                FrictionSource::Stated(friction) => implausible_friction(friction.mean),
                FrictionSource::Computed(_) | FrictionSource::File(_) => None,
            };
            let found = [stated, implausible_damping(v.machine.damping_ratio)];
            warnings.extend(found.into_iter().flatten().map(|warning| format!("[vibration] {warning}")));
            // A measured process may have another distribution.
            warnings.extend(v.load_warning().filter(|_| !matches!(v.machine.friction, FrictionSource::File(_))));
            let nominal_pa = v.machine.nominal_contact().pressure_pa;
            if let Some(hardness) = file.hardness().filter(|hardness| nominal_pa >= hardness.0) {
                warnings.push(format!(
                    "[vibration] the normal force {} presses the nominal area {} with {}, which is not below the hardness {hardness}",
                    v.machine.normal_force,
                    v.machine.nominal_area,
                    si(nominal_pa, "Pa")
                ));
            }
        }
        warnings
    }
}

/// Fractions of the variance, added as noise or changed in the covariance, above which a filling has a warning.
const NOISE_WARNING: f64 = 1e-4;
const CLIPPING_WARNING: f64 = 0.02;

/// Returns warnings of random heights that differ from the map which they continue; `nugget` is the stated noise.
pub fn filling_warnings(filling: &Filling, nugget: f64) -> Vec<String> {
    let (noise, clipped) = (filling.surface().noise(), filling.surface().clipped_variance());
    let noisy = (noise > nugget.max(NOISE_WARNING)).then(|| {
        format!(
            "in places, neighbouring heights differ more than the covariance allows, as with noise of {noise:.0e} of the variance; the \
             filled heights are smoother by that amount"
        )
    });
    let long = (clipped > CLIPPING_WARNING).then(|| {
        format!(
            "the correlation is too long for a map of this size: {:.1} % of the variance was changed to draw it",
            100.0 * clipped
        )
    });
    noisy.into_iter().chain(long).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_implausible_values_give_warnings() {
        let steel = implausible_material(210e9, 0.3, Some(2e9), Some(385e6));
        let pad = implausible_material(5e9, 0.35, Some(0.3e9), Some(50e6));
        assert!(steel.is_empty() && pad.is_empty(), "{steel:?} {pad:?}");
        let soft = implausible_material(19e9, 0.3, Some(2e9), None);
        assert!(soft.len() == 1 && soft[0].contains("19 GPa") && soft[0].contains("2 GPa"), "{soft:?}");
        let strong = implausible_material(210e9, 0.3, Some(2e9), Some(3e9));
        assert!(strong.len() == 1 && strong[0].contains("above the hardness 2 GPa"), "{strong:?}");
        // G = 26 GPa/(2·1.3) = 10 GPa.
        assert!(implausible_material(26e9, 0.3, None, Some(9.9e9)).is_empty());
        let sheared = implausible_material(26e9, 0.3, None, Some(10.1e9));
        assert!(sheared.len() == 1 && sheared[0].contains("shear modulus 10 GPa"), "{sheared:?}");
        assert_eq!([implausible_friction(IMPLAUSIBLE_FRICTION), implausible_damping(1.0)], [None, None]);
        assert!(implausible_friction(1.01 * IMPLAUSIBLE_FRICTION).is_some() && implausible_damping(1.01).is_some());
    }
}
