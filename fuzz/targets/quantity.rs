//! Quantities, distributions and uncertain values in their text forms.

#![no_main]

use std::fmt::{Debug, Display};
use std::str::FromStr;

use asperity::distribution::Marginal;
use asperity::quantity::{Area, Compliance, Length, Pressure, Velocity};
use asperity::study::StudyFile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    shown_again::<Length>(text);
    shown_again::<Area>(text);
    shown_again::<Pressure>(text);
    shown_again::<Velocity>(text);
    shown_again::<Compliance>(text);
    if let Ok(marginal) = text.parse::<Marginal>() {
        assert_eq!(marginal.to_string().parse().as_ref(), Ok(&marginal), "{marginal}");
    }
    let value = toml::Value::from(text);
    let study = format!("seed = 1\n[vibration]\ndamping_ratio = {value}\nbelt_velocity = {value}\n");
    let _ = StudyFile::parse(&study, "/nonexistent/study.toml");
});

/// What is shown reads as the same quantity.
fn shown_again<T: FromStr<Err: Debug> + Display + PartialEq + Debug>(text: &str) {
    if let Ok(quantity) = text.parse::<T>() {
        let shown = quantity.to_string();
        assert_eq!(shown.parse::<T>().unwrap_or_else(|error| panic!("{shown}: {error:?}")), quantity, "{shown}");
    }
}
