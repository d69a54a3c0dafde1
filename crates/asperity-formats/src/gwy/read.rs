//! Reader of Gwyddion files.

use std::collections::{BTreeMap, HashMap};

use super::object::{CONTAINER, Component, DATA_FIELD, MAGIC, MAGIC_1, Object, UNIT};
use crate::{
    ChosenMap, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, TextLimit, large, per_metre, warn_if,
};

/// Maximum number of images of one file.
const MAX_IMAGES: usize = 1 << 16;
/// Maximum size in bytes of a title, which is the name of its image.
const MAX_TITLE_BYTES: usize = 256;
/// Mask value above which a point is masked.
const MASKED: f64 = 0.5;

/// Offsets of the parts of an image.
#[derive(Default)]
struct Parts {
    data: Option<usize>,
    title: Option<usize>,
    mask: Option<usize>,
    meta: Option<usize>,
}

/// Reads the selected image.
///
/// # Errors
/// Files of Gwyddion 1, objects beyond the end of the file, files without an image of lengths.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Gwy, bytes);
    if bytes.starts_with(MAGIC_1) {
        let wanted = "a file that starts with GWYP; Gwyddion saves it again as one";
        return Err(input.unsupported("the file is of Gwyddion 1 (GWYO)", wanted));
    }
    let root = Object::at(input, "root", MAGIC.len(), input.len())?;
    root.expect(CONTAINER)?;
    let (images, file_name) = images(&input, &root)?;

    let mut maps = Vec::new();
    for (number, parts) in &images {
        let Some(data) = parts.data else { continue };
        let field = object(&input, &format!("/{number}/data"), data)?;
        let title = parts.title.map(|at| title(&input, at)).filter(|title| !title.is_empty());
        let title = title.unwrap_or_else(|| format!("/{number}/data"));
        let units = Units::new(&input, &field)?;
        let unit = if units.states_none() { "m".into() } else { units.z.clone() };
        maps.push((field, parts, units, (title, unit)));
    }
    let chosen = ChosenMap::new(Format::Gwy, maps.iter().map(|(.., description)| description.clone()), options)?;
    let (field, parts, units, _) = &maps[chosen.map];
    let mut scan = image(&input, field, units, chosen.per_metre)?;
    if let Some(mask) = parts.mask {
        apply_mask(&input, &object(&input, "mask", mask)?, &mut scan)?;
    }
    if let Some(meta) = parts.meta {
        add_texts(&input, &object(&input, "meta", meta)?, &mut scan)?;
    }
    scan.metadata.insert("title".into(), chosen.name().to_owned());
    if let Some(file_name) = file_name {
        scan.metadata.insert("filename".into(), file_name);
    }
    Ok(chosen.add_to(scan))
}

/// Returns the images by number, and the name of the saved file.
fn images(input: &Input, root: &Object) -> Result<(BTreeMap<u32, Parts>, Option<String>)> {
    let (mut images, mut file_name) = (BTreeMap::<u32, Parts>::new(), None);
    for component in root.components() {
        let component = component?;
        if component.name == "/filename" {
            file_name = component.text(input)?;
        }
        let Some((number, part)) = image_key(&component.name) else { continue };
        let parts = images.entry(number).or_default();
        let (place, kind) = match part {
            "data" => (&mut parts.data, b'o'),
            "data/title" => (&mut parts.title, b's'),
            "mask" => (&mut parts.mask, b'o'),
            "meta" => (&mut parts.meta, b'o'),
            _ => continue,
        };
        component.expect(input, kind)?;
        *place = Some(component.value.0);
        if images.len() > MAX_IMAGES {
            return Err(input.wrong("number of images", root.start(), images.len(), &format!("at most {MAX_IMAGES}")));
        }
    }
    Ok((images, file_name))
}

/// Splits a key such as `/0/data` into the number and the rest.
fn image_key(key: &str) -> Option<(u32, &str)> {
    let (number, rest) = key.strip_prefix('/')?.split_once('/')?;
    let is_number = number.bytes().all(|byte| byte.is_ascii_digit());
    Some((number.parse().ok().filter(|_| is_number)?, rest))
}

/// Opens an object whose offset is known from the root.
fn object<'a>(input: &Input<'a>, field: &str, offset: usize) -> Result<Object<'a>> {
    Object::at(*input, field, offset, input.len())
}

/// Reads a title whose offset is known from the root.
fn title(input: &Input, offset: usize) -> String {
    let bytes = input.bytes.get(offset..).unwrap_or_default();
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end.min(MAX_TITLE_BYTES)]).into_owned()
}

/// Units of an image; empty if they are not stated.
struct Units {
    xy: String,
    z: String,
}

impl Units {
    fn new(input: &Input, field: &Object) -> Result<Self> {
        field.expect(DATA_FIELD)?;
        let fields = field.fields(&[("si_unit_xy", b'o'), ("si_unit_z", b'o')])?;
        let unit = |name| -> Result<String> {
            let Some(component) = fields.get(name) else { return Ok(String::new()) };
            let object = Object::from_component(*input, component)?;
            object.expect(UNIT)?;
            let parts = object.fields(&[("unitstr", b's')])?;
            let text = parts.get("unitstr").map_or(Ok(None), |part| part.text(input))?;
            Ok(text.unwrap_or_default().trim().to_owned())
        };
        Ok(Self { xy: unit("si_unit_xy")?, z: unit("si_unit_z")? })
    }

