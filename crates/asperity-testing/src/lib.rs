//! Random maps, records, monitors, studies, counts of intervals, and published test functions and values for tests.

mod choices;
mod coverage;
mod distances;
mod functions;
mod maps;
mod monitors;
mod published;
mod records;
mod study;

pub use choices::Choices;
pub use coverage::{covered, least_coverage, repetitions};
pub use distances::kolmogorov_smirnov_to;
pub use functions::{BOREHOLE, ISHIGAMI, SOBOL_G, SOBOL_G_PARAMETERS, TestFunction};
pub use maps::{filtered_noise, paraboloid, self_affine};
pub use monitors::{AlwaysCancelled, CancelAfter};
pub use published::{CAPPED_HERTZ, CappedHertz, LEINE};
pub use records::autoregressive;
pub use study::{METHODS, StudyText};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
