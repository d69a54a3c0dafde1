//! Numbers as files store them.

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

    /// Appends the numbers in `bytes` to `values`; bytes that do not fill a number are left out.
    ///
    /// 64-bit integers beyond 2⁵³ are rounded.
    pub(crate) fn decode(self, order: ByteOrder, bytes: &[u8], values: &mut Vec<f64>) {
        macro_rules! decode {
            ($number:ty) => {{
                let (numbers, _) = bytes.as_chunks::<{ size_of::<$number>() }>();
                match order {
                    ByteOrder::Little => values.extend(numbers.iter().map(|&raw| <$number>::from_le_bytes(raw) as f64)),
                    ByteOrder::Big => values.extend(numbers.iter().map(|&raw| <$number>::from_be_bytes(raw) as f64)),
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
        let mut values = Vec::new();
        sample.decode(order, bytes, &mut values);
        values
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
    fn bytes_that_do_not_fill_a_number_are_left_out() {
        assert_eq!(decoded(Sample::I32, ByteOrder::Little, &[1, 0, 0, 0, 9, 9]), [1.0]);
    }
}
