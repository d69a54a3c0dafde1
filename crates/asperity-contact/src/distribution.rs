//! How contact pressures and gaps are distributed over the cells.

use crate::Solution;
use asperity_base::stats::{quantile_sorted, sorted_present};

/// Values of a field over all its cells: an atom at zero, an atom at an upper bound, and a density between.
///
/// The pressure is zero out of contact and equals the hardness H in plastic contact; the gap is zero in contact. Shares are
/// of all cells, so that both atoms and the integral of the density sum to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    cells: usize,
    /// Values above zero, ascending.
    positive: Vec<f64>,
    upper: f64,
}

impl Distribution {
    /// The distribution of `values`, none negative, with an atom at `upper` if there is one.
    fn new(values: impl ExactSizeIterator<Item = f64>, upper: Option<f64>) -> Self {
        let cells = values.len();
        let positive = sorted_present(values.filter(|value| *value > 0.0));
        Self { cells, positive, upper: upper.unwrap_or(f64::INFINITY) }
    }

    /// Values above zero and below the upper bound, ascending.
    fn between(&self) -> &[f64] {
        &self.positive[..self.positive.partition_point(|value| *value < self.upper)]
    }

    fn share(&self, cells: usize) -> f64 {
        cells as f64 / self.cells as f64
    }

    /// Share of the cells at zero: out of contact for the pressure, in contact for the gap.
    pub fn zero_fraction(&self) -> f64 {
        self.share(self.cells - self.positive.len())
    }

    /// Share of the cells at the upper bound: in plastic contact for the pressure, none for the gap.
    pub fn upper_fraction(&self) -> f64 {
        self.share(self.positive.len() - self.between().len())
    }

    /// Share of the cells above zero, those at the upper bound among them.
    pub fn positive_fraction(&self) -> f64 {
        self.share(self.positive.len())
    }

    /// Share of the cells whose value is at most `value`.
    pub fn cumulative(&self, value: f64) -> f64 {
        if value < 0.0 {
            return 0.0;
        }
        self.share(self.cells - self.positive.len() + self.positive.partition_point(|own| *own <= value))
    }

    /// Quantile of the values above zero (the pressure given contact, the gap given that there is none), in the unit of the
    /// field: linear between order statistics, as [`quantile_sorted`]. NaN if there are none.
    ///
    /// # Panics
    /// If the probability lies outside [0, 1].
    pub fn quantile_of_positive(&self, probability: f64) -> f64 {
        quantile_sorted(&self.positive, probability)
    }

    /// Mean of the values above zero, in the unit of the field; NaN if there are none.
    pub fn mean_of_positive(&self) -> f64 {
        self.positive.iter().sum::<f64>() / self.positive.len() as f64
    }

    /// Edges of `bins` equal bins from zero to the upper bound, or to the largest value where there is no bound.
    ///
    /// # Panics
    /// If `bins` is zero.
    pub fn edges(&self, bins: usize) -> Vec<f64> {
        assert!(bins > 0, "a histogram needs a bin");
        let largest = self.positive.last().copied().unwrap_or(0.0);
        let top = if self.upper.is_finite() { self.upper } else { largest };
        (0..=bins).map(|edge| top * (edge as f64 / bins as f64)).collect()
    }

    /// Density between the atoms in bins with the given ascending edges, per unit of the field: share of *all* cells over the
    /// bin's width. A bin holds its lower edge, the last one also its upper edge; values at zero or at the upper bound are in
    /// none. Divided by [`positive_fraction`](Self::positive_fraction) it is the density given contact.
    ///
    /// # Panics
    /// If edges do not ascend.
    pub fn density(&self, edges: &[f64]) -> Vec<f64> {
        assert!(edges.is_sorted_by(|a, b| a < b), "the edges of bins must ascend");
        let values = self.between();
        let last = edges.len().saturating_sub(2);
        let below = |edge: f64| values.partition_point(|value| *value < edge);
        let within = |edge: f64| values.partition_point(|value| *value <= edge);
        let bins = edges.windows(2).enumerate();
        bins.map(|(bin, ends)| {
            let count = if bin == last { within(ends[1]) } else { below(ends[1]) } - below(ends[0]);
            self.share(count) / (ends[1] - ends[0])
        })
        .collect()
    }
}

impl Solution {
    /// Distribution of the pressure in pascal, to be compared with [`PerssonPressure`](crate::exact::PerssonPressure).
    /// Where every cell has a hardness of its own there is no upper value for an atom; plastic cells count like others.
    pub fn pressure_distribution(&self) -> Distribution {
        Distribution::new(self.pressure_pa.iter().copied(), self.hardness_pa)
    }

    /// Distribution of the gap in metre.
    pub fn gap_distribution(&self) -> Distribution {
        Distribution::new(self.gap_m().iter().copied(), None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn atoms_and_density_sum_to_one() {
        let values = [0.0, 4.0, 1.0, 0.0, 2.5, 4.0, 3.0, 0.5];
        let capped = Distribution::new(values.into_iter(), Some(4.0));
        assert_eq!((capped.zero_fraction(), capped.upper_fraction(), capped.positive_fraction()), (0.25, 0.25, 0.75));
        assert_eq!(capped.edges(4), [0.0, 1.0, 2.0, 3.0, 4.0]);
        // 0.5 | 1.0 | 2.5 | 3.0, and the atom at 4 in no bin.
        assert_eq!(capped.density(&capped.edges(4)), [0.125; 4]);
        assert_eq!(capped.density(&[0.5, 2.5, 3.0]), [1.0 / 8.0, 2.0 / 4.0]);
        assert_eq!(capped.quantile_of_positive(0.5), 2.75);
        assert_eq!(capped.mean_of_positive(), 2.5);
        let cumulative = [-1.0, 0.0, 0.5, 2.0, 3.9, 4.0].map(|value| capped.cumulative(value));
        assert_eq!(cumulative, [0.0, 0.25, 0.375, 0.5, 0.75, 1.0]);
        // Without a bound the largest value closes the last bin.
        let elastic = Distribution::new(values.into_iter(), None);
        assert_eq!(elastic.upper_fraction(), 0.0);
        assert_eq!(elastic.density(&elastic.edges(2)), [2.0 / 16.0, 4.0 / 16.0]);
    }

    #[test]
    fn without_contact_there_is_the_atom_alone() {
        let none = Distribution::new([0.0, 0.0].into_iter(), None);
        assert_eq!((none.zero_fraction(), none.positive_fraction(), none.upper_fraction()), (1.0, 0.0, 0.0));
        assert!(none.quantile_of_positive(0.5).is_nan() && none.mean_of_positive().is_nan());
        assert_eq!(none.density(&[0.0, 1.0]), [0.0]);
        assert_eq!(none.density(&[]), [0.0; 0]);
    }
}
