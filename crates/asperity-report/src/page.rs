//! The HTML page: headline answers, one section per stage, inputs, assumptions, provenance, references.

pub(crate) mod answers;
mod cells;
mod cutoff;
mod friction;
mod parameters;
mod provenance;
mod random_surface;
mod references;
mod tables;
mod vibration;

use asperity_results::Provenance;
use minijinja::{AutoEscape, Environment, Value, context};

use crate::figures::{Plate, Stage};

use crate::{ReportError, Run};
pub(crate) use cells::DASH;
pub(crate) use friction::{conditions, law_name, leading_level};
pub(crate) use parameters::parameter;
pub(crate) use random_surface::{in_words, length_in_words};

const TEMPLATE: &str = include_str!("page/report.html");
/// Style of every page.
const STYLE: &str = include_str!("page/style.css");

/// A table of the page: header cells, rows of text, and the file that holds the numbers. A row of one cell is the title of
/// the rows below it.
#[derive(Debug, Clone, Default)]
struct DataTable {
    caption: String,
    headers: Vec<String>,
    rows: Vec<Vec<String>>,
    source: String,
}

impl DataTable {
    fn new(caption: &str, headers: &[&str], rows: Vec<Vec<String>>, source: &str) -> Self {
        let headers = headers.iter().map(|header| (*header).to_owned()).collect();
        Self { caption: caption.into(), headers, rows, source: source.into() }
    }

    /// Leaves out columns in which every cell is a dash.
    fn without_empty_columns(mut self) -> Self {
        let kept: Vec<bool> = (0..self.headers.len())
            .map(|c| self.rows.iter().filter(|row| row.len() > 1).any(|row| row.get(c).is_some_and(|t| t != DASH)))
            .collect();
        let keep = |row: &Vec<String>| {
            row.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(text, _)| text.clone()).collect::<Vec<_>>()
        };
        self.rows = self.rows.iter().map(keep).collect();
        let mut columns = kept.iter();
        self.headers.retain(|_| columns.next() == Some(&true));
        self
    }

    fn value(&self) -> Value {
        let rows: Vec<Value> = self.rows.iter().map(|row| Value::from(row.clone())).collect();
        context! {
            caption => self.caption.clone(),
            headers => self.headers.clone(),
            rows => rows,
            source => self.source.clone(),
        }
    }
}

/// A method of the pressure's law as a reader calls it.
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

fn section(plates: &[Plate], stage: Stage, id: &str, title: &str, lead: &str, tables: &[DataTable]) -> Option<Value> {
    let figures: Vec<Value> = plates
        .iter()
        .enumerate()
        .filter(|(_, plate)| plate.stage == stage)
        .map(|(index, plate)| {
            context! {
                number => index + 1,
                name => plate.name,
                title => plate.title.clone(),
                caption => plate.caption.clone(),
                sources => plate.sources.clone(),
                svg => Value::from_safe_string(plate.svg.clone()),
            }
        })
        .collect();
    let tables: Vec<Value> = tables.iter().filter(|table| !table.rows.is_empty()).map(DataTable::value).collect();
    (!figures.is_empty() || !tables.is_empty())
        .then(|| context! { id => id, title => title, lead => lead, tables => tables, figures => figures })
}

/// The page of a run.
///
/// # Errors
/// The template engine's.
pub(crate) fn html(run: &Run, plates: &[Plate]) -> Result<String, ReportError> {
    let results = &run.results;
    let friction = results.friction.as_ref();
    let sections: Vec<Value> = [
        section(
            plates,
            Stage::Surface,
            "surface",
            "Surface",
            "What the measured map says about heights, and the random surface that stands for it. Every statistic \
             belongs to the bandwidth between field size and pixel size.",
            &tables::surface(run),
        ),
        section(
            plates,
            Stage::Pressure,
            "pressure",
            "Contact pressure",
            &format!(
                "How often a point of the surface is in contact, and how the pressure there is distributed, by independent \
                 methods. {}",
                results.pressure.as_ref().map_or_else(String::new, tables::refused_methods)
            ),
            &results.pressure.as_ref().map_or_else(Vec::new, |pressure| tables::pressure(run, pressure)),
        ),
        section(
            plates,
            Stage::Friction,
            "friction",
            "Friction coefficient",
            &friction::lead(friction),
            &friction.map_or_else(Vec::new, friction::tables),
        ),
        section(
            plates,
            Stage::Quotient,
            "quotient",
            "Quotient F/N of single windows",
            &friction::quotient_lead(friction),
            &friction.map_or_else(Vec::new, friction::quotient_tables),
        ),
        section(
            plates,
            Stage::Vibration,
            "vibration",
            "Friction-induced vibration",
            "Whether the machine vibrates without roughness, and what the roughness does to it. Displacement and time \
             are dimensionless: X = xc/N, τ = ω₀t.",
            &results.vibration.as_ref().map_or_else(Vec::new, vibration::tables),
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    let inputs: Vec<Value> = tables::inputs(&run.inputs).iter().map(DataTable::value).collect();
    let present: Vec<Stage> = [
        (Stage::Surface, results.surface.is_some()),
        (Stage::Pressure, results.pressure.is_some()),
        (Stage::Friction, friction.is_some()),
        (Stage::Vibration, results.vibration.is_some()),
    ]
    .into_iter()
    .filter(|(stage, is_present)| *is_present || plates.iter().any(|plate| plate.stage == *stage))
    .map(|(stage, _)| stage)
    .collect();
    let answers: Vec<Value> = answers::answers(run)
        .into_iter()
        .map(|a| context! { question => a.question, answer => a.answer, detail => a.detail })
        .collect();
    let page = context! {
        name => run.name.clone(),
        answers => answers,
        warnings => results.warnings.clone(),
        sections => sections,
        inputs => inputs,
        assumptions => results.assumptions.clone(),
        provenance => provenance(run.provenance.as_ref()),
        references => references::references(&present),
    };
    filled_in(TEMPLATE, page)
}

/// Every entry of `provenance.json` as a row.
pub(crate) fn provenance(provenance: Option<&Provenance>) -> Vec<Value> {
    let rows = provenance.into_iter().flat_map(provenance::rows);
    rows.map(|(key, value)| context! { key => key, value => value }).collect()
}

/// A page from its template; all text of the context is escaped.
///
/// # Errors
/// The template engine's.
pub(crate) fn filled_in(template: &str, page: Value) -> Result<String, ReportError> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_global("style", Value::from_safe_string(STYLE.into()));
    environment
        .render_named_str("page.html", template, page)
        .map_err(|error| ReportError::Template { message: format!("{error:#}") })
}
