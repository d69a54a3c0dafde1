//! Friction of contacts that are sheared and that plough: F = τ_max A_c + Σ p |∂z/∂x| dA over plastic cells.

use crate::law::FrictionLaw;
use crate::window::WindowContact;

/// Sheared contacts whose asperities, where the counterface yields, also plough through it.
///
/// In sliding along x the yielded counterface bears on the front flanks of an asperity alone. There the pressure p = H on the
/// element dA of the nominal plane pushes back with p·∂z/∂x·dA. At equal load the front half has to be twice as large, while
/// in the solved contact, which does not slide, both flanks carry. Where they mirror each other the sum over doubled front
/// flanks is that of p·|∂z/∂x|·dA over both, which is [`WindowContact::ploughing_n`]; a rough surface has mirrored flanks on
/// average.
///
/// A cone of flank angle θ from the plane has |∂z/∂x| = tan θ·|cos φ| in the direction φ, so over its disc
/// F/N = tan θ·mean|cos φ| = (2/π) tan θ. That is Bowden and Tabor's: a front half disc of radius a carries N = Hπa²/2, and is
/// resisted over the triangle a²·tan θ that it shows to the front.
///
/// Slopes are those of the undeformed rough surface, which is the harder body. Without a hardness nothing yields and nothing
/// ploughs.
///
/// # References
/// F. P. Bowden and D. Tabor, *The Friction and Lubrication of Solids*, Clarendon Press (1950), ch. V.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdhesionPloughing {
    /// Shear strength τ_max of the contacts in pascal.
    pub shear_strength_pa: f64,
}

impl FrictionLaw for AdhesionPloughing {
    fn force_n(&self, window: &WindowContact) -> Option<f64> {
        window.loaded().then(|| self.shear_strength_pa * window.bearing_area_m2() + window.ploughing_n)
    }

    fn ploughs(&self) -> bool {
        true
    }
}
