//! Small files of every format, for tests that damage them.

use std::collections::BTreeSet;
use std::io::{Cursor, Read};

use asperity_formats::{Format, FormatError, ReadOptions, Scan};
use zip::ZipArchive;

use crate::fixtures::{gzip, md5, zip};

/// Maximum size in bytes of a file of a test that becomes a seed. Fixtures may be larger.
const SEED_BYTES: usize = 1 << 15;

/// Small file and its properties.
#[derive(Clone)]
pub(crate) struct Fixture {
    /// Format and distinguishing feature of the file.
    pub(crate) name: &'static str,
    pub(crate) content: Content,
    /// The first bytes without which the file must be refused; 0 where a beginning of it is a file as well.
    pub(crate) needed: usize,
}

/// Bytes. If only a checksum would reveal damage to them, also the bytes that the checksum covers.
#[derive(Clone)]
pub(crate) enum Content {
    Bytes(Vec<u8>),
    /// A gzip stream around bytes.
    Gzip(Vec<u8>),
    /// A zip archive of files.
    Zip(Vec<(String, Vec<u8>)>),
}

impl Fixture {
    /// A file that ends with the last byte that it needs.
    pub(crate) fn whole(name: &'static str, bytes: Vec<u8>) -> Self {
        Self { name, needed: bytes.len(), content: Content::Bytes(bytes) }
    }

    /// A file of which beginnings may be files as well.
    pub(crate) fn open_ended(name: &'static str, bytes: Vec<u8>) -> Self {
        Self { needed: 0, ..Self::whole(name, bytes) }
    }

    /// A zip archive.
    pub(crate) fn zip(name: &'static str, files: &[(&str, &[u8])]) -> Self {
        let files: Vec<_> = files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect();
        let fixture = Self { name, needed: 0, content: Content::Zip(files) };
        Self { needed: fixture.bytes().len(), ..fixture }
    }

    /// The file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.content.bytes()
    }
}

impl Content {
    pub(crate) fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Bytes(bytes) => bytes.clone(),
            Self::Gzip(bytes) => gzip(bytes),
            Self::Zip(files) => {
                let files: Vec<(&str, &[u8])> =
                    files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
                zip(&files)
            }
        }
    }
}

/// The fixtures of every format.
pub(crate) fn all() -> Vec<Fixture> {
    [
        crate::x3p::fixtures(),
        crate::sur::fixtures(),
        crate::sdf::fixtures(),
        crate::gwy::fixtures(),
        crate::opd::fixtures(),
        crate::metropro::fixtures(),
        crate::mnt::fixtures(),
        crate::datx::fixtures(),
        crate::opdx::fixtures(),
        crate::oir::fixtures(),
        crate::nanoscope::fixtures(),
        crate::ibw::fixtures(),
        crate::nid::fixtures(),
        crate::mdt::fixtures(),
        crate::wsxm::fixtures(),
        crate::zon::fixtures(),
        crate::gsf::fixtures(),
        crate::ascii::fixtures(),
        crate::plu::fixtures(),
        crate::plux::fixtures(),
        crate::al3d::fixtures(),
        crate::nms::fixtures(),
        crate::os3d::fixtures(),
        crate::zmg::fixtures(),
        crate::frt::fixtures(),
        crate::bcr::fixtures(),
        crate::tmd::fixtures(),
        crate::vk::fixtures(),
        crate::netcdf::fixtures(),
        crate::npy::fixtures(),
        crate::npz::fixtures(),
        crate::container::fixtures(),
        crate::xlsx::fixtures(),
        crate::tiff::fixtures(),
        crate::vtk::fixtures(),
        crate::xyz::fixtures(),
        crate::text::fixtures(),
        crate::gz::fixtures(),
    ]
    .concat()
}

/// Reads a file, and keeps it as a seed of fuzzing.
pub(crate) fn read_bytes(bytes: &[u8]) -> Result<Scan, FormatError> {
    read_bytes_with(bytes, &ReadOptions::default())
}

/// Reads a file with options, and keeps it as a seed of fuzzing.
pub(crate) fn read_bytes_with(bytes: &[u8], options: &ReadOptions) -> Result<Scan, FormatError> {
    if let Some(format) = Format::detect(bytes).filter(|_| bytes.len() <= SEED_BYTES) {
        keep("format", format, bytes);
        if let Some(parts) = unzip(bytes).map(|files| parts(&files)).filter(|parts| parts.len() <= SEED_BYTES) {
            keep("archive", format, &parts);
        }
    }
    asperity_formats::read_bytes_with(bytes, options)
}

/// Reads a file whose heights are stated to be in metre.
pub(crate) fn read_in_metre(bytes: &[u8]) -> Result<Scan, FormatError> {
    read_bytes_with(bytes, &ReadOptions { height_unit: Some("m".parse().unwrap()), ..ReadOptions::default() })
}

/// Reads one map of a file, by its name or number.
pub(crate) fn read_channel(bytes: &[u8], channel: &str) -> Result<Scan, FormatError> {
    read_bytes_with(bytes, &ReadOptions { channel: Some(channel.into()), ..ReadOptions::default() })
}

/// Writes a seed below the folder `ASPERITY_SEEDS`: `format-NAME` for a whole file, `archive-NAME` for the files in an
/// archive, each after a line with its name.
fn keep(kind: &str, format: Format, bytes: &[u8]) {
    let Some(seeds) = std::env::var_os("ASPERITY_SEEDS") else { return };
    // The name of a target ends at a slash, as that of a folder does.
    let name = format.name().split('/').next().unwrap();
    let folder = std::path::Path::new(&seeds).join(format!("{kind}-{name}"));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(md5(bytes)), bytes).unwrap();
}

/// Returns the names and contents of the files in a zip archive.
fn unzip(bytes: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok().filter(|_| bytes.starts_with(b"PK"))?;
    (0..archive.len())
        .map(|place| {
            let file = archive.by_index(place).ok()?;
            let name = file.name().ok()?.into_owned();
            let mut content = Vec::new();
            file.take(SEED_BYTES as u64).read_to_end(&mut content).ok()?;
            Some((name, content))
        })
        .collect()
}

/// Joins files, each after a line with its name.
fn parts(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    files.iter().flat_map(|(name, content)| [format!("\n--- {name}\n").as_bytes(), content].concat()).collect()
}

#[test]
fn every_format_has_seeds() {
    let mut names = BTreeSet::new();
    for fixture in all() {
        let bytes = fixture.bytes();
        let format = asperity_formats::read_bytes(&bytes).unwrap().format.unwrap();
        names.insert(format.name());
        keep("format", Format::detect(&bytes).unwrap(), &bytes);
        match fixture.content {
            Content::Bytes(_) => (),
            Content::Gzip(bytes) => keep("archive", format, &parts(&[("gzip".to_owned(), bytes)])),
            Content::Zip(files) => keep("archive", format, &parts(&files)),
        }
    }
    for description in asperity_formats::descriptions().filter(|description| !description.reads.is_empty()) {
        assert!(names.contains(description.format.name()), "{:?}: {names:?}", description.format);
    }
}
