//! Zygo MetroPro DAT: a header, intensities, and the connected phase, which is the height map.
//!
//! A stored phase p, `int32`, is the height p·W·S·O/R with the wavelength W, the interferometric scale factor S, the
//! obliquity factor O and the number R of counts per fringe. Zygo's *MetroPro Reference Guide* (OMP-0347, data file
//! format) defines the header and this formula. Numbers are big-endian, except in most of the second half of the
//! header. Fields have the names of Zygo's own map of the header.
//!
//! Readers differ on three points:
//! - The code of R is 0, 1 or 2 by the guide. One reader takes 1, 2, 3 and obtains heights eight times too high. A
//!   NewView file with code 1 whose scan covered 100 µm has heights of 51 µm, or of 410 µm by that reading.
//! - Some readers invert the heights if `sign` declares inverted data. The guide's formula has no sign: like the
//!   fields around it, `sign` describes how the data were made. This reader applies the formula and issues a warning.
//! - The intensities before the phase are skipped by their declared size or by their dimensions. The two agree in
//!   sound files; otherwise the size of the file decides.

use std::collections::BTreeMap;

use crate::date::utc;
use crate::input::Kind::{self, F32, I16, I32, Text, U16};
use crate::unit::in_words;
use crate::{ByteOrder, Description, Format, Input, ReadOptions, Result, Sample, Scan, Tested, refuse_if, warn_if};

pub(crate) const CODEC: Description = Description {
    extensions: &["dat"],
    vendor: "Zygo",
    known_by: "0x881B036F, 0x881B0370, 0x881B0371",
    reads: "connected phase, int32; header formats 1 to 3",
    missing_points: "2147483640 and above",
    orientation: "the first stored line is row 0: positions count from the upper left corner of the camera",
    tested: Tested::InstrumentFiles,
    ..Description::new(
        Format::MetroPro,
        |bytes| HEADERS.iter().any(|(magic, ..)| bytes.starts_with(&magic.to_be_bytes())),
        read,
    )
};

/// Kinds of headers: magic number, format number and size in bytes.
const HEADERS: [(u32, u16, u32); 3] = [(0x881b_036f, 1, 834), (0x881b_0370, 2, 834), (0x881b_0371, 3, 4096)];

/// Lowest phase that marks a missing point.
pub(crate) const INVALID: f64 = 2_147_483_640.0;
/// Counts per fringe by the code `phase_res`.
pub(crate) const COUNTS_PER_FRINGE: [f64; 3] = [4096.0, 32768.0, 131_072.0];
/// Relative difference of the sides of a camera pixel above which pixels are not square.
const SQUARE_TOLERANCE: f32 = 1e-3;

const BIG_ENDIAN_FIELDS: [(&str, usize, Kind); 39] = [
    ("swinfo_date", 12, Text(30)),
    ("cn_org_x", 64, I16),
    ("cn_org_y", 66, I16),
    ("comment", 80, Text(82)),
    ("source", 162, I16),
    ("intf_scale_factor", 164, F32),
    ("wavelength_in", 168, F32),
    ("num_aperture", 172, F32),
    ("obliquity_factor", 176, F32),
    ("magnification", 180, F32),
    ("lateral_res", 184, F32),
    ("acq_type", 188, I16),
    ("intens_avg_cnt", 190, I16),
    ("part_thickness", 198, F32),
    ("min_mod", 210, I32),
    ("phase_res", 218, I16),
    ("min_area", 220, I32),
    ("discon_action", 224, I16),
    ("discon_filter", 226, F32),
    ("connect_order", 230, I16),
    ("sign", 232, I16),
    ("camera_width", 234, I16),
    ("camera_height", 236, I16),
    ("sys_type", 238, I16),
    ("sys_serial", 242, U16),
    ("inst_id", 244, I16),
    ("obj_name", 246, Text(12)),
    ("part_name", 258, Text(40)),
    ("phase_avg_cnt", 300, I16),
    ("sub_sys_err", 302, I16),
    ("part_ser_num", 320, Text(40)),
    ("refractive_index", 360, F32),
    ("rem_tilt_bias", 364, I16),
    ("rem_fringes", 366, I16),
    ("max_area", 368, I32),
    ("scan_descr", 408, Text(20)),
    ("pixel_width", 486, F32),
    ("pixel_height", 490, F32),
    ("light_level_pct", 498, F32),
];
const LITTLE_ENDIAN_FIELDS: [(&str, usize, Kind); 10] = [
    ("coords_x_pos", 506, F32),
    ("coords_y_pos", 510, F32),
    ("coords_z_pos", 514, F32),
    ("sys_err_file_name", 534, Text(28)),
    ("zoom_descr", 562, Text(8)),
    ("material_a", 590, Text(24)),
    ("material_b", 614, Text(24)),
    ("z_position", 674, F32),
    ("min_mod_pct", 710, F32),
    ("sys_serial2", 798, I32),
];

