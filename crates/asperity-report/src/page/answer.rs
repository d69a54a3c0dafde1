//! Questions and their answers.

use crate::markup::{Html, html};

/// A question, its short answer, and its conditions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Answer {
    pub(crate) question: &'static str,
    pub(crate) answer: String,
    pub(crate) detail: String,
}

/// Returns the answers as HTML, below a sentence on the values that they hold for, if there is one.
pub(super) fn list(answers: &[Answer], lead: Option<&str>) -> Html {
    let lead = lead.map_or_else(Html::default, |lead| html!("<p class=\"lead\">{}</p>\n", lead));
    let items = answers.iter().map(|Answer { question, answer, detail }| {
        let template =
            html!("<dt>{}</dt><dd class=\"answer\">{}</dd><dd class=\"detail\">{}</dd>", question, answer, detail);
        html!("<div>{}</div>\n", template)
    });
    match answers {
        [] => Html::default(),
        _ => html!(
            "<section id=\"answers\" aria-label=\"Answers\">\n{}<dl class=\"answers\">\n{}</dl>\n</section>\n",
            lead,
            items.collect::<Html>()
        ),
    }
}
