//! Reads and writes files of measured surfaces.
//!
//! The crate reads files of optical profilers (X3P, SUR, MNT, SDF, OPD, OPDx, Wyko ASCII, MetroPro, Zygo ASCII, DATX, PLU, PLUX, AL3D,
//! NMS, OS3D, ZMG, FRT, TMD, LEXT, OIR, VK4, ZON, Keyence CSV) and probe microscopes (Nanoscope, JPK, Park Systems, IBW, NID, MDT, WSxM, GSF, GWY, BCR), and NetCDF, NPY, NPZ,
//! TIFF, XYZ, XLSX, text and containers of contact.engineering. It writes X3P, SUR, SDF, GWY, NPY, text and VTK images. [`descriptions`] returns the table of formats.
//!
//! Input is not trusted: a declared size never exceeds what the bytes can hold, unpacking has limits, arithmetic on sizes
//! is checked, and no input makes a reader panic. The content decides the format; the extension matters only for
//! writing.
//!
//! ```
//! let scan = asperity_formats::read_bytes(b"# a groove\n0 -1e-6 0\n0 -1e-6 0\n")?;
//! assert_eq!(scan.heights_m.dim(), (2, 3));
//! assert_eq!(scan.pitch_m, None);
//! # Ok::<(), asperity_formats::FormatError>(())
//! ```

mod al3d;
mod archive;
mod bcr;
mod chosen_map;
mod codec;
mod container;
mod date;
mod datx;
mod error;
mod file;
mod foreign;
mod format;
mod frt;
mod gsf;
mod gwy;
mod hdf5;
mod ibw;
mod input;
mod keyence_csv;
mod large;
mod mdt;
mod metropro;
mod mnt;
mod nanoscope;
mod netcdf;
mod nid;
mod nms;
mod npy;
mod npz;
mod oir;
mod opd;
mod opdx;
mod os3d;
mod plu;
mod plux;
mod replace;
mod sample;
mod scan;
mod sdf;
mod sections;
mod selection;
mod sur;
mod text;
mod tiff;
mod tmd;
mod unit;
mod vk;
mod vtk;
mod wsxm;
mod wyko_ascii;
mod x3p;
mod xlsx;
mod xml;
mod xyz;
mod zmg;
mod zon;
mod zygo_ascii;

pub(crate) use archive::Archive;
pub(crate) use chosen_map::ChosenMap;
pub use codec::{Description, Tested};
pub use error::{FormatError, Location, chain};
pub(crate) use error::{Result, refuse_if, shown, warn_if};
pub use file::{
    read, read_bytes, read_bytes_with, read_limited, read_series, read_settings, read_text, read_with, to_bytes, write,
};
pub use format::{Format, descriptions};
pub use gwy::write_gwy;
pub(crate) use input::{Field, Input, MAX_TEXT_BYTES, TextLimit, latin1, utf8_or_latin1, utf16_text};
pub(crate) use large::Shape;
pub use npy::{write_npy, write_series};
pub use npz::{read_npz, write_npz};
pub use replace::{
    check_writable, create_locked, is_temporary_suffix, lock_abandoned, refusal, remove_abandoned_files, replace_file,
    temporary_suffix,
};
pub(crate) use sample::{ByteOrder, Sample};
pub use scan::{MAX_POINTS, Scan};
pub use sdf::write_sdf;
pub use selection::{Channel, ReadOptions};
pub(crate) use selection::{some_of, unique};
pub use sur::write_sur;
pub use text::decimal::Decimal;
pub use unit::LengthUnit;
pub(crate) use unit::per_metre;
pub use vtk::{write_vtk, write_vtk_fields};
pub use x3p::write_x3p;
pub(crate) use xml::Document;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
