//! One file of finished blocks.
//!
//! A file is never changed. It starts with [`MAGIC`], the length and the SHA-256 of its header; the header lists the blocks
//! with their SHA-256, so a damaged block is found before it is used.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use asperity_base::monitor::RoundId;
use asperity_formats::replace_file;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

const MAGIC: &[u8; 16] = b"asperity blocks1";
/// Extension of block files.
const EXTENSION: &str = "blocks";
/// Bytes before the header: magic, length of the header, hash of the header.
const START: usize = MAGIC.len() + size_of::<u64>() + size_of::<Hash>();
/// Limit of the header, so that a damaged length does not allocate much.
const LONGEST_HEADER: u64 = 1 << 30;

pub(super) type Hash = [u8; 32];

/// Round whose blocks a file holds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Round {
    pub(super) id: u64,
    /// Name and number of blocks of the loop.
    pub(super) name: String,
    pub(super) count: usize,
    /// Number of the earlier loops of the stage with this name.
    pub(super) ordinal: u64,
}

/// Block in a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Entry {
    pub(super) round: u64,
    pub(super) index: usize,
    /// Reason of the failure that the block holds.
    pub(super) failure: Option<String>,
    /// Number of bytes.
    pub(super) length: u64,
    hash: Hash,
}

#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Header {
    pub(super) rounds: Vec<Round>,
    pub(super) entries: Vec<Entry>,
}

/// Finished block.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) round: RoundId,
    pub(super) index: usize,
    pub(super) failure: Option<String>,
    pub(super) bytes: Vec<u8>,
}

/// Writes blocks as a new file of `folder`, which appears complete or not at all.
pub(super) fn write(folder: &Path, rounds: Vec<Round>, blocks: &[Block]) -> io::Result<()> {
    let entry = |block: &Block| Entry {
        round: block.round.0,
        index: block.index,
        failure: block.failure.clone(),
        length: block.bytes.len() as u64,
        hash: Sha256::digest(&block.bytes).into(),
    };
    let header = Header { rounds, entries: blocks.iter().map(entry).collect() };
    let header = postcard::to_allocvec(&header).map_err(io::Error::other)?;
    let hash: Hash = Sha256::digest(&header).into();
    fs::create_dir_all(folder)?;
    let path = folder.join(hex(&hash[..16])).with_extension(EXTENSION);
    replace_file(&path, |file| {
        let mut file = io::BufWriter::new(file);
        file.write_all(MAGIC)?;
        file.write_all(&(header.len() as u64).to_le_bytes())?;
        file.write_all(&hash)?;
        file.write_all(&header)?;
        blocks.iter().try_for_each(|block| file.write_all(&block.bytes))?;
        file.flush()
    })?;
    sync_folder(folder)
}

/// Waits until the names in a folder are on the disk.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

/// Returns the block files of a folder, by name; none if there is no folder.
pub(super) fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == EXTENSION)).collect();
    found.sort();
    found
}

/// Reads the header of a file, and the offset of the first block. A damaged header is [`io::ErrorKind::InvalidData`].
pub(super) fn read_header(path: &Path) -> io::Result<(Header, u64)> {
    header_of(&mut File::open(path)?)
}

fn header_of(file: &mut (impl Read + Seek)) -> io::Result<(Header, u64)> {
    let damaged = || io::Error::from(io::ErrorKind::InvalidData);
    let file_length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let mut start = [0; START];
    file.read_exact(&mut start)?;
    let (magic, rest) = start.split_at(MAGIC.len());
    let (length, hash) = rest.split_at(size_of::<u64>());
    let length = u64::from_le_bytes(length.try_into().map_err(|_| damaged())?);
    if magic != MAGIC || length > LONGEST_HEADER.min(file_length) {
        return Err(damaged());
    }
    let mut header = vec![0; length as usize];
    file.read_exact(&mut header)?;
    if Sha256::digest(&header)[..] != *hash {
        return Err(damaged());
    }
    Ok((postcard::from_bytes(&header).map_err(|_| damaged())?, START as u64 + length))
}

