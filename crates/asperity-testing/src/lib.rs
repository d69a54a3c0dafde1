//! Random maps, records and monitors for tests.

mod choices;
mod maps;
mod monitors;
mod records;

pub use choices::Choices;
pub use maps::{filtered_noise, paraboloid, self_affine};
pub use monitors::{AlwaysCancelled, CancelAfter};
pub use records::autoregressive;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
