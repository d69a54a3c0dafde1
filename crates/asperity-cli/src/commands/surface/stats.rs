//! What a measured surface is.

use std::error::Error;
use std::path::PathBuf;

use asperity::study::statistics;
use asperity::surface::level::{Level, remove_form};
use clap::{Args, ValueEnum};

use crate::failure::Failure;
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::Answer;

/// Computes ISO 25178-2 parameters, correlation lengths and the fractal dimension of a map.
#[derive(Debug, Args)]
pub(crate) struct Stats {
    /// Measured or generated heights, in any format that `asperity formats` lists; known by its content.
    file: PathBuf,
    /// Form that is removed by least squares.
    #[arg(long, value_enum, default_value = "plane")]
    level: Form,
    #[command(flatten)]
    options: ScanOptions,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Form {
    /// Nothing.
    None,
    /// The mean height.
    Mean,
    /// The least-squares plane.
    Plane,
    /// The least-squares quadratic.
    Quadratic,
}

impl Stats {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let map = input::map(&self.file, &self.options, monitor)?;
        let level = match self.level {
            Form::None => Level::None,
            Form::Mean => Level::Mean,
            Form::Plane => Level::Plane,
            Form::Quadratic => Level::Quadratic,
        };
        let unusable = |e: &dyn Error| Failure::data(self.file.display(), e);
        let levelled = remove_form(&map, level).map_err(|e| unusable(&e))?;
        let statistics = monitor.at_once(|| statistics(&levelled.map, 0))?.map_err(|e| unusable(&e))?;
        Answer::of(&statistics)?.print(self.json)
    }
}
