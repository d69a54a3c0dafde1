//! From an archive to a scan.

use md5::{Digest, Md5};
use ndarray::Array2;

use super::{CHECKSUM, MAIN, path, sample};
use crate::archive::{Archive, damaged, hexadecimal};
use crate::error::shown;
use crate::sample::Sample;
use crate::scan::{Dimension, shape};
use crate::xml::Document;
use crate::{Format, FormatError, Location, ReadOptions, Scan};

/// The largest `main.xml`, in bytes: room for a data list of a few million points.
const MAX_MAIN_BYTES: u64 = 1 << 28;
/// The largest checksum file, in bytes.
const MAX_CHECKSUM_BYTES: u64 = 1 << 12;
/// Bytes that a validity file may have beyond those that its points need.
const VALIDITY_PADDING: u64 = 1 << 12;
/// The only feature type that is a height map.
const SURFACE: &str = "SUR";

/// Reads the first layer of a surface.
///
/// # Errors
/// Damaged archives and descriptions, records that are no surface on an incremental grid, and data that do not fill the
/// stated dimensions. A checksum that does not fit is only a warning.
pub(super) fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan, FormatError> {
    let mut archive = Archive::open(Format::X3p, bytes)?;
    archive.enter_folder_of(MAIN)?;
    let main = archive.read_whole(MAIN, MAX_MAIN_BYTES)?;
    let document = Document::parse(Format::X3p, MAIN, &main, path::DATUM)?;
    let mut warnings = Vec::new();
    check_main(&mut archive, &main, &document, &mut warnings)?;
    check_kind(&document)?;

    let (ny, nx, layers) = dimensions(&document)?;
    if layers > 1 {
        warnings.push(format!("{layers} layers; only the first was read"));
    }
    let letter = document.required(&axis_path("CZ", "DataType"), "I, L, F or D")?;
    let sample = sample(&letter.text)
        .ok_or_else(|| document.wrong(&axis_path("CZ", "DataType"), &letter.text, letter.offset, "I, L, F or D"))?;
    let increment = document.number(&axis_path("CZ", "Increment"))?.unwrap_or(1.0);
    let offset_m = document.number(&axis_path("CZ", "Offset"))?.unwrap_or(0.0);

    let mut heights = stored(&mut archive, &document, sample, (ny, nx, layers), &mut warnings)?;
    for z in &mut heights {
        *z = *z * increment + offset_m;
    }
    mask(&mut archive, &document, &mut heights, layers, &mut warnings)?;

    let pitch_m = document.number(&axis_path("CX", "Increment"))?.zip(document.number(&axis_path("CY", "Increment"))?);
    if pitch_m.is_none() {
        warnings.push("the x or y axis has no increment; no pixel size was read".into());
    }
    let heights_m =
        Array2::from_shape_vec((ny, nx), heights).map_err(|error| damaged(Format::X3p, MAIN, error.to_string()))?;
    let metadata = document.values.into_iter().map(|(path, value)| (path, value.text)).collect();
    Ok(Scan { metadata, warnings, ..Scan::new(heights_m, pitch_m) })
}

fn axis_path(axis: &str, field: &str) -> String {
    format!("{}/{axis}/{field}", path::AXES)
}

/// Compares `main.xml` with its checksum.
fn check_main(
    archive: &mut Archive,
    main: &[u8],
    document: &Document,
    warnings: &mut Vec<String>,
) -> Result<(), FormatError> {
    let link = document.text(path::CHECKSUM_FILE).filter(|link| archive.contains(link)).unwrap_or(CHECKSUM);
    if !archive.contains(link) {
        warnings.push(format!("the archive holds no {link}; {MAIN} could not be verified"));
        return Ok(());
    }
    let content = archive.read_whole(link, MAX_CHECKSUM_BYTES)?;
    // Lines of the form `sum *file`; a sum alone can only mean main.xml.
    let content = String::from_utf8_lossy(&content);
    let stated = content.lines().find_map(|line| {
        let (sum, file) = line.trim().split_once([' ', '\t']).unwrap_or((line.trim(), MAIN));
        file.ends_with(MAIN).then_some(sum)
    });
    match stated {
        Some(stated) => compare(MAIN, stated, &hexadecimal(&Md5::digest(main)), warnings),
        None => warnings.push(format!("{} states no sum of {MAIN}, which could not be verified", shown(link))),
    }
    Ok(())
}

fn compare(file: &str, stated: &str, found: &str, warnings: &mut Vec<String>) {
    if !stated.eq_ignore_ascii_case(found) {
        warnings.push(format!(
            "{file} has the MD5 sum {found}, not the stated `{}`; it was changed or damaged",
            shown(stated)
        ));
    }
}

