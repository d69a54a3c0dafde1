//! Mode coupling: a mass with two degrees of freedom on a belt, under friction that follows its normal force.
//!
//! Two inclined springs hold a mass, a third presses it on the belt. Motion along the belt (x) and into it (y) are coupled
//! by the inclined springs both ways, and by friction μk₃y one way: the stiffness is not symmetric, and two modes whose
//! frequencies meet as μ grows exchange energy and grow without any fall of friction with velocity.
//!
//! Dimensionless as the rest of this stage, with the static normal force N₀ and a reference stiffness c = mω₀²:
//! displacements in N₀/c, stiffnesses in c, τ = ω₀t, V = v_b·mω₀/N₀, forces in N₀, sliding distance in N₀/c.
//!
//! [`Model`] → [`eigenvalue_scan`] (modes against μ), [`Model::coalescence`] and [`critical_friction`] (where the sliding
//! state loses its stability), [`Trajectory`] (stick, slip and flight of one realisation of the friction process),
//! [`limit_cycle`], [`growth_rates`] (how fast small motion grows under fluctuating friction), [`Ensemble`] (how surely
//! it becomes a vibration).
//!
//! # References
//! Hoffmann, Fischer, Allgaier & Gaul, *Mechanics Research Communications* **29** (2002) 197,
//! <https://doi.org/10.1016/S0093-6413(02)00254-9>.

mod cycle;
mod ensemble;
mod growth;
mod model;
mod motion;
mod roots;
mod spectrum;
mod trajectory;

pub use cycle::{LimitCycle, Regime, limit_cycle};
pub use ensemble::{Ensemble, EnsembleSettings, Outcome};
pub use growth::{GrowthRates, GrowthSettings, growth_rates};
pub use model::{Damping, Model, Parameters, SteadySliding};
pub use motion::{Contact, Event, EventKind, State};
pub use spectrum::{Critical, EigenvalueScan, Instability, Mode, critical_friction, eigenvalue_scan, modes};
pub use trajectory::{Point, Trajectory, TrajectorySettings};
