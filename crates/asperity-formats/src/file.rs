//! Reading and writing of files on disk, and choice of the format.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use crate::archive::{GZIP_MAGIC, gunzip};
use crate::format::{read_names, written_extensions};
use crate::replace::replace_file;
use crate::text::separator::Separator;
use crate::text::write_text;
use crate::x3p::ZIP_MAGIC;
use crate::{Format, FormatError, Location, ReadOptions, Result, Scan, foreign, npy, refuse_if};

/// Largest file that is read, in bytes: twice the size of the largest map as `f64`.
const MAX_FILE_BYTES: u64 = 2 * 8 * crate::MAX_POINTS;
/// Largest other file, such as a record of friction.
const MAX_OTHER_BYTES: u64 = 1 << 30;
/// Largest file of settings, such as a study.
const MAX_SETTINGS_BYTES: u64 = 1 << 23;
/// Bytes that suffice to recognise the format, except for archives. Headers need a few hundred.
const PROBE_BYTES: u64 = 1 << 16;
/// Number of bytes that an error shows of unknown content.
const SHOWN_BYTES: usize = 12;

/// Reads a file of any known format. The content decides the format; a gzip stream around it is unpacked.
///
/// # Errors
/// [`FormatError::NotFound`], [`FormatError::Io`], or [`FormatError::File`] around an error of [`read_bytes`].
pub fn read(path: &Path) -> Result<Scan, FormatError> {
    read_with(path, &ReadOptions::default())
}

/// Reads the map that `options` select.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, options: &ReadOptions) -> Result<Scan, FormatError> {
    let content = content(path)?;
    let scan = read_as(None, &content, options).and_then(|scan| match is_point_list(path, &scan) {
        true => read_as(Some(Format::Xyz), &content, options),
        false => Ok(scan),
    });
    scan.and_then(|scan| scan.checked(options)).map_err(|error| error.in_file(path))
}

/// Reads a record along a path: a one-dimensional NPY array of numbers.
///
/// # Errors
/// As [`read`], and for other formats and arrays of other than one dimension.
pub fn read_series(path: &Path) -> Result<Vec<f64>, FormatError> {
    let bytes = content(path)?;
    let series = match Format::detect(&bytes) {
        Some(Format::Npy) => npy::read_series(&bytes),
        Some(format) => Err(FormatError::unsupported(format, "a map", "a one-dimensional NPY array")),
        None => Err(unrecognised(&bytes, bytes.len() as u64)),
    };
    series.map_err(|error| error.in_file(path))
}

/// Reads a whole file that contains no map, of at most 1 GiB. Devices and pipes may have no end.
///
/// # Errors
/// Errors of the operating system, and a file that is larger.
pub fn read_limited(path: &Path) -> io::Result<Vec<u8>> {
    at_most(MAX_OTHER_BYTES, File::open(path)?)
}

/// Reads a whole file of settings, of at most 8 MiB. Parsed, it takes a hundred times its size.
///
/// # Errors
/// Errors of the operating system, and a file that is larger.
pub fn read_settings(path: &Path) -> io::Result<Vec<u8>> {
    at_most(MAX_SETTINGS_BYTES, File::open(path)?)
}

fn at_most(limit: u64, file: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::other(format!("larger than {} MiB, the limit for such a file", limit >> 20)));
    }
    Ok(bytes)
}

/// Reads text as [`read_limited`].
///
/// # Errors
/// Also [`io::ErrorKind::InvalidData`] if it is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read_limited(path)?).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "not a text file"))
}

fn content(path: &Path) -> Result<Vec<u8>> {
    let failed = |error| FormatError::io(path, error);
    let mut file = File::open(path).map_err(failed)?;
    let mut start = Vec::new();
    (&mut file).take(PROBE_BYTES).read_to_end(&mut start).map_err(failed)?;
    // Pipes have no size.
    let size = file.metadata().map_or(0, |metadata| metadata.len()).max(start.len() as u64);
    refuse_if!(start.len() as u64 == PROBE_BYTES && !may_be_known(&start), unrecognised(&start, size).in_file(path));
    if let Some(format) = Format::detect(&start).filter(|_| size > MAX_FILE_BYTES) {
        return Err(too_large(format, size).in_file(path));
    }
    // The size that the system reports only sets the size of the buffer.
    let length = usize::try_from(size.min(MAX_FILE_BYTES)).unwrap_or_default();
    let mut bytes = match whole(&file, length) {
        Some(bytes) => {
            file.seek(SeekFrom::Start(length as u64)).map_err(failed)?;
            bytes
        }
        None => {
            start.reserve(length.saturating_sub(start.len()) + 1);
            start
        }
    };
    // The file may have grown.
    file.take(MAX_FILE_BYTES + 1 - bytes.len() as u64).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// Reads the first bytes of a large file with all threads. Returns `None` if the file is small or reading fails.
#[cfg(unix)]
fn whole(file: &File, length: usize) -> Option<Vec<u8>> {
    use rayon::prelude::*;
    use std::os::unix::fs::FileExt;

    /// File size in bytes above which all threads read, and size of the piece that each reads at a time.
    const PARALLEL_BYTES: usize = 4 << 20;
    const PIECE_BYTES: usize = 1 << 20;

    if length < PARALLEL_BYTES {
        return None;
    }
    // One more byte lets the reader find the end without more memory.
    let mut bytes = crate::large::zeros(length + 1);
    bytes.truncate(length);
    let pieces = bytes.par_chunks_mut(PIECE_BYTES).enumerate();
    pieces.try_for_each(|(place, piece)| file.read_exact_at(piece, (place * PIECE_BYTES) as u64)).ok()?;
    Some(bytes)
}

#[cfg(not(unix))]
fn whole(_file: &File, _length: usize) -> Option<Vec<u8>> {
    None
}

/// Returns whether a file that starts like this may have a known format, so that large files of other formats are not
/// read to their end. The directory of an archive is at its end; the directory of an OLE compound file may be
/// anywhere.
fn may_be_known(start: &[u8]) -> bool {
    start.starts_with(ZIP_MAGIC) || start.starts_with(foreign::OLE_MAGIC) || Format::detect(start).is_some()
}

/// Returns the error for content of unknown format in a file of `size` bytes.
fn unrecognised(bytes: &[u8], size: u64) -> FormatError {
    foreign::recognise(bytes, size).or_else(|| foreign::in_archive(bytes)).unwrap_or_else(|| {
        let start = bytes[..bytes.len().min(SHOWN_BYTES)].escape_ascii();
        FormatError::Unrecognised { length: size, start: format!("`{start}`"), known: read_names() }
    })
}

fn too_large(format: Format, size: u64) -> FormatError {
    FormatError::too_large(format, "the file's size in bytes", Location::Byte(0), size, MAX_FILE_BYTES)
}

/// Reads the content of a file of any known format.
///
/// # Errors
/// An error of the content, with the format, the field, its place, its value and the valid values;
/// [`FormatError::NoHeightUnit`] for heights without a unit that exceed the field of view in metre.
pub fn read_bytes(bytes: &[u8]) -> Result<Scan, FormatError> {
    read_bytes_with(bytes, &ReadOptions::default())
}

/// Reads the map that `options` select from the content of a file.
///
/// # Errors
/// As [`read_bytes`].
pub fn read_bytes_with(bytes: &[u8], options: &ReadOptions) -> Result<Scan, FormatError> {
    read_as(None, bytes, options)?.checked(options)
}

/// Returns whether the name of the file shows that a map of three columns is a list of points.
fn is_point_list(path: &Path, scan: &Scan) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    let is_named_so = [".xyz", ".xyz.gz"].iter().any(|end| name.ends_with(end));
    is_named_so && scan.format == Some(Format::Text) && scan.heights_m.ncols() == 3 && scan.pitch_m.is_none()
}

