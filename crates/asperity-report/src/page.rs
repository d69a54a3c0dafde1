//! The HTML page: the verdict or headline answers, sections with tables and figures, inputs, assumptions, provenance, references, and
//! an appendix.

pub(crate) mod answers;
mod appendix;
mod cells;
mod certainty;
mod chain;
mod cutoff;
mod friction;
mod machine;
mod mode_coupling;
mod parameters;
mod provenance;
mod random_surface;
mod references;
mod tables;
mod verdict;
mod vibration;

use std::fmt::{self, Display};

use asperity_results::Provenance;
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use sha2::{Digest, Sha256};

pub use self::verdict::verdict_text;
use crate::figures::{self, CaptionedFigure};
use crate::markup::{Html, html};
use crate::{Figure, Report, ReportError, Run};
pub(crate) use answers::Answer;
pub(crate) use cells::{DASH, percent, shown};
pub(crate) use friction::{conditions, distribution_name, operating_level};
pub(crate) use machine::Machine;
pub(crate) use parameters::parameter;
pub(crate) use random_surface::{in_words, length_in_words};
pub(crate) use verdict::{dimension, named};
pub(crate) use vibration::kind_in_words;

const STYLE: &str = include_str!("page/style.css");
/// Script of the figures, bundled from `web/src/report.ts`.
const FIGURES: &str = include_str!("page/figures.js");

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
            answers = answers::list(&answers, values),
            warnings = warnings,
            sections = sections.iter().map(|section| section.html(&mut number)).collect::<Html>(),
            appendix = appendix::html(&appendix, &mut number),
        );
        let figures = sections.into_iter().chain(appendix).flat_map(|section| section.figures).map(Figure::from);
        Report { html: html.into_string(), figures: figures.collect() }
    }
}

/// A section of a page.
#[derive(Default)]
pub(crate) struct Section {
    id: &'static str,
    title: &'static str,
    /// The answer of the section in one sentence.
    answer: String,
    lead: String,
    tables: Vec<DataTable>,
    figures: Vec<CaptionedFigure>,
    list: Html,
    /// Id and title of the entry of the appendix with further tables and figures.
    further: Option<(&'static str, &'static str)>,
}

impl Section {
    /// Returns a section of tables and figures; `None` without any.
    pub(crate) fn new(
        id: &'static str,
        title: &'static str,
        lead: impl Into<String>,
        mut tables: Vec<DataTable>,
        figures: Vec<CaptionedFigure>,
    ) -> Option<Self> {
        tables.retain(|table| !table.rows.is_empty());
        let is_empty = tables.is_empty() && figures.is_empty();
        (!is_empty).then(|| Self { id, title, lead: lead.into(), tables, figures, ..Self::default() })
    }

    /// Returns a section of sentences; `None` without any.
    pub(crate) fn sentences(id: &'static str, title: &'static str, lead: &str, items: &[String]) -> Option<Self> {
        let list = unordered(items);
        (!items.is_empty()).then(|| Self { id, title, lead: lead.into(), list, ..Self::default() })
    }

    /// Returns a section of HTML.
    pub(crate) fn of_html(id: &'static str, title: &'static str, lead: impl Into<String>, list: Html) -> Self {
        Self { id, title, lead: lead.into(), list, ..Self::default() }
    }

    /// Returns the section of the references.
    pub(crate) fn references(works: &[&str]) -> Self {
        let list = html!("<ol>{}</ol>\n", items(works));
        Self { id: "references", title: "References", list, ..Self::default() }
    }

    /// Adds how to cite the program and the paper.
    fn with_citation(self, provenance: Option<&Provenance>) -> Self {
        let version = provenance.map_or("", |provenance| provenance.asperity.as_str());
        let list = html!("{}<h3>BibTeX</h3>\n<pre tabindex=\"0\">{}</pre>\n", self.list, references::bibtex(version));
        Self { list, ..self }
    }

    /// Returns the section of the provenance; `None` without it.
    pub(crate) fn provenance(provenance: Option<&Provenance>) -> Option<Self> {
        let tables = provenance.map(provenance::table).into_iter().collect();
        Self::new("provenance", "Provenance", "", tables, Vec::new())
    }

