//! Blockwise transposition of matrices.

use asperity_fft::Complex64;

/// Columns per block: 16 complex numbers are four cache lines of every row.
pub(super) const BLOCK: usize = 16;
/// Rows per block.
pub(super) const TILE: usize = 4;

/// Writes columns of a matrix, from the column `first` on, as zero-padded rows of length `length` into `to`. `from`
/// yields the matrix in slabs of [`TILE`] rows of `width` values, the last one shorter; the number of columns follows
/// from the length of `to`.
pub(super) fn gather<'a, T: Copy + Default + 'a>(
    from: impl Iterator<Item = &'a [T]>,
    width: usize,
    first: usize,
    to: &mut [T],
    length: usize,
) {
    let mut rows = 0;
    // Four rows at a time fill a cache line of every column, which matters if `length` is a power of two and all
    // columns map to the same cache sets.
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

/// Sets the imaginary parts of the first and Nyquist coefficients of a real row to zero; realfft rejects the rounding
/// errors.
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