    fn per_metre_xy(&self) -> Option<f64> {
        if self.states_none() { Some(1.0) } else { per_metre(&self.xy) }
    }

    fn states_none(&self) -> bool {
        self.xy.is_empty() && self.z.is_empty()
    }

    fn warnings(&self, warnings: &mut Vec<String>) {
        if self.states_none() {
            warnings.push("the image states no units; its heights and sizes count as metre".into());
        } else if self.per_metre_xy().is_none() {
            let unit = &self.xy;
            warnings
                .push(format!("the lateral unit is `{unit}`, which is not a unit of length; no pixel size was read"));
        }
        for (unit, what) in [(&self.z, "heights"), (&self.xy, "sizes")] {
            if per_metre(unit).is_some_and(|per_metre| per_metre != 1.0) {
                warnings.push(format!("{what} are in {unit}; Gwyddion itself ignores prefixes"));
            }
        }
    }
}

/// Fields of a `GwyDataField` and their types.
const FIELDS: [(&str, u8); 7] =
    [("xres", b'i'), ("yres", b'i'), ("xreal", b'd'), ("yreal", b'd'), ("xoff", b'd'), ("yoff", b'd'), ("data", b'D')];

/// Returns rows, columns and the offset of the first number.
fn layout(input: &Input, field: &Object, fields: &HashMap<String, Component>) -> Result<(usize, usize, usize)> {
    let required = |name: &str| {
        let component = fields.get(name).ok_or_else(|| input.missing(name, field.start(), "xres, yres and data"))?;
        Ok::<_, FormatError>(component.value.0)
    };
    let (rows_at, columns_at, data_at) = (required("yres")?, required("xres")?, required("data")?);
    let rows = ("yres", rows_at, input.i32("yres", rows_at)?);
    let (ny, nx) = input.shape(rows, ("xres", columns_at, input.i32("xres", columns_at)?))?;
    let count = input.u32("data", data_at)?;
    if count as usize != nx * ny {
        let wanted = format!("{nx} × {ny} = {}", nx * ny);
        return Err(input.wrong("number of values in data", data_at, count, &wanted));
    }
    Ok((ny, nx, data_at + 4))
}

/// Reads the heights and the pitch of an image.
fn image(input: &Input, field: &Object, units: &Units, per_metre: f64) -> Result<Scan> {
    let fields = field.fields(&FIELDS)?;
    let (ny, nx, data_at) = layout(input, field, &fields)?;
    let heights_m = input.heights("data", data_at, (ny, nx), Sample::F64, |z| z / per_metre)?;

    let number = |name: &str| fields.get(name).map(|component| input.f64(name, component.value.0)).transpose();
    let (width, height) = (number("xreal")?, number("yreal")?);
    let mut scan = Scan::new(heights_m, None);
    scan.height_unit = Some(units.z.clone()).filter(|unit| !unit.is_empty());
    units.warnings(&mut scan.warnings);
    match (width.zip(height), units.per_metre_xy()) {
        (Some((width, height)), Some(per_metre)) => {
            scan.pitch_m = Some((width / nx as f64 / per_metre, height / ny as f64 / per_metre));
        }
        (None, _) => scan.warnings.push("the image has no xreal or yreal; no pixel size was read".into()),
        (Some(_), None) => (),
    }
    for name in ["xoff", "yoff"] {
        if let Some(offset) = number(name)?.filter(|&offset| offset != 0.0) {
            scan.metadata.insert(name.into(), format!("{offset:e} {}", units.xy).trim_end().to_owned());
        }
    }
    Ok(scan)
}

/// Sets masked heights to NaN.
fn apply_mask(input: &Input, mask: &Object, scan: &mut Scan) -> Result<()> {
    mask.expect(DATA_FIELD)?;
    let (ny, nx, data_at) = layout(input, mask, &mask.fields(&FIELDS)?)?;
    if (ny, nx) != scan.heights_m.dim() {
        scan.warnings.push(format!("the mask has {nx} × {ny} points, unlike the image; it was left out"));
        return Ok(());
    }
    let values = input.samples("data of the mask", data_at, nx * ny, Sample::F64)?;
    let masked = large::hide(&mut scan.heights_m, values.into_iter().map(|value| value > MASKED));
    warn_if!(scan.warnings, masked > 0, "{masked} points under the mask were read as missing");
    Ok(())
}

/// Adds the texts of a container to the metadata.
fn add_texts(input: &Input, meta: &Object, scan: &mut Scan) -> Result<()> {
    meta.expect(CONTAINER)?;
    let mut room = TextLimit::default();
    for component in meta.components() {
        let component = component?;
        if !room.is_left() {
            scan.warnings.push("the file holds more metadata than were read".into());
            break;
        }
        if let Some(text) = component.text(input)? {
            room.take(component.name.len() + text.len());
            scan.metadata.insert(component.name.into_owned(), text);
        }
    }
    Ok(())
}
