//! Zip archives and compressed streams: search for files, and limits of unpacking.

use std::cmp::Ordering;
use std::io::{self, Cursor, Read, Write};

use flate2::read::{MultiGzDecoder, ZlibDecoder};
use md5::{Digest, Md5};
use ruzstd::decoding::StreamingDecoder;
use zip::read::ZipFile;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

use crate::{ByteOrder, Format, FormatError, Location, MAX_POINTS, Result, Sample, large, refuse_if, shown};

/// Size in bytes that every stream may unpack to.
const FREE_BYTES: u64 = 1 << 23;
/// Above [`FREE_BYTES`], maximum ratio of unpacked to packed size. Maps of instruments reach 2 to 20.
const MAX_RATIO: u64 = 64;
/// Number of values that every stream may unpack to: a map of 2048 × 2048.
const FREE_NUMBERS: u64 = 1 << 22;
/// Above [`FREE_NUMBERS`], maximum ratio of unpacked to packed size for streams of numbers. Ideal gratings reach
/// hundreds; the limit of Deflate is 1032 (258 bytes from 2 bits, RFC 1951).
const MAX_RATIO_OF_NUMBERS: u64 = 256;
/// Size of an unpacked chunk in bytes, a multiple of the size of every number type.
pub(crate) const CHUNK_BYTES: usize = 1 << 16;
/// Number of values that memory is reserved for before unpacking, if the packed bytes do not hold more.
pub(crate) const RESERVED_NUMBERS: usize = 1 << 20;
/// Folder with files that a desktop adds to archives.
const DESKTOP_FOLDER: &str = "__MACOSX/";

/// Message for the usual damage of an archive. Its directory is at its end, which an incomplete download lacks.
pub(crate) const NO_DIRECTORY: &str =
    "the zip archive has no valid directory at its end; the file is cut off or damaged";

/// Largest part of a Zstandard stream that its decoder may keep.
const MAX_WINDOW_BYTES: u64 = 1 << 24;

/// Returns the maximum unpacked size of `packed` bytes.
pub(crate) fn unpacked_limit(packed: u64) -> u64 {
    packed.saturating_mul(MAX_RATIO).clamp(FREE_BYTES, 2 * 8 * MAX_POINTS)
}

/// Returns whether `packed` bytes may unpack to `count` numbers of `bytes` bytes in total.
pub(crate) fn may_unpack(packed: u64, count: u64, bytes: u64) -> bool {
    count <= FREE_NUMBERS || bytes <= packed.saturating_mul(MAX_RATIO_OF_NUMBERS)
}

/// Returns whether `packed` bytes may unpack to `numbers` values of a type.
pub(crate) fn may_hold(packed: u64, numbers: u64, sample: Sample) -> bool {
    may_unpack(packed, numbers, numbers.saturating_mul(sample.size() as u64))
}

/// Returns the error for `packed` bytes that exceed the limit of [`may_unpack`].
pub(crate) fn beyond_reason(format: Format, entry: &str, packed: u64, wanted: u64) -> FormatError {
    let reason = format!("{packed} bytes would unpack to {wanted}, more than {MAX_RATIO_OF_NUMBERS} times as many");
    damaged(format, entry, reason)
}

/// Zip archive, and the folder in it that holds the files of a format.
pub(crate) struct Archive<'a> {
    format: Format,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Size of the archive in bytes: an upper limit of the packed sizes that entries declare.
    packed_bytes: u64,
    names: Vec<String>,
    folder: String,
}

/// A part of a file in the archive.
struct Part<'a> {
    /// Name of the part in messages.
    name: &'a str,
    /// Offset of its first byte in the unpacked file.
    start: u64,
    /// Number of bytes.
    length: u64,
    /// Declared size of the whole file. `None` skips the rest of the file and its checksum.
    total: Option<u64>,
}

/// Result of unpacking a file.
pub(crate) struct Unpacked {
    /// MD5 of the whole file in hexadecimal digits. `None` if the file is longer than declared.
    pub(crate) md5: Option<String>,
    /// Number of unpacked bytes: the size of the file if there is a checksum.
    pub(crate) length: u64,
}

