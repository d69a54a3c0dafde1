//! Unpacking of strips or tiles to the numbers of a page.
//!
//! Strips and tiles are unpacked row by row, so that the memory holds no more than the page and one row.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;
use weezl::decode::{Configuration, Decoder};
use weezl::{BitOrder, LzwStatus};

use super::{Directory, Tag, tag};
use crate::archive::{beyond_reason, damage, damaged, may_unpack};
use crate::{ByteOrder, Format, Result, Sample, Shape, refuse_if};

/// Maximum number of strips or tiles of one page.
const MAX_CHUNKS: u64 = 1 << 16;
/// Maximum number of points in one row of a strip or tile.
const MAX_ROW: u64 = 1 << 20;

/// Compression of strips and tiles.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Packing {
    None,
    Lzw,
    Deflate,
    PackBits,
}

/// Transformation of the numbers before compression.
#[derive(Clone, Copy)]
enum Predictor {
    None,
    /// Differences of neighbouring numbers.
    Horizontal,
    /// Differences of neighbouring bytes, after grouping the bytes of a row by significance.
    FloatingPoint,
}

/// Strips or tiles of a page.
struct Chunks {
    /// Number of columns and rows of each.
    shape: (usize, usize),
    /// Number of strips or tiles side by side.
    across: usize,
    offsets: Vec<u64>,
    /// Packed sizes in bytes; empty without compression.
    sizes: Vec<u64>,
}

/// Returns the numbers of a page in row order.
///
/// # Errors
/// Unsupported compression, strips and tiles beyond the end of the file, damaged streams.
pub(super) fn decode(directory: &Directory, (ny, nx): Shape, sample: Sample, order: ByteOrder) -> Result<Vec<f64>> {
    let input = directory.input;
    if directory.integer(tag::FILL_ORDER)?.is_some_and(|order| order != 1) {
        return Err(input.unsupported("the bits of every byte are reversed (FillOrder 2)", "FillOrder 1"));
    }
    let packing = packing(directory)?;
    let predictor = predictor(directory, packing, sample)?;
    let chunks = chunks(directory, (ny, nx), sample, packing)?;
    let mut values = vec![f64::NAN; ny * nx];
    let mut row = vec![0; chunks.shape.0 * sample.size()];
    let mut numbers = Vec::with_capacity(chunks.shape.0);
    for (place, &offset) in chunks.offsets.iter().enumerate() {
        let (left, top) = (place % chunks.across * chunks.shape.0, place / chunks.across * chunks.shape.1);
        let rows = chunks.shape.1.min(ny - top);
        let columns = chunks.shape.0.min(nx - left);
        let name = format!("strip or tile {place}");
        let size = match packing {
            Packing::None => rows * row.len(),
            _ => chunks.sizes.get(place).map_or(0, |&size| usize::try_from(size).unwrap_or(usize::MAX)),
        };
        let bytes = input.take(&name, usize::try_from(offset).unwrap_or(usize::MAX), size)?;
        let mut source = unpacked(bytes, packing);
        for y in top..top + rows {
            source.read_exact(&mut row).map_err(|error| damaged(Format::Tiff, &name, damage(&error)))?;
            numbers.clear();
            match predictor {
                Predictor::None => sample.decode(order, &row, &mut numbers),
                Predictor::Horizontal => {
                    add_neighbours(&mut row, sample.size(), order);
                    sample.decode(order, &row, &mut numbers);
                }
                Predictor::FloatingPoint => {
                    sample.decode(ByteOrder::Big, &ungroup_bytes(&mut row, sample.size()), &mut numbers);
                }
            }
            values[y * nx + left..y * nx + left + columns].copy_from_slice(&numbers[..columns]);
        }
    }
    Ok(values)
}

fn packing(directory: &Directory) -> Result<Packing> {
    let found = match directory.integer(tag::COMPRESSION)? {
        None | Some(1) => return Ok(Packing::None),
        Some(5) => return Ok(Packing::Lzw),
        // 32946 is the number of Deflate before its registration.
        Some(8 | 32946) => return Ok(Packing::Deflate),
        Some(32773) => return Ok(Packing::PackBits),
        Some(2..=4) => "fax".to_owned(),
        Some(6 | 7) => "JPEG".to_owned(),
        Some(34712 | 33003 | 33005) => "JPEG 2000".to_owned(),
        Some(34887) => "LERC".to_owned(),
        Some(34925) => "LZMA".to_owned(),
        Some(50000) => "Zstandard".to_owned(),
        Some(number) => format!("the method of number {number}"),
    };
    let wanted = "no compression, LZW, Deflate or PackBits";
    Err(directory.input.unsupported(format!("the page is compressed by {found}"), wanted))
}

