//! Writer of Gwyddion files.

use std::mem::size_of;

use super::object::{CONTAINER, DATA_FIELD, MAGIC, UNIT};
use crate::{Format, FormatError, Result, Scan};

/// Title of a scan without a title.
const TITLE: &str = "Height";

/// Buffer of the file.
struct Writer(Vec<u8>);

impl Writer {
    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|&byte| byte != 0));
        self.0.push(0);
    }

    /// Writes the start of a component and a value of fixed size.
    fn value(&mut self, name: &str, kind: u8, value: &[u8]) {
        self.text(name);
        self.0.push(kind);
        self.0.extend(value);
    }

    fn string(&mut self, name: &str, value: &str) {
        self.value(name, b's', &[]);
        self.text(value);
    }

    /// Writes an object: its type, its size, and the output of `content`.
    fn object(&mut self, kind: &str, content: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.text(kind);
        let size_at = self.0.len();
        self.0.extend([0; size_of::<u32>()]);
        content(self)?;
        let size = self.0.len() - size_at - size_of::<u32>();
        let size = u32::try_from(size)
            .map_err(|_| not_storable(format!("{size} bytes in one object"), "less than 4 GiB of heights and mask"))?;
        self.0[size_at..size_at + size_of::<u32>()].copy_from_slice(&size.to_le_bytes());
        Ok(())
    }

    fn unit(&mut self, name: &str, unit: &str) -> Result<()> {
        self.value(name, b'o', &[]);
        self.object(UNIT, |writer| {
            writer.string("unitstr", unit);
            Ok(())
        })
    }

    /// Writes an image or mask of the points of the scan.
    fn field(
        &mut self,
        name: &str,
        scan: &Scan,
        (width_m, height_m): (f64, f64),
        unit: &str,
        value: impl Fn(f64) -> f64,
    ) -> Result<()> {
        let (ny, nx) = scan.heights_m.dim();
        let (Ok(xres), Ok(yres), Ok(count)) = (i32::try_from(nx), i32::try_from(ny), u32::try_from(nx * ny)) else {
            return Err(not_storable(format!("a map of {nx} × {ny} points"), "less than 4 GiB of heights and mask"));
        };
        self.value(name, b'o', &[]);
        self.object(DATA_FIELD, |writer| {
            writer.value("xres", b'i', &xres.to_le_bytes());
            writer.value("yres", b'i', &yres.to_le_bytes());
            writer.value("xreal", b'd', &width_m.to_le_bytes());
            writer.value("yreal", b'd', &height_m.to_le_bytes());
            writer.unit("si_unit_xy", "m")?;
            writer.unit("si_unit_z", unit)?;
            writer.value("data", b'D', &count.to_le_bytes());
            for &z in &scan.heights_m {
                writer.0.extend(value(z).to_le_bytes());
            }
            Ok(())
        })
    }
}

/// Writes a scan as a Gwyddion file with one image. Equal scans give equal bytes.
///
/// Missing points are masked and hold the mean of the others, as in Gwyddion. The title is the metadata field
/// `title`; all other fields become metadata of the image.
///
/// # Errors
/// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points, with an
/// invalid pixel size, or of 4 GiB and more.
pub fn write_gwy(scan: &Scan) -> Result<Vec<u8>, FormatError> {
    let ((ny, nx), (dx_m, dy_m)) = scan.to_store(Format::Gwy)?;
    let sizes_m = (nx as f64 * dx_m, ny as f64 * dy_m);
    let missing = scan.missing_points();
    let mean_m = mean(scan);
    let mut writer = Writer(Vec::with_capacity(8 * nx * ny * if missing > 0 { 2 } else { 1 }));
    writer.0.extend(MAGIC);
    writer.object(CONTAINER, |writer| {
        writer.string("/0/data/title", scan.metadata.get("title").map_or(TITLE, String::as_str));
        writer.value("/0/data/visible", b'b', &[1]);
        writer.field("/0/data", scan, sizes_m, "m", |z| if z.is_finite() { z } else { mean_m })?;
        if missing > 0 {
            writer.field("/0/mask", scan, sizes_m, "", |z| if z.is_finite() { 0.0 } else { 1.0 })?;
        }
        writer.value("/0/meta", b'o', &[]);
        writer.object(CONTAINER, |writer| {
            for (name, value) in scan.metadata.iter().filter(|(name, _)| !matches!(name.as_str(), "" | "title")) {
                writer.string(name, value);
            }
            Ok(())
        })
    })?;
    Ok(writer.0)
}

/// Returns the mean of the heights that are not missing. The format allows finite numbers only.
fn mean(scan: &Scan) -> f64 {
    let count = scan.heights_m.len() - scan.missing_points();
    let mean = scan.heights_m.iter().filter(|z| z.is_finite()).sum::<f64>() / count as f64;
    if mean.is_finite() { mean } else { 0.0 }
}

fn not_storable(found: String, wanted: &'static str) -> FormatError {
    FormatError::not_storable(Format::Gwy, found, wanted)
}
