//! Number types of stored data.

use crate::{Shape, large};

/// Number of values that are decoded at a time.
const ROW_NUMBERS: usize = 1 << 12;

/// Byte order of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    Little,
    Big,
}

/// Type of a stored number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sample {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Sample {
    /// Returns the size of one number in bytes.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Returns the integer type of `bits` bits.
    pub(crate) fn integer(bits: u64, is_signed: bool) -> Option<Self> {
        let signed = [Self::I8, Self::I16, Self::I32, Self::I64];
        let unsigned = [Self::U8, Self::U16, Self::U32, Self::U64];
        let samples = if is_signed { signed } else { unsigned };
        samples.into_iter().find(|sample| 8 * sample.size() as u64 == bits)
    }

    /// Returns the floating-point type of `bits` bits.
    pub(crate) fn float(bits: u64) -> Option<Self> {
        [Self::F32, Self::F64].into_iter().find(|sample| 8 * sample.size() as u64 == bits)
    }

    /// Returns whether this is a type of signed integers.
    pub(crate) fn is_signed(self) -> bool {
        matches!(self, Self::I8 | Self::I16 | Self::I32 | Self::I64)
    }

    /// Returns whether this is a floating-point type.
    pub(crate) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Decodes the numbers in `bytes`. Bytes that do not fill a number are ignored.
    ///
    /// 64-bit integers beyond 2⁵³ are rounded. All threads decode large arrays.
    pub(crate) fn decode_all(self, order: ByteOrder, bytes: &[u8]) -> Vec<f64> {
        self.decode_and_map(order, bytes, |value| value)
    }

    /// Decodes as [`Sample::decode_all`] and changes each number.
    pub(crate) fn decode_and_map(self, order: ByteOrder, bytes: &[u8], change: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
        let whole = &bytes[..bytes.len() / self.size() * self.size()];
        // The number of columns has no effect on the result.
        let columns = (whole.len() / self.size()).clamp(1, ROW_NUMBERS);
        let mut values = large::rows(columns, whole, columns * self.size(), |record, row| {
            self.decode_into(order, record, row);
            row.iter_mut().for_each(|value| *value = change(*value));
        });
        values.truncate(whole.len() / self.size());
        values
    }

    /// Decodes a map stored column by column and returns its numbers row by row.
    pub(crate) fn decode_columns(self, order: ByteOrder, bytes: &[u8], (ny, nx): Shape) -> Vec<f64> {
        large::transpose_from((nx, ny), |column, first, part| {
            self.decode_into(order, &bytes[(column * ny + first) * self.size()..], part);
        })
    }

    /// Appends the numbers in `bytes` to `values`.
    pub(crate) fn decode(self, order: ByteOrder, bytes: &[u8], values: &mut Vec<f64>) {
        let start = values.len();
        values.resize(start + bytes.len() / self.size(), 0.0);
        self.decode_into(order, bytes, &mut values[start..]);
    }

    /// Decodes as many numbers as fit into `values` and are present in `bytes`.
    pub(crate) fn decode_into(self, order: ByteOrder, bytes: &[u8], values: &mut [f64]) {
        macro_rules! decode {
            ($number:ty) => {{
                let (numbers, _) = bytes.as_chunks::<{ size_of::<$number>() }>();
                let pairs = values.iter_mut().zip(numbers);
                match order {
                    ByteOrder::Little => pairs.for_each(|(value, &raw)| *value = <$number>::from_le_bytes(raw) as f64),
                    ByteOrder::Big => pairs.for_each(|(value, &raw)| *value = <$number>::from_be_bytes(raw) as f64),
                }
            }};
        }
        match self {
            Self::I8 => decode!(i8),
            Self::U8 => decode!(u8),
            Self::I16 => decode!(i16),
            Self::U16 => decode!(u16),
            Self::I32 => decode!(i32),
            Self::U32 => decode!(u32),
            Self::I64 => decode!(i64),
            Self::U64 => decode!(u64),
            Self::F32 => decode!(f32),
            Self::F64 => decode!(f64),
        }
    }
}

/// Returns the little-endian bytes of a height for a file: NaN if it is missing.
pub(crate) fn stored(z: &f64) -> [u8; 8] {
    if z.is_finite() { *z } else { f64::NAN }.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(sample: Sample, order: ByteOrder, bytes: &[u8]) -> Vec<f64> {
        sample.decode_all(order, bytes)
    }

    #[test]
    fn large_arrays_are_decoded_like_small_ones() {
        let count = (1 << 19) + 7;
        let bytes: Vec<u8> = (0..count as u32).flat_map(u32::to_be_bytes).collect();
        let values = decoded(Sample::U32, ByteOrder::Big, &bytes);
        assert!(values.len() == count && values.iter().enumerate().all(|(i, value)| *value == i as f64));
    }

    #[test]
    fn columns_become_rows() {
        // Column 0 holds 0 and 1, column 1 holds 2 and 3.
        let bytes: Vec<u8> = (0..40).collect();
        let values = Sample::U8.decode_columns(ByteOrder::Little, &bytes, (2, 20));
        let wanted = (0..2).flat_map(|y| (0..20).map(move |x| f64::from(2 * x + y)));
        assert!(values.iter().copied().eq(wanted), "{values:?}");
    }

    #[test]
    fn bytes_that_do_not_fill_a_number_are_left_out() {
        assert_eq!(decoded(Sample::I32, ByteOrder::Little, &[1, 0, 0, 0, 9, 9]), [1.0]);
    }
}
