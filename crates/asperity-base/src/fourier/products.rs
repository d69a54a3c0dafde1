//! Power spectra and autocorrelations of real maps and profiles by the squared modulus of their transforms.
//!
//! Columns are transformed in blocks that fit the level-2 cache and reduced immediately, so that the full complex
//! spectrum is never stored.

use std::ops::Range;

use asperity_fft::{complex_f64, real_forward, real_inverse};

use super::transpose::{BLOCK, TILE, gather, make_real};
use super::{Complex64, good_length};
use crate::blocks;

/// Profiles whose powers are summed per block.
const PROFILES_PER_BLOCK: usize = 64;
/// Points of a map from which its transforms along x are computed twice and stored by halves.
const HALVED_FROM: usize = 1 << 21;

/// Returns the transforms along x of a map of `rows` × `columns` values zero-padded to the length `nx`, at some of the
/// wavenumbers 0 … nx/2, as slabs of [`TILE`] rows. `fill` writes a row of the map.
///
/// Each slab is allocated separately, which is faster than one large allocation.
fn transformed_rows(
    rows: usize,
    columns: usize,
    nx: usize,
    wavenumbers: Range<usize>,
    fill: &(impl Fn(usize, &mut [f64]) + Sync),
) -> Vec<Vec<Complex64>> {
    let plan = real_forward(nx);
    let width = wavenumbers.len();
    blocks::map_with(
        0..rows.div_ceil(TILE),
        || (plan.make_input_vec(), plan.make_output_vec(), plan.make_scratch_vec()),
        |(input, output, scratch), slab| {
            let range = slab * TILE..((slab + 1) * TILE).min(rows);
            let mut transformed = vec![Complex64::default(); range.len() * width];
            for (row, out) in range.zip(transformed.chunks_exact_mut(width)) {
                fill(row, &mut input[..columns]);
                input[columns..].fill(0.0);
                let done = plan.process_with_scratch(input, output, scratch);
                debug_assert!(done.is_ok());
                out.copy_from_slice(&output[wavenumbers.clone()]);
            }
            transformed
        },
    )
}

/// Returns |X|² of a map of `ny` × `nx` values, in the layout of the spectrum of [`super::RealFft2`]; `fill` writes a
/// row of the map.
#[doc(hidden)]
pub fn power(nx: usize, ny: usize, fill: impl Fn(usize, &mut [f64]) + Sync) -> Vec<f64> {
    of_spectrum(nx, ny, fill, |value| value.norm_sqr())
}

/// Returns the real parts of X as [`power`] does |X|²: the spectrum of a map that is even on its periodic grid.
#[doc(hidden)]
pub fn even_spectrum(nx: usize, ny: usize, fill: impl Fn(usize, &mut [f64]) + Sync) -> Vec<f64> {
    of_spectrum(nx, ny, fill, |value| value.re)
}

fn of_spectrum(
    nx: usize,
    ny: usize,
    fill: impl Fn(usize, &mut [f64]) + Sync,
    real: impl Fn(&Complex64) -> f64 + Sync,
) -> Vec<f64> {
    let stored = nx / 2 + 1;
    let transformed = transformed_rows(ny, nx, nx, 0..stored, &fill);
    let [plan, _] = complex_f64(ny);
    let mut values = vec![0.0; stored * ny];
    blocks::for_each_with(
        values.chunks_mut(BLOCK * ny).enumerate(),
        || (vec![Complex64::default(); BLOCK * ny], vec![Complex64::default(); plan.get_inplace_scratch_len()]),
        |(columns, scratch), (block, out)| {
            let columns = &mut columns[..out.len()];
            gather(transformed.iter().map(Vec::as_slice), stored, block * BLOCK, columns, ny);
            plan.process_with_scratch(columns, scratch);
            out.iter_mut().zip(columns).for_each(|(out, value)| *out = real(value));
        },
    );
    values
}

