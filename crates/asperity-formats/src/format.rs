//! The formats: what is known of each, and how they are told apart.

use crate::{FormatError, ReadOptions, Scan, foreign};

/// A file format for measured surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// X3P, ISO 25178-72: a zip archive of an XML description and binary heights.
    X3p,
    /// Digital Surf SUR and PRO.
    Sur,
    /// ISO 25178-71 SDF, text or binary.
    Sdf,
    /// Gwyddion native file.
    Gwy,
    /// Wyko (Veeco, Bruker) OPD.
    Opd,
    /// Zygo MetroPro DAT.
    MetroPro,
    /// Zygo DATX: HDF5.
    Datx,
    /// Sensofar PLU.
    Plu,
    /// Sensofar PLUX: a zip archive.
    Plux,
    /// Alicona AL3D.
    Al3d,
    /// NanoFocus NMS.
    Nms,
    /// FRT MicroProf.
    Frt,
    /// BCR-STM and BCRF.
    Bcr,
    /// TrueMap TMD.
    Tmd,
    /// Keyence VK4, VK6, VK7.
    Vk,
    /// NetCDF classic.
    NetCdf,
    /// NumPy array file.
    Npy,
    /// Zip archive of NumPy array files.
    Npz,
    /// TIFF with numbers for heights.
    Tiff,
    /// VTK image for ParaView.
    Vtk,
    /// Points x, y, z on a grid, as text.
    Xyz,
    /// Matrix of numbers as text.
    Text,
    /// A gzip stream around any other format.
    Gzip,
}

/// What the reader of a format was tried on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tested {
    /// Files that instruments or the vendors' programs wrote.
    InstrumentFiles,
    /// Files that another program wrote.
    OtherPrograms,
    /// Files assembled from the description of the format.
    Specification,
}

impl Tested {
    /// In words for the user.
    pub fn describe(self) -> &'static str {
        match self {
            Self::InstrumentFiles => "instrument files",
            Self::OtherPrograms => "files of other programs",
            Self::Specification => "files made from the specification",
        }
    }
}

/// What is known of a format: a row of the table of formats.
#[derive(Debug, Clone, Copy)]
pub struct Description {
    /// The format.
    pub format: Format,
    /// Its name.
    pub name: &'static str,
    /// Usual extensions, without the dot.
    pub extensions: &'static [&'static str],
    /// Whose format it is.
    pub vendor: &'static str,
    /// How its content is known.
    pub known_by: &'static str,
    /// What is read; empty where the format is only written.
    pub reads: &'static str,
    /// What is written; empty where the format is only read.
    pub writes: &'static str,
    /// Whether files state the distance between points.
    pub stores_pitch: bool,
    /// How missing points are marked; empty where the format has no mark.
    pub missing_points: &'static str,
    /// Which way the rows of a file run, and why row 0 of a scan is at the top.
    pub orientation: &'static str,
    /// What the reader was tried on.
    pub tested: Tested,
}

/// Bytes of a file from a scan.
type Write = fn(&Scan) -> Result<Vec<u8>, FormatError>;

/// A format with the functions behind it.
pub(crate) struct Codec {
    pub(crate) description: Description,
    /// Whether bytes look like this format.
    pub(crate) detect: fn(&[u8]) -> bool,
    /// Reads a map.
    pub(crate) read: fn(&[u8], &ReadOptions) -> Result<Scan, FormatError>,
    /// Writes the form that [`write`](crate::write) uses, where the format is written.
    pub(crate) write: Option<Write>,
}

/// All formats, in the order in which content is compared with them: signatures first, X3P after the other zip archives,
/// text of any kind last.
pub(crate) const CODECS: [&Codec; 22] = [
    &crate::plux::CODEC,
    &crate::npz::CODEC,
    &crate::x3p::CODEC,
    &crate::sur::CODEC,
    &crate::sdf::CODEC,
    &crate::gwy::CODEC,
    &crate::opd::CODEC,
    &crate::metropro::CODEC,
    &crate::datx::CODEC,
    &crate::al3d::CODEC,
    &crate::nms::CODEC,
    &crate::frt::CODEC,
    &crate::bcr::CODEC,
    &crate::tmd::CODEC,
    &crate::vk::CODEC,
    &crate::netcdf::CODEC,
    &crate::npy::CODEC,
    &crate::tiff::CODEC,
    &crate::vtk::CODEC,
    &crate::plu::CODEC,
    &crate::xyz::CODEC,
    &crate::text::CODEC,
];

/// The table of formats.
pub fn descriptions() -> impl Iterator<Item = &'static Description> {
    CODECS.iter().map(|codec| &codec.description)
}

impl Format {
    /// The unit of the heights in files of this format whose reader does not name it; `None` where files may lack one.
    pub(crate) fn height_unit(self) -> Option<&'static str> {
        match self {
            Self::Text | Self::Xyz | Self::Npy | Self::Npz | Self::Tiff | Self::Gwy | Self::NetCdf => None,
            Self::Plu | Self::Plux | Self::Nms => Some("um"),
            Self::Opd | Self::Bcr => Some("nm"),
            Self::Vk => Some("pm"),
            Self::Tmd => Some("mm"),
            _ => Some("m"),
        }
    }

    /// The functions of the format; `None` for [`Format::Gzip`], which is transparent.
    pub(crate) fn codec(self) -> Option<&'static Codec> {
        CODECS.into_iter().find(|codec| codec.description.format == self)
    }

    /// The name for the user.
    pub fn name(self) -> &'static str {
        self.codec().map_or("gzip", |codec| codec.description.name)
    }

    /// Whether files of this format state how far apart their points are.
    pub fn stores_pitch(self) -> bool {
        self.codec().is_some_and(|codec| codec.description.stores_pitch)
    }

    /// The format of a file's content; `None` for content of no known format.
    ///
    /// Zip archives are told apart by the names of their files. Text that is no other format counts as a matrix:
    /// whether it holds one is found out by reading it.
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(&crate::file::GZIP_MAGIC) {
            return Some(Self::Gzip);
        }
        // Some of them are text.
        if foreign::recognise(bytes, bytes.len() as u64).is_some() {
            return None;
        }
        CODECS.into_iter().find(|codec| (codec.detect)(bytes)).map(|codec| codec.description.format)
    }

    /// The format that is written under an extension (without its dot, in any case).
    pub fn from_extension(extension: &str) -> Option<Self> {
        let extension = extension.to_ascii_lowercase();
        let written = CODECS.into_iter().filter(|codec| codec.write.is_some()).map(|codec| &codec.description);
        written.filter(|known| known.extensions.contains(&extension.as_str())).map(|known| known.format).next()
    }
}

/// The extensions that are written, for a message.
pub(crate) fn written_extensions() -> String {
    let written = CODECS.iter().filter(|codec| codec.write.is_some());
    let extensions: Vec<String> =
        written.flat_map(|codec| codec.description.extensions).map(|extension| format!(".{extension}")).collect();
    extensions.join(" ")
}

/// The names of the formats that are read, for a message.
pub(crate) fn read_names() -> String {
    let read = CODECS.iter().filter(|codec| !codec.description.reads.is_empty());
    read.map(|codec| codec.description.name).collect::<Vec<_>>().join(", ")
}
