//! Writer of text.

use std::fmt::Write;

use crate::Scan;
use crate::text::separator::Separator;

/// Writes the heights in metre as text, one row per line. Each number has the fewest digits that read back to the
/// same `f64`; missing heights are `nan`.
///
/// Two comments before them state the unit of the heights and the pixel size, if the scan has one. The metadata are
/// not stored.
pub(crate) fn write_text(scan: &Scan, separator: Separator) -> Vec<u8> {
    let mut text = String::from("# unit: m\n");
    // Writing to a String cannot fail.
    if let Some((dx_m, dy_m)) = scan.pitch_m {
        let _ = writeln!(text, "# pixel size: {dx_m:e} m x {dy_m:e} m");
    }
    for row in scan.heights_m.rows() {
        for (column, &z) in row.iter().enumerate() {
            if column > 0 {
                text.push(char::from(separator.sign()));
            }
            let _ = if z.is_finite() { write!(text, "{z:e}") } else { write!(text, "nan") };
        }
        text.push('\n');
    }
    text.into_bytes()
}
