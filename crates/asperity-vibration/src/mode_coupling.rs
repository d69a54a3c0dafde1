//! Mode coupling: a mass with two degrees of freedom on a belt, with friction proportional to its normal force.
//!
//! Two inclined springs hold a mass, and a third one presses it on the belt. The inclined springs couple the motion
//! along the belt (x) and into it (y) in both directions; friction, μk₃y, couples it in one direction only. The
//! stiffness matrix is therefore not symmetric. Two modes whose frequencies meet as μ grows exchange energy and grow,
//! even if friction does not fall with velocity.
//!
//! All quantities are dimensionless, with the static normal force N₀ and a reference stiffness c = mω₀²: displacements
//! in N₀/c, stiffnesses in c, τ = ω₀t, V = v_b·mω₀/N₀, forces in N₀, sliding distance in N₀/c.
//!
//! [`Model`] → [`eigenvalue_scan`] (modes against μ), [`Model::coalescence`] and [`critical_friction`] (loss of
//! stability of steady sliding), [`friction_margin`], [`CoupledTrajectory`] (stick, slip and flight under one realisation of the friction process),
//! [`limit_cycle`], [`growth_rates`] (growth of small motion under fluctuating friction), [`CoupledEnsemble`] (probability of
//! vibration).
//!
//! # References
//! Hoffmann, Fischer, Allgaier & Gaul, *Mechanics Research Communications* **29** (2002) 197,
//! <https://doi.org/10.1016/S0093-6413(02)00254-9>.

mod cycle;
mod ensemble;
mod growth;
mod limit;
mod model;
mod motion;
mod onset;
mod roots;
mod spectrum;
mod trajectory;

pub use cycle::{CoupledCycle, CoupledRegime, limit_cycle, limit_cycle_within};
pub use ensemble::{CoupledEnsemble, CoupledEnsembleSettings, CoupledOutcome};
pub use growth::{GrowthRates, GrowthSettings, growth_rates};
pub use model::{CoupledParameters, Damping, Model, SteadySliding};
pub use motion::state::{Contact, State};
pub use motion::{CoupledEvent, CoupledEventKind};
pub use onset::{SCAN_POINTS, friction_margin, instability, onset, scan_end};
pub use roots::Mode;
pub use spectrum::{Critical, EigenvalueScan, Instability, critical_friction, eigenvalue_scan, modes};
pub use trajectory::{CoupledTrajectory, CoupledTrajectorySettings, Point};
