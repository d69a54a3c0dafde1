//! What is known of the cells of a slab as a whole, and of those of all slabs.

/// What is known of pressure p and v = S p − z of the cells near contact.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::contact) struct Summary {
    /// Σ p, of all and of the cells below the upper bound, and Σ p v of the latter.
    pub(in crate::contact) pressure: f64,
    pub(in crate::contact) free: f64,
    pub(in crate::contact) free_v: f64,
    /// Σ v and number of the cells between the bounds.
    pub(in crate::contact) between_v: f64,
    pub(in crate::contact) between: f64,
    /// Cells without pressure that are far from contact.
    pub(in crate::contact) idle: f64,
    /// The least v below the upper bound.
    pub(in crate::contact) least_v: f64,
    /// Cells at the upper bound.
    pub(in crate::contact) full: f64,
    /// Largest displacement by the last step over its unit.
    pub(in crate::contact) largest_image: f64,
    pub(in crate::contact) moved: bool,
}

impl Summary {
    pub(in crate::contact) const NONE: Self = Self {
        pressure: 0.0,
        free: 0.0,
        free_v: 0.0,
        between_v: 0.0,
        between: 0.0,
        idle: 0.0,
        least_v: f64::INFINITY,
        full: 0.0,
        largest_image: 0.0,
        moved: false,
    };

    /// Height of the plane that rests on the elastic contact; without any, on the cell that touches next.
    pub(in crate::contact) fn resting_m(&self) -> f64 {
        if self.free > 0.0 { -self.free_v / self.free } else { -self.least_v }
    }

    /// That of more cells.
    pub(in crate::contact) fn with(self, other: Self) -> Self {
        Self {
            pressure: self.pressure + other.pressure,
            free: self.free + other.free,
            free_v: self.free_v + other.free_v,
            between_v: self.between_v + other.between_v,
            between: self.between + other.between,
            idle: self.idle + other.idle,
            least_v: self.least_v.min(other.least_v),
            full: self.full + other.full,
            largest_image: self.largest_image.max(other.largest_image),
            moved: self.moved | other.moved,
        }
    }
}

/// Sums over the cells that may move: their number, and products of gradient g, preconditioned gradient z, last step s and
/// its image w, all over their units.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::contact) struct Products {
    pub(in crate::contact) members: f64,
    pub(in crate::contact) g: f64,
    pub(in crate::contact) z: f64,
    pub(in crate::contact) s: f64,
    pub(in crate::contact) w: f64,
    pub(in crate::contact) gg: f64,
    pub(in crate::contact) gz: f64,
    pub(in crate::contact) gs: f64,
    pub(in crate::contact) sw: f64,
    pub(in crate::contact) zw: f64,
}

impl Products {
    /// The sums over more cells.
    pub(in crate::contact) fn with(self, other: Self) -> Self {
        Self {
            members: self.members + other.members,
            g: self.g + other.g,
            z: self.z + other.z,
            s: self.s + other.s,
            w: self.w + other.w,
            gg: self.gg + other.gg,
            gz: self.gz + other.gz,
            gs: self.gs + other.gs,
            sw: self.sw + other.sw,
            zw: self.zw + other.zw,
        }
    }
}

/// The trial p + `pressure`·p + `step`·s + `preconditioned`·z + `gradient`·g + `constant`, with s, z and g over their units.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::contact) struct Direction {
    pub(in crate::contact) pressure: f64,
    pub(in crate::contact) step: f64,
    pub(in crate::contact) preconditioned: f64,
    pub(in crate::contact) gradient: f64,
    pub(in crate::contact) constant: f64,
}

/// A trial before it is brought within the bounds: over the cells that may move.
#[derive(Debug, Clone, Copy)]
pub(in crate::contact) struct Extent {
    pub(in crate::contact) least: f64,
    pub(in crate::contact) largest: f64,
    pub(in crate::contact) members: usize,
    /// Sum and largest of the upper bounds.
    pub(in crate::contact) capacity: f64,
    pub(in crate::contact) ceiling: f64,
}

impl Extent {
    pub(in crate::contact) const NONE: Self =
        Self { least: f64::INFINITY, largest: f64::NEG_INFINITY, members: 0, capacity: 0.0, ceiling: 0.0 };

    /// That of more cells.
    pub(in crate::contact) fn with(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            largest: self.largest.max(other.largest),
            members: self.members + other.members,
            capacity: self.capacity + other.capacity,
            ceiling: self.ceiling.max(other.ceiling),
        }
    }
}
