//! Results of a study as one self-contained HTML page and SVG figures.
//!
//! [`render`] is a pure function of a [`Run`]: it reads no file, clock or environment, and equal runs give equal bytes.
//! A study may stop after any of its stages; the report leaves out absent results, tables and fields.
//!
//! # Conventions
//! - Numbers are in SI units, with the unit in the names of columns and keys (`lag_m`, `pressure_pa`); the report chooses
//!   engineering units for display.
//! - NaN in tables and `None` in results mean undefined. Curves are interrupted there and cells show a dash.
//! - All text of the caller is escaped: HTML is written from literal templates only.

mod campaign;
mod cells;
mod error;
mod figures;
mod fits;
mod format;
#[doc(hidden)]
pub mod live;
mod markup;
mod motion;
mod page;
mod plot;
mod record;
mod run;
mod twin;
mod verdict;
mod words;
mod works;

pub use campaign::{CampaignRun, campaign_summary, render_campaign};
pub use error::ReportError;
pub use figures::Figure;
pub use motion::{CoupledModes, VibrationFigures, render_vibration};
pub use page::Report;
pub use page::answers::vibration_answer;
pub use page::verdict::text::{verdict_summary, verdict_text};
pub use record::record_figures;
pub use run::{Input, Run};
pub use twin::render_twins;
pub use twin::run::TwinRun;
pub use verdict::{not_stated, verdict_answer, verdict_sentence};
pub use works::{Work, program_bibtex, works};

/// Renders the report of a run.
///
/// # Errors
/// The PNG encoder failed.
pub fn render(run: &Run) -> Result<Report, ReportError> {
    Ok(page::of_run(run)?.render())
}
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
