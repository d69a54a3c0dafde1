//! Large arrays: memory in huge pages, and parallel passes.

use rayon::prelude::*;

/// Number of rows and number of columns of a map.
pub(crate) type Shape = (usize, usize);

/// Size of an array above which all threads work on it, and number of values that each takes at a time.
const PARALLEL_NUMBERS: usize = 1 << 18;
const PIECE_NUMBERS: usize = 1 << 16;
/// Side of the squares in which a map is transposed. Two of them fit into the first-level cache.
const TILE: usize = 32;

/// Allocates `count` zeros.
pub(crate) fn zeros<T: Clone + Default>(count: usize) -> Vec<T> {
    let mut values = vec![T::default(); count];
    huge_pages(&mut values);
    values
}

/// Allocates memory for `count` values.
pub(crate) fn with_capacity<T>(count: usize) -> Vec<T> {
    let mut values = Vec::with_capacity(count);
    huge_pages(&mut values);
    values
}

/// Asks the system for huge pages under a large array. Most of the time for reading a large file goes into the first
/// access to small pages.
#[cfg(target_os = "linux")]
fn huge_pages<T>(values: &mut Vec<T>) {
    use rustix::mm::{Advice, madvise};
    /// Size below which huge pages bring nothing.
    const LEAST_BYTES: usize = 4 << 20;
    const PAGE_BYTES: usize = 4096;

    let bytes = values.capacity() * size_of::<T>();
    if bytes < LEAST_BYTES {
        return;
    }
    let start: *mut T = values.as_mut_ptr();
    let skipped = start.cast::<u8>().align_offset(PAGE_BYTES);
    let Some(length) = bytes.checked_sub(skipped).map(|length| length / PAGE_BYTES * PAGE_BYTES) else { return };
    #[expect(unsafe_code, reason = "the standard library has no call for advice on memory")]
    // SAFETY: the bytes are whole pages within the memory of `values`, and this advice does not change their content.
    // If the system has no huge pages, the call fails without effect.
    let _ = unsafe { madvise(start.cast::<u8>().wrapping_add(skipped).cast(), length, Advice::LinuxHugepage) };
}

#[cfg(not(target_os = "linux"))]
fn huge_pages<T>(_values: &mut Vec<T>) {}

/// Applies `fold` to the pieces of an array and returns its results in order. A small array is one piece.
pub(crate) fn pass<T: Send>(values: &mut [f64], fold: impl Fn(&mut [f64]) -> T + Sync) -> Vec<T> {
    if values.len() < PARALLEL_NUMBERS {
        return vec![fold(values)];
    }
    values.par_chunks_mut(PIECE_NUMBERS).map(&fold).collect()
}

/// Replaces every number.
pub(crate) fn map(values: &mut [f64], change: impl Fn(f64) -> f64 + Sync) {
    pass(values, |piece| piece.iter_mut().for_each(|value| *value = change(*value)));
}

/// Changes every number. Returns how many times `change` returned true.
pub(crate) fn count(values: &mut [f64], change: impl Fn(&mut f64) -> bool + Sync) -> usize {
    let count = |piece: &mut [f64]| piece.iter_mut().map(|value| usize::from(change(value))).sum::<usize>();
    pass(values, count).into_iter().sum()
}

/// Sets marked heights to NaN. Returns their number.
pub(crate) fn hide<'z>(heights: impl IntoIterator<Item = &'z mut f64>, marks: impl IntoIterator<Item = bool>) -> usize {
    let marked = heights.into_iter().zip(marks).filter(|(_, is_marked)| *is_marked);
    marked.map(|(z, _)| *z = f64::NAN).count()
}

