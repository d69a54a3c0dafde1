//! Contact that is plastic almost everywhere, whose friction does not depend on the roughness.

use asperity_results::SATURATED;

use crate::friction::WindowFriction;
use crate::study::check::FrictionStudy;
use crate::study::sentence;

/// Returns a sentence on contact that is plastic almost everywhere; `None` for other contact, and for friction laws that depend on more
/// than the area of contact.
pub(super) fn plastic_sentence(friction: &FrictionStudy, window: &WindowFriction) -> Option<String> {
    let floor = friction.plastic_floor().filter(|_| !friction.law.ploughs())?;
    let excess = 1.0 - floor / window.mean;
    (excess <= SATURATED).then(|| {
        format!(
            "Friction is τ/H here, and roughness hardly matters: μ = {} is {} % above τ/H = {}. Surface finish, load and area hardly \
             change it; hardness, shear strength, the fall of friction with velocity and the damping decide about vibration.",
            sentence::digits(window.mean),
            sentence::digits(100.0 * (window.mean / floor - 1.0).max(0.0)),
            sentence::digits(floor),
        )
    })
}
