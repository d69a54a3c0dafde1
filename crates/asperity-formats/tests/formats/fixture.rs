//! Small files of every format, for tests that damage them.

use asperity_formats::Format;

use crate::fixtures::{gzip, zip};

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
        crate::frt::fixtures(),
        crate::bcr::fixtures(),
        crate::tmd::fixtures(),
        crate::vk::fixtures(),
        crate::netcdf::fixtures(),
        crate::npy::fixtures(),
        crate::npz::fixtures(),
        crate::tiff::fixtures(),
        crate::vtk::fixtures(),
        crate::xyz::fixtures(),
        crate::text::fixtures(),
        crate::gz::fixtures(),
    ]
    .concat()
}

/// Writes the fixtures below the folder `ASPERITY_SEEDS`, from which coverage-guided fuzzing starts: `format-NAME` for whole
/// files, `archive-NAME` for the files in archives, each after a line with its name.
#[test]
fn every_format_has_seeds() {
    let name = |fixture: &Fixture| asperity_formats::read_bytes(&fixture.bytes()).unwrap().format.unwrap().name();
    let names: std::collections::BTreeSet<&str> = all().iter().map(name).collect();
    for description in asperity_formats::descriptions().filter(|description| !description.reads.is_empty()) {
        assert!(names.contains(description.format.name()), "{:?}: {names:?}", description.format);
    }
    let Some(seeds) = std::env::var_os("ASPERITY_SEEDS") else { return };
    let write = |folder: String, number: usize, bytes: &[u8]| {
        let folder = std::path::Path::new(&seeds).join(folder);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(format!("fixture-{number}")), bytes).unwrap();
    };
    for (number, fixture) in all().iter().enumerate() {
        let bytes = fixture.bytes();
        write(format!("format-{}", Format::detect(&bytes).unwrap().name()), number, &bytes);
        let files = match &fixture.content {
            Content::Bytes(_) => continue,
            Content::Gzip(bytes) => vec![("gzip".to_owned(), bytes.clone())],
            Content::Zip(files) => files.clone(),
        };
        let parts = files.iter().map(|(name, bytes)| [format!("\n--- {name}\n").as_bytes(), bytes.as_slice()].concat());
        write(format!("archive-{}", name(fixture)), number, &parts.collect::<Vec<_>>().concat());
    }
}
