//! Units in ImageDescription, in the conventions of ImageJ and of OME-XML.

use std::collections::BTreeMap;

use quick_xml::events::Event;
use quick_xml::{Reader, XmlVersion};

use crate::per_metre;

/// Content of a description.
#[derive(Default)]
pub(super) struct Units {
    /// Distance between points in metre.
    pub(super) pitch_m: Option<(f64, f64)>,
    /// Number of units of XResolution and YResolution per metre.
    pub(super) per_metre: Option<(f64, f64)>,
    /// Straight line from stored numbers to metre: offset and slope.
    pub(super) line_m: Option<(f64, f64)>,
    /// Whether rows are stored from the bottom up if the file does not say it.
    pub(super) is_bottom_up: bool,
    /// Fields of a description in lines, or the whole description.
    pub(super) metadata: BTreeMap<String, String>,
    pub(super) warnings: Vec<String>,
}

/// Reads a description. A description of no known convention becomes metadata as a whole.
pub(super) fn units(text: &str) -> Units {
    if text.starts_with("ImageJ=") {
        return image_j(text);
    }
    let mut units = Units { metadata: BTreeMap::from([("ImageDescription".into(), text.into())]), ..Units::default() };
    if text.starts_with('<') && text.contains("<OME") {
        units.pitch_m = ome(text);
    }
    units
}

/// Reads lines of the form `key=value`.
fn image_j(text: &str) -> Units {
    let mut units = Units::default();
    for (key, value) in text.lines().filter_map(|line| line.split_once('=')) {
        // Java escapes the micro sign.
        units.metadata.insert(key.trim().into(), value.trim().replace("\\u00B5", "µ"));
    }
    let value = |key: &str| units.metadata.get(key).map(String::as_str);
    let length = |key: &str| value(key).and_then(per_metre);
    let number = |key: &str| value(key).and_then(|value| value.parse::<f64>().ok()).filter(|value| value.is_finite());
    let x = length("unit");
    let per_metre = x.map(|x| (x, length("yunit").unwrap_or(x)));
    let line_m = match (length("vunit"), value("cf"), number("c0"), number("c1")) {
        (Some(per_metre), Some("0"), Some(offset), Some(slope)) => Some((offset / per_metre, slope / per_metre)),
        (Some(per_metre), None, ..) => Some((0.0, 1.0 / per_metre)),
        _ => None,
    };
    let doubt = (line_m.is_none() && value("cf").is_some()).then(|| {
        "the calibration of ImageJ (cf, c0, c1, vunit) is not a linear conversion to a length; it was ignored".into()
    });
    Units { per_metre, line_m, warnings: doubt.into_iter().collect(), ..units }
}

/// Returns the sizes of points in the first `Pixels` element.
fn ome(text: &str) -> Option<(f64, f64)> {
    let mut reader = Reader::from_str(text);
    loop {
        match reader.read_event().ok()? {
            Event::Eof => return None,
            Event::Start(start) | Event::Empty(start) if start.local_name().into_inner() == "Pixels" => {
                let attribute = |name: &str| {
                    let mut all = start.attributes();
                    let found = all.with_checks(false).flatten().find(|attribute| attribute.key.into_inner() == name);
                    found.and_then(|found| Some(found.normalized_value(XmlVersion::Implicit1_0).ok()?.into_owned()))
                };
                let size = |name: &str| {
                    let size: f64 = attribute(name)?.trim().parse().ok()?;
                    // Default of the schema.
                    let unit = attribute(&format!("{name}Unit")).unwrap_or_else(|| "µm".into());
                    Some(size / per_metre(unit.trim())?)
                };
                let x = size("PhysicalSizeX")?;
                return Some((x, size("PhysicalSizeY").unwrap_or(x)));
            }
            _ => (),
        }
    }
}
