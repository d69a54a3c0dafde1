//! Renders a run made of analytic functions: `cargo run -p asperity-report --example demo -- FOLDER`.

#![expect(clippy::disallowed_methods, reason = "writes the rendered page")]

#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use std::{env, error::Error, fs, path::PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(env::args().nth(1).ok_or("name the folder to write to")?);
    fs::create_dir_all(folder.join("figures"))?;
    for (page, run) in [("report.html", synthetic::full_run()), ("surface.html", synthetic::surface_run())] {
        let report = asperity_report::render(&run)?;
        fs::write(folder.join(page), report.html)?;
        for figure in report.figures {
            fs::write(folder.join("figures").join(figure.name + ".svg"), figure.svg)?;
        }
    }
    Ok(())
}
