//! Hardness of the cells of a slab, and chunks of its lists.

/// Hardness of the listed cells.
pub(crate) trait Hardness: Copy + Send + Sync {
    /// Whether a hardness is finite.
    const YIELD: bool;
    /// Returns the hardness of the first n cells.
    fn head(self, n: usize) -> Self;
    /// Returns the hardness of a cell.
    fn at(self, i: usize) -> f64;
    /// Returns the hardness of a chunk of cells.
    fn chunk<const L: usize>(self, chunk: usize) -> [f64; L];
}

/// Infinite hardness.
#[derive(Clone, Copy)]
pub(super) struct Unbounded;

impl Hardness for Unbounded {
    const YIELD: bool = false;

    #[inline(always)]
    fn head(self, _n: usize) -> Self {
        self
    }

    #[inline(always)]
    fn at(self, _i: usize) -> f64 {
        f64::INFINITY
    }

    #[inline(always)]
    fn chunk<const L: usize>(self, _chunk: usize) -> [f64; L] {
        [f64::INFINITY; L]
    }
}

/// Finite hardness of every cell.
#[derive(Clone, Copy)]
pub(super) struct Yielding<'a>(pub(super) &'a [f64]);

impl Hardness for Yielding<'_> {
    const YIELD: bool = true;

    #[inline(always)]
    fn head(self, n: usize) -> Self {
        Self(&self.0[..n])
    }

    #[inline(always)]
    fn at(self, i: usize) -> f64 {
        self.0[i]
    }

    #[inline(always)]
    fn chunk<const L: usize>(self, chunk: usize) -> [f64; L] {
        load(self.0, chunk, f64::INFINITY)
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
