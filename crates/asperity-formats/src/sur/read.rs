//! Reader of SUR.

use std::collections::BTreeMap;

use super::header::{Axis, Header, INVERTED, LINES, OBJECT_NAME, OBJECT_TYPE, OBJECTS};
use super::header::{NAME_BYTES, SPECIAL_POINTS, VOID_BELOW_MINIMUM, X, Y, Z, Z_MAX, Z_MIN};
use super::object::{Object, is_followed_by_images, kind, objects};
use crate::{Format, Input, ReadOptions, Result, Scan, large, per_metre, refuse_if};

/// Object types that some writers use for surfaces.
const UNKNOWN: i16 = 0;
const PROFILE: i16 = 1;

/// Reads the selected surface, by default the first.
///
/// # Errors
/// Objects that are not surfaces, damaged streams, and sizes beyond the end of the file.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let (objects, left_out) = objects(Input::new(Format::Sur, bytes), check_kind)?;
    let mut warnings: Vec<String> = left_out.into_iter().collect();
    let first = &objects[0];
    let announced = first.header.i16(OBJECTS)?;
    if usize::try_from(announced).is_ok_and(|announced| announced > objects.len()) {
        warnings.push(format!("the header declares {announced} objects; the file holds {}", objects.len()));
    }
    let (channels, surfaces) = surfaces(&objects)?;
    let channel = options.choose(Format::Sur, &channels)?;
    let object = surfaces[channel];

    warn_about_kind(object, &mut warnings)?;
    let mut heights = object.numbers()?;
    scale(&object.header, &mut heights, &mut warnings)?;
    let pitch_m = pitch(&object.header, &mut warnings)?;
    for axis in [X, Y, Z] {
        warnings.extend(object.header.ratio_warning(axis)?);
    }
    // Writers describe the measurement only in the first object.
    let mut metadata = BTreeMap::new();
    for object in [first, object] {
        metadata.extend(object.header.metadata()?);
        let comment = object.comment()?;
        if !comment.is_empty() {
            metadata.insert("comment".into(), comment);
        }
    }
    let heights_m = object.header.input.matrix(LINES.0, LINES.1, (object.ny, object.nx), heights)?;
    let height_unit = Some(object.header.unit(Z.step_unit)?);
    Ok(Scan { metadata, warnings, height_unit, ..Scan::new(heights_m, pitch_m) }.with_channels(channels, channel))
}

/// Refuses files without a surface.
fn check_kind(header: &Header) -> Result<()> {
    let unsupported = |kind: &str| Err(header.input.unsupported(format!("the file holds {kind}"), "a surface"));
    kind(header.i16(OBJECT_TYPE)?).map_or_else(unsupported, |_| Ok(()))
}

/// Warns about surfaces with another object type.
fn warn_about_kind(object: &Object, warnings: &mut Vec<String>) -> Result<()> {
    // Gwyddion stores surfaces with the type of profiles.
    if let (UNKNOWN | PROFILE, Ok(kind), 2..) = (object.code, kind(object.code), object.ny) {
        warnings.push(format!("the type of the file is {kind}; its {} lines were read as a surface", object.ny));
    }
    if object.header.i16(INVERTED)? != 0 {
        warnings.push("the file states that it holds an inverted surface; heights were not inverted".into());
    }
    Ok(())
}

/// Returns the objects that are height maps with unique names: the names of the objects, or their numbers.
///
/// Layers in other units, such as a phase, are not heights, and neither are the images that belong to a surface.
fn surfaces<'o, 'a>(objects: &'o [Object<'a>]) -> Result<(Vec<String>, Vec<&'o Object<'a>>)> {
    let (mut names, mut surfaces, mut seen) = (Vec::new(), Vec::new(), BTreeMap::new());
    let only_first = is_followed_by_images(objects[0].code);
    for object in objects.iter().take(if only_first { 1 } else { objects.len() }) {
        let header = &object.header;
        let is_profile = |object: &Object<'_>| object.code == PROFILE && object.ny == 1;
        let is_beside = is_profile(object) && !is_profile(&objects[0]);
        if is_beside || kind(object.code).is_err() || per_metre(&header.unit(Z.step_unit)?).is_none() {
            continue;
        }
        surfaces.push(object);
        let name = header.text(OBJECT_NAME, NAME_BYTES)?;
        let name = if name.is_empty() { format!("surface {}", surfaces.len()) } else { name };
        let times: &mut usize = seen.entry(name.clone()).or_default();
        *times += 1;
        names.push(if *times > 1 { format!("{name} ({times})") } else { name });
    }
    if surfaces.is_empty() {
        let header = &objects[0].header;
        let unit = header.unit(Z.step_unit)?;
        return Err(header.wrong(Z.step_unit, unit, "a unit of length (m, cm, mm, µm, nm, …)"));
    }
    Ok((names, surfaces))
}

/// Converts stored integers to metre; NaN for missing points.
fn scale(header: &Header, heights: &mut [f64], warnings: &mut Vec<String>) -> Result<()> {
    let unit = header.unit(Z.step_unit)?;
    let per_metre = per_metre(&unit).ok_or_else(|| header.wrong(Z.step_unit, unit, "a unit of length"))?;
    let spacing_m = f64::from(header.f32(Z.spacing)?) / per_metre;
    // Programs that divide the range of a flat map by the number of steps state a spacing of 0. The height is then
    // the offset.
    let is_flat = heights.iter().all(|z| Some(z) == heights.first());
    if !(spacing_m.is_finite() && (spacing_m != 0.0 || is_flat)) {
        return Err(header.wrong(Z.spacing, header.f32(Z.spacing)?, "a finite number other than 0"));
    }
    let offset_m = f64::from(header.f32(Z.offset)?) / per_metre;
    refuse_if!(!offset_m.is_finite(), header.wrong(Z.offset, header.f32(Z.offset)?, "a finite number"));
    // Integers of 32 bits are exact as f64.
    let (low, high) = (f64::from(header.i32(Z_MIN)?), f64::from(header.i32(Z_MAX)?));
    let void = low - f64::from(VOID_BELOW_MINIMUM);
    let marked = header.i16(SPECIAL_POINTS)? != 0;
    let counts = large::pass(heights, |piece| {
        let (mut coded, mut outside) = (0_usize, 0_usize);
        for z in piece {
            let is_code = *z == void;
            coded += usize::from(is_code);
            outside += usize::from(!is_code && (*z < low || *z > high));
            *z = if is_code && marked { f64::NAN } else { *z * spacing_m + offset_m };
        }
        (coded, outside)
    });
    let (coded, outside) = counts.into_iter().fold((0, 0), |sum, count| (sum.0 + count.0, sum.1 + count.1));
    if coded > 0 && !marked {
        warnings.push(format!(
            "{coded} heights equal the code for missing points, but the header says that none are missing; they were kept"
        ));
    }
    if outside > 0 && low < high {
        warnings.push(format!("{outside} heights are outside of the stated range and may be saturated"));
    }
    Ok(())
}

/// Returns the pitch in metre if the units of both axes are lengths.
fn pitch(header: &Header, warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    let mut along = |axis: Axis| {
        let unit = header.unit(axis.step_unit)?;
        let Some(per_metre) = per_metre(&unit) else {
            let field = axis.step_unit.0;
            warnings.push(format!("the {field} is `{unit}`, which is not a unit of length; no pixel size was read"));
            return Ok(None);
        };
        Ok(Some(f64::from(header.f32(axis.spacing)?) / per_metre))
    };
    let (dx_m, dy_m) = (along(X)?, along(Y)?);
    Ok(dx_m.zip(dy_m))
}
