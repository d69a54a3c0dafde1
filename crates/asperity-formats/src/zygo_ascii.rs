//! Zygo ASCII: thirteen or fourteen lines of header, then intensities and phases as whole numbers, each part ended by `#`.
//!
//! A phase p is the height p·W·S·O/R of [`crate::metropro`], whose binary files hold the same numbers. Zygo's *MetroPro Reference Guide*
//! (OMP-0347) defines the header.

use crate::metropro::{COUNTS_PER_FRINGE, INVALID};
use crate::text::rows::{self, Layout};
use crate::text::separator::Separator;
use crate::{Description, Format, Input, ReadOptions, Result, Scan, large, refuse_if, utf8_or_latin1, warn_if};

pub(crate) const CODEC: Description = Description {
    extensions: &["asc"],
    vendor: "Zygo",
    known_by: "`Zygo ASCII Data File`",
    reads: "connected phase",
    missing_points: "2147483640 and above",
    orientation: "the first stored line is row 0, as in MetroPro DAT",
    ..Description::new(Format::ZygoAscii, |bytes| bytes.starts_with(b"Zygo ASCII Data File"), read)
};

/// Bytes after the header, and the smallest number of its lines.
const HEADER_END: &[u8] = b"\n#";
const LEAST_LINES: usize = 11;
/// Largest header in bytes.
const MAX_HEADER_BYTES: usize = 1 << 13;

/// Reads the phases as heights.
///
/// # Errors
/// A header of other lines, no phases, invalid factors, and fewer numbers than declared.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::ZygoAscii, bytes);
    let start = &bytes[..bytes.len().min(MAX_HEADER_BYTES)];
    let end = start.windows(HEADER_END.len()).position(|window| window == HEADER_END);
    let end = end.ok_or_else(|| input.missing("the end of the header", 0, "a line that starts with `#`"))?;
    let header = utf8_or_latin1(&bytes[..end]);
    let lines: Vec<&str> = header.lines().collect();
    refuse_if!(lines.len() < LEAST_LINES, input.wrong("lines of the header", 0, lines.len(), "13 or 14"));
    let field = |name: &str, line: usize, place: usize| {
        let text = lines[line - 1].split_ascii_whitespace().nth(place).unwrap_or_default();
        let at = lines[line - 1].as_ptr() as usize - header.as_ptr() as usize;
        text.parse::<f64>().map_err(|_| input.wrong(name, at, text, "a number"))
    };
    let factor = |name, line, place| input.factor(name, 0, field(name, line, place)?);
    let whole = |name, line, place| Ok::<_, crate::FormatError>(field(name, line, place)?.clamp(0.0, 1e18) as u64);
    let (columns, rows) = (whole("phase width", 4, 2)?, whole("phase height", 4, 3)?);
    if columns == 0 || rows == 0 {
        return Err(
            input.unsupported("the file holds intensities or nothing, but no connected phase", "connected phase")
        );
    }
    let (ny, nx) = input.shape(("phase height", 0, rows), ("phase width", 0, columns))?;
    let counts = COUNTS_PER_FRINGE.get(whole("phase_res", 11, 0)? as usize);
    let counts = counts.ok_or_else(|| input.wrong("phase_res", 0, lines[10], "0, 1 or 2"))?;
    let waves = factor("intf_scale_factor", 8, 1)? * factor("obliquity_factor", 8, 4)?;
    let scale_m = factor("wavelength", 8, 2)? * waves / counts;

    // Intensities, then phases.
    let phases = bytes[end..].split(|&byte| byte == b'#').nth(2);
    let phases = phases.ok_or_else(|| input.missing("phases", bytes.len(), "numbers after `#`"))?;
    let before = phases.as_ptr() as usize - bytes.as_ptr() as usize;
    let lines_before = bytes[..before].iter().filter(|&&byte| byte == b'\n').count();
    let layout = Layout::new(Format::ZygoAscii, Separator::Space, b"", b'\n').with_decimal(options.decimal);
    let mut heights = rows::read(phases, &layout, lines_before)?.values;
    refuse_if!(heights.len() != ny * nx, input.wrong("number of phases", end, heights.len(), &format!("{nx} × {ny}")));
    large::map(&mut heights, |phase| if phase >= INVALID { f64::NAN } else { phase * scale_m });
    let heights_m = input.matrix("phase width", 0, (ny, nx), heights)?;
    let lateral = field("camera_res", 8, 6)?;
    let mut scan = Scan::new(heights_m, Some((lateral, lateral)).filter(|_| lateral != 0.0));
    warn_if!(scan.warnings, lateral == 0.0, "the lateral resolution is 0, which means unknown; no pixel size was read");
    for (name, line) in [("comment", 5), ("part_serial_number", 6), ("part_number", 7)] {
        scan.metadata.insert(name.into(), lines[line - 1].trim_matches(['"', ' ']).to_owned());
    }
    Ok(scan)
}
