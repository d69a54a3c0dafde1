//! Keyed permutations that are evaluated at one index without a table.

use rand::Rng;

use asperity_base::random::{Stream, hash};

/// Pseudo-random permutation of 0 … n−1 by the swap-or-not shuffle.
///
/// In each round the elements x and K − x (mod n) are partners, and a keyed bit of the pair decides whether they swap.
/// With 6⌈log₂ n⌉ + 32 rounds, the published bound on the advantage of distinguishing the image of one index from a
/// uniform one is below 2⁻⁹ for n ≥ 64.
///
/// # References
/// Hoang, Morris & Rogaway, *CRYPTO* (2012) 1, <https://doi.org/10.1007/978-3-642-32009-5_1>.
#[derive(Debug, Clone)]
pub(super) struct Permutation {
    n: u64,
    /// (K, key of the swap bits) of each round.
    rounds: Vec<(u64, u64)>,
}

impl Permutation {
    /// Creates the permutation of `n` elements whose keys come from `stream`.
    pub(super) fn new(n: u64, stream: &mut Stream) -> Self {
        assert!(n > 0, "a permutation needs elements");
        let bits = u64::BITS - (n - 1).leading_zeros();
        let rounds = (0..6 * bits + 32)
            .map(|_| (((u128::from(stream.next_u64()) * u128::from(n)) >> 64) as u64, stream.next_u64()))
            .collect();
        Self { n, rounds }
    }

    /// Returns the image of `index`.
    pub(super) fn at(&self, index: u64) -> u64 {
        assert!(index < self.n, "index {index} of {} elements", self.n);
        let mut x = index;
        for &(shift, key) in &self.rounds {
            let partner = if shift >= x { shift - x } else { shift + self.n - x };
            if hash(key, x.max(partner)) >> 63 == 1 {
                x = partner;
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::stream;

    #[test]
    fn every_element_is_reached_once() {
        for n in [1, 2, 3, 7, 64, 1000] {
            let permutation = Permutation::new(n, &mut stream(1, "test", n));
            let mut image: Vec<u64> = (0..n).map(|i| permutation.at(i)).collect();
            image.sort_unstable();
            assert_eq!(image, (0..n).collect::<Vec<_>>());
        }
    }

    #[test]
    fn all_orders_of_four_elements_are_equally_frequent() {
        let trials = 24_000;
        let mut counts = std::collections::HashMap::new();
        for trial in 0..trials {
            let permutation = Permutation::new(4, &mut stream(3, "orders", trial));
            let order: Vec<u64> = (0..4).map(|i| permutation.at(i)).collect();
            *counts.entry(order).or_insert(0_u32) += 1;
        }
        assert_eq!(counts.len(), 24);
        let expected = f64::from(trials as u32) / 24.0;
        let chi_square: f64 = counts.values().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
        // 23 degrees of freedom: mean 23, standard deviation √46; four of them.
        assert!(chi_square < 23.0 + 4.0 * 46.0_f64.sqrt(), "χ² = {chi_square:.1}");
    }
}
