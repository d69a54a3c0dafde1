//! Units of length as instrument files spell them.

/// How often a unit of length goes into a metre, `None` for what is no length.
///
/// Dividing by it is exact to the last place where multiplying by its inverse is not. The micro sign occurs as U+00B5
/// and U+03BC, in UTF-8 read as Latin-1, and in the DOS code pages. `A` is the ampere: programs of probe microscopes
/// state it of maps of a current.
pub(crate) fn per_metre(unit: &str) -> Option<f64> {
    match unit {
        "m" | "meter" | "metre" | "meters" | "metres" => Some(1.0),
        "dm" => Some(1e1),
        "cm" => Some(1e2),
        "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" => Some(1e3),
        "um" | "\u{b5}m" | "\u{3bc}m" | "\u{c2}\u{b5}m" | "\u{ce}\u{bc}m" | "\u{e6}m" | "~m" | "micron" | "microns"
        | "micrometer" | "micrometre" | "micrometers" | "micrometres" => Some(1e6),
        "nm" | "nanometer" | "nanometre" | "nanometers" | "nanometres" => Some(1e9),
        "pm" | "picometer" | "picometre" | "picometers" | "picometres" => Some(1e12),
        "\u{c5}" | "\u{212b}" | "\u{c3}\u{85}" | "Ang" | "angstrom" | "Angstrom" | "angstroms" => Some(1e10),
        "in" | "inch" | "inches" => Some(1.0 / 0.0254),
        "mil" => Some(1.0 / 2.54e-5),
        _ => None,
    }
}