/// Returns the predictor. The specification defines it for LZW only, libtiff for LZW and Deflate; files with other
/// compression may state one that was never applied.
fn predictor(directory: &Directory, packing: Packing, sample: Sample) -> Result<Predictor> {
    if matches!(packing, Packing::None | Packing::PackBits) {
        return Ok(Predictor::None);
    }
    match directory.integer(tag::PREDICTOR)? {
        None | Some(1) => Ok(Predictor::None),
        Some(2) => Ok(Predictor::Horizontal),
        Some(3) if sample.is_float() => Ok(Predictor::FloatingPoint),
        Some(other) => Err(directory.wrong(tag::PREDICTOR, other, "1, 2, or 3 for floating-point numbers")),
    }
}

/// Returns the places of strips or tiles, checked against the size of the file.
fn chunks(directory: &Directory, (ny, nx): Shape, sample: Sample, packing: Packing) -> Result<Chunks> {
    let input = directory.input;
    let is_tiled = directory.integer(tag::TILE_WIDTH)?.is_some();
    let dimension = |tag: Tag, default: u64| {
        let found = directory.integer(tag)?.unwrap_or(default);
        if found > 0 { Ok(found) } else { Err(directory.wrong(tag, found, "1 or more")) }
    };
    let (width, height, at, sizes_at) = if is_tiled {
        let (width, height) = (dimension(tag::TILE_WIDTH, 1)?, dimension(tag::TILE_LENGTH, 1)?);
        (width, height, tag::TILE_OFFSETS, tag::TILE_BYTE_COUNTS)
    } else {
        let height = dimension(tag::ROWS_PER_STRIP, u64::MAX)?.min(ny as u64);
        (nx as u64, height, tag::STRIP_OFFSETS, tag::STRIP_BYTE_COUNTS)
    };
    let (across, down) = ((nx as u64).div_ceil(width), (ny as u64).div_ceil(height));
    let count = across * down;
    if width > MAX_ROW || count > MAX_CHUNKS {
        let found = format!("{count} strips or tiles with rows of {width}");
        return Err(directory.wrong(at, found, &format!("at most {MAX_CHUNKS} with rows of at most {MAX_ROW}")));
    }
    let listed = |tag: Tag| match directory.integers(tag, count)? {
        Some(numbers) if numbers.len() as u64 == count => Ok(numbers),
        found => {
            let found = found.map_or(0, |numbers| numbers.len());
            Err(directory.wrong(tag, format!("{found} numbers"), &format!("{count} numbers")))
        }
    };
    let offsets = listed(at)?;
    let sizes = if packing == Packing::None { Vec::new() } else { listed(sizes_at)? };
    // Tiles are complete, also beyond the lower edge of the page.
    let rows = if is_tiled { down.saturating_mul(height) } else { ny as u64 };
    let points = (across * width).saturating_mul(rows);
    let unpacked = points.saturating_mul(sample.size() as u64);
    let present = input.len() as u64;
    if packing == Packing::None {
        if unpacked > present {
            return Err(directory.wrong(at, format!("places for {unpacked} bytes"), &format!("at most {present}")));
        }
    } else {
        let packed = sizes.iter().fold(0_u64, |sum, &size| sum.saturating_add(size));
        if packed > present {
            let found = format!("{packed} bytes in strips or tiles");
            return Err(directory.wrong(sizes_at, found, &format!("at most the {present} of the file")));
        }
        refuse_if!(!may_unpack(packed, points, unpacked), beyond_reason(Format::Tiff, "the page", packed, unpacked));
    }
    Ok(Chunks { shape: (width as usize, height.min(rows) as usize), across: across as usize, offsets, sizes })
}

fn unpacked<'a>(bytes: &'a [u8], packing: Packing) -> Box<dyn Read + 'a> {
    match packing {
        Packing::None => Box::new(bytes),
        Packing::Deflate => Box::new(ZlibDecoder::new(bytes)),
        Packing::PackBits => Box::new(PackBits { bytes, literal: 0, repeat: 0 }),
        Packing::Lzw => Box::new(Lzw {
            bytes,
            decoder: Configuration::with_tiff_size_switch(BitOrder::Msb, 8).with_yield_on_full_buffer(true).build(),
        }),
    }
}

/// LZW stream as in TIFF 6.0: codes from the highest bit on, of a width that grows one code early.
struct Lzw<'a> {
    bytes: &'a [u8],
    decoder: Decoder,
}

impl Read for Lzw<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        loop {
            let step = self.decoder.decode_bytes(self.bytes, buffer);
            self.bytes = self.bytes.get(step.consumed_in..).unwrap_or_default();
            match step.status {
                Err(error) => return Err(io::Error::new(io::ErrorKind::InvalidData, error)),
                Ok(LzwStatus::Ok | LzwStatus::NoProgress) if step.consumed_out == 0 && step.consumed_in > 0 => (),
                Ok(_) => return Ok(step.consumed_out),
            }
        }
    }
}

