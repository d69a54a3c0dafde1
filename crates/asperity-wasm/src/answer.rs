//! Results and errors of calls.

use std::error::Error;
use std::mem;

use asperity_base::sentence::chain;
use serde::Serialize;
use serde::de::DeserializeOwned;
use wasm_bindgen::prelude::*;

/// Result of a call: numbers as a JSON text, and arrays by name.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Answer {
    json: String,
    arrays: Vec<(&'static str, Vec<f64>)>,
}

#[wasm_bindgen]
impl Answer {
    /// Returns the numbers as a JSON object; undefined numbers are `null`.
    #[must_use]
    pub fn json(&self) -> String {
        self.json.clone()
    }

    /// Returns the names of the arrays.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.arrays.iter().map(|(name, _)| (*name).to_owned()).collect()
    }

    /// Takes an array out of the answer; empty if there is none of this name.
    pub fn take(&mut self, name: &str) -> Vec<f64> {
        let found = self.arrays.iter_mut().find(|(own, _)| *own == name);
        found.map(|(_, values)| mem::take(values)).unwrap_or_default()
    }
}

impl Answer {
    /// Creates an answer without arrays.
    pub(crate) fn new(numbers: &impl Serialize) -> Result<Self, Failure> {
        Ok(Self { json: serde_json::to_string(numbers)?, arrays: Vec::new() })
    }

    /// Adds an array.
    pub(crate) fn with(mut self, name: &'static str, values: Vec<f64>) -> Self {
        self.arrays.push((name, values));
        self
    }
}

/// Message of an error and of its causes.
#[derive(Debug, PartialEq)]
pub(crate) struct Failure(pub(crate) String);

impl<E: Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(chain(&error))
    }
}

impl From<Failure> for JsError {
    fn from(failure: Failure) -> Self {
        Self::new(&failure.0)
    }
}

/// Reads settings.
pub(crate) fn read<T: DeserializeOwned>(json: &str) -> Result<T, Failure> {
    Ok(serde_json::from_str(json)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_is_taken_once() {
        let mut answer = Answer::new(&[f64::NAN]).unwrap().with("pressure_pa", vec![1.0, 2.0]);
        assert_eq!((answer.json(), answer.names()), ("[null]".to_owned(), vec!["pressure_pa".to_owned()]));
        assert_eq!(answer.take("pressure_pa"), [1.0, 2.0]);
        assert!(answer.take("pressure_pa").is_empty() && answer.take("gap_m").is_empty());
    }
}
