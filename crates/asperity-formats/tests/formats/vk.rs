//! VK4/VK6.

use crate::fixture::Fixture;

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![]
}
