//! Windows that share the load of a machine.

use crate::friction::{Upscaling, WindowFriction};

/// Relation of the variance of friction to that of one window.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sharing {
    /// That many independent windows.
    Windows(f64),
    /// The windows of the nominal area.
    Area,
}

impl Sharing {
    /// Returns the variance of friction over that of one window.
    pub(super) fn variance_reduction(self, window: &WindowFriction) -> f64 {
        match self {
            Self::Windows(windows) => 1.0 / windows,
            Self::Area => window.variance_reduction,
        }
    }

    /// Returns the standard deviation of friction, along the path and between parts.
    pub(super) fn friction_std(self, window: &WindowFriction) -> f64 {
        window.std.hypot(window.between_parts_std) * self.variance_reduction(window).sqrt()
    }

    /// Returns whether the verdict itself averages in this way.
    pub(super) fn is_the_studys(self, upscaling: Upscaling) -> bool {
        match self {
            Self::Windows(windows) => upscaling == Upscaling::Paper && windows == 1.0,
            Self::Area => upscaling == Upscaling::Area,
        }
    }
}
