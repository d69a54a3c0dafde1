//! Numbers as files store them.

use rayon::prelude::*;

/// Numbers from which on all threads decode, and how many each takes at a time.
const PARALLEL_NUMBERS: usize = 1 << 18;
const CHUNK_NUMBERS: usize = 1 << 16;
/// Columns that are turned into parts of rows together.
const COLUMNS_AT_ONCE: usize = 16;

/// Order of the bytes of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    Little,
    Big,
}

/// Type of one stored number.
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
    /// Bytes of one number.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The numbers in `bytes`; bytes that do not fill a number are left out.
    ///
    /// 64-bit integers beyond 2⁵³ are rounded. Large arrays are decoded by all threads: most of the time goes into the
    /// first touch of new memory.
    pub(crate) fn decode_all(self, order: ByteOrder, bytes: &[u8]) -> Vec<f64> {
        let mut values = vec![0.0; bytes.len() / self.size()];
        if values.len() < PARALLEL_NUMBERS {
            self.decode_into(order, bytes, &mut values);
        } else {
            let chunks = bytes.par_chunks(CHUNK_NUMBERS * self.size());
            values
                .par_chunks_mut(CHUNK_NUMBERS)
                .zip(chunks)
                .for_each(|(values, bytes)| self.decode_into(order, bytes, values));
        }
        values
    }

    /// The numbers of a map whose columns follow each other in `bytes`, in the order of rows.
    pub(crate) fn decode_columns(self, order: ByteOrder, bytes: &[u8], (ny, nx): (usize, usize)) -> Vec<f64> {
        let mut values = vec![0.0; ny * nx];
        // Neighbours in a row share a line of the processor's cache.
        let mut columns = Vec::new();
        for (strip, stored) in bytes.chunks(COLUMNS_AT_ONCE * ny * self.size()).enumerate() {
            columns.clear();
            self.decode(order, stored, &mut columns);
            for (y, row) in values.chunks_mut(nx).enumerate() {
                let row = row.iter_mut().skip(strip * COLUMNS_AT_ONCE);
                row.zip(columns.iter().skip(y).step_by(ny)).for_each(|(value, &stored)| *value = stored);
            }
        }
        values
    }

    /// Appends the numbers in `bytes` to `values`, as [`Sample::decode_all`].
    pub(crate) fn decode(self, order: ByteOrder, bytes: &[u8], values: &mut Vec<f64>) {
        let start = values.len();
        values.resize(start + bytes.len() / self.size(), 0.0);
        self.decode_into(order, bytes, &mut values[start..]);
    }

    /// Decodes as many numbers as `values` has room for and `bytes` hold.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(sample: Sample, order: ByteOrder, bytes: &[u8]) -> Vec<f64> {
        sample.decode_all(order, bytes)
    }

    #[test]
    fn integers_keep_their_sign_and_order() {
        assert_eq!(decoded(Sample::I16, ByteOrder::Little, &[0xfe, 0xff, 0x00, 0x80]), [-2.0, -32768.0]);
        assert_eq!(decoded(Sample::U16, ByteOrder::Big, &[0xff, 0xfe]), [65534.0]);
        assert_eq!(decoded(Sample::I8, ByteOrder::Big, &[0x80]), [-128.0]);
        assert_eq!(decoded(Sample::I64, ByteOrder::Little, &[0xff; 8]), [-1.0]);
    }

    #[test]
    fn floats_read_in_both_orders() {
        assert_eq!(decoded(Sample::F32, ByteOrder::Big, &[0x3f, 0x80, 0, 0]), [1.0]);
        assert_eq!(decoded(Sample::F64, ByteOrder::Little, &[0, 0, 0, 0, 0, 0, 0xf0, 0xbf]), [-1.0]);
    }

    #[test]
    fn large_arrays_are_decoded_like_small_ones() {
        let count = 2 * PARALLEL_NUMBERS + 7;
        let bytes: Vec<u8> = (0..count as u32).flat_map(u32::to_be_bytes).collect();
        let values = decoded(Sample::U32, ByteOrder::Big, &bytes);
        assert!(values.len() == count && values.iter().enumerate().all(|(i, value)| *value == i as f64));
    }

    #[test]
    fn columns_become_rows() {
        // More columns than are turned at once; column 0 is 0, 1, column 1 is 2, 3.
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
