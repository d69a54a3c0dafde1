//! List of readable and writable file formats.

use asperity_formats::{Description, descriptions};
use clap::Args;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, print};

/// Lists the formats of surface files.
///
/// Content read, content written, and the files that the reader was tested on.
#[derive(Debug, Args)]
pub(crate) struct Formats {
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Formats {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        monitor.check()?;
        if self.json {
            let formats: Vec<Value> = descriptions().map(as_json).collect();
            return Answer::default().with("formats", formats).print(true);
        }
        print(&table())
    }
}

fn as_json(format: &Description) -> Value {
    json!({
        "name": format.format.name(),
        "extensions": format.extensions,
        "vendor": format.vendor,
        "known_by": format.known_by,
        "reads": format.reads,
        "writes": format.writes,
        "stores_pixel_size": format.stores_pitch,
        "missing_points": format.missing_points,
        "orientation": format.orientation,
        "tested_on": format.tested.describe(),
    })
}

/// Formats a line per format, followed by the content that is read and written.
fn table() -> String {
    let extensions = |format: &Description| {
        format.extensions.iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(" ")
    };
    let names = descriptions().map(|format| format.format.name().chars().count()).max().unwrap_or_default();
    let endings = descriptions().map(|format| extensions(format).chars().count()).max().unwrap_or_default();
    let mut text = String::new();
    for format in descriptions() {
        text += &format!("{:names$}  {:endings$}  {}\n", format.format.name(), extensions(format), format.vendor);
        for (label, content) in [("reads", format.reads), ("writes", format.writes)] {
            if !content.is_empty() {
                text += &format!("  {label:9}{content}\n");
            }
        }
        if !format.reads.is_empty() {
            text += &format!("  {:9}{}\n", "tried on", format.tested.describe());
        }
    }
    text += "The content of a file decides its format, not its name. Files compressed with gzip are unpacked. Row 0 is at the top.\n";
    text
}
