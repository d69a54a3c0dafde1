//! Questions and their answers.

use crate::markup::{Html, html};

/// A question, its short answer, and its conditions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Answer {
    pub(crate) question: &'static str,
    pub(crate) answer: String,
    pub(crate) detail: String,
}

/// Returns the answers as HTML.
pub(super) fn list(answers: &[Answer]) -> Html {
    let items = answers.iter().map(|Answer { question, answer, detail }| {
        let template =
            html!("<dt>{}</dt><dd class=\"answer\">{}</dd><dd class=\"detail\">{}</dd>", question, answer, detail);
        html!("<div>{}</div>\n", template)
    });
    match answers {
        [] => Html::default(),
        _ => html!(
            "<section id=\"answers\" aria-label=\"Answers\">\n<dl class=\"answers\">\n{}</dl>\n</section>\n",
            items.collect::<Html>()
        ),
    }
}
