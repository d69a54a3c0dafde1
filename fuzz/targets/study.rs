//! Study and campaign files: `study` alone, or parts `study` and `campaign`.

#![no_main]

use std::path::Path;

use asperity::study::{Campaign, Study};
use libfuzzer_sys::fuzz_target;

/// A folder without files: studies name scans and samples.
const FILE: &str = "/nonexistent/study.toml";

fuzz_target!(|input: &str| {
    let parts = asperity_fuzz::parts(input.as_bytes());
    let text = |name: &str| {
        let part = parts.iter().find(|(own, _)| own == name).map(|(_, part)| *part);
        part.and_then(|part| std::str::from_utf8(part).ok())
    };
    let study = text("study").unwrap_or(input);
    if let Some(campaign) = text("campaign") {
        let _ = asperity_fuzz::bounded(input.len(), || Campaign::parse(campaign, Path::new(FILE), study, None));
    } else if let Ok(parsed) = asperity_fuzz::bounded(input.len(), || Study::parse(study, FILE)) {
        // What `asperity check` states and what a run folder holds.
        let _ = (parsed.warnings(), parsed.estimate(0, 2), parsed.disk_bytes());
        let table = parsed.file().to_table().expect("a valid study can be written");
        let text = toml::to_string(&table).expect("a table is TOML");
        let again = Study::parse(&text, FILE).expect("a written study is valid");
        assert_eq!(again.file(), parsed.file());
    }
});
