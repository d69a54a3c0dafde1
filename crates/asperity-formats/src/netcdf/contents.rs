//! Content of a file of either kind.

use crate::{FormatError, Sample, Shape, large, per_metre};

/// Variable of the map in files of SurfaceTopography.
pub(super) const HEIGHTS: &str = "heights";
/// Attributes that name a unit.
pub(super) const UNITS: [&str; 3] = ["unit", "units", "length_unit"];
/// Maximum number of dimensions, variables and attributes of one file together.
pub(super) const MAX_ENTRIES: usize = 1 << 16;
/// Maximum number of numbers of an attribute.
pub(super) const MAX_NUMBERS: usize = 16;

/// Content of a file.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) dimensions: Vec<Dimension>,
    pub(super) attributes: Vec<Attribute>,
    pub(super) variables: Vec<Variable>,
    /// Error of the first variable that could not be read.
    pub(super) first_error: Option<FormatError>,
}

/// Name and length.
pub(super) type Dimension = (String, usize);
/// Name and value.
pub(super) type Attribute = (String, Value);

pub(super) enum Value {
    Text(String),
    Numbers(Vec<f64>),
}

pub(super) struct Variable {
    pub(super) name: String,
    /// Indices of the dimensions; `None` for an HDF5 dataset without dimension scales.
    pub(super) dimensions: Vec<Option<usize>>,
    pub(super) shape: Vec<usize>,
    pub(super) attributes: Vec<Attribute>,
    /// Type of the numbers; `None` for texts.
    pub(super) sample: Option<Sample>,
    /// Offset of the numbers, or of the HDF5 object.
    pub(super) at: usize,
    /// Size of a record in bytes if the first dimension is the record dimension.
    pub(super) record_bytes: Option<usize>,
}

impl Variable {
    pub(super) fn attribute(&self, name: &str) -> Option<&Value> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value)
    }

    pub(super) fn numbers(&self, name: &str) -> &[f64] {
        match self.attribute(name) {
            Some(Value::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }

    pub(super) fn unit(&self) -> Option<&str> {
        UNITS.iter().find_map(|name| match self.attribute(name) {
            Some(Value::Text(text)) if !text.trim().is_empty() => Some(text.trim()),
            _ => None,
        })
    }

    /// Returns the last two dimensions if the variable is a map of numbers, 1 and the length if it is a line scan.
    pub(super) fn map(&self) -> Option<(usize, usize)> {
        let (columns, rest) = self.shape.split_last()?;
        if rest.is_empty() && self.name == HEIGHTS && self.sample.is_some() {
            return Some((1, *columns));
        }
        let (rows, rest) = rest.split_last()?;
        (self.sample.is_some() && rest.iter().all(|&length| length == 1)).then_some((*rows, *columns))
    }

    pub(super) fn is_height(&self) -> bool {
        self.map().is_some()
            && match self.unit() {
                Some(unit) => per_metre(unit).is_some(),
                None => self.name == HEIGHTS,
            }
    }
}

/// Returns the numbers of a map in column order. A wrong number of values is returned unchanged and fails later.
pub(super) fn transposed(numbers: Vec<f64>, shape: Shape) -> Vec<f64> {
    if numbers.len() == shape.0 * shape.1 { large::transposed(&numbers, shape) } else { numbers }
}
