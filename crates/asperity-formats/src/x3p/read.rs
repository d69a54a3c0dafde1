//! Reader of X3P.

use md5::{Digest, Md5};

use super::names::{CHECKSUM, MAIN, sample};
use crate::archive::hexadecimal;
use crate::xml::Value;
use crate::{Archive, Document, Format, FormatError, ReadOptions, Result, Sample, Scan, large, scan, shown, warn_if};

/// Largest `main.xml` in bytes: it holds a data list of two million points.
const MAX_MAIN_BYTES: u64 = 1 << 26;
/// Largest checksum file in bytes.
const MAX_CHECKSUM_BYTES: u64 = 1 << 12;
/// Maximum number of surplus bytes in a validity file.
const VALIDITY_PADDING: u64 = 1 << 12;
/// Maximum number of layers of one file.
const MAX_LAYERS: u64 = 1 << 12;
/// Origin of files whose first line is at the top.
const TOP_LEFT: &str = "NW";
/// Program that writes the integers as unsigned. It names itself as the manufacturer.
const UNSIGNED_WRITER: &str = "SurfaceTopography";
/// Feature types of a height map and of a profile.
const SURFACE: &str = "SUR";
const PROFILE: &str = "PRF";

/// Stored matrix and the selected layer.
struct Matrix {
    ny: usize,
    nx: usize,
    layers: u64,
    layer: u64,
}

impl Matrix {
    /// Returns the number of points of one layer.
    fn points(&self) -> usize {
        self.nx * self.ny
    }

    /// Returns the number of points before the layer. A few thousand layers of 2²⁸ points fit into `u64`.
    fn skipped(&self) -> u64 {
        self.layer * self.points() as u64
    }

    /// Returns the number of points of all layers.
    fn total(&self) -> u64 {
        self.layers * self.points() as u64
    }
}

/// Reads the selected layer of a surface, by default the first.
///
/// # Errors
/// Damaged archives and descriptions, records that are not surfaces on an incremental grid, and data that do not fill
/// the stated dimensions. A wrong checksum only gives a warning.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let mut archive = Archive::open(Format::X3p, bytes)?;
    archive.enter_folder_of(MAIN)?;
    let main = archive.read_whole(MAIN, MAX_MAIN_BYTES)?;
    let document = Document::parse(Format::X3p, MAIN, &main, "Record3/DataList/Datum")?;
    let mut warnings = Vec::new();
    check_main(&mut archive, &main, &document, &mut warnings)?;
    check_kind(&document)?;

    let (ny, nx, layers) = dimensions(&document)?;
    let channels: Vec<String> = (1..=layers).map(|layer| format!("layer {layer}")).collect();
    let channel = options.choose(Format::X3p, &channels)?;
    let matrix = Matrix { ny, nx, layers, layer: channel as u64 };
    let (sample, increment, offset_m) = z_axis(&document, &mut warnings)?;

    let mut record = Record { archive, document, matrix, warnings };
    let mut heights = record.stored(sample)?;
    for z in &mut heights {
        *z = *z * increment + offset_m;
    }
    record.mask(&mut heights)?;
    let Record { document, mut warnings, .. } = record;

    let is_profile = document.text("Record1/FeatureType") == Some(PROFILE);
    let increment = |axis: &str| document.number(&axis_path(axis, "Increment"));
    // A profile has no other axis.
    let pitch_m = increment("CX")?.zip(increment(if is_profile { "CX" } else { "CY" })?);
    warn_if!(warnings, pitch_m.is_none(), "the x or y axis has no increment; no pixel size was read");
    if let Some(origin) = document.text("Record1/Axes/Origin").filter(|origin| *origin != TOP_LEFT) {
        let origin = shown(origin);
        warnings.push(format!("the file states the origin `{origin}`; its first line was read as the top line"));
    }
    let heights_m = scan::matrix(Format::X3p, "Record3/DataLink/PointDataLink", document.at(0), (ny, nx), heights)?;
    let metadata = document.values.into_iter().map(|(path, value)| (path, value.text)).collect();
    Ok(Scan { metadata, warnings, ..Scan::new(heights_m, pitch_m) }.with_channels(channels, channel))
}

