//! Kinds of motion.

asperity_base::choice! {
    /// Kind of motion that an oscillator settles into. Every kind except [`MotionKind::None`] is vibration.
    pub enum MotionKind: "kind of motion" {
        /// The mass sticks to the belt in every period.
        StickSlip = "stick_slip",
        /// The mass passes the velocity of the belt (the relative velocity changes its sign) and never sticks.
        Overtaking = "overtaking",
        /// The mass stays slower than the belt throughout the period.
        SlipCycle = "slip_cycle",
        /// Steady sliding.
        None = "none",
    }
}

impl MotionKind {
    /// Returns whether the motion is vibration.
    pub fn is_vibration(self) -> bool {
        self != Self::None
    }
}