/// Reads a block at an offset; `None` if it is damaged or cannot be read.
pub(super) fn read_block(path: &Path, offset: u64, entry: &Entry) -> Option<Vec<u8>> {
    block_of(&mut File::open(path).ok()?, offset, entry)
}

fn block_of(file: &mut (impl Read + Seek), offset: u64, entry: &Entry) -> Option<Vec<u8>> {
    let end = offset.checked_add(entry.length)?;
    if end > file.seek(SeekFrom::End(0)).ok()? {
        return None;
    }
    file.seek(SeekFrom::Start(offset)).ok()?;
    let mut bytes = vec![0; entry.length as usize];
    file.read_exact(&mut bytes).ok()?;
    (Sha256::digest(&bytes)[..] == entry.hash).then_some(bytes)
}

/// Reads every block of a file in memory, for fuzz targets.
#[cfg(fuzzing)]
pub fn read_blocks(bytes: &[u8]) {
    let mut file = io::Cursor::new(bytes);
    let Ok((header, mut offset)) = header_of(&mut file) else { return };
    for entry in header.entries {
        let _ = block_of(&mut file, offset, &entry);
        offset = offset.saturating_add(entry.length);
    }
}

/// Returns the SHA-256 of bytes as lower-case hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Returns bytes as lower-case hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> (tempfile::TempDir, Vec<u8>) {
        let folder = tempfile::tempdir().unwrap();
        let block = |index: usize, failure: Option<&str>| Block {
            round: RoundId(7),
            index,
            failure: failure.map(str::to_owned),
            bytes: vec![index as u8; 5 + index],
        };
        let rounds = vec![Round { id: 7, name: "pressure/reference".into(), count: 3, ordinal: 0 }];
        write(folder.path(), rounds, &[block(0, None), block(2, Some("no convergence"))]).unwrap();
        let bytes = fs::read(&files(folder.path())[0]).unwrap();
        (folder, bytes)
    }

    /// Returns the blocks of a file that are not damaged, with the reasons of their failures.
    fn read(path: &Path) -> Vec<(usize, Option<String>, Vec<u8>)> {
        let Ok((header, mut offset)) = read_header(path) else { return Vec::new() };
        let mut found = Vec::new();
        for entry in header.entries {
            if let Some(bytes) = read_block(path, offset, &entry) {
                found.push((entry.index, entry.failure.clone(), bytes));
            }
            offset += entry.length;
        }
        found
    }

    #[test]
    fn blocks_are_read_as_written_and_equal_ones_share_a_file() {
        let (folder, bytes) = example();
        let (other, same) = example();
        assert_eq!((files(folder.path())[0].file_name(), &bytes), (files(other.path())[0].file_name(), &same));
        let failed = (2, Some("no convergence".to_owned()), vec![2; 7]);
        assert_eq!(read(&files(folder.path())[0]), [(0, None, vec![0; 5]), failed]);
        assert!(files(&folder.path().join("none")).is_empty());
    }

    #[test]
    fn no_damage_of_a_byte_and_no_missing_end_is_read_as_numbers() {
        let (folder, bytes) = example();
        let (path, intact) = (files(folder.path())[0].clone(), read(&files(folder.path())[0]));
        let lost = |damaged: &[u8]| {
            fs::write(&path, damaged).unwrap();
            let found = read(&path);
            assert!(found.iter().all(|block| intact.contains(block)), "{found:?}");
            intact.len() - found.len()
        };
        for place in 0..bytes.len() {
            for bit in [1, 16, 128] {
                let mut damaged = bytes.clone();
                damaged[place] ^= bit;
                assert!(lost(&damaged) > 0, "byte {place}");
            }
            assert!(lost(&bytes[..place]) > 0, "length {place}");
        }
        // Bytes that follow do no harm.
        assert_eq!(lost(&[bytes, vec![0; 9]].concat()), 0);
    }
}
