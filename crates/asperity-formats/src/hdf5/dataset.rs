//! Datasets: datatype, shape, and data in one of three layouts.

use std::borrow::Cow;

use super::datatype::dimensions;
use super::header::{DATASPACE, DATATYPE, FILL_VALUE, FILTERS, LAYOUT, OLD_FILL_VALUE};
use super::layout::{self, Chunks, Filter};
use super::{Class, Datatype, File, Object, Piece, Value};
use crate::{ByteOrder, Result, Sample};

/// Dataset with its header.
pub(crate) struct Dataset<'a> {
    /// Offset of its header.
    pub(crate) at: usize,
    pub(crate) datatype: Datatype,
    pub(crate) shape: Vec<usize>,
    layout: Layout<'a>,
    pub(super) filters: Vec<Filter>,
    /// Value of elements that were never written; zeros if `None`.
    pub(super) fill: Option<&'a [u8]>,
}

/// Place of the elements.
enum Layout<'a> {
    /// Data in the header.
    Compact(&'a [u8]),
    /// Contiguous data; `None` if nothing was written.
    Contiguous(Option<usize>),
    Chunked(Chunks),
}

impl<'a> File<'a> {
    /// Returns the dataset of an object; `None` for a group.
    pub(crate) fn dataset(&self, object: &Object) -> Result<Option<Dataset<'a>>> {
        let (Some(datatype), Some(space), Some(layout)) =
            (object.first(DATATYPE), object.first(DATASPACE), object.first(LAYOUT))
        else {
            return Ok(None);
        };
        let shape = dimensions(self.message(space, "dataspace")?)?;
        let datatype = self.datatype(self.message(datatype, "datatype")?, datatype.shared)?;
        let layout = read_layout(self.message(layout, "layout")?)?;
        let filters = match object.first(FILTERS) {
            Some(message) => layout::filters(self.message(message, "filters")?)?,
            None => Vec::new(),
        };
        let fill = match (object.first(FILL_VALUE), object.first(OLD_FILL_VALUE)) {
            (Some(message), _) => fill_value(self.message(message, "fill value")?)?,
            (None, Some(message)) => sized(self.message(message, "fill value")?)?,
            (None, None) => None,
        };
        let fill = fill.filter(|fill| fill.len() == datatype.bytes);
        Ok(Some(Dataset { at: object.at, datatype, shape, layout, filters, fill }))
    }

    /// Returns all bytes of a dataset in row order.
    ///
    /// # Errors
    /// Absent data, and chunks that unpack to more than the size of the file allows.
    pub(crate) fn bytes(&self, dataset: &Dataset<'a>) -> Result<Cow<'a, [u8]>> {
        let count = dataset.shape.iter().copied().fold(1, usize::saturating_mul);
        let length = count.saturating_mul(dataset.datatype.bytes);
        let at = dataset.at;
        match &dataset.layout {
            Layout::Compact(bytes) => match bytes.get(..length) {
                Some(bytes) => Ok(Cow::Borrowed(bytes)),
                None => Err(self.input.wrong("data in the header", at, bytes.len(), &format!("{length} bytes"))),
            },
            Layout::Contiguous(Some(address)) => self.input.take("data", *address, length).map(Cow::Borrowed),
            Layout::Contiguous(None) => Err(self.input.missing("data", at, "data that were written")),
            Layout::Chunked(chunks) => self.unpack(dataset, chunks).map(Cow::Owned),
        }
    }

    /// Returns the numbers of a dataset in row order; `None` if its elements are not numbers.
    pub(crate) fn numbers(&self, dataset: &Dataset<'a>) -> Result<Option<Vec<f64>>> {
        let Some((sample, order)) = dataset.sample() else { return Ok(None) };
        let bytes = self.bytes(dataset)?;
        let mut numbers = Vec::with_capacity(bytes.len() / sample.size());
        sample.decode(order, &bytes, &mut numbers);
        Ok(Some(numbers))
    }

    /// Passes the elements of a dataset to `visit` until it returns a value.
    pub(crate) fn find_element<T>(
        &self,
        dataset: &Dataset<'a>,
        bytes: &[u8],
        mut visit: impl FnMut(Value) -> Result<Option<T>>,
    ) -> Result<Option<T>> {
        for bytes in bytes.chunks_exact(dataset.datatype.bytes) {
            self.charge("table", dataset.at, bytes.len())?;
            let found = visit(Value { file: self, datatype: &dataset.datatype, bytes })?;
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }
}

impl Dataset<'_> {
    /// Returns the type of the elements if they are numbers.
    pub(crate) fn sample(&self) -> Option<(Sample, ByteOrder)> {
        match self.datatype.class {
            Class::Number(sample, order) => Some((sample, order)),
            _ => None,
        }
    }
}

fn read_layout<'a>(mut message: Piece<'a>) -> Result<Layout<'a>> {
    let version = message.version(&[3, 4])?;
    let class_at = message.at();
    Ok(match message.u8("class")? {
        0 => {
            let length = message.size("size", 2)?;
            Layout::Compact(message.take("data", length)?)
        }
        1 => Layout::Contiguous(message.optional_address("address")?),
        2 => Layout::Chunked(layout::layout(message, version)?),
        class => return Err(message.wrong("class", class_at, class, "0 compact, 1 contiguous, 2 chunked")),
    })
}

/// Returns the value in a fill value message; `None` if it is undefined.
fn fill_value<'a>(mut message: Piece<'a>) -> Result<Option<&'a [u8]>> {
    let is_defined = match message.version(&[1, 2, 3])? {
        // Bit 5 of the flags marks a defined value.
        3 => message.u8("flags")? & 1 << 5 != 0,
        version => {
            message.skip("times", 2)?;
            message.u8("defined")? != 0 || version == 1
        }
    };
    if is_defined { sized(message) } else { Ok(None) }
}

/// Returns a value after its size; `None` for size 0.
fn sized<'a>(mut message: Piece<'a>) -> Result<Option<&'a [u8]>> {
    let length = message.size("size", 4)?;
    Ok(Some(message.take("value", length)?).filter(|value| !value.is_empty()))
}
