//! A study: configuration, run, results. The only module that knows the whole chain, and that writes files.

pub mod config;
mod parse;
mod series;

pub use config::Study;
pub use parse::StudyFileError;
pub use series::{Field, Table, TableError};
