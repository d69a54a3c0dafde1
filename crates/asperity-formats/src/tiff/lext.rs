//! Olympus LEXT (OLS4000 and later): a picture with two XML descriptions, and a page of heights.
//!
//! The description of the first page states the picometre of a stored 1 and of a pixel (`HeightDataPerPixelZ`, X, Y), the settings of the
//! device in its Exif directory a factor of calibration for each in parts per million (`MakerCalibrationValueZ`, X, Y). The description
//! of the page of heights is `HEIGHT`.
//!
//! The vendor published no description. Gwyddion and SurfaceTopography use the same fields.

use std::collections::BTreeMap;

use super::{Directory, File, Tag, Units, tag};
use crate::{Document, Format, FormatError, MAX_TEXT_BYTES, Result};

const EXIF: Tag = Tag(34665, "Exif");
const DEVICE_SETTINGS: Tag = Tag(41995, "DeviceSettingDescription");
/// Root of the description.
const ROOT: &str = "<TiffTagDescData";
const HEIGHT: &str = "HEIGHT";
/// Number of pages that are searched.
const PAGES: usize = 16;
/// Units of the scales per metre, and of the calibration.
const PICOMETRES: f64 = 1e12;
const MILLIONTHS: f64 = 1e6;

/// Returns the page of heights of a file, and their units; `None` if it is not of this kind.
///
/// # Errors
/// Damaged XML, a scale that is absent, and fields beyond the end of the file.
pub(super) fn heights<'a>(file: &File<'a>) -> Result<Option<(Directory<'a>, Units)>> {
    let (mut described, mut height) = (None, None);
    let mut next = file.first()?;
    for _ in 0..PAGES {
        if next == 0 {
            break;
        }
        let page = file.directory(next)?;
        next = page.next;
        if page.length(tag::IMAGE_DESCRIPTION) > MAX_TEXT_BYTES as u64 {
            continue;
        }
        match page.text(tag::IMAGE_DESCRIPTION)? {
            Some(text) if text.contains(ROOT) => described = Some((page, text)),
            Some(text) if text == HEIGHT => height = Some(page),
            _ => (),
        }
    }
    let Some(((page, text), height)) = described.zip(height) else { return Ok(None) };
    let image = Document::parse(Format::Tiff, "ImageDescription", text.as_bytes(), "")?;
    let exif = page.integer(EXIF)?.map(|offset| file.directory(offset)).transpose()?;
    let settings = exif.map(|exif| exif.text(DEVICE_SETTINGS)).transpose()?.flatten();
    let settings =
        settings.ok_or_else(|| page.input.missing(DEVICE_SETTINGS.1, page.offset, "XML with the calibration"))?;
    let device = Document::parse(Format::Tiff, "DeviceSettingDescription", settings.as_bytes(), "")?;
    let scale_m = |axis: char| {
        let per_pixel = format!("HeightInfo/HeightDataPerPixel{axis}");
        let calibration = format!("ImageCommonSettingsInfo/MakerCalibrationValue{axis}");
        let picometre = image.number(&per_pixel)?.ok_or_else(|| image.missing(&per_pixel, "a number of picometre"))?;
        let millionths = device.number(&calibration)?.ok_or_else(|| device.missing(&calibration, "a number"))?;
        Ok::<_, FormatError>(picometre / PICOMETRES * millionths / MILLIONTHS)
    };
    let (line_m, pitch_m) = (Some((0.0, scale_m('Z')?)), Some((scale_m('X')?, scale_m('Y')?)));
    let mut metadata: BTreeMap<String, String> =
        image.values.into_iter().map(|(path, value)| (path, value.text)).collect();
    metadata.insert("vunit".into(), "pm".into());
    Ok(Some((height, Units { line_m, pitch_m, metadata, ..Units::default() })))
}
