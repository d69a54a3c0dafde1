//! Friction by shear and ploughing: F = τ_max A_c + Σ p |∂z/∂x| dA over plastic cells.

use std::sync::Arc;

use asperity_base::statement::Statement;

use crate::WindowContact;
use crate::law::{SHEAR_STRENGTH, WindowLaw, describe_shear, required, shear_strength_pa};

/// Sheared contacts whose asperities also plough through a plastic counterface.
///
/// During sliding along x the plastic counterface bears only on the front flanks of an asperity. There the pressure p =
/// H on the element dA of the nominal plane resists with p·∂z/∂x·dA. At equal load the front half must be twice as
/// large as in the solved contact, which does not slide and is carried by both flanks. For mirror-symmetric flanks the
/// sum over doubled front flanks equals p·|∂z/∂x|·dA over both, which is [`WindowContact::ploughing_n`]. A rough
/// surface has mirror-symmetric flanks on average.
///
/// A cone of flank angle θ from the plane has |∂z/∂x| = tan θ·|cos φ| in the direction φ, so over its disc
/// F/N = tan θ·mean|cos φ| = (2/π) tan θ. This is the result of Bowden and Tabor: a front half disc of radius a carries
/// N = Hπa²/2 and meets the resistance of its frontal triangle a²·tan θ.
///
/// Slopes are those of the undeformed rough surface, the harder body. Without a hardness there is no plastic contact
/// and no ploughing.
///
/// # References
/// F. P. Bowden and D. Tabor, *The Friction and Lubrication of Solids*, Clarendon Press (1950), ch. V.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdhesionPloughing {
    /// Shear strength τ_max of the contacts in pascal.
    pub shear_strength_pa: f64,
}

const HARDNESS: &str = "material.hardness";

impl AdhesionPloughing {
    pub(super) const STATEMENT: &Statement<Arc<dyn WindowLaw>> = &Statement {
        inputs: &[SHEAR_STRENGTH, HARDNESS],
        law: |stated| {
            let shear_strength_pa = shear_strength_pa(stated)?;
            let reason = "law = \"adhesion_ploughing\" needs the hardness: elastic contacts do not plough";
            required(stated, HARDNESS, reason)?;
            Ok(Arc::new(Self { shear_strength_pa }))
        },
    };
}

impl WindowLaw for AdhesionPloughing {
    fn force_n(&self, window: &WindowContact) -> f64 {
        self.shear_strength_pa * window.bearing_area_m2() + window.ploughing_n
    }

    fn describe(&self) -> String {
        format!(
            "Contacts are sheared and, where they yield, plough: μ = (τ_max A_c + ∫p|∂z/∂x| dA)/N, the integral over \
             plastic contact, with {}",
            describe_shear(self.shear_strength_pa)
        )
    }

    fn plastic_floor(&self, hardness_pa: f64) -> Option<f64> {
        Some(self.shear_strength_pa / hardness_pa)
    }

    fn ploughs(&self) -> bool {
        true
    }
}
