//! Large samples by fewer values.

use std::borrow::Cow;

/// Largest number of values of a condensed sample.
const MOST: usize = 1 << 15;

/// Returns a sorted sample or, if it is large, the means of groups of neighbours in it.
///
/// All groups have the same number of values, or one more. The group means represent the sample to second order in the
/// widths of the groups, which hold at most 1/16384 of the probability each.
pub(super) fn condensed(sorted: &[f64]) -> Cow<'_, [f64]> {
    let n = sorted.len();
    if n <= MOST {
        return Cow::Borrowed(sorted);
    }
    let groups = n / n.div_ceil(MOST);
    let start = |group: usize| (group as u64 * n as u64 / groups as u64) as usize;
    let mean = |group: usize| {
        let values = &sorted[start(group)..start(group + 1)];
        // Relative to the first, so that equal values have exactly their mean.
        values[0] + values.iter().map(|x| x - values[0]).sum::<f64>() / values.len() as f64
    };
    (0..groups).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use crate::stats::{Moments, sorted_present};

    #[test]
    fn group_means_have_the_moments_of_the_sample_and_equal_values_stay_equal() {
        for n in [MOST + 1, 50_000, 100_003] {
            let mut values = random::standard_normal(&mut random::stream(8, "condensed", 0), n);
            values[..n / 10].fill(0.1);
            let sorted = sorted_present(values);
            let few = condensed(&sorted);
            assert!(few.len() <= MOST && 2 * few.len() > MOST - 2 && few.is_sorted(), "{n}: {}", few.len());
            let (all, found) = (Moments::new(&sorted), Moments::new(&few));
            assert!(
                (found.mean - all.mean).abs() < 1e-3 && (found.std / all.std - 1.0).abs() < 1e-3,
                "{found:?} {all:?}"
            );
            assert!(few.iter().filter(|x| **x == 0.1).count() > few.len() / 11);
        }
        assert!(matches!(condensed(&[1.0, 2.0]), Cow::Borrowed(_)));
    }
}
