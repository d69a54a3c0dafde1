//! The details at the end of a page: further figures and all tables of each link of the chain, inputs and conditions, folded.

use crate::markup::{Html, html};
use crate::page::section::Section;

/// Returns the entries as HTML; `number` is the number of figures before them. A link to an entry opens it, because its target is inside.
pub(super) fn html(entries: &[Section], number: &mut usize) -> Html {
    if entries.is_empty() {
        return Html::default();
    }
    let entries = entries.iter().map(|entry| {
        let content = entry.content(number);
        html!(
            "<details>\n<summary>{}</summary>\n<div id=\"{}\">\n{}</div>\n</details>\n",
            entry.title,
            entry.id,
            content
        )
    });
    html!("<section id=\"details\">\n<h2>Details</h2>\n{}</section>\n", entries.collect::<Html>())
}