/// Reads content in the given format, or in the detected one. The scan is still to be [checked](Scan::checked).
fn read_as(format: Option<Format>, bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    if !bytes.starts_with(&GZIP_MAGIC) {
        return read_plain(format, bytes, options);
    }
    read_plain(format, &gunzip(bytes)?, options).map_err(|error| match error {
        FormatError::Unrecognised { length: 1.., start, known } => {
            let start = format!("{start} once unpacked");
            FormatError::Unrecognised { length: bytes.len() as u64, start, known }
        }
        error => error,
    })
}

/// Reads content that is not compressed as a whole.
pub(crate) fn read_plain(format: Option<Format>, bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let size = bytes.len() as u64;
    let detected = format.or_else(|| Format::detect(bytes)).and_then(Format::codec);
    let codec = detected.ok_or_else(|| unrecognised(bytes, size))?;
    let format = codec.format;
    refuse_if!(size > MAX_FILE_BYTES, too_large(format, size));
    let mut scan = (codec.read)(bytes, options)?;
    if scan.channels.is_empty() {
        // In a file of one map, only map number 1 exists.
        options.choose(format, &[format.name().to_owned()])?;
    }
    scan.metadata.retain(|_, text| !text.is_empty());
    if scan.is_profile() {
        // Some formats state no distance across a profile, or 0.
        scan.pitch_m = scan.pitch_m.map(|(step_m, across_m)| (step_m, if across_m > 0.0 { across_m } else { step_m }));
    }
    scan.format = Some(format);
    scan.height_unit = scan.height_unit.or_else(|| format.height_unit().map(str::to_owned));
    Ok(scan)
}

/// Writes a scan in the format of the extension of the path. [`descriptions`](crate::descriptions) lists the formats.
///
/// The file appears whole or not at all: the bytes go to a temporary file beside it, which then replaces it.
///
/// # Errors
/// [`FormatError::File`] around an unknown extension or content that the format cannot store; [`FormatError::Io`] or
/// [`FormatError::NotFound`] (no such folder) from the operating system.
pub fn write(scan: &Scan, path: &Path) -> Result<(), FormatError> {
    let bytes = to_bytes(scan, path)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    replace_file(path, |file| file.write_all(&bytes)).map_err(|error| match folder {
        // The error is about the folder, not about the file.
        Some(folder) if error.kind() == io::ErrorKind::NotFound => FormatError::io(folder, error),
        _ => FormatError::io(path, error),
    })
}

/// Returns the bytes that [`write()`] writes to the file `path`, without writing it.
///
/// # Errors
/// [`FormatError::File`] around an unknown extension or content that the format cannot store.
pub fn to_bytes(scan: &Scan, path: &Path) -> Result<Vec<u8>, FormatError> {
    let extension =
        path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let bytes = match Format::from_extension(&extension) {
        Some(Format::Text) if extension == "csv" => Ok(write_text(scan, Separator::Comma)),
        format => match format.and_then(Format::codec).and_then(|codec| codec.write) {
            Some(write) => write(scan),
            None => Err(FormatError::UnknownExtension { extension, written: written_extensions() }),
        },
    };
    bytes.map_err(|error| error.in_file(path))
}

#[cfg(test)]
mod tests {
    use super::at_most;

    #[test]
    fn a_file_without_end_is_refused() {
        assert_eq!(at_most(3, &b"abc"[..]).unwrap(), b"abc");
        assert!(at_most(3, std::io::repeat(0)).unwrap_err().to_string().contains("limit"));
    }
}
