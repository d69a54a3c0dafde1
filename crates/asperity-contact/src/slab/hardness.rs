//! Hardness of the cells of a slab, and chunks of its lists.

/// Hardness of all cells.
pub(crate) trait Hardness: Copy + Send + Sync {
    /// Whether the hardness is finite.
    const YIELD: bool;
    /// Returns the hardness in pascal.
    fn pa(self) -> f64;
    /// Returns the hardness in every lane; a constant array, unlike a repeated value, lets the compiler drop comparisons with infinity.
    fn lanes<const L: usize>(self) -> [f64; L];
}

/// Infinite hardness.
#[derive(Clone, Copy)]
pub(super) struct Unbounded;

impl Hardness for Unbounded {
    const YIELD: bool = false;

    #[inline(always)]
    fn pa(self) -> f64 {
        f64::INFINITY
    }

    #[inline(always)]
    fn lanes<const L: usize>(self) -> [f64; L] {
        [f64::INFINITY; L]
    }
}

/// Finite hardness in pascal.
#[derive(Clone, Copy)]
pub(super) struct Yielding(pub(super) f64);

impl Hardness for Yielding {
    const YIELD: bool = true;

    #[inline(always)]
    fn pa(self) -> f64 {
        self.0
    }

    #[inline(always)]
    fn lanes<const L: usize>(self) -> [f64; L] {
        [self.0; L]
    }
}

/// Returns a chunk of a list, padded with `fill` beyond the end of the list.
#[inline(always)]
pub(super) fn load<T: Copy, const L: usize>(list: &[T], chunk: usize, fill: T) -> [T; L] {
    let (chunks, rest) = list.as_chunks::<L>();
    if let Some(chunk) = chunks.get(chunk) {
        return *chunk;
    }
    let mut out = [fill; L];
    out[..rest.len()].copy_from_slice(rest);
    out
}
