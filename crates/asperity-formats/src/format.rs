//! List of all formats, and their detection.

use crate::archive::GZIP_MAGIC;
use crate::{Description, foreign};

/// Defines the formats: each with its name, the unit of the heights in its files if its reader does not name it, and its module.
macro_rules! formats {
    ($($(#[$doc:meta])* $format:ident($name:literal, $unit:expr) $(= $module:ident)?,)*) => {
        /// File format for measured surfaces.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Format {
            $($(#[$doc])* $format,)*
        }

        /// Rows of all formats that have a module.
        const CODECS: &[&Description] = &[$($(&crate::$module::CODEC,)?)*];

        impl Format {
            fn name_and_unit(self) -> (&'static str, Option<&'static str>) {
                match self {
                    $(Self::$format => ($name, $unit),)*
                }
            }
        }
    };
}

// The order is that of detection: signatures first, containers before the zip archives that they may hold, X3P after the other zip
// archives, text last.
formats! {
    /// Container of contact.engineering: a zip archive of measurements.
    Container("Container", None) = container,
    /// Excel workbook (XLSX): a zip archive of sheets.
    Xlsx("XLSX", None) = xlsx,
    /// Sensofar PLUX: a zip archive.
    Plux("PLUX", Some("um")) = plux,
    /// Zip archive of NumPy array files.
    Npz("NPZ", None) = npz,
    /// Olympus OIR and POIR.
    Oir("OIR", None) = oir,
    /// X3P, ISO 25178-72: a zip archive of an XML description and binary heights.
    X3p("X3P", Some("m")) = x3p,
    /// Digital Surf SUR and PRO.
    Sur("SUR", Some("m")) = sur,
    /// Digital Surf Mountains MNT.
    Mnt("MNT", None) = mnt,
    /// ISO 25178-71 SDF, text or binary.
    Sdf("SDF", Some("m")) = sdf,
    /// Gwyddion native file.
    Gwy("GWY", None) = gwy,
    /// Wyko (Veeco, Bruker) OPD.
    Opd("OPD", Some("nm")) = opd,
    /// Bruker OPDx of Vision64 and Dektak.
    Opdx("OPDx", None) = opdx,
    /// Wyko ASCII.
    WykoAscii("Wyko ASCII", Some("nm")) = wyko_ascii,
    /// Zygo MetroPro DAT.
    MetroPro("MetroPro DAT", Some("m")) = metropro,
    /// Zygo ASCII.
    ZygoAscii("Zygo ASCII", Some("m")) = zygo_ascii,
    /// Zygo DATX: HDF5.
    Datx("DATX", Some("m")) = datx,
    /// Alicona AL3D.
    Al3d("AL3D", Some("m")) = al3d,
    /// NanoFocus NMS.
    Nms("NMS", Some("um")) = nms,
    /// OmniSurf3D OS3D of Digital Metrology.
    Os3d("OS3D", Some("um")) = os3d,
    /// Zeta Instruments ZMG.
    Zmg("ZMG", Some("um")) = zmg,
    /// FRT MicroProf.
    Frt("FRT", Some("m")) = frt,
    /// BCR-STM and BCRF.
    Bcr("BCR", Some("nm")) = bcr,
    /// TrueMap TMD.
    Tmd("TMD", Some("mm")) = tmd,
    /// Keyence VK4, VK6, VK7.
    Vk("VK4/VK6", Some("pm")) = vk,
    /// Keyence ZON.
    Zon("ZON", Some("m")) = zon,
    /// Keyence CSV.
    KeyenceCsv("Keyence CSV", None) = keyence_csv,
    /// Nanoscope of Digital Instruments, Veeco and Bruker.
    Nanoscope("Nanoscope", None) = nanoscope,
    /// Igor binary wave, as of Asylum Research.
    Ibw("IBW", None) = ibw,
    /// Nanosurf NID.
    Nid("NID", None) = nid,
    /// NT-MDT MDT.
    Mdt("MDT", None) = mdt,
    /// WSxM.
    Wsxm("WSxM", None) = wsxm,
    /// Gwyddion simple field.
    Gsf("GSF", None) = gsf,
    /// NetCDF classic.
    NetCdf("NetCDF", None) = netcdf,
    /// NumPy array file.
    Npy("NPY", None) = npy,
    /// TIFF with one number per point.
    Tiff("TIFF", None) = tiff,
    /// VTK image for ParaView.
    Vtk("VTK image", Some("m")) = vtk,
    /// Sensofar PLU.
    Plu("PLU", Some("um")) = plu,
    /// Points x, y, z on a grid, as text.
    Xyz("XYZ", None) = xyz,
    /// Matrix of numbers as text.
    Text("text", None) = text,
    /// Gzip stream around any other format.
    Gzip("gzip", Some("m")),
}

impl Format {
    /// Returns the unit of the heights in files of this format if its reader does not name it; `None` if files may
    /// lack a unit.
    pub(crate) fn height_unit(self) -> Option<&'static str> {
        self.name_and_unit().1
    }

    /// Returns the name for the user.
    pub fn name(self) -> &'static str {
        self.name_and_unit().0
    }

    /// Returns the functions of the format; `None` for [`Format::Gzip`], which wraps other formats.
    pub(crate) fn codec(self) -> Option<&'static Description> {
        CODECS.iter().copied().find(|codec| codec.format == self)
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
        CODECS.iter().copied().find(|codec| (codec.detect)(bytes)).map(|codec| codec.format)
    }

    /// Returns the format that is written with an extension (without dot, in any case).
    pub fn from_extension(extension: &str) -> Option<Self> {
        let extension = extension.to_ascii_lowercase();
        let mut written = CODECS.iter().copied().filter(|codec| codec.write.is_some());
        written.find(|codec| codec.extensions.contains(&extension.as_str())).map(|codec| codec.format)
    }
}

/// Returns the table of formats.
pub fn descriptions() -> impl Iterator<Item = &'static Description> {
    CODECS.iter().copied()
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