/// Fills an array from records of `stride` bytes. Each record gives one row of `columns` numbers.
pub(crate) fn rows(columns: usize, records: &[u8], stride: usize, fill: impl Fn(&[u8], &mut [f64]) + Sync) -> Vec<f64> {
    let mut values = zeros(records.len().div_ceil(stride) * columns);
    let pairs = |values: &mut [f64], records: &[u8]| {
        for (row, record) in values.chunks_mut(columns).zip(records.chunks(stride)) {
            fill(record, row);
        }
    };
    if values.len() < PARALLEL_NUMBERS {
        pairs(&mut values, records);
    } else {
        let at_once = PIECE_NUMBERS.div_ceil(columns);
        let records = records.par_chunks(at_once * stride);
        values.par_chunks_mut(at_once * columns).zip(records).for_each(|(values, records)| pairs(values, records));
    }
    values
}

/// Reverses the order of the rows of a map.
pub(crate) fn flip(values: &mut [f64], columns: usize) {
    let mut rows = values.chunks_exact_mut(columns);
    while let (Some(first), Some(last)) = (rows.next(), rows.next_back()) {
        first.swap_with_slice(last);
    }
}

/// Returns the numbers of a map in column order. `part(row, column, values)` fills `values` from a row, starting at a
/// column.
pub(crate) fn transpose_from((rows, columns): Shape, part: impl Fn(usize, usize, &mut [f64]) + Sync) -> Vec<f64> {
    let mut turned = zeros(rows * columns);
    let strip = |(place, strip): (usize, &mut [f64])| {
        // The rows of a large map share cache lines when read by column. Copies of a square do not.
        let (mut row, mut tile) = ([0.0; TILE], [[0.0; TILE]; TILE]);
        let row = &mut row[..strip.len() / rows];
        for top in (0..rows).step_by(TILE) {
            let height = TILE.min(rows - top);
            for y in 0..height {
                part(top + y, place * TILE, row);
                tile.iter_mut().zip(&*row).for_each(|(column, &value)| column[y] = value);
            }
            for (column, turned) in strip.chunks_mut(rows).zip(&tile) {
                column[top..top + height].copy_from_slice(&turned[..height]);
            }
        }
    };
    turned.par_chunks_mut(TILE * rows.max(1)).enumerate().for_each(strip);
    turned
}

/// Returns the numbers of a map in column order.
pub(crate) fn transposed(values: &[f64], (rows, columns): Shape) -> Vec<f64> {
    transpose_from((rows, columns), |row, first, part| {
        let start = row * columns + first;
        part.copy_from_slice(&values[start..start + part.len()]);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_arrays_start_as_zeros_and_are_changed_everywhere() {
        for count in [3, PARALLEL_NUMBERS + 5, (4 << 20) / 8 + 1] {
            let mut values: Vec<f64> = zeros(count);
            assert!(values.len() == count && values.iter().all(|&value| value == 0.0));
            map(&mut values, |value| value + 2.0);
            let sum: f64 = pass(&mut values, |piece| piece.iter().sum::<f64>()).iter().sum();
            assert_eq!(sum, 2.0 * count as f64);
        }
    }

    #[test]
    fn a_transposed_map_has_its_indices_exchanged() {
        for (rows, columns) in [(1, 1), (1, 70), (70, 1), (33, 65), (2, 3)] {
            let values: Vec<f64> = (0..rows * columns).map(|place| place as f64).collect();
            let turned = transposed(&values, (rows, columns));
            for y in 0..rows {
                for x in 0..columns {
                    assert_eq!(turned[x * rows + y], values[y * columns + x]);
                }
            }
        }
    }

    #[test]
    fn rows_come_from_records_of_any_stride() {
        for (count, columns) in [(3, 2), (700, 600)] {
            let records: Vec<u8> = (0..count).flat_map(|y: usize| [y as u8, (y >> 8) as u8, 9]).collect();
            let values = rows(columns, &records, 3, |record, row| {
                row.fill(f64::from(u16::from_le_bytes([record[0], record[1]])));
            });
            assert!(values.iter().enumerate().all(|(place, &value)| value == (place / columns) as f64));
        }
    }
}
