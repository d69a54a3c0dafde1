//! Construction of random generators; no other module creates one.
//!
//! A stream is a function of (seed, stage, sample index): sample 17 of a stage does not depend on the order of the
//! samples or the thread.

use std::convert::Infallible;

use rand::{SeedableRng, TryRng};
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

/// Counter-based random generator, ChaCha with twelve rounds. It is a generator of the crate `rand` as well.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stream(ChaCha12Rng);

#[doc(hidden)]
impl TryRng for Stream {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.0.try_next_u32()
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.0.try_next_u64()
    }

    #[inline]
    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.0.try_fill_bytes(bytes)
    }
}

/// Returns the generator of sample `index` of the named `stage` under `seed`.
///
/// The seed and the stage name (FNV-1a, 64 bits) fill the ChaCha key, the index selects the 64-bit stream, so streams
/// of different indices never overlap.
pub fn stream(seed: u64, stage: &str, index: u64) -> Stream {
    let stage_hash =
        stage.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3));
    let mut key = [0_u8; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&stage_hash.to_le_bytes());
    let mut rng = ChaCha12Rng::from_seed(key);
    rng.set_stream(index);
    Stream(rng)
}

/// The golden-ratio increment of SplitMix64.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Returns SplitMix64 at the counter `counter` of the sequence `key`: a fixed hash of two words rather than a
/// generator.
///
/// # References
/// Steele, Lea & Flood, *OOPSLA* (2014) 453, <https://doi.org/10.1145/2660193.2660195>.
#[doc(hidden)]
pub fn hash(key: u64, counter: u64) -> u64 {
    let mut z = key.wrapping_add(counter.wrapping_add(1).wrapping_mul(GOLDEN));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Fills `xi` with independent standard normal variables.
pub fn fill_standard_normal(stream: &mut Stream, xi: &mut [f64]) {
    for xi in xi {
        *xi = StandardNormal.sample(stream);
    }
}

/// Returns `n` independent standard normal variables.
pub fn standard_normal(stream: &mut Stream, n: usize) -> Vec<f64> {
    let mut xi = vec![0.0; n];
    fill_standard_normal(stream, &mut xi);
    xi
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_depends_only_on_seed_stage_and_index() {
        let draw = |seed, stage, index| standard_normal(&mut stream(seed, stage, index), 3);
        assert_eq!(draw(1, "a", 2), draw(1, "a", 2));
        assert_ne!(draw(1, "a", 2), draw(2, "a", 2));
        assert_ne!(draw(1, "a", 2), draw(1, "b", 2));
        assert_ne!(draw(1, "a", 2), draw(1, "a", 3));
    }
}
