//! Names of the formats.

/// File format for measured surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// X3P, ISO 25178-72: a zip archive of an XML description and binary heights.
    X3p,
    /// Digital Surf SUR and PRO.
    Sur,
    /// Digital Surf Mountains MNT.
    Mnt,
    /// ISO 25178-71 SDF, text or binary.
    Sdf,
    /// Gwyddion native file.
    Gwy,
    /// Wyko (Veeco, Bruker) OPD.
    Opd,
    /// Wyko ASCII.
    WykoAscii,
    /// Bruker OPDx of Vision64 and Dektak.
    Opdx,
    /// Zygo MetroPro DAT.
    MetroPro,
    /// Zygo ASCII.
    ZygoAscii,
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
    /// Keyence ZON.
    Zon,
    /// Keyence CSV.
    KeyenceCsv,
    /// Olympus OIR and POIR.
    Oir,
    /// Nanoscope of Digital Instruments, Veeco and Bruker.
    Nanoscope,
    /// Igor binary wave, as of Asylum Research.
    Ibw,
    /// Nanosurf NID.
    Nid,
    /// NT-MDT MDT.
    Mdt,
    /// WSxM.
    Wsxm,
    /// Gwyddion simple field.
    Gsf,
    /// NetCDF classic.
    NetCdf,
    /// NumPy array file.
    Npy,
    /// Zip archive of NumPy array files.
    Npz,
    /// TIFF with one number per point.
    Tiff,
    /// VTK image for ParaView.
    Vtk,
    /// Points x, y, z on a grid, as text.
    Xyz,
    /// Matrix of numbers as text.
    Text,
    /// Gzip stream around any other format.
    Gzip,
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

    fn name_and_unit(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::X3p => ("X3P", Some("m")),
            Self::Sur => ("SUR", Some("m")),
            Self::Mnt => ("MNT", None),
            Self::Oir => ("OIR", None),
            Self::Sdf => ("SDF", Some("m")),
            Self::Gwy => ("GWY", None),
            Self::Opd => ("OPD", Some("nm")),
            Self::WykoAscii => ("Wyko ASCII", Some("nm")),
            Self::Opdx => ("OPDx", None),
            Self::MetroPro => ("MetroPro DAT", Some("m")),
            Self::ZygoAscii => ("Zygo ASCII", Some("m")),
            Self::Datx => ("DATX", Some("m")),
            Self::Plu => ("PLU", Some("um")),
            Self::Plux => ("PLUX", Some("um")),
            Self::Al3d => ("AL3D", Some("m")),
            Self::Nms => ("NMS", Some("um")),
            Self::Frt => ("FRT", Some("m")),
            Self::Bcr => ("BCR", Some("nm")),
            Self::Tmd => ("TMD", Some("mm")),
            Self::Vk => ("VK4/VK6", Some("pm")),
            Self::Zon => ("ZON", Some("m")),
            Self::KeyenceCsv => ("Keyence CSV", None),
            Self::Nanoscope => ("Nanoscope", None),
            Self::Ibw => ("IBW", None),
            Self::Nid => ("NID", None),
            Self::Mdt => ("MDT", None),
            Self::Wsxm => ("WSxM", None),
            Self::Gsf => ("GSF", None),
            Self::NetCdf => ("NetCDF", None),
            Self::Npy => ("NPY", None),
            Self::Npz => ("NPZ", None),
            Self::Tiff => ("TIFF", None),
            Self::Vtk => ("VTK image", Some("m")),
            Self::Xyz => ("XYZ", None),
            Self::Text => ("text", None),
            Self::Gzip => ("gzip", Some("m")),
        }
    }
}