/// Returns Σ z[r, c] z[r + k, c + l] of a map of `rows` × `columns` values over the pairs inside the map, for the lags
/// k = 0 … `reach_y` and l = −`reach_x` … `reach_x`, as rows of 2·`reach_x` + 1 values. `fill` writes a row of the map.
///
/// The map is zero-padded by the largest lags, which excludes wrapped pairs from the circular correlation: the sums are
/// exact up to rounding.
///
/// # Panics
/// If a lag exceeds the map.
#[doc(hidden)]
pub fn autocorrelation_sums(
    (rows, columns): (usize, usize),
    (reach_x, reach_y): (usize, usize),
    fill: impl Fn(usize, &mut [f64]) + Sync,
) -> Vec<f64> {
    assert!(reach_x < columns && reach_y < rows, "lags up to ({reach_x}, {reach_y}) exceed {columns} × {rows} points");
    let (nx, ny) = (good_length(columns + reach_x), good_length(rows + reach_y));
    let (stored, lags_y) = (nx / 2 + 1, reach_y + 1);
    let mut half = vec![Complex64::default(); stored * lags_y];
    // The transforms along x of a large map are stored half at a time.
    let passes = if rows * columns < HALVED_FROM { 1 } else { 2 };
    let per_pass = stored.div_ceil(BLOCK).div_ceil(passes) * BLOCK;
    for (pass, half) in half.chunks_mut(per_pass * lags_y).enumerate() {
        let wavenumbers = pass * per_pass..pass * per_pass + half.len() / lags_y;
        let transformed = transformed_rows(rows, columns, nx, wavenumbers, &fill);
        lag_sums_along_y(&transformed, ny, half, lags_y);
    }

    let width = 2 * reach_x + 1;
    let mut sums = vec![0.0; lags_y * width];
    let plan = real_inverse(nx);
    let scale = 1.0 / (nx * ny) as f64;
    blocks::for_each_with(
        sums.chunks_mut(BLOCK * width).enumerate(),
        || (vec![Complex64::default(); BLOCK * stored], plan.make_output_vec(), plan.make_scratch_vec()),
        |(inputs, lags, scratch), (block, out)| {
            let inputs = &mut inputs[..out.len() / width * stored];
            gather(half.chunks(TILE * lags_y), lags_y, block * BLOCK, inputs, stored);
            for (input, out) in inputs.chunks_exact_mut(stored).zip(out.chunks_exact_mut(width)) {
                make_real(input, nx);
                let done = plan.process_with_scratch(input, lags, scratch);
                debug_assert!(done.is_ok());
                let (left, right) = out.split_at_mut(reach_x);
                left.iter_mut().zip(&lags[nx - reach_x..]).for_each(|(out, value)| *out = value * scale);
                right.iter_mut().zip(lags.iter()).for_each(|(out, value)| *out = value * scale);
            }
        },
    );
    sums
}

/// Computes Σ_ky |X|² e^{2πi ky k/ny} for k = 0 … `lags_y` − 1, the conjugate of the transform of a real sequence, from
/// the transforms along x. `sums` has `lags_y` values for each wavenumber along x.
fn lag_sums_along_y(transformed: &[Vec<Complex64>], ny: usize, sums: &mut [Complex64], lags_y: usize) {
    let [forward, _] = complex_f64(ny);
    let back = real_forward(ny);
    let wavenumbers = sums.len() / lags_y;
    blocks::for_each_with(
        sums.chunks_mut(BLOCK * lags_y).enumerate(),
        || {
            let scratch = forward.get_inplace_scratch_len().max(back.get_scratch_len());
            let zeros = |length: usize| vec![Complex64::default(); length];
            (zeros(BLOCK * ny), zeros(scratch), back.make_input_vec(), back.make_output_vec())
        },
        |(columns, scratch, squares, lags), (block, out)| {
            let columns = &mut columns[..out.len() / lags_y * ny];
            gather(transformed.iter().map(Vec::as_slice), wavenumbers, block * BLOCK, columns, ny);
            forward.process_with_scratch(columns, scratch);
            for (column, out) in columns.chunks_exact(ny).zip(out.chunks_exact_mut(lags_y)) {
                squares.iter_mut().zip(column).for_each(|(square, value)| *square = value.norm_sqr());
                let done = back.process_with_scratch(squares, lags, &mut scratch[..back.get_scratch_len()]);
                debug_assert!(done.is_ok());
                out.iter_mut().zip(lags.iter()).for_each(|(out, value)| *out = value.conj());
            }
        },
    );
}

/// Returns Σ |X|² over `profiles` of `length` values zero-padded to `padded`, for the wavenumbers 0 … padded/2. `fill`
/// writes the profiles of a range, one after the other.
#[doc(hidden)]
pub fn summed_power(
    profiles: usize,
    length: usize,
    padded: usize,
    fill: impl Fn(Range<usize>, &mut [f64]) + Sync,
) -> Vec<f64> {
    let plan = real_forward(padded);
    let blocks: Vec<Vec<f64>> = blocks::map_with(
        0..profiles.div_ceil(PROFILES_PER_BLOCK),
        || {
            (
                vec![0.0; PROFILES_PER_BLOCK * length],
                plan.make_input_vec(),
                plan.make_output_vec(),
                plan.make_scratch_vec(),
            )
        },
        |(values, input, output, scratch), block| {
            let range = block * PROFILES_PER_BLOCK..((block + 1) * PROFILES_PER_BLOCK).min(profiles);
            let values = &mut values[..range.len() * length];
            fill(range, values);
            let mut sums = vec![0.0; padded / 2 + 1];
            for profile in values.chunks_exact(length) {
                input[..length].copy_from_slice(profile);
                input[length..].fill(0.0);
                let done = plan.process_with_scratch(input, output, scratch);
                debug_assert!(done.is_ok());
                sums.iter_mut().zip(output.iter()).for_each(|(sum, value)| *sum += value.norm_sqr());
            }
            sums
        },
    );
    let mut sums = vec![0.0; padded / 2 + 1];
    for block in blocks {
        sums.iter_mut().zip(block).for_each(|(sum, value)| *sum += value);
    }
    sums
}

