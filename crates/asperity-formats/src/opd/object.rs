//! Objects of newer OPD files: a byte for the type, then the value.
//!
//! Texts and quantities start with their length: a byte with the width of the length, then the length. A quantity
//! consists of a `float64`, the name of its unit and the symbol of the unit, each text after its length as `uint32`,
//! and the relation of the unit to the SI. The OPDx files of the same vendor use the same layout of values.

use crate::{Format, Input};

const INT32: u8 = 0x06;
const TEXT: u8 = 0x12;
const QUANTITY: u8 = 0x13;

/// Returns a text, an integer or a quantity as text; `None` for other or damaged objects.
pub(super) fn value(bytes: &[u8]) -> Option<String> {
    let (&kind, rest) = bytes.split_first()?;
    match kind {
        INT32 => Input::new(Format::Opd, rest).i32("", 0).ok().map(|number| number.to_string()),
        TEXT => Some(utf8(sized(rest)?)),
        QUANTITY => {
            let content = Input::new(Format::Opd, sized(rest)?);
            let number = content.f64("", 0).ok()?;
            let text = |at: usize| -> Option<&[u8]> {
                let length = content.u32("", at).ok()? as usize;
                content.take("", at + 4, length).ok()
            };
            let name = text(8)?;
            Some(format!("{number} {}", utf8(text(12 + name.len())?)).trim_end().into())
        }
        _ => None,
    }
}

/// Returns the content after a length.
fn sized(bytes: &[u8]) -> Option<&[u8]> {
    let (&width, rest) = bytes.split_first()?;
    let (length, content) = rest.split_at_checked(width.into())?;
    let length = match *length {
        [a] => a.into(),
        [a, b] => u16::from_le_bytes([a, b]).into(),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        _ => return None,
    };
    content.get(..usize::try_from(length).ok()?)
}

fn utf8(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim_matches(['\0', ' ']).to_owned()
}
