//! Quantities that a slab and the descent exchange: sums over cells, directions, steps and parts of the fields.

/// Sums of pressure p and v = S p − z over the cells near contact.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Summary {
    /// Σ p of all cells; Σ p and Σ p v of the cells below the hardness.
    pub(crate) pressure: f64,
    pub(crate) free: f64,
    pub(crate) free_v: f64,
    /// Σ v and number of the cells between the bounds.
    pub(crate) between_v: f64,
    pub(crate) between: f64,
    /// Number of cells without pressure that are far from contact.
    pub(crate) idle: f64,
    /// Least v below the hardness.
    pub(crate) least_v: f64,
    /// Number of cells at the hardness.
    pub(crate) full: f64,
    /// Largest displacement by the last step, over its unit.
    pub(crate) largest_image: f64,
    pub(crate) moved: bool,
}

impl Summary {
    pub(crate) const NONE: Self = Self {
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

    /// Returns the height of the plane that rests on the elastic contact. Without elastic contact it rests on the cell
    /// that touches next.
    pub(crate) fn resting_m(&self) -> f64 {
        if self.free > 0.0 { -self.free_v / self.free } else { -self.least_v }
    }

    /// Combines two summaries.
    pub(crate) fn with(self, other: Self) -> Self {
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

/// Sums over the cells that may move: their number, and products of gradient g, preconditioned gradient z, last step s
/// and its image w, all over their units.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Products {
    pub(crate) members: f64,
    pub(crate) g: f64,
    pub(crate) z: f64,
    pub(crate) s: f64,
    pub(crate) w: f64,
    pub(crate) gg: f64,
    pub(crate) gz: f64,
    pub(crate) gs: f64,
    pub(crate) sw: f64,
    pub(crate) zw: f64,
}

impl Products {
    /// Combines the sums of two sets of cells.
    pub(crate) fn with(self, other: Self) -> Self {
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

/// Trial p + `pressure`·p + `step`·s + `preconditioned`·z + `gradient`·g + `constant`, with s, z and g over their units.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Direction {
    pub(crate) pressure: f64,
    pub(crate) step: f64,
    pub(crate) preconditioned: f64,
    pub(crate) gradient: f64,
    pub(crate) constant: f64,
}

/// Length and units of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Advance {
    /// Factor on the step.
    pub(crate) length: f64,
    /// Units of the step and of its image.
    pub(crate) unit_pa: f64,
    pub(crate) unit_m: f64,
    /// Cells whose v is below this bound are near contact.
    pub(crate) bound: f64,
}

/// Pressure, v and hardness, if any, of some cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) p: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) hardness_pa: Option<f64>,
}

impl Part<'_> {
    pub(crate) fn cells(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let hardness_pa = self.hardness_pa.unwrap_or(f64::INFINITY);
        self.p.iter().zip(self.v).map(move |(p, v)| (*p, *v, hardness_pa))
    }
}
