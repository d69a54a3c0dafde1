//! Conditions that close a contact problem: beyond the edge of the grid, and for the position of the plane.

/// Condition beyond the edge of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Boundary {
    /// A finite patch on an infinite half-space, unloaded outside (the paper's case).
    Free,
    /// The patch repeats periodically.
    Periodic {
        /// Displacement of the mean plane per mean pressure, K(0), in m/Pa.
        ///
        /// It has no finite value on a half-space and is therefore an input. It matters if the position of the plane is
        /// prescribed. [`HalfSpace::default_mean_compliance_m_per_pa`](crate::HalfSpace::default_mean_compliance_m_per_pa) is the usual choice.
        mean_compliance_m_per_pa: f64,
    },
}

/// Prescribed quantity that closes a contact problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// The plane lies at this height, in the coordinates of the map, in metre.
    Plane {
        /// Height of the plane in metre.
        height_m: f64,
    },
    /// The plane lies this far below the highest point, in metre.
    Penetration {
        /// Penetration in metre, ≥ 0.
        metre: f64,
    },
    /// Height of the plane, as the percentage of the undeformed heights that lies above it.
    Percentile {
        /// 0 to 100 percent.
        percent: f64,
    },
    /// The mean pressure over the whole patch.
    MeanPressure {
        /// Mean pressure in pascal, > 0.
        pascal: f64,
    },
    /// The total force on the patch.
    Load {
        /// Force in newton, > 0.
        newton: f64,
    },
    /// The mean gap over the whole patch. The smallest gap that double precision resolves is about 10⁻¹⁵ of the
    /// roughness over the tolerance, and larger on the free boundary. A smaller gap ends as
    /// [`PrecisionLimit`](crate::SolverStop::PrecisionLimit) or at the iteration limit.
    MeanGap {
        /// Mean gap in metre, > 0.
        metre: f64,
    },
}

impl Control {
    /// Returns whether the position of the plane is prescribed. Only then does the pressure on a periodic half-space
    /// depend on its mean compliance. Otherwise the mean compliance shifts only the separation; zero measures
    /// displacements from their mean.
    pub fn prescribes_plane(&self) -> bool {
        matches!(self, Self::Plane { .. } | Self::Penetration { .. } | Self::Percentile { .. })
    }
}

/// Fixed quantity that closes the problem. Heights are counted from the mean height of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Closure {
    /// The plane is fixed.
    Plane {
        /// Height in metre.
        height_m: f64,
    },
    /// The plane is fixed at this height and the mean displacement is zero, so this height is the mean gap.
    Gap {
        /// Mean gap in metre.
        metre: f64,
    },
    /// The sum of the pressures is fixed.
    Sum {
        /// Sum in pascal.
        pascal: f64,
    },
}

impl Closure {
    /// Returns the height of the plane above the mean height in metre, if it is fixed.
    pub(crate) fn plane_m(self) -> Option<f64> {
        match self {
            Self::Plane { height_m } | Self::Gap { metre: height_m } => Some(height_m),
            Self::Sum { .. } => None,
        }
    }
}
