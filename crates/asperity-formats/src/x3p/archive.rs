//! The zip archive: which file is meant, and how much of it may be unpacked.

use std::io::{Cursor, Read};

use md5::{Digest, Md5};
use zip::ZipArchive;
use zip::read::ZipFile;

use super::{MAIN, archive_error, hexadecimal};
use crate::sample::{ByteOrder, Sample};
use crate::{Format, FormatError, Location};

/// A deflated stream cannot grow by more than this factor (258 bytes from 2 bits, RFC 1951).
const DEFLATE_RATIO: u64 = 1032;
/// Bytes unpacked at a time.
const CHUNK_BYTES: usize = 1 << 16;
/// Numbers that memory is reserved for before any has been unpacked.
const RESERVED_NUMBERS: usize = 1 << 20;
/// Files that a desktop leaves in archives beside the real ones.
const DESKTOP_FOLDER: &str = "__MACOSX/";

/// An archive and the folder inside it that holds `main.xml`.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes of the archive: what an entry says of its packed size is not to be believed beyond.
    packed_bytes: u64,
    names: Vec<String>,
    folder: String,
}

/// Heights or other numbers from one file of the archive.
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    /// MD5 of the whole file, `None` when it is longer than was asked for.
    pub(super) md5: Option<String>,
}

impl<'a> Archive<'a> {
    /// Opens an archive and looks for the `main.xml` nearest to its root.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|error| archive_error("archive", error))?;
        // Some writers separate folders with backslashes; names that cannot be decoded match nothing.
        let names: Vec<String> =
            zip.file_names().map(|name| name.map(|name| name.replace('\\', "/")).unwrap_or_default()).collect();
        let folder_of = |name: &String| {
            let folder = name.strip_suffix(MAIN)?;
            ((folder.is_empty() || folder.ends_with('/')) && !folder.starts_with(DESKTOP_FOLDER))
                .then(|| folder.to_owned())
        };
        let folder = names.iter().filter_map(folder_of).min_by_key(|folder| folder.matches('/').count());
        let folder = folder.ok_or_else(|| archive_error("archive", "it holds no main.xml"))?;
        Ok(Self { zip, packed_bytes: bytes.len() as u64, names, folder })
    }

    /// The index of a file that `main.xml` links to, by its path beside `main.xml`.
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

    fn entry(&mut self, link: &str) -> Result<ZipFile<'_, Cursor<&'a [u8]>>, FormatError> {
        let index = self.index(link).ok_or_else(|| archive_error(link, "no such file in the archive"))?;
        self.zip.by_index(index).map_err(|error| archive_error(link, error))
    }

    /// Whether the archive holds a file.
    pub(super) fn contains(&self, link: &str) -> bool {
        self.index(link).is_some()
    }

    /// The whole content of a file that must not be longer than `limit` bytes.
    pub(super) fn read_whole(&mut self, link: &str, limit: u64) -> Result<Vec<u8>, FormatError> {
        let entry = self.entry(link)?;
        let mut bytes = Vec::new();
        entry.take(limit + 1).read_to_end(&mut bytes).map_err(|error| archive_error(link, error))?;
        if bytes.len() as u64 > limit {
            return Err(FormatError::TooLarge {
                format: Format::X3p,
                field: "the file's size in bytes".into(),
                at: Location::Entry { entry: link.into(), offset: 0 },
                found: bytes.len() as u64,
                limit,
            });
        }
        Ok(bytes)
    }

    /// The first `count` numbers of a file that should hold `total` of them.
    ///
    /// Sizes that the packed bytes cannot reach are refused at once, and memory grows with what is unpacked.
    pub(super) fn read_numbers(
        &mut self,
        link: &str,
        sample: Sample,
        count: usize,
        total: u64,
    ) -> Result<Numbers, FormatError> {
        let packed_bytes = self.packed_bytes;
        let mut entry = self.entry(link)?;
        let wanted = count as u64 * sample.size() as u64;
        let truncated = |found: u64| FormatError::Truncated {
            format: Format::X3p,
            part: link.into(),
            at: Location::Entry { entry: link.into(), offset: 0 },
            found,
            wanted,
        };
        let reachable = entry.compressed_size().min(packed_bytes).saturating_mul(DEFLATE_RATIO);
        if reachable < wanted {
            return Err(truncated(entry.size().min(reachable)));
        }
        let mut values = Vec::with_capacity(count.min(RESERVED_NUMBERS));
        let mut md5 = Md5::new();
        let mut chunk = vec![0; CHUNK_BYTES];
        let mut found = 0;
        while found < wanted {
            let room = chunk.len().min(usize::try_from(wanted - found).unwrap_or(usize::MAX));
            let filled = fill(&mut entry, &mut chunk[..room]).map_err(|error| archive_error(link, error))?;
            found += filled as u64;
            if filled < room {
                return Err(truncated(found));
            }
            md5.update(&chunk[..filled]);
            // A chunk is a multiple of every number's size, so no number is cut.
            sample.decode(ByteOrder::Little, &chunk[..filled], &mut values);
        }
        let size = total.saturating_mul(sample.size() as u64);
        loop {
            let filled = fill(&mut entry, &mut chunk).map_err(|error| archive_error(link, error))?;
            found += filled as u64;
            md5.update(&chunk[..filled]);
            if filled == 0 || found > size {
                break;
            }
        }
        Ok(Numbers { values, md5: (found <= size).then(|| hexadecimal(&md5.finalize())) })
    }
}

/// Reads until the buffer is full or the source ends; the number of bytes read.
fn fill(source: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match source.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => (),
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}