/// Refuses records that are no surface on an incremental grid.
fn check_kind(document: &Document) -> Result<(), FormatError> {
    let feature = document.required(path::FEATURE_TYPE, "SUR (a surface)")?;
    let unsupported =
        |found: String| Err(FormatError::Unsupported { format: Format::X3p, found, wanted: "a surface (SUR)" });
    match feature.text.as_str() {
        SURFACE => (),
        "PRF" => return unsupported("the record is a profile (PRF)".into()),
        "PCL" => return unsupported("the record is a point cloud (PCL)".into()),
        other => return unsupported(format!("the record has the feature type `{}`", shown(other))),
    }
    for axis in ["CX", "CY"] {
        if document.text(&axis_path(axis, "AxisType")) == Some("A") {
            let found = format!("the axis {axis} is absolute, so that the points lie on no regular grid");
            return Err(FormatError::Unsupported {
                format: Format::X3p,
                found,
                wanted: "incremental x and y axes (I)",
            });
        }
    }
    Ok(())
}

/// Checked rows, columns and layers.
fn dimensions(document: &Document) -> Result<(usize, usize, u64), FormatError> {
    let dimension = |field: &'static str| {
        document.integer(field).map(|(found, offset)| Dimension { field, at: document.at(offset), found })
    };
    let (ny, nx) = shape(Format::X3p, &dimension(path::SIZE_Y)?, &dimension(path::SIZE_X)?)?;
    if document.text(path::SIZE_Z).is_none() {
        return Ok((ny, nx, 1));
    }
    let (layers, offset) = document.integer(path::SIZE_Z)?;
    match u64::try_from(layers) {
        Ok(layers) if layers > 0 => Ok((ny, nx, layers)),
        _ => Err(document.wrong(path::SIZE_Z, &layers.to_string(), offset, "1 or more")),
    }
}

/// The numbers of the first layer as they are stored.
fn stored(
    archive: &mut Archive,
    document: &Document,
    sample: Sample,
    (ny, nx, layers): (usize, usize, u64),
    warnings: &mut Vec<String>,
) -> Result<Vec<f64>, FormatError> {
    let total = (ny as u64 * nx as u64).saturating_mul(layers);
    let Some(link) = document.text(path::POINT_DATA) else {
        return listed(document, ny * nx, total, warnings);
    };
    let numbers = archive.read_numbers(link, sample, ny * nx, total)?;
    match (numbers.md5, document.text(path::POINT_DATA_MD5)) {
        (None, _) => warnings.push(format!("{link} is longer than the stated dimensions")),
        (Some(found), Some(stated)) => compare(link, stated, &found, warnings),
        (Some(_), None) => (),
    }
    Ok(numbers.values)
}

/// The numbers of a data list in `main.xml`.
fn listed(document: &Document, count: usize, total: u64, warnings: &mut Vec<String>) -> Result<Vec<f64>, FormatError> {
    let Some(list) = &document.list else {
        return Err(document.missing(path::POINT_DATA, "a link to the heights, or Record3/DataList"));
    };
    match list.get(..count) {
        Some(first) => {
            if list.len() as u64 != total {
                warnings.push(format!("the data list has {} values, not the stated {total}", list.len()));
            }
            Ok(first.to_vec())
        }
        None => Err(document.wrong(path::DATUM, &format!("{} values", list.len()), 0, &format!("{total} values"))),
    }
}

/// Takes out the heights that the validity file marks: one bit per point, the lowest bit first, 1 for a valid point.
fn mask(
    archive: &mut Archive,
    document: &Document,
    heights: &mut [f64],
    layers: u64,
    warnings: &mut Vec<String>,
) -> Result<(), FormatError> {
    let Some(link) = document.text(path::VALID_POINTS) else { return Ok(()) };
    let wanted = heights.len().div_ceil(8);
    let total = (heights.len() as u64).saturating_mul(layers).div_ceil(8);
    let bits = archive.read_whole(link, total.min(crate::MAX_POINTS) + VALIDITY_PADDING)?;
    if bits.len() < wanted {
        return Err(FormatError::Truncated {
            format: Format::X3p,
            part: "the validity bits".into(),
            at: Location::Entry { entry: link.into(), offset: 0 },
            found: bits.len() as u64,
            wanted: wanted as u64,
        });
    }
    if let Some(stated) = document.text(path::VALID_POINTS_MD5) {
        compare(link, stated, &hexadecimal(&Md5::digest(&bits)), warnings);
    }
    for (point, z) in heights.iter_mut().enumerate() {
        if bits[point / 8] >> (point % 8) & 1 == 0 {
            *z = f64::NAN;
        }
    }
    Ok(())
}
