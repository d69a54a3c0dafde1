//! Tabulated map g ↦ F⁻¹(Φ(g)), fast enough for whole maps.

use asperity_base::distribution::Marginal;
use asperity_base::numeric::cubic;

/// Nodes per unit of the table, and its reach.
const NODES_PER_UNIT: f64 = 128.0;
const REACH: f64 = 8.0;

/// The map g ↦ offset + scale·F⁻¹(Φ(g)).
#[derive(Debug, Clone)]
pub(super) struct NormalToMarginal {
    marginal: Marginal,
    offset: f64,
    scale: f64,
    /// Values at −REACH, …, REACH and two nodes beyond each end; only for distributions whose quantile needs a root
    /// search.
    table: Option<Vec<f64>>,
}

impl NormalToMarginal {
    pub(super) fn new(marginal: &Marginal, offset: f64, scale: f64) -> Self {
        let table = matches!(marginal, Marginal::Beta { .. }).then(|| {
            let nodes = (2.0 * REACH * NODES_PER_UNIT) as usize + 5;
            (0..nodes).map(|i| marginal.translate((i as f64 - 2.0) / NODES_PER_UNIT - REACH)).collect()
        });
        Self { marginal: marginal.clone(), offset, scale, table }
    }

    pub(super) fn value(&self, g: f64) -> f64 {
        let value = match &self.table {
            Some(table) if g.abs() < REACH => interpolate(table, (g + REACH) * NODES_PER_UNIT),
            _ => self.marginal.translate(g),
        };
        self.offset + self.scale * value
    }
}

/// Interpolates at `position` (in nodes after the second) by a cubic Hermite polynomial with fourth-order slopes: error
/// O(h⁴).
fn interpolate(table: &[f64], position: f64) -> f64 {
    let left = (position.floor() as usize + 2).min(table.len() - 4);
    let t = position - (left as f64 - 2.0);
    let slope = |i: usize| (table[i - 2] - 8.0 * table[i - 1] + 8.0 * table[i + 1] - table[i + 2]) / 12.0;
    cubic([table[left], slope(left)], [table[left + 1], slope(left + 1)], t)
}
