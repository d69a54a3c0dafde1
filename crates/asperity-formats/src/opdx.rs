//! Bruker OPDx of Vision64 and Dektak: a tree of named items.
//!
//! An item is a name (its length as `u32`, then the text), a type (`u8`) and a value. Values of variable length start with the size of the
//! length in bytes (1, 2 or 4) and the length. Containers hold items up to one of the type 0x7F. `2D_Data/NAME` holds the `Matrix` of
//! `float32`, rows first, the unit of a stored 1 (`DataScale`), and the distances of the first point from the last along y and x
//! (`Dimension1Extent`, `Dimension2Extent`).
//!
//! The vendor published no description. Gwyddion and SurfaceTopography describe the items.

use std::collections::BTreeMap;

use crate::{
    ChosenMap, Description, Format, Input, ReadOptions, Result, Sample, Scan, TextLimit, per_metre, utf8_or_latin1,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["opdx"],
    vendor: "Bruker",
    known_by: "`VCA DATA`",
    reads: "float32; no profiles",
    missing_points: "NaN",
    orientation: "the first stored line is row 0",
    ..Description::new(Format::Opdx, |bytes| bytes.starts_with(MAGIC), read)
};

const MAGIC: &[u8] = b"VCA DATA";
/// Offset of the first item.
const ITEMS: usize = 12;
/// Largest depth of containers.
const MAX_DEPTH: usize = 16;
/// Types of the last item of a container, and of a time with its size.
const TERMINATOR: u8 = 0x7f;
const TIME: u8 = 0x15;
const TIME_BYTES: usize = 9;
const DATA: &str = "/2D_Data/";
const PRIMARY: &str = "/MetaData/PrimaryData2D";

/// Value of an item that is used.
enum Item {
    Number(f64),
    Text(String),
    Quantity(f64, String),
    /// Offset of the first number, rows and columns, and where the item ends.
    Matrix(usize, u32, u32, usize),
}

impl Item {
    /// Returns a value as text; `None` for a matrix.
    fn text(&self) -> Option<String> {
        match self {
            Self::Number(number) => Some(number.to_string()),
            Self::Text(text) => Some(text.clone()),
            Self::Quantity(value, unit) => Some(format!("{value} {unit}")),
            Self::Matrix(..) => None,
        }
    }
}

/// Returns the value of an object of newer OPD files, a type and a value like those of an item, as text; `None` for other or damaged
/// objects.
pub(crate) fn object(bytes: &[u8]) -> Option<String> {
    let input = Input::new(Format::Opd, bytes);
    let mut tree = Tree { input, at: 0, items: BTreeMap::new(), room: TextLimit::default() };
    let text = tree.item("", MAX_DEPTH).ok()??.text()?;
    Some(text.trim_matches(['\0', ' ']).to_owned())
}

/// Reads a height map.
///
/// # Errors
/// Items beyond the end of the file, unknown types of items, and no matrix of heights.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Opdx, bytes);
    let mut tree = Tree { input, at: ITEMS, items: BTreeMap::new(), room: TextLimit::default() };
    tree.read("", input.len(), 0)?;
    let items = tree.items;
    let quantity = |path: &str| match items.get(path) {
        Some(Item::Quantity(value, unit)) => Some((*value, unit.as_str())),
        _ => None,
    };
    let text = |path: &str| match items.get(path) {
        Some(Item::Text(text)) => Some(text.as_str()),
        _ => None,
    };
    let mut names: Vec<&str> =
        items.keys().filter_map(|path| path.strip_prefix(DATA)?.strip_suffix("/Matrix")).collect();
    // The main map comes first.
    names.sort_by_key(|name| Some(*name) != text(PRIMARY));
    let maps = names.iter().map(|name| {
        let unit = quantity(&format!("{DATA}{name}/DataScale")).map_or("", |(_, unit)| unit);
        ((*name).to_owned(), unit.to_owned())
    });
    let chosen = ChosenMap::new(Format::Opdx, maps, options)?;
    let folder = format!("{DATA}{}", names[chosen.map]);
    let Some(Item::Matrix(start, rows, columns, end)) = items.get(&format!("{folder}/Matrix")) else {
        return Err(input.missing(&folder, ITEMS, "a matrix"));
    };
    let (ny, nx) = input.shape(("rows", start - 8, *rows), ("columns", start - 4, *columns))?;
    let (scale, unit) = quantity(&format!("{folder}/DataScale")).unwrap_or((f64::NAN, ""));
    let heights_m =
        input.up_to(*end).heights("the matrix", *start, (ny, nx), Sample::F32, |z| z * scale / chosen.per_metre)?;
    let pitch = |dimension: usize, points: usize| {
        let (extent, unit) = quantity(&format!("{folder}/Dimension{dimension}Extent"))?;
        Some(extent / (points.max(2) - 1) as f64 / per_metre(unit)?)
    };
    let mut scan = Scan { height_unit: Some(unit.to_owned()), ..Scan::new(heights_m, pitch(2, nx).zip(pitch(1, ny))) };
    for (path, item) in &items {
        let Some(name) = path.strip_prefix("/MetaData/") else { continue };
        scan.metadata.extend(item.text().map(|text| (name.to_owned(), text)));
    }
    Ok(chosen.add_to(scan))
}

