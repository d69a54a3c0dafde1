//! The table of formats, and its copy in the README.

use asperity_formats::{Description, Format, Tested, descriptions};

/// The README of the crate.
const README: &str = include_str!("../../README.md");

fn row(format: &Description) -> String {
    let extensions: Vec<String> = format.extensions.iter().map(|extension| format!("`.{extension}`")).collect();
    let or_dash = |text: &str| if text.is_empty() { "–".to_owned() } else { text.to_owned() };
    let tested = if format.reads.is_empty() { "–".into() } else { format.tested.describe().to_owned() };
    format!(
        "| {} | {} | {} | {} | {} | {} | {} |",
        format.format.name(),
        extensions.join(" "),
        format.vendor,
        or_dash(format.reads),
        or_dash(format.writes),
        or_dash(format.missing_points),
        tested
    )
}

#[test]
fn the_readme_shows_the_table() {
    let wanted: Vec<String> = descriptions().map(row).collect();
    let found: Vec<&str> = README.lines().filter(|line| line.starts_with("| ") && line.contains("`.")).collect();
    assert_eq!(found, wanted, "the table for the README:\n{}", wanted.join("\n"));
}

#[test]
fn every_format_is_described() {
    for format in descriptions() {
        let name = format.format.name();
        assert!(!format.extensions.is_empty() && !format.vendor.is_empty(), "{name}");
        assert!(!format.reads.is_empty() || !format.writes.is_empty(), "{name}");
        assert!(format.reads.is_empty() || !format.orientation.is_empty() && !format.known_by.is_empty(), "{name}");
        assert_eq!(format.format.stores_pitch(), format.stores_pitch);
    }
    assert!(descriptions().any(|format| format.tested == Tested::InstrumentFiles));
}

#[test]
fn names_and_written_extensions_are_unique() {
    let mut names: Vec<&str> = descriptions().map(|format| format.format.name()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), descriptions().count());
    for format in descriptions().filter(|format| !format.writes.is_empty()) {
        assert_eq!(Format::from_extension(format.extensions[0]), Some(format.format), "{}", format.format.name());
        assert_eq!(Format::from_extension(&format.extensions[0].to_uppercase()), Some(format.format));
    }
    assert_eq!(Format::from_extension("docx"), None);
}