/// Returns the real sequence of even `length` with the real and even transform `power` of length/2 + 1 values: for a
/// [`summed_power`], the sums of products at the lags 0 … length/2 of the profiles.
#[doc(hidden)]
pub fn lag_sums_of_power(power: &[f64], length: usize) -> Vec<f64> {
    let plan = real_inverse(length);
    let mut input: Vec<Complex64> = power.iter().map(|value| Complex64::from(*value)).collect();
    let mut output = plan.make_output_vec();
    let done = plan.process(&mut input, &mut output);
    debug_assert!(done.is_ok());
    output.iter().take(length / 2 + 1).map(|value| value / length as f64).collect()
}

/// Returns the real parts of the transform of a real sequence, for the wavenumbers 0 … length/2.
#[doc(hidden)]
pub fn real_transform(values: &[f64]) -> Vec<f64> {
    let plan = real_forward(values.len());
    let (mut input, mut output) = (values.to_vec(), plan.make_output_vec());
    let done = plan.process(&mut input, &mut output);
    debug_assert!(done.is_ok());
    output.iter().map(|value| value.re).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fourier::RealFft2;
    use crate::random;

    fn map(rows: usize, columns: usize) -> Vec<f64> {
        random::standard_normal(&mut random::stream(6, "products", (rows * columns) as u64), rows * columns)
    }

    #[test]
    fn sums_of_products_are_those_of_the_pairs_inside_the_map() {
        for (rows, columns, reach_x, reach_y) in
            [(7, 9, 8, 6), (7, 9, 0, 3), (20, 33, 16, 2), (5, 40, 1, 4), (2, 2, 1, 1)]
        {
            let z = map(rows, columns);
            let found = autocorrelation_sums((rows, columns), (reach_x, reach_y), |row, out| {
                out.copy_from_slice(&z[row * columns..(row + 1) * columns]);
            });
            for lag_y in 0..=reach_y {
                for (place, lag_x) in (-(reach_x as isize)..=reach_x as isize).enumerate() {
                    let mut sum = 0.0;
                    for row in 0..rows - lag_y {
                        for column in 0..columns as isize {
                            if (0..columns as isize).contains(&(column + lag_x)) {
                                let other = (row + lag_y) * columns + (column + lag_x) as usize;
                                sum += z[row * columns + column as usize] * z[other];
                            }
                        }
                    }
                    let value = found[lag_y * (2 * reach_x + 1) + place];
                    assert!((value - sum).abs() < 1e-12 * (rows * columns) as f64, "({lag_x}, {lag_y}): {value} {sum}");
                }
            }
        }
    }

    #[test]
    fn powers_are_those_of_the_transform() {
        let (rows, columns) = (24, 50);
        let z = map(rows, columns);
        let fft = RealFft2::new(columns, rows);
        let mut spectrum = fft.spectrum();
        fft.forward(&z, &mut spectrum, &mut fft.workspace());
        let found = power(columns, rows, |row, out| out.copy_from_slice(&z[row * columns..(row + 1) * columns]));
        assert!(found.iter().zip(&spectrum).all(|(power, value)| (power - value.norm_sqr()).abs() < 1e-10));
    }

    #[test]
    fn summed_powers_give_the_sums_of_products_of_profiles() {
        let (profiles, length) = (2 * PROFILES_PER_BLOCK + 3, 10);
        let z = map(profiles, length);
        let found = summed_power(profiles, length, 20, |range, out| {
            out.copy_from_slice(&z[range.start * length..range.end * length]);
        });
        let sums = lag_sums_of_power(&found, 20);
        for lag in 0..length {
            let direct: f64 = z
                .chunks(length)
                .flat_map(|profile| (0..length - lag).map(move |i| profile[i] * profile[i + lag]))
                .sum();
            assert!((sums[lag] - direct).abs() < 1e-10, "lag {lag}");
        }
    }
}