/// Returns the type of the stored numbers, and the increment and offset that convert them to metre.
fn z_axis(document: &Document, warnings: &mut Vec<String>) -> Result<(Sample, f64, f64)> {
    let (type_path, increment_path) = (axis_path("CZ", "DataType"), axis_path("CZ", "Increment"));
    let letter = document.required(&type_path, "I, L, F or D")?;
    let sample =
        sample(&letter.text).ok_or_else(|| document.wrong(&type_path, &letter.text, letter.offset, "I, L, F or D"))?;
    let is_integer = sample.is_signed();
    let is_unsigned = is_integer && document.text("Record2/Instrument/Manufacturer") == Some(UNSIGNED_WRITER);
    let doubt = "writes unsigned integers, against the format; they were read as unsigned";
    warn_if!(warnings, is_unsigned, "{UNSIGNED_WRITER} {doubt}");
    let sample = Sample::integer(8 * sample.size() as u64, false).filter(|_| is_unsigned).unwrap_or(sample);
    let increment = match document.number(&increment_path)? {
        // The schema requires an increment only for integers. An increment of 0 for floats means that there is none.
        Some(0.0) if is_integer => return Err(document.wrong(&increment_path, "0", 0, "a number other than 0")),
        Some(increment) if increment != 0.0 => increment,
        found => {
            match found {
                Some(_) => warnings.push("the increment of CZ is 0; the floating-point heights count as metre".into()),
                None if is_integer => warnings.push("CZ has integers and no increment; they count as metre".into()),
                None => (),
            }
            1.0
        }
    };
    if document.text(&axis_path("CZ", "AxisType")) == Some("I") {
        warnings.push("the type of CZ is incremental, against the format; its numbers were read as heights".into());
    }
    Ok((sample, increment, document.number(&axis_path("CZ", "Offset"))?.unwrap_or(0.0)))
}

fn axis_path(axis: &str, field: &str) -> String {
    format!("Record1/Axes/{axis}/{field}")
}

/// Compares `main.xml` with its checksum.
fn check_main(archive: &mut Archive, main: &[u8], document: &Document, warnings: &mut Vec<String>) -> Result<()> {
    let link = document.text("Record4/ChecksumFile").filter(|link| archive.contains(link)).unwrap_or(CHECKSUM);
    if !archive.contains(link) {
        warnings.push(format!("the archive holds no {link}; {MAIN} could not be verified"));
        return Ok(());
    }
    let content = archive.read_whole(link, MAX_CHECKSUM_BYTES)?;
    // Lines have the form `sum *file`. A sum alone belongs to main.xml.
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

/// Refuses records that are not surfaces on an incremental grid.
fn check_kind(document: &Document) -> Result<()> {
    let feature = document.required("Record1/FeatureType", "SUR (a surface)")?;
    let is_list =
        document.text("Record3/ListDimension").is_some() && document.text("Record3/MatrixDimension/SizeX").is_none();
    let kind = match feature.text.as_str() {
        SURFACE | PROFILE if is_list => Some("is a list of points (ListDimension), a profile or a point cloud".into()),
        SURFACE => None,
        PROFILE if document.text("Record3/MatrixDimension/SizeY") == Some("1") => None,
        PROFILE => Some("is a profile (PRF) of several lines".into()),
        "PCL" => Some("is a point cloud (PCL)".into()),
        other => Some(format!("has the feature type `{}`", shown(other))),
    };
    if let Some(kind) = kind {
        return Err(FormatError::unsupported(
            Format::X3p,
            format!("the record {kind}"),
            "a surface (SUR) or a profile (PRF) as a matrix",
        ));
    }
    for axis in ["CX", "CY"] {
        if document.text(&axis_path(axis, "AxisType")) == Some("A") {
            let found = format!("the axis {axis} is absolute, so that the points lie on no regular grid");
            return Err(FormatError::unsupported(Format::X3p, found, "incremental x and y axes (I)"));
        }
    }
    Ok(())
}

/// Returns the checked numbers of rows, columns and layers.
fn dimensions(document: &Document) -> Result<(usize, usize, u64)> {
    let (ny, nx) = document.shape("Record3/MatrixDimension/SizeY", "Record3/MatrixDimension/SizeX")?;
    if document.text("Record3/MatrixDimension/SizeZ").is_none() {
        return Ok((ny, nx, 1));
    }
    let (layers, offset) = document.integer("Record3/MatrixDimension/SizeZ")?;
    match u64::try_from(layers) {
        Ok(found) if found > MAX_LAYERS => Err(FormatError::too_large(
            Format::X3p,
            "Record3/MatrixDimension/SizeZ",
            document.at(offset),
            found,
            MAX_LAYERS,
        )),
        Ok(layers) if layers > 0 => Ok((ny, nx, layers)),
        _ => Err(document.wrong("Record3/MatrixDimension/SizeZ", &layers.to_string(), offset, "1 or more")),
    }
}

/// Archive, its description, and the selected layer.
struct Record<'a> {
    archive: Archive<'a>,
    document: Document,
    matrix: Matrix,
    warnings: Vec<String>,
}

