//! The appendix: fitted distributions, the comparison of methods, and checks of models, folded.

use crate::figures::{self, CaptionedFigure};
use crate::markup::{Html, html};
use crate::page::section::Section;
use crate::page::{friction, parameters, tables};
use crate::{ReportError, Run};

/// Figures of the appendix.
const METHODS: [&str; 3] = ["pressure_intervals", "pressure_accuracy", "expansion_error"];
const MODELS: [&str; 2] = ["friction_pit", "friction_qq"];

/// Returns the entries for the sections surface, pressure and friction.
///
/// # Errors
/// The PNG encoder failed.
pub(super) fn entries(run: &Run) -> Result<[Option<Section>; 3], ReportError> {
    let (pressure, friction) = (run.results.pressure.as_ref(), run.results.friction.as_ref());
    Ok([
        Section::new(
            "appendix-surface",
            "Distributions fitted to the heights",
            "",
            parameters::distributions(run).into_iter().collect(),
            Vec::new(),
        ),
        Section::new(
            "appendix-pressure",
            if pressure.is_some_and(|pressure| pressure.reference_samples > 0) {
                "Comparison of the methods for the pressure"
            } else {
                "Numbers of the distribution of the pressure"
            },
            "",
            pressure.map(tables::methods).into_iter().collect(),
            moved(figures::pressure::figures(run)?, &METHODS),
        ),
        Section::new(
            "appendix-friction",
            "Distributions and correlation families of the friction coefficient",
            "",
            friction.map_or_else(Vec::new, friction::model_tables),
            moved(figures::friction::figures(run), &MODELS),
        ),
    ])
}

fn moved(figures: Vec<CaptionedFigure>, names: &[&str]) -> Vec<CaptionedFigure> {
    figures.into_iter().filter(|figure| names.contains(&figure.name)).collect()
}

/// Returns the figures of a section without those of the appendix.
pub(super) fn without_moved(mut figures: Vec<CaptionedFigure>) -> Vec<CaptionedFigure> {
    figures.retain(|figure| !METHODS.contains(&figure.name) && !MODELS.contains(&figure.name));
    figures
}

/// Returns the entries as HTML; `number` is the number of figures before them.
pub(super) fn html(entries: &[Section], number: &mut usize) -> Html {
    if entries.is_empty() {
        return Html::default();
    }
    let entries = entries.iter().map(|entry| {
        let content = entry.content(number);
        html!("<details id=\"{}\">\n<summary>{}</summary>\n{}</details>\n", entry.id, entry.title, content)
    });
    html!("<section id=\"appendix\">\n<h2>Appendix</h2>\n{}</section>\n", entries.collect::<Html>())
}
