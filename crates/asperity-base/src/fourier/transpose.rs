//! Moving rows of one matrix to columns of another.

use super::Complex64;

/// Columns that are moved at a time: 16 complex numbers are four cache lines of every row.
pub(super) const BLOCK: usize = 16;
/// Rows that are moved at a time.
pub(super) const TILE: usize = 4;

/// Writes columns of a matrix, from the column `first` on, as rows of length `length` into `to`, continued with zeros
/// where the matrix has fewer rows. `from` yields the matrix in slabs of [`TILE`] rows of `width` values, the last one
/// shorter; `to` takes as many columns as it has room for.
pub(super) fn gather<'a, T: Copy + Default + 'a>(
    from: impl Iterator<Item = &'a [T]>,
    width: usize,
    first: usize,
    to: &mut [T],
    length: usize,
) {
    let mut rows = 0;
    // Four rows at a time fill a whole cache line of every column, which matters where `length` is a power of two and
    // all columns compete for the same places of the cache.
    for slab in from {
        for (column, out) in to.chunks_exact_mut(length).enumerate() {
            let out = &mut out[rows..];
            for (out, row) in out.iter_mut().zip(slab.chunks_exact(width)) {
                *out = row[first + column];
            }
        }
        rows += slab.len() / width;
    }
    for column in to.chunks_exact_mut(length) {
        column[rows..].fill(T::default());
    }
}

/// Returns a real row has real first and Nyquist coefficients; rounding leaves dust there that realfft refuses.
pub(super) fn make_real(half: &mut [Complex64], length: usize) {
    half[0].im = 0.0;
    if length.is_multiple_of(2) {
        half[length / 2].im = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_become_rows_continued_with_zeros() {
        let from: Vec<i32> = (0..15).collect();
        let mut to = vec![-1; 8];
        gather(from.chunks(TILE * 5), 5, 2, &mut to, 4);
        assert_eq!(to, [2, 7, 12, 0, 3, 8, 13, 0]);
    }
}