/// PackBits stream (TIFF 6.0, section 9): pieces of 1 to 128 bytes, either literal or one repeated byte.
struct PackBits<'a> {
    bytes: &'a [u8],
    /// Number of bytes left in a literal piece.
    literal: usize,
    /// Number of repetitions left of the next byte.
    repeat: usize,
}

impl Read for PackBits<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.literal == 0 && self.repeat == 0 {
            let Some((&head, rest)) = self.bytes.split_first() else { return Ok(0) };
            self.bytes = rest;
            match head {
                0..=127 => self.literal = usize::from(head) + 1,
                128 => (),
                129.. => self.repeat = 257 - usize::from(head),
            }
        }
        if self.literal > 0 {
            let length = self.literal.min(buffer.len()).min(self.bytes.len());
            buffer[..length].copy_from_slice(&self.bytes[..length]);
            self.bytes = &self.bytes[length..];
            self.literal -= length;
            return Ok(length);
        }
        let Some(&byte) = self.bytes.first() else { return Ok(0) };
        let length = self.repeat.min(buffer.len());
        buffer[..length].fill(byte);
        self.repeat -= length;
        if self.repeat == 0 {
            self.bytes = &self.bytes[1..];
        }
        Ok(length)
    }
}

/// Sums up differences of neighbouring numbers, as integers of `size` bytes.
fn add_neighbours(row: &mut [u8], size: usize, order: ByteOrder) {
    macro_rules! add {
        ($number:ty) => {{
            let mut sum: $number = 0;
            for raw in row.as_chunks_mut::<{ size_of::<$number>() }>().0 {
                *raw = match order {
                    ByteOrder::Little => {
                        sum = sum.wrapping_add(<$number>::from_le_bytes(*raw));
                        sum.to_le_bytes()
                    }
                    ByteOrder::Big => {
                        sum = sum.wrapping_add(<$number>::from_be_bytes(*raw));
                        sum.to_be_bytes()
                    }
                };
            }
        }};
    }
    match size {
        1 => add!(u8),
        2 => add!(u16),
        4 => add!(u32),
        _ => add!(u64),
    }
}

/// Sums up differences of bytes, grouped by significance from the highest on, and returns big-endian numbers
/// (Technical Note 3 of TIFF).
fn ungroup_bytes(row: &mut [u8], size: usize) -> Vec<u8> {
    let mut sum = 0_u8;
    for byte in row.iter_mut() {
        sum = sum.wrapping_add(*byte);
        *byte = sum;
    }
    let columns = row.len() / size;
    let mut numbers = Vec::with_capacity(row.len());
    for column in 0..columns {
        numbers.extend((0..size).map(|place| row[place * columns + column]));
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_packbits_example_of_the_specification_unpacks() {
        // TIFF 6.0, section 9.
        let packed = [0xfe, 0xaa, 0x02, 0x80, 0x00, 0x2a, 0xfd, 0xaa, 0x03, 0x80, 0x00, 0x2a, 0x22, 0xf7, 0xaa];
        let wanted = [
            0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0x22, 0xaa, 0xaa, 0xaa, 0xaa,
            0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa,
        ];
        let mut found = Vec::new();
        unpacked(&packed, Packing::PackBits).read_to_end(&mut found).unwrap();
        assert_eq!(found, wanted);
    }

    #[test]
    fn the_lzw_example_of_the_specification_unpacks() {
        // TIFF 6.0, section 13: Clear 7 258 8 8 258 6 6 End, nine bits each.
        let codes = [256_u32, 7, 258, 8, 8, 258, 6, 6, 257];
        let bits: Vec<bool> = codes.iter().flat_map(|code| (0..9).rev().map(move |bit| code >> bit & 1 == 1)).collect();
        let packed: Vec<u8> = bits
            .chunks(8)
            .map(|byte| byte.iter().enumerate().map(|(i, &bit)| u8::from(bit) << (7 - i)).sum())
            .collect();
        let mut found = Vec::new();
        unpacked(&packed, Packing::Lzw).read_to_end(&mut found).unwrap();
        assert_eq!(found, [7, 7, 7, 8, 8, 7, 7, 6, 6]);
    }

    #[test]
    fn differences_are_summed_in_either_order() {
        let mut little = [1, 1, 0xff, 0xff, 2, 0];
        add_neighbours(&mut little, 2, ByteOrder::Little);
        assert_eq!(little, [1, 1, 0, 1, 2, 1]);
        let mut big = [1, 1, 0xff, 0xff, 0, 2];
        add_neighbours(&mut big, 2, ByteOrder::Big);
        assert_eq!(big, [1, 1, 1, 0, 1, 2]);
    }
}
