//! Isotonic regression.

/// Returns the non-decreasing sequence nearest to `values` in weighted least squares. Each value has its positive weight.
///
/// Neighbours in the wrong order are replaced by their mean until none is left (pool adjacent violators; Barlow et al., *Statistical
/// Inference under Order Restrictions*, Wiley, 1972).
pub fn isotonic(values: impl IntoIterator<Item = [f64; 2]>) -> Vec<f64> {
    /// Values that share a mean.
    struct Pool {
        mean: f64,
        weight: f64,
        count: usize,
    }
    let mut pools: Vec<Pool> = Vec::new();
    for [mean, weight] in values {
        let mut pool = Pool { mean, weight, count: 1 };
        while let Some(last) = pools.pop_if(|last| last.mean >= pool.mean) {
            let weight = last.weight + pool.weight;
            let mean = (last.mean * last.weight + pool.mean * pool.weight) / weight;
            pool = Pool { mean, weight, count: last.count + pool.count };
        }
        pools.push(pool);
    }
    pools.iter().flat_map(|pool| std::iter::repeat_n(pool.mean, pool.count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_in_the_wrong_order_have_their_weighted_mean() {
        assert_eq!(isotonic([[1.0, 1.0], [2.0, 1.0], [4.0, 5.0]]), [1.0, 2.0, 4.0]);
        assert_eq!(isotonic([[3.0, 1.0], [1.0, 3.0], [2.0, 1.0]]), [1.5, 1.5, 2.0]);
        assert_eq!(isotonic([[2.0, 1.0], [5.0, 1.0], [3.0, 1.0], [-2.0, 1.0]]), [2.0; 4]);
        assert!(isotonic([]).is_empty());
    }

    #[test]
    fn no_other_sequence_is_nearer() {
        // The mean of the values from j to k, largest over j ≤ i and least over k ≥ i, is the other formula of the solution.
        let values: Vec<[f64; 2]> = (0..40_u32).map(|i| [f64::from(i * 37 % 41), f64::from(1 + i * 13 % 5)]).collect();
        let mean = |j: usize, k: usize| {
            let sum = |of: fn(&[f64; 2]) -> f64| values[j..=k].iter().map(of).sum::<f64>();
            sum(|[value, weight]| value * weight) / sum(|[_, weight]| *weight)
        };
        for (i, found) in isotonic(values.iter().copied()).into_iter().enumerate() {
            let least = |j: usize| (i..40).map(|k| mean(j, k)).fold(f64::INFINITY, f64::min);
            let wanted = (0..=i).map(least).fold(f64::NEG_INFINITY, f64::max);
            assert!((found - wanted).abs() < 1e-12, "{found} instead of {wanted} at {i}");
        }
    }
}
