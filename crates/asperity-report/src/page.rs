//! The HTML page: the verdict or headline answers, sections with tables and figures, inputs, assumptions, provenance, references, and
//! an appendix.

pub(crate) mod answer;
pub(crate) mod answers;
mod appendix;
mod certainty;
mod chain;
mod cutoff;
pub(crate) mod data_table;
mod friction;
mod machine;
mod mode_coupling;
pub(crate) mod parameters;
mod provenance;
mod random_surface;
mod references;
pub(crate) mod section;
mod tables;
pub(crate) mod verdict;
mod vibration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use sha2::{Digest, Sha256};

use self::answer::Answer;
use self::machine::Machine;
use self::section::{Section, unordered};
use crate::figures;
use crate::markup::{Html, html};
use crate::{Figure, ReportError, Run};

const STYLE: &str = include_str!("page/style.css");
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
    pub(crate) warnings: &'a [String],
    pub(crate) sections: Vec<Section>,
    pub(crate) appendix: Vec<Section>,
    /// Script of the page beside that of its figures; empty for none.
    pub(crate) script: &'static str,
    /// Machine that the reader can move.
    pub(crate) machine: Option<Machine<'a>>,
}

impl Page<'_> {
    /// Renders the page. Figures are numbered through all sections.
    pub(crate) fn render(self) -> Report {
        let Self { title, intro, first_screen, answers, warnings, mut sections, appendix, script, machine } = self;
        if let Some(machine) = &machine {
            machine.add_to(&mut sections);
        }
        let links = answers.first().map(|_| ("answers", "Answers")).into_iter();
        let links = links.chain(sections.iter().map(|section| (section.id, section.title)));
        let links = links.chain(appendix.first().map(|_| ("appendix", "Appendix")));
        let links = links.map(|(id, title)| html!("<li><a href=\"#{}\">{}</a></li>\n", id, title));
        let nav = html!("<nav aria-label=\"Sections\"><ul>\n{}</ul></nav>\n", links.collect::<Html>());
        let values = first_screen.as_ref().map(|_| "The chain with all values at their centres:");
        let (opening, first_screen) = match first_screen {
            Some(screen) => (html!("<h1 class=\"small\">{}</h1>\n", &title), html!("{}{}", screen, nav)),
            None => (html!("<h1>{}</h1>\n<p>{}</p>\n{}", &title, intro, nav), Html::default()),
        };
        let warnings = match warnings {
            [] => Html::default(),
            _ => html!(
                "<div class=\"warnings\" role=\"note\"><strong>Warnings</strong>\n{}</div>\n",
                unordered(warnings)
            ),
        };
        let draws = sections.iter().chain(&appendix).any(|section| !section.figures.is_empty());
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
            opening = opening,
            first_screen = first_screen,
            answers = answer::list(&answers, values),
            warnings = warnings,
            sections = sections.iter().map(|section| section.html(&mut number)).collect::<Html>(),
            appendix = appendix::html(&appendix, &mut number),
        );
        let figures = sections.into_iter().chain(appendix).flat_map(|section| section.figures).map(Figure::from);
        Report { html: html.into_string(), figures: figures.collect() }
    }
}

