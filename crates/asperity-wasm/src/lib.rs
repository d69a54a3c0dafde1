//! WebAssembly bindings of asperity, for browsers.
//!
//! Settings are passed as JSON texts, in SI units unless a name says otherwise. Results are an [`Answer`]: numbers as
//! a JSON text, with the keys of the command line's `--json`, and arrays by name. An error is a JavaScript `Error`
//! with the message of the library.
//!
//! | call | result |
//! |---|---|
//! | [`dimensionless`] | a machine in the variables of the oscillator |
//! | [`cycle`], [`limits`], [`ensemble`] | motion of the oscillator |
//! | [`portrait`], [`reattachment`] | figures of the motion as SVG |
//! | [`Surface`] | statistics, spectrum, random twin, contact and friction of a scan or a stated surface |
//!
//! Without the feature `surface` the module contains the oscillator alone.
//!
//! Long calls report progress to the function `asperityProgress(task, done, total)` of the global object. They cannot
//! be interrupted: run them in a worker, and end the worker to cancel.

mod answer;
#[cfg(all(fuzzing, feature = "surface"))]
pub mod fuzzing;
mod monitor;
mod oscillator;
#[cfg(feature = "surface")]
mod surface;

pub use answer::Answer;
pub use oscillator::{cycle, dimensionless, ensemble, limits, portrait, reattachment};
#[cfg(feature = "surface")]
pub use surface::{Surface, inputs};

use std::panic;

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn log_error(text: &str);
}

/// Writes the message of an internal error to the console of the browser. Runs when the module is loaded.
#[wasm_bindgen(start)]
pub fn start() {
    panic::set_hook(Box::new(|information| log_error(&information.to_string())));
}

/// Returns the version of the library.
#[wasm_bindgen]
#[must_use]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
