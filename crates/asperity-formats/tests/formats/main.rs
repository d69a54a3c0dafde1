//! Files assembled byte by byte from the descriptions of their formats, read back; round trips of the writers; hostile
//! bytes.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod al3d;
mod ascii;
mod bcr;
mod check;
mod container;
mod datx;
mod decimal;
mod files;
mod fixture;
mod fixtures;
mod foreign;
mod frt;
mod gsf;
mod gwy;
mod gz;
mod height_unit;
mod hostile;
mod ibw;
mod mdt;
#[path = "../memory/mod.rs"]
mod memory;
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
mod reference;
mod reports;
mod round_trip;
mod sdf;
mod series;
mod sur;
mod table;
mod text;
mod tiff;
mod tmd;
mod vk;
mod vtk;
mod wsxm;
mod x3p;
mod xlsx;
mod xyz;
mod zmg;
mod zon;

use asperity_formats::Scan;

/// The heights in row order as bits, so that NaN compares equal to itself.
fn bits(scan: &Scan) -> Vec<u64> {
    scan.heights_m.iter().map(|z| if z.is_nan() { f64::NAN.to_bits() } else { z.to_bits() }).collect()
}

/// Asserts heights in row order, to one unit in the last place of the largest.
fn assert_heights(scan: &Scan, wanted: &[f64]) {
    let found: Vec<f64> = scan.heights_m.iter().copied().collect();
    let scale = wanted.iter().filter(|z| z.is_finite()).fold(0.0_f64, |scale, z| scale.max(z.abs()));
    assert_eq!(found.len(), wanted.len());
    for (z, w) in found.iter().zip(wanted) {
        assert!(z.is_nan() && w.is_nan() || (z - w).abs() <= scale * f64::EPSILON, "{found:?}, wanted {wanted:?}");
    }
}

/// A missing height.
const NAN: f64 = f64::NAN;

/// Asserts the texts of some fields of the metadata.
fn assert_metadata(scan: &Scan, wanted: &[(&str, &str)]) {
    for (field, text) in wanted {
        assert_eq!(scan.metadata.get(*field).map(String::as_str), Some(*text), "{field}");
    }
}
