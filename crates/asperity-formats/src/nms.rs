//! NanoFocus NMS of the program µsoft: a header of 3468 bytes, the heights as `u16`, and the intensities as bytes.
//!
//! A stored number n is the height `f_low` + (n − `n_low`) · (`f_high` − `f_low`) / (`n_high` − `n_low`) in µm, with
//! these four numbers from the header. Some readers always divide by 65534, or count from `f_high`: then the highest
//! point, 65535, lies above `f_high`. Steps along x and y are in nm. A point of intensity 0 has no height.
//!
//! The vendor published no description. Readers of several authors and files agree on the layout; fields of unknown
//! meaning are left out. Numbers are little-endian.

use crate::input::Kind;
use crate::{Description, Field, Format, Input, ReadOptions, Result, Sample, Scan, Tested, large, refuse_if, warn_if};

pub(crate) const CODEC: Description = Description {
    extensions: &["nms", "orginal"],
    vendor: "NanoFocus",
    known_by: "`OM_MS_` at byte 32",
    reads: "uint16; no profiles",
    missing_points: "intensity 0, numbers outside of n_low to n_high",
    orientation: "the first stored line is row 0, as in the intensities beside it",
    tested: Tested::InstrumentFiles,
    ..Description::new(
        Format::Nms,
        |bytes| bytes.get(VERSION.1..).is_some_and(|rest| rest.starts_with(VERSION_START)),
        read,
    )
};

/// Size of the header in bytes.
const HEADER_BYTES: usize = 3468;
/// Start of the version of every file, and the version of the known layout.
const VERSION_START: &[u8] = b"OM_MS_";
const KNOWN_VERSION: &str = "OM_MS_2.0";
/// Data type of `u16`.
const UNSIGNED_SHORT: i32 = 2;
/// Dimension type of an area.
const AREA: i32 = 1;
/// Units per metre: heights are in micrometre, steps in nanometre.
const MICROMETRES: f64 = 1e6;
const NANOMETRES: f64 = 1e9;

const DATA_TYPE: Field = Field("data type", 0);
const DIMENSION_TYPE: Field = Field("dimension type", 4);
const N_LOW: Field = Field("n_low", 8);
const N_HIGH: Field = Field("n_high", 12);
const F_LOW: Field = Field("f_low", 16);
const F_HIGH: Field = Field("f_high", 24);
const VERSION: Field = Field("version", 32);
const HEADER_SIZE: Field = Field("header size", 1352);
const COLUMNS: Field = Field("nx", 1368);
const ROWS: Field = Field("ny", 1372);
const STEP_X: Field = Field("dx", 1376);
const STEP_Y: Field = Field("dy", 1384);
const HAS_INTENSITY: Field = Field("has intensity", 1416);

/// Texts of the header.
const TEXTS: [(&str, usize, Kind); 4] = [
    (VERSION.0, VERSION.1, Kind::Text(VERSION_BYTES)),
    ("title", 52, Kind::Text(1024)),
    ("date", 1076, Kind::Text(20)),
    ("note", 1096, Kind::Text(256)),
];
const VERSION_BYTES: usize = 20;

/// Reads the heights.
///
/// # Errors
/// Other types of numbers, profiles, and data that do not fill the stated dimensions.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Nms, bytes);
    input.take("the bytes of the header", 0, HEADER_BYTES)?;
    let mut warnings = Vec::new();
    check_kind(&input, &mut warnings)?;
    let (rows, columns) = (input.i32(ROWS.0, ROWS.1)?, input.i32(COLUMNS.0, COLUMNS.1)?);
    let (ny, nx) = input.shape((ROWS.0, ROWS.1, rows), (COLUMNS.0, COLUMNS.1, columns))?;

    let points = ny * nx;
    let intensity_at = HEADER_BYTES + points * Sample::U16.size();
    let intensity = match input.i32(HAS_INTENSITY.0, HAS_INTENSITY.1)? {
        1.. => input.take("the intensities", intensity_at, points)?,
        _ => &[],
    };
    let mut heights = input.samples("the heights", HEADER_BYTES, points, Sample::U16)?;
    scale(&input, &mut heights, &mut warnings)?;
    large::hide(&mut heights, intensity.iter().map(|&intensity| intensity == 0));
    // Steps between points: the field of view of 160 µm of a 100× objective is 512 steps of 312.5 nm.
    let pitch_m = Some((input.f64(STEP_X.0, STEP_X.1)? / NANOMETRES, input.f64(STEP_Y.0, STEP_Y.1)? / NANOMETRES));
    let heights_m = input.matrix(COLUMNS.0, COLUMNS.1, (ny, nx), heights)?;
    Ok(Scan { metadata: input.values(&TEXTS)?, warnings, ..Scan::new(heights_m, pitch_m) })
}

/// Refuses data other than areas of `u16`, and warns about headers of another form.
fn check_kind(input: &Input, warnings: &mut Vec<String>) -> Result<()> {
    let data_type = input.i32(DATA_TYPE.0, DATA_TYPE.1)?;
    if data_type != UNSIGNED_SHORT {
        return Err(input.unsupported(format!("the numbers have the data type {data_type}"), "uint16 (data type 2)"));
    }
    match input.i32(DIMENSION_TYPE.0, DIMENSION_TYPE.1)? {
        AREA => (),
        0 => return Err(input.unsupported("the file holds a profile", "an area")),
        other => return Err(input.wrong(DIMENSION_TYPE.0, DIMENSION_TYPE.1, other, "1, an area")),
    }
    let version = input.latin1(VERSION.0, VERSION.1, VERSION_BYTES)?;
    warn_if!(warnings, version != KNOWN_VERSION, "the version is {version}; the file was read as {KNOWN_VERSION}");
    let size = input.u32(HEADER_SIZE.0, HEADER_SIZE.1)?;
    if size as usize != HEADER_BYTES {
        warnings.push(format!("the header states its size as {size} bytes; it was read as {HEADER_BYTES}"));
    }
    Ok(())
}

/// Converts stored numbers to metre; NaN for numbers outside of the declared range.
fn scale(input: &Input, heights: &mut [f64], warnings: &mut Vec<String>) -> Result<()> {
    let (n_low, n_high) = (input.i32(N_LOW.0, N_LOW.1)?, input.i32(N_HIGH.0, N_HIGH.1)?);
    refuse_if!(n_low >= n_high, input.wrong(N_HIGH.0, N_HIGH.1, n_high, &format!("more than n_low, {n_low}")));
    let (n_low, n_high) = (f64::from(n_low), f64::from(n_high));
    let bound = |field: Field| {
        let found = input.f64(field.0, field.1)?;
        if found.is_finite() { Ok(found) } else { Err(input.wrong(field.0, field.1, found, "a finite number")) }
    };
    let (f_low, f_high) = (bound(F_LOW)?, bound(F_HIGH)?);
    let step = (f_high - f_low) / (n_high - n_low);
    let outside = large::count(heights, |z| {
        let is_outside = *z < n_low || *z > n_high;
        *z = if is_outside { f64::NAN } else { (f_low + (*z - n_low) * step) / MICROMETRES };
        is_outside
    });
    warn_if!(warnings, outside > 0, "{outside} numbers are outside of {n_low} to {n_high} and count as missing");
    Ok(())
}
