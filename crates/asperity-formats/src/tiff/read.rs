//! Reader of TIFF.

use ndarray::{Array2, Axis};

use super::description::units;
use super::directory::sample;
use super::{Directory, File, Tag, Units, decode, jpk, lext, park, tag};
use crate::foreign::TO_GWY;
use crate::{ByteOrder, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, shown, some_of, unique};

/// Value of the Orientation tag of rows from the bottom up.
const BOTTOM_LEFT: u64 = 4;
/// Maximum number of pages of one file.
const MAX_PAGES: usize = 4096;
/// Number of pages that are checked for fields of vendors.
const VENDOR_PAGES: usize = 8;
/// Maximum size of the name of a page in bytes. Longer names are ignored.
const MAX_NAME_BYTES: u64 = 256;
/// Resolutions per inch that programs write without knowing a size: none, of screens, of printers.
const DEFAULTS: [f64; 7] = [1.0, 72.0, 96.0, 100.0, 150.0, 300.0, 600.0];
/// Text fields that become metadata.
const TEXTS: [Tag; 9] = [
    Tag(269, "DocumentName"),
    tag::MAKE,
    tag::MODEL,
    tag::PAGE_NAME,
    Tag(305, "Software"),
    Tag(306, "DateTime"),
    Tag(315, "Artist"),
    Tag(316, "HostComputer"),
    Tag(33432, "Copyright"),
];

/// Reads the selected page.
///
/// # Errors
/// Directories beyond the end of the file, files without a page of one number per point, unsupported compression.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let file = File::open(Input::new(Format::Tiff, bytes))?;
    let order = if bytes.starts_with(b"MM") { ByteOrder::Big } else { ByteOrder::Little };
    if let Some((page, units)) = lext::heights(&file)? {
        let refused = |reason| file.input.unsupported(format!("the page of heights {reason}"), "a grey page");
        let mut scan = map(&page, numbers(&page)?.map_err(refused)?, order, &units, options)?;
        scan.metadata.extend(units.metadata);
        return Ok(scan);
    }
    let (mut maps, mut names, mut others) = (Vec::new(), Vec::new(), Vec::new());
    let mut seen = Vec::new();
    let mut next = file.first()?;
    let first = if next == 0 { None } else { Some(file.directory(next)?) };
    if let Some(park) = first.as_ref().filter(|first| park::is_park(first)) {
        return park::read(park, options);
    }
    let first = first.filter(jpk::is_jpk);
    while next != 0 {
        if seen.contains(&next) || seen.len() == MAX_PAGES {
            let at = seen.last().map_or(0, |&offset| usize::try_from(offset).unwrap_or(usize::MAX));
            let wanted = format!("a place where no earlier directory stands, and at most {MAX_PAGES} of them");
            return Err(file.input.wrong("offset of the next directory", at, next, &wanted));
        }
        seen.push(next);
        let page = file.directory(next)?;
        if seen.len() <= VENDOR_PAGES
            && first.is_none()
            && let Some(vendor) = vendor(&page)?
        {
            return Err(vendor);
        }
        let name = Some(tag::PAGE_NAME).filter(|&name| page.length(name) <= MAX_NAME_BYTES);
        let name = name.map_or(Ok(None), |name| page.text(name))?;
        let name = if first.is_some() { jpk::name(&page)? } else { name };
        let name = name.unwrap_or_else(|| format!("page {}", seen.len()));
        let other_unit = match &first {
            Some(first) => jpk::units(first, &page)?.err(),
            None => None,
        };
        match numbers(&page)? {
            Ok(_) if other_unit.is_some() => {
                others.push(format!("{name} has the unit `{}`", shown(&other_unit.unwrap_or_default())))
            }
            Ok(sample) => {
                maps.push((next, sample));
                names.push(name);
            }
            Err(reason) => others.push(format!("{name} {reason}")),
        }
        next = page.next;
    }
    if maps.is_empty() {
        let found = if others.is_empty() { "the file has no page".into() } else { some_of(&others) };
        return Err(file.input.unsupported(found, "a grey page of integers or floating-point numbers"));
    }
    let names = unique(names);
    let place = options.choose(Format::Tiff, &names)?;
    let (offset, sample) = maps[place];
    let page = file.directory(offset)?;
    // Programs describe all pages in the first one.
    let own = page.text(tag::IMAGE_DESCRIPTION)?;
    let description = match own {
        Some(description) => Some(description),
        None => file.directory(file.first()?)?.text(tag::IMAGE_DESCRIPTION)?,
    };
    let units = match &first {
        Some(first) => jpk::units(first, &page)?.unwrap_or_default(),
        None => description.map_or_else(Units::default, |description| units(&description)),
    };
    let mut scan = map(&page, sample, order, &units, options)?;
    scan.metadata.extend(units.metadata);
    scan.warnings.extend(units.warnings);
    if options.channel.is_none() && !others.is_empty() {
        scan.warnings.push(format!("pages other than heights were left out: {}", some_of(&others)));
    }
    Ok(scan.with_channels(names, place))
}

