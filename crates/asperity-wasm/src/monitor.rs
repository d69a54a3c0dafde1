//! Progress of long calls.

use asperity_base::monitor::Monitor;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_name = asperityProgress)]
    fn report(task: &str, done: u32, total: u32);
}

/// Monitor that reports to `asperityProgress` and never cancels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Progress;

impl Monitor for Progress {
    fn progress(&self, what: &str, done: usize, total: usize) {
        report(what, done as u32, total as u32);
    }

    fn cancelled(&self) -> bool {
        false
    }
}