/// Reader of the items, and the items by their paths.
struct Tree<'a> {
    input: Input<'a>,
    at: usize,
    items: BTreeMap<String, Item>,
    room: TextLimit,
}

/// Defines a function that reads one number and moves on.
macro_rules! next {
    ($name:ident) => {
        fn $name(&mut self) -> Result<$name> {
            let number = self.input.$name("an item", self.at)?;
            self.at += size_of::<$name>();
            Ok(number)
        }
    };
}

impl Tree<'_> {
    next!(u8);
    next!(u16);
    next!(u32);
    next!(f64);

    /// Reads the items of a container that ends at `end`.
    fn read(&mut self, folder: &str, end: usize, depth: usize) -> Result<()> {
        while self.at < end && self.room.is_left() {
            let path = format!("{folder}/{}", self.name()?);
            if self.input.u8("an item", self.at)? == TERMINATOR {
                self.at += 1;
                return Ok(());
            }
            if let Some(item) = self.item(&path, depth)? {
                self.room.take(path.len());
                self.items.insert(path, item);
            }
        }
        Ok(())
    }

    /// Reads the type and the value of an item; `None` for one that is not used.
    fn item(&mut self, path: &str, depth: usize) -> Result<Option<Item>> {
        let at = self.at;
        Ok(match self.u8()? {
            0x46 | 0x47 | 0x7d if depth < MAX_DEPTH => {
                let end = self.end()?;
                self.read(path, end, depth + 1)?;
                self.at = end;
                None
            }
            0x12 => {
                let end = self.end()?;
                let text = self.input.take("a text", self.at, end - self.at)?;
                self.at = end;
                Some(Item::Text(utf8_or_latin1(text)))
            }
            // The name of a unit, and its symbol.
            0x13 => {
                let end = self.end()?;
                let (value, _, symbol) = (self.f64()?, self.name()?, self.name()?);
                self.at = end;
                Some(Item::Quantity(value, symbol))
            }
            kind @ (0x00 | 0x45) => Some(self.matrix(kind == 0x00)?),
            // Units, and named types, arrays, lists and positions.
            kind @ (0x0e | 0x18 | 0x40 | 0x42 | 0x7c) => {
                if kind != 0x18 {
                    self.name()?;
                }
                self.at = self.end()?;
                None
            }
            kind => {
                let (sample, size) = match kind {
                    0x01 => (Some(Sample::U8), 1),
                    0x04 => (Some(Sample::I16), 2),
                    0x05 => (Some(Sample::U16), 2),
                    0x06 => (Some(Sample::I32), 4),
                    0x07 => (Some(Sample::U32), 4),
                    0x0a => (Some(Sample::I64), 8),
                    0x0b => (Some(Sample::U64), 8),
                    0x0c => (Some(Sample::F32), 4),
                    0x0d => (Some(Sample::F64), 8),
                    TIME => (None, TIME_BYTES),
                    _ => return Err(self.input.wrong("type of an item", at, kind, "a known one")),
                };
                let start = self.at;
                self.at += size;
                let numbers = sample.map(|sample| self.input.samples(path, start, 1, sample)).transpose()?;
                numbers.map(|numbers| Item::Number(numbers[0]))
            }
        })
    }

    /// Reads a name, which its length precedes.
    fn name(&mut self) -> Result<String> {
        let length = self.u32()? as usize;
        let text = self.input.take("a name", self.at, length)?;
        self.at += length;
        Ok(utf8_or_latin1(text))
    }

    /// Reads a length and returns where the value that follows ends.
    fn end(&mut self) -> Result<usize> {
        let at = self.at;
        let length = match self.u8()? {
            1 => self.u8()?.into(),
            2 => self.u16()?.into(),
            4 => self.u32()? as usize,
            other => return Err(self.input.wrong("size of a length", at, other, "1, 2 or 4")),
        };
        self.input.take("an item", self.at, length)?;
        Ok(self.at + length)
    }

    /// Reads the shape of a matrix. One with a type has more names.
    fn matrix(&mut self, has_type: bool) -> Result<Item> {
        self.name()?;
        if has_type {
            self.u32()?;
            self.name()?;
        }
        let end = self.end()?;
        let (rows, columns) = (self.u32()?, self.u32()?);
        let start = self.at;
        self.at = end;
        Ok(Item::Matrix(start, rows, columns, end))
    }
}
