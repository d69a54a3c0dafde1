//! Friction of contacts whose shear strength grows with the pressure: F = τ₀ A_c + αN.

use std::sync::Arc;

use asperity_base::statement::Statement;

use crate::WindowContact;
use crate::law::{SHEAR_STRENGTH, WindowLaw, describe_shear, required, shear_strength_pa};

/// Shear strength τ = τ₀ + αp in every point of contact, so that F = ∫τ dA = τ₀ A_c + αN and μ = τ₀ A_c/N + α.
///
/// α is the increase of the shear strength of solids, boundary films and lacquers with pressure, some hundredths to
/// tenths. The area is the one of [`crate::law::BowdenTabor`], so that μ ≥ τ₀/H + α.
///
/// # References
/// B. J. Briscoe and D. Tabor, *J. Adhesion* **9** (1978) 145, <https://doi.org/10.1080/00218467808075110>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressureDependent {
    /// Shear strength τ₀ of the contacts without pressure, in pascal.
    pub shear_strength_pa: f64,
    /// α = dτ/dp.
    pub pressure_coefficient: f64,
}

const PRESSURE_COEFFICIENT: &str = "friction.pressure_coefficient";

impl PressureDependent {
    pub(super) const STATEMENT: &Statement<Arc<dyn WindowLaw>> = &Statement {
        inputs: &[SHEAR_STRENGTH, PRESSURE_COEFFICIENT],
        law: |stated| {
            let shear_strength_pa = shear_strength_pa(stated)?;
            let reason = "law = \"pressure_dependent\" needs its α, such as 0.05";
            let pressure_coefficient = required(stated, PRESSURE_COEFFICIENT, reason)?;
            Ok(Arc::new(Self { shear_strength_pa, pressure_coefficient }))
        },
    };
}

impl WindowLaw for PressureDependent {
    fn force_n(&self, window: &WindowContact) -> f64 {
        self.shear_strength_pa * window.bearing_area_m2() + self.pressure_coefficient * window.load_n
    }

    fn describe(&self) -> String {
        format!(
            "The shear strength of contacts grows with the pressure, τ = τ_max + αp, so that μ = τ_max A_c/N + α with α = \
             {}, {}",
            self.pressure_coefficient,
            describe_shear(self.shear_strength_pa)
        )
    }

    fn plastic_floor(&self, hardness_pa: f64) -> Option<f64> {
        Some(self.shear_strength_pa / hardness_pa + self.pressure_coefficient)
    }
}
