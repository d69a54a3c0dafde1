//! A study: configuration, run, results. The only module that knows the whole chain, and that writes files.

pub mod config;
mod parse;
mod result;
mod series;
mod store;

pub use config::Study;
pub use parse::StudyFileError;
pub use result::*;
pub use series::{Field, Table, TableError};
pub use store::{Staging, StoreError, StoredField, StoredRun, json_bytes};
