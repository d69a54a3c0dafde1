//! The HTML page: the verdict or headline answers, a section with one or two figures for each link of the chain, and folded details.

pub(crate) mod answer;
mod answer_table;
pub(crate) mod answers;
mod certainty;
mod chain;
mod cutoff;
pub(crate) mod data_table;
mod details;
mod friction;
mod machine;
mod mode_coupling;
pub(crate) mod parameters;
mod provenance;
mod random_surface;
pub(crate) mod section;
mod stages;
mod tables;
pub(crate) mod verdict;
mod vibration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use sha2::{Digest, Sha256};

use self::answer::Answer;
use self::machine::Machine;
use self::section::{Section, unordered};
use crate::markup::{Html, html};
use crate::verdict::is_exact;
use crate::works::works;
use crate::{Figure, ReportError, Run};

const STYLE: &str = concat!(include_str!("page/style.css"), include_str!("page/figures.css"));
/// Script of the figures, bundled from `web/src/report.ts`.
const FIGURES: &str = include_str!("page/figures.js");

/// A rendered report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// One HTML document that needs no other file and no network.
    pub html: String,
    /// The figures of the document, for use elsewhere.
    pub figures: Vec<Figure>,
}

/// A page before it is rendered.
pub(crate) struct Page<'a> {
    pub(crate) title: String,
    pub(crate) intro: &'static str,
    /// The first screen of a run with a verdict; it takes the place of the introduction.
    pub(crate) first_screen: Option<Html>,
    pub(crate) answers: Vec<Answer>,
    pub(crate) warnings: Vec<String>,
    pub(crate) sections: Vec<Section>,
    /// Folded sections at the end.
    pub(crate) details: Vec<Section>,
    /// Script of the page beside that of its figures; empty for none.
    pub(crate) script: &'static str,
    /// Machine that the reader can move.
    pub(crate) machine: Option<Machine<'a>>,
}

impl Page<'_> {
    /// Renders the page. Figures are numbered through all sections.
    pub(crate) fn render(self) -> Report {
        let Self { title, intro, first_screen, answers, warnings, mut sections, details, script, machine } = self;
        if let Some(machine) = &machine {
            machine.add_to(&mut sections);
        }
        let links = first_screen.as_ref().map(|_| ("answer", "Verdict")).into_iter();
        let links = links.chain(answers.first().map(|_| ("answers", "Answers")));
        let links = links.chain(sections.iter().map(|section| (section.id, section.title)));
        let links = links.chain(details.first().map(|_| ("details", "Details")));
        let links = links.map(|(id, title)| html!("<li><a href=\"#{}\">{}</a></li>\n", id, title)).collect::<Html>();
        let (opening, first_screen) = match first_screen {
            Some(screen) => (html!("<h1 class=\"small\">{}</h1>\n", &title), screen),
            None => (html!("<h1>{}</h1>\n<p>{}</p>\n", &title, intro), Html::default()),
        };
        let warnings = match warnings.as_slice() {
            [] => Html::default(),
            _ => html!(
                "<div class=\"warnings\" role=\"note\"><strong>Warnings</strong>\n{}</div>\n",
                unordered(&warnings)
            ),
        };
        let draws = sections.iter().chain(&details).any(|section| !section.figures.is_empty());
        let scripts = [script, if draws { FIGURES } else { "" }].map(str::trim_end).into_iter();
        let scripts: Vec<&str> = scripts.filter(|script| !script.is_empty()).collect();
        let hash = |text: &&str| format!(" 'sha256-{}'", BASE64.encode(Sha256::digest(text)));
        let allowed = match scripts.as_slice() {
            [] => " 'none'".to_owned(),
            scripts => scripts.iter().map(hash).collect(),
        };
        let (computes, workers) = machine.as_ref().map_or(("", "'none'"), |_| (" 'wasm-unsafe-eval'", "blob:"));
        let mut number = 0;
        let html = html!(
            include_str!("page/skeleton.html"),
            script_policy = Html::from_markup(allowed + computes),
            worker_policy = Html::from_markup(workers.to_owned()),
            module = machine.map_or_else(Html::default, |_| machine::module()),
            style_policy = Html::from_markup(hash(&STYLE)),
            scripts = scripts
                .iter()
                .map(|script| Html::from_markup(format!("<script>{script}</script>\n")))
                .collect::<Html>(),
            title = title,
            style = Html::from_markup(STYLE.to_owned()),
            links = links,
            opening = opening,
            first_screen = first_screen,
            answers = answer::list(&answers),
            warnings = warnings,
            sections = sections.iter().map(|section| section.html(&mut number)).collect::<Html>(),
            details = details::html(&details, &mut number),
        );
        let figures = sections.into_iter().chain(details).flat_map(|section| section.figures).map(Figure::from);
        Report { html: html.into_string(), figures: figures.collect() }
    }
}

/// Arranges the page of a run.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn of_run(run: &Run) -> Result<Page<'_>, ReportError> {
    let results = &run.results;
    let links = [
        stages::judged(run)?,
        stages::surface(run)?,
        stages::contact(run)?,
        stages::coefficient(run)?,
        stages::motion(run)?,
        stages::coupled(run),
    ];
    let cited = works(results, &run.inputs);
    let inputs = "What was measured, stated or left to a default. study.toml has the settings of the computation, too.";
    let assumptions = "Conventions and defaults behind the results above.";
    let conditions = [
        Section::new(
            "certainty",
            "How sure, and why",
            "Brackets are 95 % intervals. They contain the errors of sampling, but not errors of the model or of values that the study \
             states as exact. Where the truth is known, 93 to 97 % of such intervals contain it. Fewer do for a Beta distribution \
             whose bounds are fitted to friction (bounds 78 to 90 %, shapes 86 to 94 %), Svk of heights that end sharply (86 %) and \
             Sku of slightly skewed heights (88 %). The percentage is 90 to 93 % for the shape of the friction tail and its return \
             levels, and 89 to 92 % for the correlation length of strongly skewed friction. In some cases it is 91 to 93 % for the \
             standard deviation and skewness of friction, the correlation at a lag, Svk, and quantiles of the pressure by Latin \
             hypercubes.",
            vec![certainty::table(run)],
            Vec::new(),
        ),
        Section::new("inputs", "Inputs", inputs, tables::inputs(&run.inputs), Vec::new()),
        Section::sentences("assumptions", "Assumptions", assumptions, &results.assumptions),
        Section::provenance(run.provenance.as_ref()),
        Some(Section::references(cited.iter().map(|work| work.text())).with_citation(&cited, run.provenance.as_ref())),
    ];
    let (sections, details): (Vec<_>, Vec<_>) = links.into_iter().map(|[section, entry]| (section, entry)).unzip();
    let sections: Vec<Section> = sections.into_iter().flatten().collect();
    let ids: Vec<&str> = sections.iter().map(|section| section.id).collect();
    let first_screen =
        results.verdict.as_ref().map(|verdict| verdict::first_screen(run, verdict, &chain::strip(run, &ids)));
    Ok(Page {
        title: run.name.clone(),
        intro: "From the rough surface to friction and vibration: report of a study by asperity.",
        first_screen,
        answers: if results.verdict.is_some() { Vec::new() } else { answers::answers(run) },
        warnings: results.warnings.clone(),
        sections,
        details: details.into_iter().chain(conditions).flatten().collect(),
        script: "",
        machine: run.machine.as_deref().map(|json| Machine {
            json,
            is_centre: results.verdict.as_ref().is_some_and(|verdict| !is_exact(verdict)),
        }),
    })
}