impl<'a> Archive<'a> {
    /// Opens an archive.
    ///
    /// # Errors
    /// [`FormatError::Archive`] if the bytes are not a zip archive.
    pub(crate) fn open(format: Format, bytes: &'a [u8]) -> Result<Self> {
        let zip =
            ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(format, "archive", damage_of_zip(&error)))?;
        // Some writers separate folders with backslashes. Names that cannot be decoded match nothing.
        let names: Vec<String> =
            zip.file_names().map(|name| name.map(|name| name.replace('\\', "/")).unwrap_or_default()).collect();
        Ok(Self { format, zip, packed_bytes: bytes.len() as u64, names, folder: String::new() })
    }

    /// Returns the names of the files, with `/` between folders.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Enters the folder that holds `main`, the nearest to the root. Later links are relative to it.
    ///
    /// # Errors
    /// [`FormatError::Archive`] if there is no such file.
    pub(crate) fn enter_folder_of(&mut self, main: &str) -> Result<()> {
        let folder_of = |name: &String| {
            let folder = name.strip_suffix(main)?;
            ((folder.is_empty() || folder.ends_with('/')) && !folder.starts_with(DESKTOP_FOLDER))
                .then(|| folder.to_owned())
        };
        let folder = self.names.iter().filter_map(folder_of).min_by_key(|folder| folder.matches('/').count());
        self.folder = folder.ok_or_else(|| damaged(self.format, "archive", format!("it holds no {main}")))?;
        Ok(())
    }

    /// Returns the index of a linked file.
    fn index(&self, link: &str) -> Option<usize> {
        let link = link.trim().replace('\\', "/");
        let mut relative = link.as_str();
        while let Some(rest) = relative.strip_prefix("./").or_else(|| relative.strip_prefix('/')) {
            relative = rest;
        }
        let name = format!("{}{relative}", self.folder);
        let exact = self.names.iter().position(|candidate| *candidate == name);
        exact.or_else(|| self.names.iter().position(|candidate| candidate.eq_ignore_ascii_case(&name)))
    }

    fn stream(&mut self, link: &str) -> Result<ZipFile<'_, Cursor<&'a [u8]>>> {
        let format = self.format;
        let index = self.index(link).ok_or_else(|| damaged(format, link, "no such file in the archive".to_owned()))?;
        self.zip.by_index(index).map_err(|error| damaged(format, link, damage_of_zip(&error)))
    }

    /// Returns whether the archive holds a file.
    pub(crate) fn contains(&self, link: &str) -> bool {
        self.index(link).is_some()
    }

    /// Reads a whole file of at most `limit` bytes.
    ///
    /// # Errors
    /// [`FormatError::TooLarge`] above `limit` or above the limit of its packed size; [`FormatError::Archive`] if the
    /// file is absent or damaged.
    pub(crate) fn read_whole(&mut self, link: &str, limit: u64) -> Result<Vec<u8>> {
        let (format, packed_bytes) = (self.format, self.packed_bytes);
        let entry = self.stream(link)?;
        let limit = limit.min(unpacked_limit(entry.compressed_size().min(packed_bytes)));
        let too_large =
            |found| FormatError::too_large(format, "the file's size in bytes", place(link, 0), found, limit);
        refuse_if!(entry.size() > limit, too_large(entry.size()));
        let mut bytes = Vec::new();
        entry.take(limit + 1).read_to_end(&mut bytes).map_err(|error| damaged(format, link, damage(&error)))?;
        refuse_if!(bytes.len() as u64 > limit, too_large(bytes.len() as u64));
        Ok(bytes)
    }

    /// Reads the first bytes of a file, at most `length`.
    ///
    /// # Errors
    /// [`FormatError::Archive`] if the file is absent or damaged.
    pub(crate) fn read_start(&mut self, link: &str, length: usize) -> Result<Vec<u8>> {
        let format = self.format;
        let mut bytes = Vec::with_capacity(length);
        let read = self.stream(link)?.take(length as u64).read_to_end(&mut bytes);
        read.map_err(|error| damaged(format, link, damage(&error)))?;
        Ok(bytes)
    }

    /// Reads `count` numbers of a file from byte `start` on.
    ///
    /// # Errors
    /// As [`Archive::read_numbers`].
    pub(crate) fn read_array(
        &mut self,
        link: &str,
        start: usize,
        number: (Sample, ByteOrder),
        count: usize,
    ) -> Result<Vec<f64>> {
        let length = (count * number.0.size()) as u64;
        let part = Part { name: "the numbers", start: start as u64, length, total: None };
        Ok(self.unpack_numbers(link, &part, number, count as u64)?.0)
    }

    /// Reads the numbers of a part of a file whose first `reached` numbers must be plausible for its packed size.
    fn unpack_numbers(
        &mut self,
        link: &str,
        part: &Part,
        (sample, order): (Sample, ByteOrder),
        reached: u64,
    ) -> Result<(Vec<f64>, Unpacked)> {
        // The size of the archive limits the memory that is reserved.
        let held = usize::try_from(self.packed_bytes).unwrap_or(usize::MAX) / sample.size();
        let count = usize::try_from(part.length).unwrap_or(usize::MAX) / sample.size();
        let mut values = large::with_capacity(count.min(RESERVED_NUMBERS.max(held)));
        // Chunks are multiples of the size of every number, so no number is cut.
        let take = |chunk: &[u8]| sample.decode(order, chunk, &mut values);
        let unpacked = self.unpack(link, part, |packed| may_hold(packed, reached, sample), take)?;
        Ok((values, unpacked))
    }

    /// Reads `count` little-endian numbers, after the first `skipped` ones, of a file that should hold `total`
    /// numbers.
    ///
    /// Sizes that the packed bytes cannot reach are refused before unpacking. Memory grows with the unpacked bytes.
    ///
    /// # Errors
    /// [`FormatError::Truncated`] if the file ends before the last number; [`FormatError::Archive`] if it is absent,
    /// damaged or beyond the limits of unpacking.
    pub(crate) fn read_numbers(
        &mut self,
        link: &str,
        sample: Sample,
        skipped: u64,
        count: usize,
        total: u64,
    ) -> Result<(Vec<f64>, Unpacked)> {
        let bytes = |numbers: u64| numbers.saturating_mul(sample.size() as u64);
        let numbers = skipped.saturating_add(count as u64);
        let (start, length, total) = (bytes(skipped), bytes(count as u64), Some(bytes(total)));
        let part = Part { name: "the numbers", start, length, total };
        self.unpack_numbers(link, &part, (sample, ByteOrder::Little), numbers)
    }

    /// Reads `length` bytes, after the first `start` ones, of a file that should hold `total` bytes.
    ///
    /// The ratio of unpacked to packed size is not limited: use it only for parts whose size another file confirms.
    ///
    /// # Errors
    /// [`FormatError::Truncated`] if the file ends early; [`FormatError::Archive`] if it is absent or damaged.
    pub(crate) fn read_part(
        &mut self,
        link: &str,
        name: &str,
        (start, length): (u64, usize),
        total: u64,
    ) -> Result<(Vec<u8>, Unpacked)> {
        let mut bytes = Vec::new();
        let part = Part { name, start, length: length as u64, total: Some(total) };
        let unpacked = self.unpack(link, &part, |_| true, |chunk: &[u8]| bytes.extend(chunk))?;
        Ok((bytes, unpacked))
    }

    /// Passes a part of a file to `take` in chunks, then reads to the end of the file for the checksum.
    ///
    /// `is_reachable` checks the packed size.
    fn unpack(
        &mut self,
        link: &str,
        part: &Part,
        is_reachable: impl Fn(u64) -> bool,
        mut take: impl FnMut(&[u8]),
    ) -> Result<Unpacked> {
        let (format, packed_bytes) = (self.format, self.packed_bytes);
        let mut entry = self.stream(link)?;
        let end = part.start.saturating_add(part.length);
        let truncated = |found: u64| {
            let found = found.saturating_sub(part.start);
            FormatError::truncated(format, part.name, place(link, part.start), found, part.length)
        };
        refuse_if!(entry.size() < end, truncated(entry.size()));
        let packed = entry.compressed_size().min(packed_bytes);
        refuse_if!(!is_reachable(packed), beyond_reason(format, link, packed, end));
        let limit = part.total.map_or(0, |total| total.min(end.saturating_add(unpacked_limit(packed))));
        let (mut md5, mut chunk, mut found) = (part.total.map(|_| Md5::new()), Vec::with_capacity(CHUNK_BYTES), 0);
        loop {
            // No chunk crosses a border of the part.
            let border = [part.start, end, u64::MAX].into_iter().find(|&border| found < border).unwrap_or(found);
            let room = CHUNK_BYTES.min(usize::try_from(border - found).unwrap_or(usize::MAX));
            chunk.clear();
            let read = entry.by_ref().take(room as u64).read_to_end(&mut chunk);
            let filled = read.map_err(|error| damaged(format, link, damage(&error)))?;
            if let Some(md5) = &mut md5 {
                md5.update(&chunk);
            }
            if (part.start..end).contains(&found) {
                take(&chunk);
            }
            found += filled as u64;
            refuse_if!(filled < room && found < end, truncated(found));
            if filled < room || found > limit.max(end) || part.total.is_none() && found == end {
                let md5 = md5.filter(|_| found <= limit).map(|md5| hexadecimal(&md5.finalize()));
                return Ok(Unpacked { md5, length: found });
            }
        }
    }
}