/// Returns the error for a page of a vendor that stores heights, or their scale, in private fields.
///
/// JPK numbers its fields from 32768 on. Park's fields start at 50432 (its magic number) and hold the heights beside
/// a picture. Olympus (LEXT, OLS) describes its pages in XML or in lines of text, or names itself.
fn vendor(page: &Directory) -> Result<Option<FormatError>> {
    // Descriptions of instruments take a few kilobytes.
    const MAX_DESCRIPTION: u64 = 1 << 16;
    let has = |tag: u16| page.length(Tag(tag, "")) > 0;
    let name = if (50432..=50435).any(has) {
        Some("a Park Systems TIFF file without heights")
    } else if (32768..=32775).chain(32832..=32837).chain(32848..=32850).any(has) {
        Some("a JPK file without the size of its grid")
    } else {
        let text = |tag: Tag| {
            let tag = Some(tag).filter(|&tag| page.length(tag) <= MAX_DESCRIPTION);
            Ok::<_, FormatError>(tag.map_or(Ok(None), |tag| page.text(tag))?.unwrap_or_default())
        };
        let description = text(tag::IMAGE_DESCRIPTION)?;
        let is_olympus = description.contains("TiffTagDescData")
            || description.contains("System Name") && description.contains("OLS")
            || text(tag::MAKE)?.starts_with("OLYMPUS")
            || text(tag::MODEL)?.contains("LEXT");
        is_olympus.then_some("an Olympus LEXT file without a page of heights, or of an OLS3000")
    };
    Ok(name.map(|name| FormatError::NotRead { name, advice: TO_GWY }))
}

/// Returns the number type of a page with one number per point, or the reason why the page is not a map.
fn numbers(page: &Directory) -> Result<Result<Sample, String>> {
    let subfile = page.integer(tag::NEW_SUBFILE_TYPE)?.unwrap_or(0);
    if subfile & 1 != 0 {
        return Ok(Err("is a smaller copy of another".into()));
    }
    let colours = match page.integer(tag::PHOTOMETRIC)? {
        // Writers of data other than pictures omit the field.
        None | Some(0 | 1) => None,
        Some(2) => Some("in colours (RGB)"),
        Some(3) => Some("in colours of a palette"),
        Some(4) => Some("a mask"),
        Some(5) => Some("in colours (CMYK)"),
        Some(6) => Some("in colours (YCbCr)"),
        Some(8..=10) => Some("in colours (L*a*b*)"),
        Some(_) => Some("of an unknown PhotometricInterpretation"),
    };
    if let Some(colours) = colours {
        return Ok(Err(format!("is {colours}")));
    }
    let per_point = page.integer(tag::SAMPLES_PER_PIXEL)?.unwrap_or(1);
    if per_point != 1 {
        return Ok(Err(format!("has {per_point} numbers per point")));
    }
    let bits = page.integer(tag::BITS_PER_SAMPLE)?.unwrap_or(1);
    let kind = page.integer(tag::SAMPLE_FORMAT)?.unwrap_or(1);
    Ok(sample(bits, kind).ok_or_else(|| format!("has numbers of {bits} bits and SampleFormat {kind}")))
}