    /// States the answer of the section.
    fn with_answer(self, answer: Option<String>) -> Self {
        Self { answer: answer.unwrap_or_default(), ..self }
    }

    /// Names the entry of the appendix that belongs to the section, if there is one.
    fn with_further(self, entry: Option<&Self>) -> Self {
        Self { further: entry.map(|entry| (entry.id, entry.title)), ..self }
    }

    fn html(&self, number: &mut usize) -> Html {
        let content = self.content(number);
        html!("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", self.id, self.title, content)
    }

    /// Returns everything below the title.
    fn content(&self, number: &mut usize) -> Html {
        let paragraph = |class: &'static str, text: &str| match text {
            "" => Html::default(),
            text => html!("<p class=\"{}\">{}</p>\n", class, text),
        };
        let lead = html!("{}{}", paragraph("found", &self.answer), paragraph("lead", &self.lead));
        let figures = self.figures.iter().map(|figure| {
            *number += 1;
            figure_html(*number, figure)
        });
        let further = self.further.map_or_else(Html::default, |(id, title)| {
            html!("<p class=\"further\">In the appendix: <a href=\"#{}\">{}</a></p>\n", id, title)
        });
        html!(
            "{}<div class=\"tables\">\n{}</div>\n<div class=\"figures\">\n{}</div>\n{}{}",
            lead,
            self.tables.iter().map(DataTable::html).collect::<Html>(),
            figures.collect::<Html>(),
            &self.list,
            further,
        )
    }
}

fn items<T: AsRef<str>>(texts: &[T]) -> Html {
    texts.iter().map(|text| html!("<li>{}</li>", text)).collect()
}

fn unordered(texts: &[String]) -> Html {
    html!("<ul>{}</ul>\n", items(texts))
}

fn figure_html(number: usize, figure: &CaptionedFigure) -> Html {
    let sources = figure.sources.iter().enumerate().map(|(place, source)| {
        let comma = if place == 0 { "" } else { ", " };
        html!("{}<code>{}</code>", comma, source)
    });
    html!(
        "<figure id=\"figure-{0}\">\n<h3>Figure {1}. {2} <a class=\"permalink\" href=\"#figure-{0}\" aria-label=\"Link to figure {1}\">#</a></h3>\n\
         <div class=\"static\">{3}</div>\n<script type=\"application/json\">{4}</script>\n<figcaption>{5} Data: {6}.</figcaption>\n</figure>\n",
        figure.name,
        number.to_string(),
        &figure.title,
        Html::from_markup(figure.svg()),
        // No tag can begin inside of the data.
        Html::from_markup(figure.layout.json().to_string().replace('<', "\\u003c")),
        &figure.caption,
        sources.collect::<Html>(),
    )
}

/// A table of the page: header cells, rows of text, and the file that holds the numbers. A row of one cell is the title of
/// the rows below it.
#[derive(Debug, Clone, Default)]
pub(crate) struct DataTable {
    caption: String,
    headers: Vec<String>,
    rows: Vec<Vec<String>>,
    /// Rows whose last cell is highlighted.
    highlighted: Vec<usize>,
    source: String,
}

impl DataTable {
    pub(crate) fn new(caption: &str, headers: &[&str], rows: Vec<Vec<String>>, source: &str) -> Self {
        let headers = headers.iter().map(|header| (*header).to_owned()).collect();
        Self { caption: caption.into(), headers, rows, highlighted: Vec::new(), source: source.into() }
    }

    /// Returns a table of names and values. A name with an empty value is the title of the rows below it.
    pub(crate) fn properties(caption: &str, rows: impl IntoIterator<Item = (String, String)>, source: &str) -> Self {
        let row = |(name, value): (String, String)| if value.is_empty() { vec![name] } else { vec![name, value] };
        Self::new(caption, &["Property", "Value"], rows.into_iter().map(row).collect(), source)
    }

    /// Highlights the last cell of some rows.
    pub(crate) fn with_highlighted(self, highlighted: Vec<usize>) -> Self {
        Self { highlighted, ..self }
    }