/// Reads the connected phase as heights.
///
/// # Errors
/// Headers of other kinds, files without phase, invalid factors, and fewer phases than declared.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::MetroPro, bytes).with_order(ByteOrder::Big);
    let header_bytes = header_bytes(&input)?;
    let (width, height) = (input.u16("cn_width", 68)?, input.u16("cn_height", 70)?);
    if width == 0 || height == 0 {
        return Err(
            input.unsupported("the file holds intensities or nothing, but no connected phase", "connected phase")
        );
    }
    let (ny, nx) = input.shape(("cn_height", 70, height), ("cn_width", 68, width))?;
    let scale_m = scale_m(&input)?;

    let mut warnings = Vec::new();
    let phase_bytes = (nx * ny).saturating_mul(Sample::I32.size());
    let intensity_bytes = intensity_bytes(&input, header_bytes.saturating_add(phase_bytes), &mut warnings)?;
    let start = header_bytes.saturating_add(intensity_bytes);
    let in_metre = |phase| if phase >= INVALID { f64::NAN } else { phase * scale_m };
    let heights_m = input.heights("the connected phase", start, (ny, nx), Sample::I32, in_metre)?;
    let surplus = bytes.len() - start - phase_bytes;
    warn_if!(warnings, surplus > 0, "{surplus} bytes follow the connected phase and were not read");
    if input.i16("sign", 232)? != 0 {
        warnings.push("the file states that its data are inverted; heights were not inverted".into());
    }
    let pitch_m = pitch(&input, &mut warnings)?;
    Ok(Scan { metadata: metadata(&input)?, warnings, ..Scan::new(heights_m, pitch_m) })
}

/// Returns the checked size of the header. The guide requires readers to check all three fields that define its kind.
fn header_bytes(input: &Input) -> Result<usize> {
    let magic = input.u32("magic_number", 0)?;
    let known = HEADERS.into_iter().find(|(known, ..)| *known == magic);
    let known = known.ok_or_else(|| input.wrong("magic_number", 0, magic, "the number of a MetroPro file"))?;
    let (format, bytes) = (input.u16("header_format", 4)?, input.u32("header_size", 6)?);
    refuse_if!(format != known.1, input.wrong("header_format", 4, format, &known.1.to_string()));
    refuse_if!(bytes != known.2, input.wrong("header_size", 6, bytes, &known.2.to_string()));
    let bytes = bytes as usize;
    input.take("the bytes of the header", 0, bytes)?;
    Ok(bytes)
}

/// Returns the height of one count in metre.
fn scale_m(input: &Input) -> Result<f64> {
    let code = input.u16("phase_res", 218)?;
    let counts = COUNTS_PER_FRINGE.get(usize::from(code));
    let counts = counts.ok_or_else(|| input.wrong("phase_res", 218, code, "0, 1 or 2"))?;
    let factor = |field, offset| input.factor(field, offset, input.f32(field, offset)?);
    let waves_per_fringe = factor("intf_scale_factor", 164)? * factor("obliquity_factor", 176)?;
    Ok(factor("wavelength_in", 168)? * waves_per_fringe / counts)
}

/// Returns the size of the intensities before the phase in bytes; `others` is the size of everything else.
fn intensity_bytes(input: &Input, others: usize, warnings: &mut Vec<String>) -> Result<usize> {
    let stated = input.u32("ac_n_bytes", 60)? as usize;
    let mut counted = size_of::<u16>();
    for (field, offset) in [("ac_width", 52), ("ac_height", 54), ("ac_n_buckets", 56)] {
        counted = counted.saturating_mul(input.u16(field, offset)?.into());
    }
    if stated == counted {
        return Ok(stated);
    }
    let skipped = if stated.saturating_add(others) == input.len() { stated } else { counted };
    warnings.push(format!(
        "the header states {stated} bytes of intensities, whose dimensions need {counted}; {skipped} were skipped"
    ));
    Ok(skipped)
}

/// Returns the distance between points: the size of a camera pixel on the surface, by the guide equal along both
/// axes.
fn pitch(input: &Input, warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    let lateral_res = input.f32("lateral_res", 184)?;
    if lateral_res == 0.0 {
        warnings.push("the lateral resolution is 0, which means unknown; no pixel size was read".into());
        return Ok(None);
    }
    let (width, height) = (input.f32("pixel_width", 486)?, input.f32("pixel_height", 490)?);
    if width > 0.0 && height > 0.0 && (width / height - 1.0).abs() > SQUARE_TOLERANCE {
        let [width, height] = [width, height].map(|side| in_words(side.into()));
        warnings.push(format!(
            "the pixels of the camera are {width} × {height}, but the lateral resolution is one number; it was \
             used along both axes"
        ));
    }
    Ok(Some((lateral_res.into(), lateral_res.into())))
}

/// Returns further fields of the header.
fn metadata(input: &Input) -> Result<BTreeMap<String, String>> {
    let mut metadata = input.values(&BIG_ENDIAN_FIELDS)?;
    metadata.extend(input.with_order(ByteOrder::Little).values(&LITTLE_ENDIAN_FIELDS)?);
    let [major, minor, bug] = [42, 44, 46].map(|offset| input.i16("swinfo_vers", offset));
    metadata.insert("swinfo_vers".into(), format!("{}.{}.{}", major?, minor?, bug?));
    let seconds = input.i32("time_stamp", 76)?;
    if seconds > 0 {
        metadata.insert("time_stamp".into(), utc(seconds.cast_unsigned()));
    }
    Ok(metadata)
}
