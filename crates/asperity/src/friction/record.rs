//! Statistics of friction records.
