//! Friction proportional to the load: F = μN.

use std::sync::Arc;

use asperity_base::statement::Statement;

use crate::WindowContact;
use crate::law::{WindowLaw, required};

/// A constant friction coefficient, independent of the contact. It does not vary along the strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb {
    /// Friction coefficient μ.
    pub coefficient: f64,
}

const COEFFICIENT: &str = "friction.coefficient";

impl Coulomb {
    pub(super) const STATEMENT: &Statement<Arc<dyn WindowLaw>> = &Statement {
        inputs: &[COEFFICIENT],
        law: |stated| {
            let reason = "law = \"coulomb\" needs its μ, such as 0.2";
            Ok(Arc::new(Self { coefficient: required(stated, COEFFICIENT, reason)? }))
        },
    };
}

impl WindowLaw for Coulomb {
    fn force_n(&self, window: &WindowContact) -> f64 {
        self.coefficient * window.load_n
    }

    fn describe(&self) -> String {
        format!("Friction is Coulomb's, μ = {} whatever the contact", self.coefficient)
    }

    fn plastic_floor(&self, _hardness_pa: f64) -> Option<f64> {
        None
    }
}
