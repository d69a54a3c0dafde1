//! Errors against closed forms and published values, as Markdown, with the solutions and functions that the tests use.
//!
//! `cargo run --release -p asperity-validation --bin validate_closed_forms` prints what `docs/validation/closed-forms.md` holds; `just
//! validate` writes it.
#![expect(clippy::print_stdout, reason = "the tables are what this program is for")]

mod chaos;
mod contact;
mod vibration;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const HEAD: &str = "# Closed forms and published values

`just validate` writes this page, with the solutions and functions of the tests. After it you know the error of each link where the truth is
known, and how it falls with the effort. Errors are relative unless a column says otherwise.
";

fn main() -> Result<()> {
    println!("{HEAD}");
    for section in [
        contact::hertz()?,
        contact::capped_hertz()?,
        contact::westergaard()?,
        contact::light_load()?,
        vibration::leine()?,
        chaos::functions()?,
    ] {
        println!("{section}");
    }
    Ok(())
}

/// Returns a Markdown table.
fn table(headers: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head = line(&headers.iter().map(|header| (*header).to_owned()).collect::<Vec<_>>());
    let rule = line(&vec!["---:".to_owned(); headers.len()]);
    rows.into_iter().fold(head + &rule, |text, row| text + &line(&row))
}

/// Formats an error with two digits.
fn error(value: f64) -> String {
    format!("{value:.1e}")
}
