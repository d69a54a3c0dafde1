//! Sections of a page.

use asperity_results::Provenance;

use super::data_table::DataTable;
use super::provenance;
use crate::figures::CaptionedFigure;
use crate::markup::{Html, html, with_code};
use crate::works::{Work, program_bibtex};

/// Most figures of a link of the chain before the details.
const PICTURES: usize = 2;

/// A section of a page.
#[derive(Default)]
pub(crate) struct Section {
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    /// The answer of the section in one sentence.
    answer: String,
    lead: String,
    tables: Vec<DataTable>,
    pub(super) figures: Vec<CaptionedFigure>,
    list: Html,
    /// Id of the entry of the details with further figures and all tables.
    further: Option<&'static str>,
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

    /// Returns a section of figures and HTML.
    pub(crate) fn of_html(
        id: &'static str,
        title: &'static str,
        lead: impl Into<String>,
        figures: Vec<CaptionedFigure>,
        list: Html,
    ) -> Self {
        Self { id, title, lead: lead.into(), figures, list, ..Self::default() }
    }

    /// Returns the section of the references.
    pub(crate) fn references(works: impl IntoIterator<Item = String>) -> Self {
        let list = html!("<ol>{}</ol>\n", items(&works.into_iter().collect::<Vec<_>>()));
        Self { id: "references", title: "References", list, ..Self::default() }
    }

    /// Adds the program and the works for BibTeX.
    pub(super) fn with_citation(self, works: &[&Work], provenance: Option<&Provenance>) -> Self {
        let version = provenance.map_or("", |provenance| provenance.asperity.as_str());
        let entries: String = works.iter().map(|work| work.bibtex()).collect();
        let entries = program_bibtex(version) + "\n" + &entries;
        let list = html!("{}<h3>BibTeX</h3>\n<pre tabindex=\"0\">{}</pre>\n", self.list, entries);
        Self { list, ..self }
    }

    /// Returns the section of the provenance; `None` without it.
    pub(crate) fn provenance(provenance: Option<&Provenance>) -> Option<Self> {
        let tables = provenance.map(provenance::table).into_iter().collect();
        Self::new("provenance", "Provenance", "", tables, Vec::new())
    }

    /// States the answer of the section.
    pub(super) fn with_answer(self, answer: Option<String>) -> Self {
        Self { answer: answer.unwrap_or_default(), ..self }
    }

    /// Keeps the first two figures of these names, and moves the others and all tables to an entry of the details, given by its id, its
    /// title and its first sentence. A section of which nothing else is left is dropped.
    pub(super) fn folded(
        section: Option<Self>,
        shown: &[&str],
        entry: (&'static str, &'static str, &str),
    ) -> [Option<Self>; 2] {
        let Some(mut section) = section else { return [None, None] };
        let place =
            |figure: &CaptionedFigure| shown.iter().position(|name| *name == figure.name).unwrap_or(shown.len());
        section.figures.sort_by_key(place);
        let kept = section.figures.iter().filter(|figure| place(figure) < shown.len()).count().min(PICTURES);
        let (id, title, lead) = entry;
        let figures = section.figures.split_off(kept);
        let details = Self::new(id, title, lead, std::mem::take(&mut section.tables), figures);
        section.further = details.as_ref().map(|_| id);
        let is_empty = section.figures.is_empty() && section.answer.is_empty() && section.lead.is_empty();
        [(!is_empty).then_some(section), details]
    }

    pub(super) fn html(&self, number: &mut usize) -> Html {
        let content = self.content(number);
        html!("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", self.id, self.title, content)
    }

    /// Returns everything below the title.
    pub(super) fn content(&self, number: &mut usize) -> Html {
        let paragraph = |class: &'static str, text: &str| match text {
            "" => Html::default(),
            text => html!("<p class=\"{}\">{}</p>\n", class, text),
        };
        let lead = html!("{}{}", paragraph("found", &self.answer), paragraph("lead", &self.lead));
        let figures = self.figures.iter().map(|figure| {
            *number += 1;
            figure_html(*number, figure)
        });
        let further = self.further.map_or_else(Html::default, |id| {
            html!("<p class=\"further\"><a href=\"#{}\">All figures and numbers</a></p>\n", id)
        });
        let block = |class: &'static str, count: usize, parts: Html| match count {
            0 => Html::default(),
            _ => html!("<div class=\"{}\">\n{}</div>\n", class, parts),
        };
        html!(
            "{}{}{}{}{}",
            lead,
            block("figures", self.figures.len(), figures.collect::<Html>()),
            block("tables", self.tables.len(), self.tables.iter().map(DataTable::html).collect::<Html>()),
            &self.list,
            further,
        )
    }
}

fn items<T: AsRef<str>>(texts: &[T]) -> Html {
    texts.iter().map(|text| html!("<li>{}</li>", with_code(text.as_ref()))).collect()
}

/// Returns texts as the items of a list.
pub(super) fn unordered(texts: &[String]) -> Html {
    html!("<ul>{}</ul>\n", items(texts))
}

fn figure_html(number: usize, figure: &CaptionedFigure) -> Html {
    let sources = figure
        .sources
        .iter()
        .enumerate()
        .map(|(place, source)| html!("{}<code>{}</code>", if place == 0 { " Data: " } else { ", " }, source));
    let end = if figure.sources.is_empty() { "" } else { "." };
    html!(
        "<figure id=\"figure-{0}\">\n<h3>Figure {1}. {2} <a class=\"permalink\" href=\"#figure-{0}\" aria-label=\"Link to figure {1}\">#</a></h3>\n\
         <div class=\"drawing\" tabindex=\"0\">{3}</div>\n<figcaption>{4}{5}{6}</figcaption>\n</figure>\n",
        figure.name,
        number.to_string(),
        &figure.title,
        Html::from_markup(figure.svg_of_page()),
        &figure.caption,
        sources.collect::<Html>(),
        end,
    )
}
