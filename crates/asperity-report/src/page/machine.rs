//! The section in which the reader moves the machine of a run, with the core of asperity in the browser.

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;

use crate::markup::{Html, html};
use crate::page::section::Section;

/// The oscillator in WebAssembly, gzipped, and the script of its worker; both built from `web`.
const MODULE: &[u8] = include_bytes!("oscillator.wasm.gz");
const WORKER: &str = include_str!("oscillator.js");

/// Machine that the reader of a page can move.
pub(crate) struct Machine<'a> {
    /// The content of `machine.json`.
    pub(crate) json: &'a str,
    /// Whether other machines of the study have other values.
    pub(crate) is_centre: bool,
}

impl Machine<'_> {
    /// Adds the section of the machine behind that of its vibration.
    pub(super) fn add_to(&self, sections: &mut Vec<Section>) {
        let centre = if self.is_centre { ", with all uncertain values at their centres" } else { "" };
        let lead = format!(
            "The machine of this study{centre}. Move a slider, and your browser computes the vibration again; nothing leaves this computer. \
             Friction keeps its distribution and its correlation length; the surface is not computed again."
        );
        let list = html!(
            "<div id=\"machine\" hidden>\n<script type=\"application/json\">{}</script>\n<div class=\"controls\"></div>\n\
             <div class=\"moved\">\n<p class=\"found\" id=\"moved\" aria-live=\"polite\"></p>\n<p id=\"moved-details\"></p>\n\
             <p class=\"problem\" role=\"alert\" hidden></p>\n<p class=\"status\" hidden><progress max=\"1\" aria-label=\"Progress\"></progress> \
             <button type=\"button\" id=\"moved-cancel\">Cancel</button></p>\n</div>\n\
             <div class=\"portrait\"></div>\n<div class=\"histogram\"></div>\n</div>\n\
             <p class=\"without-script\">The sliders appear in a browser that runs scripts and WebAssembly.</p>\n",
            // No tag can begin inside of the data.
            Html::from_markup(self.json.replace('<', "\\u003c")),
        );
        let place = sections.iter().position(|section| section.id == "vibration").map_or(sections.len(), |at| at + 1);
        sections.insert(place, Section::of_html("move", "Try it", lead, Vec::new(), list));
    }
}

/// Returns the elements of the page with the module and the script of its worker.
pub(super) fn module() -> Html {
    Html::from_markup(format!(
        "<script type=\"text/plain\" id=\"module\">{}</script>\n<script type=\"text/plain\" id=\"worker\">{}</script>\n",
        BASE64.encode(MODULE),
        WORKER.trim_end()
    ))
}