/// Writes a zip archive whose bytes depend only on its files, not on clock or host.
pub(crate) fn written(
    files: &[(&str, &[u8])],
    method: CompressionMethod,
    level: Option<i64>,
) -> Result<Vec<u8>, ZipError> {
    let options = SimpleFileOptions::default()
        .compression_method(method)
        .compression_level(level)
        .last_modified_time(DateTime::default())
        .system(System::Unix)
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for &(name, bytes) in files {
        zip.start_file(name, options.large_file(u32::try_from(bytes.len()).is_err()))?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// First bytes of a gzip stream.
pub(crate) const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Unpacks a gzip stream, and one in it.
///
/// # Errors
/// [`FormatError::TooLarge`] above the limit of its packed size, [`FormatError::Archive`] for a damaged stream.
pub(crate) fn gunzip(bytes: &[u8]) -> Result<Vec<u8>> {
    let limit = unpacked_limit(bytes.len() as u64);
    let content = gunzip_up_to(limit, bytes)?;
    if content.starts_with(&GZIP_MAGIC) { gunzip_up_to(limit, &content) } else { Ok(content) }
}

fn gunzip_up_to(limit: u64, bytes: &[u8]) -> Result<Vec<u8>> {
    let mut content = Vec::new();
    MultiGzDecoder::new(bytes)
        .take(limit + 1)
        .read_to_end(&mut content)
        .map_err(|error| damaged(Format::Gzip, "stream", damage(&error)))?;
    if content.len() as u64 > limit {
        let (field, found) = ("the size of the content in bytes", content.len() as u64);
        return Err(FormatError::too_large(Format::Gzip, field, Location::Byte(0), found, limit));
    }
    Ok(content)
}

/// Unpacks a Zstandard stream of at most `limit` unpacked bytes.
///
/// # Errors
/// [`FormatError::TooLarge`] above `limit` or the limit of its packed size, [`FormatError::Archive`] for a damaged stream.
pub(crate) fn unpack_zstandard(format: Format, name: &str, bytes: &[u8], limit: u64) -> Result<Vec<u8>> {
    let is_damaged = || damaged(format, name, "the Zstandard stream is damaged".into());
    let limit = limit.min(unpacked_limit(bytes.len() as u64));
    let stream = StreamingDecoder::new_with_max_window_size(bytes, MAX_WINDOW_BYTES).map_err(|_| is_damaged())?;
    let mut content = Vec::new();
    stream.take(limit + 1).read_to_end(&mut content).map_err(|_| is_damaged())?;
    if content.len() as u64 > limit {
        let field = "the file's unpacked size in bytes";
        return Err(FormatError::too_large(format, field, place(name, 0), content.len() as u64, limit));
    }
    Ok(content)
}

/// Formats an MD5 sum in hexadecimal digits.
pub(crate) fn hexadecimal(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the place of a byte in a file of an archive.
fn place(link: &str, offset: u64) -> Location {
    Location::Entry { entry: shown(link), offset }
}

/// Returns the error for a damaged archive or stream.
pub(crate) fn damaged(format: Format, entry: &str, reason: String) -> FormatError {
    FormatError::Archive { format, entry: shown(entry), reason }
}

/// Appends the content of a zlib stream that should unpack to `size` bytes. An error describes the damage.
pub(crate) fn unpack(stream: &[u8], size: u64, bytes: &mut Vec<u8>) -> std::result::Result<(), String> {
    // One more byte reveals surplus bytes, and makes the decoder compare the checksum at the end.
    let unpacked = ZlibDecoder::new(stream).take(size + 1).read_to_end(bytes).map_err(|error| damage(&error))?;
    match (unpacked as u64).cmp(&size) {
        Ordering::Less => Err(format!("it unpacks to {unpacked} bytes, not to the stated {size}")),
        Ordering::Equal => Ok(()),
        Ordering::Greater => Err(format!("it unpacks to more than the stated {size} bytes")),
    }
}

/// Describes an error of a decompressor.
pub(crate) fn damage(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "the compressed stream ends early; the file is cut off".into(),
        _ => "the compressed stream is damaged".into(),
    }
}

/// Describes an error of the archive reader and writer.
pub(crate) fn damage_of_zip(error: &ZipError) -> String {
    match error {
        ZipError::Io(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            "it ends early; the file is cut off or damaged".into()
        }
        ZipError::InvalidArchive(_) => NO_DIRECTORY.into(),
        ZipError::CompressionMethodNotSupported(method) => {
            format!("it is packed by method {method}; wanted stored or deflated files")
        }
        ZipError::UnsupportedArchive(_) | ZipError::InvalidPassword => {
            "it is encrypted, split, or packed in a way that is not read".into()
        }
        _ => "it is damaged".into(),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// Returns an archive with a file of zeros that deflates to a thousandth of its size.
    fn bomb(zeros: usize) -> Vec<u8> {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        zip.start_file("zeros", zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&vec![0; zeros]).unwrap();
        zip.finish().unwrap().into_inner()
    }

    #[test]
    fn a_part_of_a_file_is_read_after_the_skipped_bytes() {
        let numbers: Vec<u8> = (0..200_000_u32).flat_map(u32::to_le_bytes).collect();
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        zip.start_file("numbers", zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&numbers).unwrap();
        let bytes = zip.finish().unwrap().into_inner();
        let mut archive = Archive::open(Format::X3p, &bytes).unwrap();
        let sum = archive.read_numbers("numbers", Sample::U32, 0, 200_000, 200_000).unwrap().1.md5;
        // Parts that cross chunks, and one at the end.
        for (skipped, count) in [(0, 1), (16_383, 3), (70_001, 50_000), (199_999, 1)] {
            let (values, found) = archive.read_numbers("numbers", Sample::U32, skipped, count, 200_000).unwrap();
            assert!(values.iter().copied().eq((0..count).map(|n| (n as u64 + skipped) as f64)));
            assert_eq!((found.md5, found.length), (sum.clone(), 800_000));
        }
        let (part, _) = archive.read_part("numbers", "a part", (65_535, 3), 800_000).unwrap();
        assert_eq!(part, numbers[65_535..65_538]);
        assert!(matches!(
            archive.read_numbers("numbers", Sample::U32, 199_999, 2, 200_001),
            Err(FormatError::Truncated { found: 4, wanted: 8, .. })
        ));
        // A file that is longer than declared has no checksum.
        assert_eq!(archive.read_numbers("numbers", Sample::U32, 0, 10, 20).unwrap().1.md5, None);
    }

    #[test]
    fn a_file_is_unpacked_up_to_its_limit() {
        let bytes = bomb(1_000_000);
        assert!(bytes.len() < 2000);
        let mut archive = Archive::open(Format::X3p, &bytes).unwrap();
        assert_eq!(archive.read_whole("zeros", 1_000_000).unwrap().len(), 1_000_000);
        assert!(matches!(archive.read_whole("zeros", 999_999), Err(FormatError::TooLarge { limit: 999_999, .. })));
    }

    #[test]
    fn numbers_that_the_packed_bytes_cannot_hold_are_refused_before_unpacking() {
        let bytes = bomb(1_000_000);
        let mut archive = Archive::open(Format::X3p, &bytes).unwrap();
        let (numbers, unpacked) = archive.read_numbers("zeros", Sample::I16, 0, 500_000, 500_000).unwrap();
        assert_eq!(numbers, vec![0.0; 500_000]);
        // MD5 of a million zero bytes, by `head -c 1000000 /dev/zero | md5sum`.
        assert_eq!(unpacked.md5.as_deref(), Some("879f4bba57ed37c9ec5e5aedf9864698"));
        assert!(matches!(
            archive.read_numbers("zeros", Sample::F64, 0, 1 << 27, 1 << 27),
            Err(FormatError::Truncated { found: 1_000_000, .. })
        ));
        assert!(matches!(
            archive.read_numbers("zeros", Sample::I16, 0, 500_001, 500_001),
            Err(FormatError::Truncated { found: 1_000_000, wanted: 1_000_002, .. })
        ));
    }
}