/// Arranges the page of a run.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn of_run(run: &Run) -> Result<Page<'_>, ReportError> {
    let results = &run.results;
    let (pressure, friction, vibration) =
        (results.pressure.as_ref(), results.friction.as_ref(), results.vibration.as_ref());
    let [heights, methods, models] = appendix::entries(run)?;
    let surface = Section::new(
        "surface",
        "Surface",
        "Height statistics of the measured map, and the random surface fitted to it. Every statistic belongs to the bandwidth \
         between field size and pixel size.",
        tables::surface(run),
        figures::surface::figures(run)?,
    )
    .map(|section| section.with_further(heights.as_ref()).with_answer(answers::of_surface(run)));
    let contact = Section::new(
        "pressure",
        "Contact pressure",
        format!(
            "Probability that a point of the surface is in contact, and distribution of the pressure there, by independent methods. {}",
            pressure.map_or_else(String::new, tables::refused_methods)
        ),
        pressure.map(tables::scalars).into_iter().collect(),
        appendix::without_moved(figures::pressure::figures(run)?),
    )
    .map(|section| section.with_further(methods.as_ref()).with_answer(pressure.map(answers::of_pressure)));
    let coefficient = Section::new(
        "friction",
        "Friction coefficient",
        friction::lead(friction),
        friction.map_or_else(Vec::new, friction::tables),
        appendix::without_moved(figures::friction::figures(run)),
    )
    .map(|section| section.with_further(models.as_ref()).with_answer(friction.map(answers::of_friction)));
    let quotient = Section::new(
        "quotient",
        "Quotient F/N of single windows",
        friction::quotient_lead(friction),
        friction.map_or_else(Vec::new, friction::quotient_tables),
        figures::friction::quotient_figures(run)?,
    )
    .map(|section| section.with_answer(friction.and_then(answers::of_quotient)));
    let motion = Section::new(
        "vibration",
        "Friction-induced vibration",
        "The vibration of the machine without roughness, and the effect of the roughness on it. Displacement, time and \
         velocity are dimensionless: X = xc/N, τ = ω₀t and dX/dτ.",
        vibration.map_or_else(Vec::new, vibration::tables),
        figures::vibration::figures(run)?,
    )
    .map(|section| section.with_answer(vibration.map(answers::of_vibration)));
    let coupled = Section::new(
        "mode-coupling",
        "Mode coupling",
        "Stability of steady sliding of a mass with two modes that friction couples, and the vibration that follows.",
        results.mode_coupling.as_ref().map_or_else(Vec::new, mode_coupling::tables),
        figures::vibration::coupled_figures(run),
    )
    .map(|section| section.with_answer(results.mode_coupling.as_ref().map(answers::of_mode_coupling)));
    let judged = Section::new(
        "verdict",
        "Behind the verdict",
        verdict::lead(results.verdict.as_ref().map(|verdict| verdict.model).unwrap_or_default()),
        results.verdict.as_ref().map_or_else(Vec::new, verdict::tables),
        figures::verdict::figures(run)?,
    )
    .map(|section| section.with_answer(results.verdict.as_ref().map(crate::verdict_sentence)));
    let stages = [
        surface.is_some() || results.surface.is_some(),
        contact.is_some() || pressure.is_some(),
        coefficient.is_some() || friction.is_some(),
        motion.is_some() || vibration.is_some(),
        coupled.is_some(),
    ];
    let inputs = "The study with all defaults, and where each value comes from. Settings change the error of the computation, not the \
                  machine.";
    let assumptions = "Conventions and defaults behind the results above.";
    let sections = [
        judged,
        surface,
        contact,
        coefficient,
        quotient,
        motion,
        coupled,
        Section::new(
            "certainty",
            "How sure, and why",
            "Brackets are 95 % intervals. They contain the errors of sampling, but not errors of the model or of values that the study \
             states as exact. Where the truth is known, 93 to 97 % of such intervals contain it. Fewer do for a Beta distribution \
             whose bounds are fitted to friction (bounds 78 to 90 %, shapes 86 to 94 %), Svk of heights that end sharply (86 %) and \
             Sku of slightly skewed heights (88 %). The percentage is 90 to 93 % for the shape of the friction tail and its return \
             levels, and 89 to 92 % for the correlation length of strongly skewed friction. In some cases it is 91 to 93 % for the \
             standard deviation and skewness of friction, the correlation at a lag, Svk, and quantiles of the pressure by Latin \
             hypercubes. Nearly all intervals of small probabilities of vibration contain the truth, because they allow for regions \
             that no draw reached.",
            vec![certainty::table(run)],
            Vec::new(),
        ),
        Section::new("inputs", "Inputs", inputs, tables::inputs(&run.inputs), Vec::new()),
        Section::sentences("assumptions", "Assumptions", assumptions, &results.assumptions),
        Section::provenance(run.provenance.as_ref()),
        Some(Section::references(&references::references(stages)).with_citation(run.provenance.as_ref())),
    ];
    let sections: Vec<Section> = sections.into_iter().flatten().collect();
    let ids: Vec<&str> = sections.iter().map(|section| section.id).collect();
    let first_screen =
        results.verdict.as_ref().map(|verdict| verdict::first_screen(run, verdict, &chain::strip(run, &ids)));
    Ok(Page {
        title: run.name.clone(),
        intro: "From the rough surface to friction and vibration: report of a study by asperity.",
        first_screen,
        answers: answers::answers(run),
        warnings: &results.warnings,
        sections,
        appendix: [heights, methods, models].into_iter().flatten().collect(),
        script: "",
        machine: run.machine.as_deref().map(|json| Machine { json, is_centre: results.verdict.is_some() }),
    })
}
