//! Contact that is plastic almost everywhere, whose friction does not depend on the roughness.

use crate::friction::WindowFriction;
use crate::study::check::FrictionStudy;
use crate::study::sentence;

/// Least fraction of the contact cells at the hardness. The mean contact pressure is at least this fraction of H, and μ at most its
/// reciprocal times τ_max/H: 5 % more.
const PLASTIC: f64 = 0.95;

/// Returns a sentence on contact that is plastic almost everywhere; `None` for other contact, and for friction laws that depend on more
/// than the area of contact.
pub(super) fn plastic_sentence(friction: &FrictionStudy, window: &WindowFriction) -> Option<String> {
    let fraction = window.plastic_fraction.filter(|fraction| *fraction >= PLASTIC)?;
    let floor = friction.law.plastic_floor(friction.material.hardness_pa?).filter(|_| !friction.law.ploughs())?;
    Some(format!(
        "{} % of the contact has the hardness, so μ ≈ τ/H = {}, whatever the roughness (solved: {}). Surface finish, load and area hardly \
         change it; hardness, shear strength, the fall of friction with velocity and the damping decide about vibration.",
        sentence::digits(100.0 * fraction),
        sentence::digits(floor),
        sentence::digits(window.mean)
    ))
}
