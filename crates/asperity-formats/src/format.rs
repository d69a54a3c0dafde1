//! Names of the formats.

/// File format for measured surfaces.
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
        match self {
            Self::Text | Self::Xyz | Self::Npy | Self::Npz | Self::Tiff | Self::Gwy | Self::NetCdf => None,
            Self::Plu | Self::Plux | Self::Nms => Some("um"),
            Self::Opd | Self::Bcr => Some("nm"),
            Self::Vk => Some("pm"),
            Self::Tmd => Some("mm"),
            _ => Some("m"),
        }
    }

    /// Returns the name for the user.
    pub fn name(self) -> &'static str {
        match self {
            Self::X3p => "X3P",
            Self::Sur => "SUR",
            Self::Sdf => "SDF",
            Self::Gwy => "GWY",
            Self::Opd => "OPD",
            Self::MetroPro => "MetroPro DAT",
            Self::Datx => "DATX",
            Self::Plu => "PLU",
            Self::Plux => "PLUX",
            Self::Al3d => "AL3D",
            Self::Nms => "NMS",
            Self::Frt => "FRT",
            Self::Bcr => "BCR",
            Self::Tmd => "TMD",
            Self::Vk => "VK4/VK6",
            Self::NetCdf => "NetCDF",
            Self::Npy => "NPY",
            Self::Npz => "NPZ",
            Self::Tiff => "TIFF",
            Self::Vtk => "VTK image",
            Self::Xyz => "XYZ",
            Self::Text => "text",
            Self::Gzip => "gzip",
        }
    }
}
