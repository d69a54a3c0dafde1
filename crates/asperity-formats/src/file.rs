//! Files on disk: what kind they are, and how they are replaced.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::text::Separator;
use crate::{Format, FormatError, Location, Scan, X3pData, npy, sur, text, write_npy, write_text, write_x3p, x3p};

/// The largest file that is read, in bytes: twice the heights of the largest map as `f64`.
const MAX_FILE_BYTES: u64 = 2 * 8 * crate::MAX_POINTS;
/// Bytes that an error shows of content it does not know.
const SHOWN_BYTES: usize = 12;

/// Reads a file of any known format; the content decides which.
///
/// # Errors
/// [`FormatError::NotFound`], [`FormatError::Io`], or [`FormatError::File`] around what [`read_bytes`] says.
pub fn read(path: &Path) -> Result<Scan, FormatError> {
    let file = File::open(path).map_err(|error| FormatError::io(path, error))?;
    let mut bytes = Vec::new();
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(|error| FormatError::io(path, error))?;
    read_bytes(&bytes).map_err(|error| error.in_file(path))
}

/// Reads the content of a file of any known format.
///
/// # Errors
/// What is wrong with the content: the format, the field, where it stands, what was found and wanted.
pub fn read_bytes(bytes: &[u8]) -> Result<Scan, FormatError> {
    let scan = match Format::detect(bytes) {
        Some(format) if bytes.len() as u64 > MAX_FILE_BYTES => Err(FormatError::TooLarge {
            format,
            field: "the file's size in bytes".into(),
            at: Location::Byte(0),
            found: bytes.len() as u64,
            limit: MAX_FILE_BYTES,
        }),
        Some(Format::X3p) => x3p::read(bytes),
        Some(Format::Sur) => sur::read(bytes),
        Some(Format::Npy) => npy::read(bytes),
        Some(Format::Text) => text::read(bytes),
        None => {
            let start = bytes[..bytes.len().min(SHOWN_BYTES)].escape_ascii();
            Err(FormatError::Unrecognised { length: bytes.len(), start: format!("`{start}`") })
        }
    }?;
    Ok(scan.checked())
}

/// Writes a scan in the format of the path's extension: `.x3p` (float64), `.npy`, `.txt` and `.dat` (space separated) or
/// `.csv` (comma separated). Only X3P keeps the pixel size and the metadata.
///
/// The file appears whole or not at all: the bytes go to a temporary file beside it, which then takes its name.
///
/// # Errors
/// [`FormatError::File`] around an unknown extension or what the format cannot store; [`FormatError::Io`] or
/// [`FormatError::NotFound`] (no such folder) from the operating system.
pub fn write(scan: &Scan, path: &Path) -> Result<(), FormatError> {
    let extension =
        path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let bytes = match Format::from_extension(&extension) {
        Some(Format::X3p) => write_x3p(scan, X3pData::Float64),
        Some(Format::Npy) => Ok(write_npy(scan)),
        Some(Format::Text) if extension == "csv" => Ok(write_text(scan, Separator::Comma)),
        Some(Format::Text) => Ok(write_text(scan, Separator::Space)),
        Some(Format::Sur) | None => Err(FormatError::UnknownExtension { extension }),
    };
    replace(path, &bytes.map_err(|error| error.in_file(path))?)
}

/// Puts `bytes` under `path` so that a reader sees the old content or the new, never a part.
fn replace(path: &Path, bytes: &[u8]) -> Result<(), FormatError> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    let unique = COUNTER.fetch_add(1, Ordering::Relaxed);
    let temporary = path.with_file_name(format!(".{name}.{}-{unique}.tmp", std::process::id()));
    let written = OpenOptions::new().write(true).create_new(true).open(&temporary).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    written.and_then(|()| fs::rename(&temporary, path)).map_err(|error| {
        // The first error is the one to tell; a temporary file that was never made cannot be removed.
        let _ = fs::remove_file(&temporary);
        FormatError::io(path, error)
    })
}
