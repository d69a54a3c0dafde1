//! Strokes of alternating sign in the records of reciprocating tribometers.

use super::sampling;
use asperity_base::stats::sorted_present;

/// Fraction of the typical |μ| below which a value belongs to a reversal.
const REVERSAL: f64 = 0.5;
/// Largest fraction of such values, and largest ratio of the standard deviation of |μ| without them to its mean. For
/// noise about zero they are .26 and .52.
const MOST_REVERSING: f64 = 0.22;
const LARGEST_VARIATION: f64 = 0.42;
/// Least fraction of values of each sign, and least mean number of values per stroke.
const LEAST_OF_A_SIGN: f64 = 0.1;
const LEAST_VALUES: usize = 8;
/// Ratio of mean to mean |μ| below which friction has no direction.
const NO_DIRECTION: f64 = 0.25;

/// Interpretation of the signs of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Signs {
    /// One direction; negative on average if `reversed`.
    One {
        /// Whether friction is negative on average.
        reversed: bool,
    },
    /// Reciprocating strokes.
    Strokes(Strokes),
    /// Neither: values on both sides of zero without a direction.
    None {
        /// Ratio of mean to mean |μ|.
        ratio: f64,
    },
}

/// Reciprocating strokes without their reversals.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strokes {
    /// |μ|, NaN at reversals.
    pub(super) friction: Vec<f64>,
    /// First value of every stroke except the first.
    pub(super) starts: Vec<usize>,
    /// Fraction of the present values that were reversals.
    pub(super) reversal_fraction: f64,
}

/// Classifies the signs of a record.
pub(super) fn signs(friction: &[f64]) -> Signs {
    let (sum, present) = sampling::sum(friction);
    let sizes = sorted_present(friction.iter().map(|mu| mu.abs()));
    let size: f64 = sizes.iter().sum();
    if present == 0 || size == 0.0 {
        return Signs::One { reversed: false };
    }
    if let Some(strokes) = strokes(friction, sizes[sizes.len() / 2]) {
        return Signs::Strokes(strokes);
    }
    match sum / size {
        ratio if ratio.abs() < NO_DIRECTION => Signs::None { ratio },
        ratio => Signs::One { reversed: ratio < 0.0 },
    }
}

fn strokes(friction: &[f64], typical: f64) -> Option<Strokes> {
    let high = |mu: &&f64| mu.abs() >= REVERSAL * typical;
    let sliding: Vec<f64> = friction.iter().filter(high).copied().collect();
    let (present, n) = (sampling::sum(friction).1 as f64, sliding.len() as f64);
    let positive = sliding.iter().filter(|mu| **mu > 0.0).count() as f64 / n;
    let mean = sliding.iter().map(|mu| mu.abs()).sum::<f64>() / n;
    let variation = (sliding.iter().map(|mu| (mu.abs() - mean).powi(2)).sum::<f64>() / n).sqrt() / mean;
    if positive.min(1.0 - positive) < LEAST_OF_A_SIGN
        || n < (1.0 - MOST_REVERSING) * present
        || variation > LARGEST_VARIATION
    {
        return None;
    }
    // Every change of direction: the last value in one direction and the first in the other.
    let (mut changes, mut last) = (Vec::new(), None::<(usize, f64)>);
    for (index, mu) in friction.iter().enumerate().filter(|(_, mu)| high(mu)) {
        if let Some((before, _)) = last.filter(|(_, sign)| sign * mu < 0.0) {
            changes.push((before, index));
        }
        last = Some((index, *mu));
    }
    if changes.is_empty() || friction.len() / (changes.len() + 1) < LEAST_VALUES {
        return None;
    }
    let mut sizes: Vec<f64> = friction.iter().map(|mu| mu.abs()).collect();
    for (before, after) in &changes {
        // On either side a straight ramp is half as long as its part between half the heights.
        let ramp = (after - before).div_ceil(2);
        sizes[before.saturating_sub(ramp) + 1..(after + ramp).min(friction.len())].fill(f64::NAN);
    }
    // A record may start and end within a reversal.
    if let (Some(first), Some((end, _))) = (friction.iter().position(|mu| high(&mu)), last) {
        let behind = friction.len() - 1 - end;
        sizes[..(2 * first).min(friction.len())].fill(f64::NAN);
        sizes[friction.len().saturating_sub(2 * behind)..].fill(f64::NAN);
    }
    let left = sampling::sum(&sizes).1 as f64;
    Some(Strokes {
        friction: sizes,
        starts: changes.iter().map(|(before, after)| (before + after).div_ceil(2)).collect(),
        reversal_fraction: 1.0 - left / present,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;
    use asperity_testing::autoregressive;

    fn noise(n: usize, index: u64) -> Vec<f64> {
        autoregressive((-0.1_f64).exp(), n, &mut random::stream(53, "strokes", index))
    }

    #[test]
    fn strokes_are_found_and_their_reversals_left_out() {
        // Strokes of 200 values with ramps of ten between them.
        let sign = |i: usize| {
            let place = (i + 100) % 400;
            let wave = if place < 200 { place as f64 - 100.0 } else { 300.0 - place as f64 };
            (wave / 5.0).clamp(-1.0, 1.0)
        };
        let record: Vec<f64> = noise(4000, 1).iter().enumerate().map(|(i, g)| sign(i) * (0.4 + 0.03 * g)).collect();
        let Signs::Strokes(found) = signs(&record) else { panic!("no strokes") };
        assert!(found.starts.len() >= 19 && found.starts.len() <= 20, "{:?}", found.starts);
        let (sum, present) = sampling::sum(&found.friction);
        assert!((sum / present as f64 - 0.4).abs() < 0.01);
        assert!(found.friction.iter().all(|mu| mu.is_nan() || *mu > 0.2));
        // Ramps are a twentieth of the record.
        assert!((found.reversal_fraction - 0.05).abs() < 0.02, "{}", found.reversal_fraction);
    }

    #[test]
    fn one_direction_is_recognised_and_noise_about_zero_is_refused() {
        let one: Vec<f64> = noise(2000, 2).iter().map(|g| -0.3 + 0.05 * g).collect();
        assert_eq!(signs(&one), Signs::One { reversed: true });
        assert!(matches!(signs(&noise(4000, 3)), Signs::None { ratio } if ratio.abs() < 0.25));
    }
}
