//! Stages of a study.

use crate::choice;

choice! {
    /// Stage of a study.
    pub enum Stage: "stage" {
        /// Statistics and random surfaces.
        Surface = "surface",
        /// Distribution of the random pressure.
        Pressure = "pressure",
        /// Friction as a process.
        Friction = "friction",
        /// Stick-slip, or mode coupling.
        Vibration = "vibration",
        /// Probability of vibration over uncertain values.
        Verdict = "verdict",
    }
}
