//! HDF5 containers as far as instrument files use them. Untrusted bytes are read without copying.
//!
//! Supported are: superblocks of version 0 to 3 with 8-byte addresses; object headers of version 1 and 2; groups as
//! symbol tables, link messages and dense links; attributes in the header and in a fractal heap; numbers, texts,
//! compounds, arrays and variable-length values in the global heap; data that are compact, contiguous, one chunk, or
//! chunks under a version 1 B-tree, with deflate, shuffle and Fletcher-32. Soft and external links are skipped. Other
//! features are refused by name: chunk indices of HDF5 1.10 and later (with the command that rewrites the file), other filters, shared messages beyond
//! committed datatypes.
//!
//! Structures refer to each other by address, so a small file can describe a very large or an endless structure.
//! Every byte of a structure that is read counts against a budget ([`WORK_BYTES`]): a loop, or a structure that is
//! shared too often, ends with an error. Names, texts and data remain slices of the file until the final copy.
//! Checksums of structures are not verified; invalid values reveal damaged fields.
//!
//! Layout: HDF5 File Format Specification, version 3.0.

mod chunks;
mod dataset;
mod datatype;
mod file;
mod group;
mod header;
mod heap;
mod layout;
mod piece;
mod tree;
mod value;

use crate::Result;

pub(crate) use dataset::Dataset;
use datatype::{Class, Datatype};
pub(crate) use file::File;
use file::MAX_ENTRIES;
pub(crate) use header::Object;
use piece::Piece;
use tree::Keys;
pub(crate) use value::{Attribute, Value, shown_name, shown_number};

impl<'a> File<'a> {
    /// Returns the names of the links in the root group.
    pub(crate) fn names(&self) -> Result<Vec<&'a [u8]>> {
        let root = self.object(self.root)?;
        Ok(self.links(&root)?.iter().map(|link| link.name).collect())
    }

    /// Returns the object at a path from the root; `None` if there is none.
    pub(crate) fn find(&self, path: &str) -> Result<Option<Object>> {
        let mut object = self.object(self.root)?;
        for name in path.split('/').filter(|name| !name.is_empty()) {
            match self.links(&object)?.iter().find(|link| link.name == name.as_bytes()) {
                Some(link) => object = self.object(link.address)?,
                None => return Ok(None),
            }
        }
        Ok(Some(object))
    }
}