impl Record<'_> {
    /// Reads the stored numbers of the layer.
    fn stored(&mut self, sample: Sample) -> Result<Vec<f64>> {
        let Self { archive, document, matrix, warnings } = self;
        let Some(link) = document.text("Record3/DataLink/PointDataLink") else { return self.listed() };
        let (numbers, unpacked) =
            archive.read_numbers(link, sample, matrix.skipped(), matrix.points(), matrix.total())?;
        let wanted = matrix.total() * sample.size() as u64;
        match (unpacked.md5, document.text("Record3/DataLink/MD5ChecksumPointData")) {
            (None, _) if unpacked.length > wanted => {
                warnings.push(format!("{link} is longer than the stated dimensions"))
            }
            (None, _) => warnings.push(format!("{link} is too long after the layer and could not be verified")),
            (Some(found), stated) => {
                if unpacked.length < wanted {
                    warnings.push(format!("{link} is shorter than the stated {} layers", matrix.layers));
                }
                if let Some(stated) = stated {
                    compare(link, stated, &found, warnings);
                }
            }
        }
        Ok(numbers)
    }

    /// Reads the numbers of the layer from the data list in `main.xml`.
    fn listed(&mut self) -> Result<Vec<f64>> {
        let Self { document, matrix, warnings, .. } = self;
        let Some(list) = &document.list else {
            return Err(
                document.missing("Record3/DataLink/PointDataLink", "a link to the heights, or Record3/DataList")
            );
        };
        if let Some(Value { text, offset }) = &document.wrong_datum {
            return Err(document.wrong(
                "Record3/DataList/Datum",
                text,
                *offset,
                "one number, or nothing for a missing point",
            ));
        }
        let total = matrix.total();
        let start = usize::try_from(matrix.skipped()).unwrap_or(usize::MAX);
        match list.get(start..).and_then(|rest| rest.get(..matrix.points())) {
            Some(layer) => {
                if list.len() as u64 != total {
                    warnings.push(format!("the data list has {} values, not the stated {total}", list.len()));
                }
                Ok(layer.to_vec())
            }
            None => Err(document.wrong(
                "Record3/DataList/Datum",
                &format!("{} values", list.len()),
                0,
                &format!("{total} values"),
            )),
        }
    }

    /// Sets the heights that the validity file marks to NaN: one bit per point, the lowest bit first, 1 for a valid
    /// point.
    ///
    /// The unpacked size of this file is not limited: its points have already been unpacked, and take at least 16
    /// times as many bits.
    fn mask(&mut self, heights: &mut [f64]) -> Result<()> {
        let Self { archive, document, matrix, warnings } = self;
        let Some(link) = document.text("Record3/DataLink/ValidPointsLink") else { return Ok(()) };
        // Layers have no padding between them, so a layer may start within a byte.
        let (start, shift) = (matrix.skipped() / 8, (matrix.skipped() % 8) as usize);
        let length = (shift + heights.len()).div_ceil(8);
        let total = matrix.total().div_ceil(8) + VALIDITY_PADDING;
        let (bits, unpacked) = archive.read_part(link, "the validity bits", (start, length), total)?;
        match (unpacked.md5, document.text("Record3/DataLink/MD5ChecksumValidPoints")) {
            (Some(found), Some(stated)) => compare(link, stated, &found, warnings),
            (None, Some(_)) => warnings.push(format!("{link} is too long to be verified")),
            (_, None) => (),
        }
        large::hide(heights, (shift..).map(|point| bits[point / 8] >> (point % 8) & 1 == 0));
        Ok(())
    }
}
