//! List of all formats, and their detection.

use crate::archive::GZIP_MAGIC;
use crate::{Description, Format, foreign};

/// All formats in the order of detection: signatures first, X3P after the other zip archives, text last.
const CODECS: [&Description; 35] = [
    &crate::plux::CODEC,
    &crate::npz::CODEC,
    &crate::oir::CODEC,
    &crate::x3p::CODEC,
    &crate::sur::CODEC,
    &crate::mnt::CODEC,
    &crate::sdf::CODEC,
    &crate::gwy::CODEC,
    &crate::opd::CODEC,
    &crate::opdx::CODEC,
    &crate::wyko_ascii::CODEC,
    &crate::metropro::CODEC,
    &crate::zygo_ascii::CODEC,
    &crate::datx::CODEC,
    &crate::al3d::CODEC,
    &crate::nms::CODEC,
    &crate::frt::CODEC,
    &crate::bcr::CODEC,
    &crate::tmd::CODEC,
    &crate::vk::CODEC,
    &crate::zon::CODEC,
    &crate::keyence_csv::CODEC,
    &crate::nanoscope::CODEC,
    &crate::ibw::CODEC,
    &crate::nid::CODEC,
    &crate::mdt::CODEC,
    &crate::wsxm::CODEC,
    &crate::gsf::CODEC,
    &crate::netcdf::CODEC,
    &crate::npy::CODEC,
    &crate::tiff::CODEC,
    &crate::vtk::CODEC,
    &crate::plu::CODEC,
    &crate::xyz::CODEC,
    &crate::text::CODEC,
];

/// Returns the table of formats.
pub fn descriptions() -> impl Iterator<Item = &'static Description> {
    CODECS.into_iter()
}

impl Format {
    /// Returns the functions of the format; `None` for [`Format::Gzip`], which wraps other formats.
    pub(crate) fn codec(self) -> Option<&'static Description> {
        CODECS.into_iter().find(|codec| codec.format == self)
    }

    /// Returns whether files of this format state the distance between points.
    pub fn stores_pitch(self) -> bool {
        self.codec().is_some_and(|codec| codec.stores_pitch)
    }

    /// Detects the format of content. Returns `None` for unknown content.
    ///
    /// Zip archives are recognised by the names of their files. Text in no other format counts as a matrix; its
    /// reader checks it.
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(&GZIP_MAGIC) {
            return Some(Self::Gzip);
        }
        // Some of these formats are text.
        if foreign::recognise(bytes, bytes.len() as u64).is_some() {
            return None;
        }
        CODECS.into_iter().find(|codec| (codec.detect)(bytes)).map(|codec| codec.format)
    }

    /// Returns the format that is written with an extension (without dot, in any case).
    pub fn from_extension(extension: &str) -> Option<Self> {
        let extension = extension.to_ascii_lowercase();
        let mut written = CODECS.into_iter().filter(|codec| codec.write.is_some());
        written.find(|codec| codec.extensions.contains(&extension.as_str())).map(|codec| codec.format)
    }
}

/// Returns the extensions of formats that are written, for a message.
pub(crate) fn written_extensions() -> String {
    let written = CODECS.iter().filter(|codec| codec.write.is_some());
    let extensions: Vec<String> =
        written.flat_map(|codec| codec.extensions).map(|extension| format!(".{extension}")).collect();
    extensions.join(" ")
}

/// Returns the names of the formats that are read, for a message.
pub(crate) fn read_names() -> String {
    let read = CODECS.iter().filter(|codec| !codec.reads.is_empty());
    read.map(|codec| codec.format.name()).collect::<Vec<_>>().join(", ")
}
