//! Serialised objects and their components.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::{Input, MAX_TEXT_BYTES, Result, shown};

/// First bytes of a file.
pub(super) const MAGIC: &[u8] = b"GWYP";
/// First bytes of a file of Gwyddion 1.
pub(super) const MAGIC_1: &[u8] = b"GWYO";
/// Type of the root and of metadata.
pub(super) const CONTAINER: &str = "GwyContainer";
/// Type of an image or mask.
pub(super) const DATA_FIELD: &str = "GwyDataField";
/// Type of a unit.
pub(super) const UNIT: &str = "GwySIUnit";

/// Serialised object.
#[derive(Clone, Copy)]
pub(super) struct Object<'a> {
    input: Input<'a>,
    /// Offset of the name of its type.
    offset: usize,
    /// Start and end of its components.
    content: (usize, usize),
}

/// Component of an object.
pub(super) struct Component<'a> {
    pub(super) name: Cow<'a, str>,
    /// Letter of its type.
    pub(super) kind: u8,
    /// Start and end of its value.
    pub(super) value: (usize, usize),
}

/// Returns the offset after the next zero before `limit`.
fn text_end(input: &Input, field: &str, offset: usize, limit: usize) -> Result<usize> {
    let bytes = input.bytes.get(offset..limit).unwrap_or_default();
    let length = bytes.iter().position(|&byte| byte == 0);
    let wrong = || input.wrong(field, offset, "a text without end", "a zero byte after it");
    length.map(|length| offset + length + 1).ok_or_else(wrong)
}

/// Reads the text up to the next zero before `limit`, cut to [`MAX_TEXT_BYTES`]. Returns it with the offset after the
/// zero.
fn string<'a>(input: &Input<'a>, field: &str, offset: usize, limit: usize) -> Result<(Cow<'a, str>, usize)> {
    let end = text_end(input, field, offset, limit)?;
    let kept = &input.bytes[offset..(end - 1).min(offset.saturating_add(MAX_TEXT_BYTES))];
    Ok((String::from_utf8_lossy(kept), end))
}

/// Returns the end of `length` bytes from `offset` on, checked against `limit`.
fn end(input: &Input, field: &str, offset: usize, length: u64, limit: usize) -> Result<usize> {
    let room = limit.saturating_sub(offset);
    match usize::try_from(length) {
        Ok(length) if length <= room => Ok(offset + length),
        _ => Err(input.wrong(field, offset, format!("{length} bytes"), &format!("at most {room} bytes"))),
    }
}

impl<'a> Object<'a> {
    /// Opens the object at `offset`, which ends before `limit`.
    ///
    /// # Errors
    /// A size beyond `limit`.
    pub(super) fn at(input: Input<'a>, field: &str, offset: usize, limit: usize) -> Result<Self> {
        let size_at = text_end(&input, field, offset, limit)?;
        let start = end(&input, field, size_at, 4, limit)?;
        let content_end = end(&input, field, start, input.u32(field, size_at)?.into(), limit)?;
        Ok(Self { input, offset, content: (start, content_end) })
    }

    /// Opens the object in a component.
    pub(super) fn from_component(input: Input<'a>, component: &Component) -> Result<Self> {
        Self::at(input, &component.name, component.value.0, component.value.1)
    }

    /// Refuses objects of another type.
    pub(super) fn expect(&self, kind: &str) -> Result<()> {
        let (found, _) = string(&self.input, "type of the object", self.offset, self.content.0)?;
        if found == kind { Ok(()) } else { Err(self.input.wrong("type of the object", self.offset, found, kind)) }
    }

    /// Returns the start of the components.
    pub(super) fn start(&self) -> usize {
        self.content.0
    }

    /// Returns the components with the given names, after a check of their types.
    pub(super) fn fields(&self, kinds: &[(&str, u8)]) -> Result<HashMap<String, Component<'a>>> {
        let mut fields = HashMap::new();
        for component in self.components() {
            let component = component?;
            if let Some((name, kind)) = kinds.iter().find(|(name, _)| *name == component.name) {
                component.expect(&self.input, *kind)?;
                fields.insert((*name).to_owned(), component);
            }
        }
        Ok(fields)
    }

    /// Returns the components in order. Nested objects are skipped by their size.
    pub(super) fn components(&self) -> impl Iterator<Item = Result<Component<'a>>> + use<'a> {
        let (input, (mut offset, limit)) = (self.input, self.content);
        std::iter::from_fn(move || {
            (offset < limit).then(|| {
                let component = component(&input, offset, limit);
                // The components after a damaged one cannot be located.
                offset = component.as_ref().map_or(limit, |component| component.value.1);
                component
            })
        })
    }
}

/// Reads the component at `offset`.
fn component<'a>(input: &Input<'a>, offset: usize, limit: usize) -> Result<Component<'a>> {
    let (name, kind_at) = string(input, "name of a component", offset, limit)?;
    let start = end(input, &name, kind_at, 1, limit)?;
    let kind = input.u8(&name, kind_at)?;
    let end = match kind {
        b'b' | b'c' => end(input, &name, start, 1, limit)?,
        b'i' => end(input, &name, start, 4, limit)?,
        b'q' | b'd' => end(input, &name, start, 8, limit)?,
        b's' => text_end(input, &name, start, limit)?,
        b'o' => Object::at(*input, &name, start, limit)?.content.1,
        b'C' | b'I' | b'Q' | b'D' | b'S' | b'O' => {
            let items = end(input, &name, start, 4, limit)?;
            let count = input.u32(&name, start)?;
            match kind {
                b'C' => end(input, &name, items, count.into(), limit)?,
                b'I' => end(input, &name, items, 4 * u64::from(count), limit)?,
                b'Q' | b'D' => end(input, &name, items, 8 * u64::from(count), limit)?,
                // Every text takes a byte and every object five, so the size of the file limits the count.
                b'S' => (0..count).try_fold(items, |at, _| text_end(input, &name, at, limit))?,
                _ => (0..count).try_fold(items, |at, _| Ok(Object::at(*input, &name, at, limit)?.content.1))?,
            }
        }
        _ => {
            let found = (kind as char).escape_default();
            let field = format!("type of the component {}", shown(&name));
            return Err(input.wrong(&field, kind_at, found, "one of b c i q d s o C I Q D S O"));
        }
    };
    Ok(Component { name, kind, value: (start, end) })
}

impl Component<'_> {
    /// Refuses values of another type.
    pub(super) fn expect(&self, input: &Input, kind: u8) -> Result<()> {
        if self.kind == kind {
            return Ok(());
        }
        let field = format!("type of the component {}", self.name);
        Err(input.wrong(&field, self.value.0 - 1, self.kind as char, &(kind as char).to_string()))
    }

    /// Returns the value of a text, a number or a truth value as text.
    pub(super) fn text(&self, input: &Input) -> Result<Option<String>> {
        let (start, end) = self.value;
        Ok(Some(match self.kind {
            b's' => string(input, &self.name, start, end)?.0.into_owned(),
            b'i' => input.i32(&self.name, start)?.to_string(),
            b'q' => input.i64(&self.name, start)?.to_string(),
            b'd' => input.f64(&self.name, start)?.to_string(),
            b'b' => (input.u8(&self.name, start)? != 0).to_string(),
            _ => return Ok(None),
        }))
    }
}