    /// Leaves out columns in which every cell is a dash.
    fn without_empty_columns(mut self) -> Self {
        let kept: Vec<bool> = (0..self.headers.len())
            .map(|c| self.rows.iter().filter(|row| row.len() > 1).any(|row| row.get(c).is_some_and(|t| t != DASH)))
            .collect();
        for row in self.rows.iter_mut().chain([&mut self.headers]) {
            let mut columns = kept.iter();
            row.retain(|_| columns.next() == Some(&true));
        }
        self
    }

    fn html(&self) -> Html {
        let caption = match self.caption.as_str() {
            "" => Html::default(),
            caption => html!("<caption>{}</caption>\n", caption),
        };
        let headers = self.headers.iter().map(|header| html!("<th scope=\"col\">{}</th>", header));
        let rows = self.rows.iter().enumerate().map(|(place, row)| match row.as_slice() {
            [title] => {
                let span = self.headers.len().to_string();
                html!("<tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{}\">{}</th></tr>\n", span, title)
            }
            [first, cells @ ..] => {
                let is_highlighted = self.highlighted.contains(&place);
                let cells =
                    cells.iter().enumerate().map(|(column, cell)| match is_highlighted && column + 1 == cells.len() {
                        true => html!("<td class=\"outside\">{}</td>", cell),
                        false => html!("<td>{}</td>", cell),
                    });
                html!("<tr><th scope=\"row\">{}</th>{}</tr>\n", first, cells.collect::<Html>())
            }
            [] => Html::default(),
        });
        html!(
            "<div class=\"table\" role=\"region\" tabindex=\"0\" aria-label=\"{}\">\n<table>\n{}<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n</table>\n\
             <p class=\"source\">Source: <code>{}</code></p>\n</div>\n",
            if self.caption.is_empty() { "Table" } else { &self.caption },
            caption,
            headers.collect::<Html>(),
            rows.collect::<Html>(),
            &self.source,
        )
    }
}

impl Display for DataTable {
    /// Writes the caption, then the headers and rows in aligned columns.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = || std::iter::once(&self.headers).chain(&self.rows);
        let cell = |row: &[String], column: usize| row.get(column).map_or(0, |cell| cell.chars().count());
        let widths: Vec<usize> =
            (0..self.headers.len()).map(|column| rows().map(|row| cell(row, column)).max().unwrap_or(0)).collect();
        writeln!(f, "{}", self.caption)?;
        for row in rows() {
            let cells = row.iter().zip(&widths).map(|(cell, width)| format!("  {cell:width$}"));
            writeln!(f, "{}", cells.collect::<String>().trim_end())?;
        }
        Ok(())
    }
}

/// Returns the name of a method for the distribution of the pressure, for readers.
pub(crate) fn method_name(method: &str) -> String {
    match method {
        "monte_carlo" => "Monte Carlo".into(),
        "latin_hypercube" => "Latin hypercube".into(),
        "sobol" => "Sobol’ sequence".into(),
        "polynomial_chaos" => "polynomial chaos".into(),
        "polynomial_chaos_log" => "polynomial chaos of log p".into(),
        "polynomial_chaos_local" => "local polynomial chaos".into(),
        "default" => "default of asperity".into(),
        other => other.replace('_', " "),
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
            "Brackets are 95 % intervals of what was sampled. They do not contain errors of the model, nor of values that the study states \
             as exact. Where the truth is known, 93 to 97 % of such intervals contain it; fewer do for the bounds of a Beta distribution \
             that are fitted to friction (78 to 93 %), Svk of heights that end sharply (86 %), Sku of slightly skewed heights (88 %), the \
             shape of the friction tail and its return levels (90 to 93 %), and the correlation length of strongly skewed friction (91 %); \
             in some cases 91 to 93 % do for the standard deviation and skewness of friction, the correlation at a lag, Svk, and quantiles of \
             the pressure by Latin hypercubes. \
             Nearly all intervals of small probabilities of vibration contain it, because they allow for regions that no draw reached.",
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
