//! TIFF.

use crate::fixture::Fixture;

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![]
}