/// Reads the heights and the pitch of a page.
fn map(page: &Directory, sample: Sample, order: ByteOrder, units: &Units, options: &ReadOptions) -> Result<Scan> {
    let dimension = |tag: Tag| {
        let found = page.integer(tag)?.ok_or_else(|| page.input.missing(tag.1, page.offset, "a whole number"))?;
        Ok::<_, FormatError>((tag.1, page.offset, found))
    };
    let (ny, nx) = page.input.shape(dimension(tag::IMAGE_LENGTH)?, dimension(tag::IMAGE_WIDTH)?)?;
    let mut values = decode::decode(page, (ny, nx), sample, order)?;
    let mut scan = Scan::new(Array2::zeros((0, 0)), None);
    remove_voids(page, sample, &mut values)?;
    let is_integer = !sample.is_float();
    match units.line_m {
        Some((offset_m, slope_m)) => {
            values.iter_mut().for_each(|z| *z = *z * slope_m + offset_m);
            scan.height_unit = units.metadata.get("vunit").cloned();
        }
        None if is_integer && options.height_unit.is_none() => {
            let doubt = "the numbers are integers, counts without a unit; they count as heights in metre";
            scan.warnings.push(doubt.into());
        }
        None => (),
    }
    let values = page.input.matrix(tag::IMAGE_WIDTH.1, page.offset, (ny, nx), values)?;
    let pitch_m = pitch(page, units, &mut scan.warnings)?;
    let turned = page.integer(tag::ORIENTATION)?.unwrap_or(if units.is_bottom_up { BOTTOM_LEFT } else { 1 });
    (scan.heights_m, scan.pitch_m) = match turned {
        1..=8 => (upright(values, turned), pitch_m.map(|(x, y)| if turned > 4 { (y, x) } else { (x, y) })),
        _ => return Err(page.wrong(tag::ORIENTATION, turned, "1 to 8")),
    };
    for tag in TEXTS {
        if let Some(text) = page.text(tag)? {
            scan.metadata.insert(tag.1.into(), text);
        }
    }
    Ok(scan)
}

/// Sets the numbers that mark missing points to NaN.
fn remove_voids(page: &Directory, sample: Sample, values: &mut [f64]) -> Result<()> {
    let Some(text) = page.text(tag::GDAL_NODATA)? else { return Ok(()) };
    let void: f64 = text.parse().map_err(|_| page.wrong(tag::GDAL_NODATA, &text, "a number"))?;
    // The text has the digits of a double also if the numbers are in single precision.
    let void = if sample == Sample::F32 { f64::from(void as f32) } else { void };
    values.iter_mut().filter(|z| **z == void).for_each(|z| *z = f64::NAN);
    Ok(())
}

/// Returns the distance between points along the stored rows and columns.
fn pitch(page: &Directory, units: &Units, warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    if units.pitch_m.is_some() {
        return Ok(units.pitch_m);
    }
    let positive = |tag: Tag| Ok::<_, FormatError>(page.real(tag)?.filter(|&number| number > 0.0));
    let Some((x, y)) = positive(tag::X_RESOLUTION)?.zip(positive(tag::Y_RESOLUTION)?) else { return Ok(None) };
    if let Some((per_metre_x, per_metre_y)) = units.per_metre {
        return Ok(Some((1.0 / (x * per_metre_x), 1.0 / (y * per_metre_y))));
    }
    let unit_m = match page.integer(tag::RESOLUTION_UNIT)?.unwrap_or(2) {
        2 => 0.0254,
        3 => 0.01,
        // Other values mean that there is no absolute size.
        _ => return Ok(None),
    };
    if unit_m == 0.0254 && DEFAULTS.contains(&x) {
        warnings.push(format!(
            "the resolution of {x} points per inch may be a screen's or printer's, not the instrument's"
        ));
    }
    Ok(Some((unit_m / x, unit_m / y)))
}

/// Rotates and mirrors stored rows and columns so that row 0 is at the top and column 0 at the left.
///
/// The Orientation tag defines the place of row 0 and column 0: 1 top left, 2 top right, 3 bottom right, 4 bottom
/// left, and with rows stored as columns 5 left top, 6 right top, 7 right bottom, 8 left bottom.
fn upright(stored: Array2<f64>, orientation: u64) -> Array2<f64> {
    let mut turned = if orientation > 4 { stored.reversed_axes() } else { stored };
    if matches!(orientation, 3 | 4 | 7 | 8) {
        turned.invert_axis(Axis(0));
    }
    if matches!(orientation, 2 | 3 | 6 | 7) {
        turned.invert_axis(Axis(1));
    }
    if turned.is_standard_layout() { turned } else { turned.as_standard_layout().into_owned() }
}
