//! Prints errors against closed forms and published values as Markdown. The solutions and functions are those of the tests.
//!
//! `cargo run --release -p asperity-validation --bin validate_closed_forms` prints `docs/validation/closed-forms.md`; `just validate`
//! writes the file.
#![expect(clippy::print_stdout, reason = "prints tables")]

mod chaos;
mod contact;
mod vibration;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const HEAD: &str = "# Closed forms and published values

After this page you know the error of each link of the chain where the exact answer is known, and how the error falls with the effort. `just
validate` writes this page, with the solutions and functions of the tests. Errors are relative unless a column header states otherwise.
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
