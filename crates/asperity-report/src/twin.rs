//! A scan beside its twins: one page, and the figures on it.

mod figures;

use std::collections::BTreeMap;

use asperity_results::Provenance;
use minijinja::{Value, context};
use serde_json::Value as Json;

use crate::format::{Dimension, significant};
use crate::page::{DASH, filled_in, in_words, length_in_words, parameter, provenance};
use crate::{Field, Figure, Report, ReportError, Table};

const TEMPLATE: &str = include_str!("twin/page.html");

/// Works that twins rest on.
const REFERENCES: [&str; 4] = [
    "M. Grigoriu: Crossings of non-Gaussian translation processes. Journal of Engineering Mechanics 110 (1984) 610–620. \
     doi:10.1061/(ASCE)0733-9399(1984)110:4(610)",
    "C. R. Dietrich, G. N. Newsam: Fast and exact simulation of stationary Gaussian processes through circulant embedding of \
     the covariance matrix. SIAM Journal on Scientific Computing 18 (1997) 1088–1107. doi:10.1137/S1064827592240555",
    "R. J. Hyndman, Y. Fan: Sample quantiles in statistical packages. The American Statistician 50 (1996) 361–365. \
     doi:10.1080/00031305.1996.10473566",
    "ISO 25178-2:2021, Geometrical product specifications (GPS), Surface texture: Areal, Part 2: Terms, definitions and \
     surface texture parameters.",
];

/// Everything that the page of a comparison shows.
#[derive(Debug, Clone, Default)]
pub struct TwinRun {
    /// Name of the scan.
    pub name: String,
    /// The parsed `comparison.json`.
    pub comparison: Json,
    /// The tables by the name of their CSV file, without its extension.
    pub tables: BTreeMap<String, Table>,
    /// The scan as it was prepared, in metre.
    pub scan: Option<Field>,
    /// The first twins, in metre.
    pub twins: Vec<Field>,
    /// The content of `provenance.json`.
    pub provenance: Option<Provenance>,
}

/// Renders the page of a scan and its twins; a pure function, as [`crate::render`].
///
/// # Errors
/// A table with columns of different lengths, a field that does not fill its grid or has no pixel size; never because
/// something is absent.
pub fn render_twins(run: &TwinRun) -> Result<Report, ReportError> {
    let fields = run.scan.iter().map(|scan| ("scan", scan)).chain(run.twins.iter().map(|twin| ("twin", twin)));
    crate::validate(run.tables.iter().map(|(name, table)| (name.as_str(), table)), fields)?;
    let drawn = figures::all(run)?;
    let html = page(run, &drawn)?;
    let figures = drawn.into_iter().map(|drawn| Figure { name: drawn.name.into(), svg: drawn.svg }).collect();
    Ok(Report { html, figures })
}

fn page(run: &TwinRun, drawn: &[figures::Drawn]) -> Result<String, ReportError> {
    let comparison = &run.comparison;
    let figures: Vec<Value> = drawn
        .iter()
        .enumerate()
        .map(|(index, drawn)| {
            context! {
                number => index + 1,
                name => drawn.name,
                title => drawn.title,
                caption => drawn.caption.clone(),
                sources => drawn.sources.clone(),
                svg => Value::from_safe_string(drawn.svg.clone()),
            }
        })
        .collect();
    let sentences = |key: &str| -> Vec<String> {
        comparison[key].as_array().into_iter().flatten().filter_map(|s| s.as_str().map(str::to_owned)).collect()
    };
    let page = context! {
        name => run.name.clone(),
        answers => answers(comparison),
        warnings => sentences("warnings"),
        figures => figures,
        rows => rows(comparison),
        band => band_in_words(comparison),
        limits => sentences("limits"),
        assumptions => sentences("assumptions"),
        provenance => provenance(run.provenance.as_ref()),
        references => REFERENCES,
    };
    filled_in(TEMPLATE, page)
}

/// The statistics of a comparison in the order in which parameters are shown.
fn statistics(comparison: &Json) -> Vec<(&str, &Json)> {
    let order = |key: &str| parameter(key).map_or(usize::MAX, |(place, _, _)| place);
    let mut found: Vec<(&str, &Json)> =
        comparison["twins"].as_object().into_iter().flatten().map(|(key, value)| (key.as_str(), value)).collect();
    found.sort_by_key(|(key, _)| order(key));
    found
}

/// Symbol of a statistic, and what it means.
fn named(key: &str) -> (String, String) {
    match parameter(key) {
        // Its symbol is that of the forward differences too.
        Some((_, symbol, meaning)) if key == "Sdq_7point" => (format!("{symbol} (7 points)"), meaning.into()),
        Some((_, symbol, meaning)) => (symbol.into(), meaning.into()),
        None => (Dimension::of_key(key).0.replace('_', " "), String::new()),
    }
}

fn band_of(statistic: &Json) -> Option<(f64, f64)> {
    Some((statistic["band"][0].as_f64()?, statistic["band"][1].as_f64()?))
}

fn rows(comparison: &Json) -> Vec<Value> {
    let row = |(key, statistic): (&str, &Json)| {
        let (symbol, meaning) = named(key);
        let dimension = Dimension::of_key(key).1;
        let show = |value: &Json| value.as_f64().map_or("–".into(), |value| dimension.show(value));
        let twins = statistic["mean"].as_f64().map_or("–".into(), |m| dimension.show_interval(m, band_of(statistic)));
        let inside = statistic["inside"].as_bool();
        context! {
            symbol => symbol,
            meaning => meaning,
            scan => show(&statistic["target"]),
            twins => twins,
            distance => distance(statistic).map_or("–".into(), |d| format!("{}{}", if d > 0.0 { "+" } else { "" }, crate::format::fixed(d, 1))),
            verdict => match inside { Some(true) => "within", Some(false) => "outside", None => "–" },
            outside => inside == Some(false),
        }
    };
    statistics(comparison).into_iter().map(row).collect()
}

/// How far the scan lies from the mean of its twins, in their standard deviations.
fn distance(statistic: &Json) -> Option<f64> {
    let (target, mean, std) = (statistic["target"].as_f64()?, statistic["mean"].as_f64()?, statistic["std"].as_f64()?);
    (std > 0.0).then(|| (target - mean) / std)
}

fn band_in_words(comparison: &Json) -> String {
    let count = comparison["count"].as_u64().unwrap_or(0);
    match comparison["band_method"].as_str() {
        Some("student_t") => format!(
            "The band holds the statistic of a further twin with probability 95 %: Student’s prediction interval of {count} \
             twins, which takes statistics for normal: positive ones on a logarithmic scale and shares by their log-odds, so \
             that the band stays in their range. From 39 twins on it ends at order statistics and takes nothing for granted."
        ),
        Some("quantiles") => format!(
            "The band holds the statistic of a further twin with probability 95 %: it ends at the order statistics of \
             {count} twins, whatever the law of the statistic."
        ),
        _ => "A single twin has no band; draw more.".into(),
    }
}

/// How much of the functions lies in the pointwise bands: as part of the answer, and function by function.
fn curves_in_words(comparison: &Json) -> (String, String) {
    const CURVES: [(&str, &str); 6] = [
        ("height_pdf", "height density"),
        ("acf_x", "autocorrelation along x"),
        ("acf_y", "autocorrelation along y"),
        ("psd_x", "spectrum along x"),
        ("psd_y", "spectrum along y"),
        ("psd_radial", "radial spectrum"),
    ];
    let percent = |share: f64| format!("{} %", crate::format::fixed(100.0 * share, 0));
    let (inside, points) = (comparison["curves_inside"].as_f64(), comparison["curves_compared"].as_f64());
    let (Some(inside), Some(points)) = (inside, points.filter(|points| *points > 0.0)) else {
        return (String::new(), String::new());
    };
    let each: Vec<String> = CURVES
        .iter()
        .filter_map(|(key, name)| {
            Some(format!("{name} {}", percent(comparison["curves"][*key]["inside_share"].as_f64()?)))
        })
        .collect();
    let detail = format!(
        " Points of the curves within: {}. Chance alone would leave 95 % there, with a wide scatter for density and \
         autocorrelation, whose neighbours go together.",
        each.join(", ")
    );
    (format!(" and {} of the points of the curves", percent(inside / points)), detail)
}

/// A word of the comparison, or a dash.
fn word(value: &Json) -> &str {
    value.as_str().unwrap_or(DASH)
}

fn answers(comparison: &Json) -> Vec<Value> {
    let answer = |question: &str, answer: String, detail: String| context! { question => question, answer => answer, detail => detail };
    let mut answers = Vec::new();
    if let (Some(inside), Some(compared @ 1..)) = (comparison["inside"].as_u64(), comparison["compared"].as_u64()) {
        let outside: Vec<String> = statistics(comparison)
            .into_iter()
            .filter(|(_, statistic)| statistic["inside"] == Json::Bool(false))
            .map(|(key, _)| named(key).0)
            .collect();
        let chance = significant((0.5 * compared as f64).round() / 10.0, 2);
        let detail = if outside.is_empty() {
            format!("Chance alone would put about {chance} outside.")
        } else {
            format!("Outside: {}. Chance alone would put about {chance} there.", outside.join(", "))
        };
        let (curves, by_curve) = curves_in_words(comparison);
        let said = format!("{inside} of {compared} statistics{curves} lie within");
        answers.push(answer("Is the scan like its twins?", said, format!("{detail}{by_curve}")));
    }
    let model = &comparison["model"];
    if model.is_object() {
        let covariance = &model["covariance"];
        let length = |key: &str| covariance[key].as_f64().map_or("–".into(), |v| Dimension::Length.show(v));
        let kind = if covariance.is_object() {
            format!("{} covariance", in_words(word(&covariance["model"])))
        } else {
            in_words(word(&model["generator"]))
        };
        let lengths = if covariance.is_object() {
            let to_1_e = match (covariance["decay_length_x_m"].as_f64(), length_in_words(word(&covariance["model"]))) {
                (Some(_), parameter) if parameter != "to 1/e" => {
                    format!(
                        "; correlation lengths (to 1/e) {} and {}",
                        length("decay_length_x_m"),
                        length("decay_length_y_m")
                    )
                }
                _ => String::new(),
            };
            format!(
                " Lengths ({}) {} along x and {} along y{to_1_e}.",
                length_in_words(word(&covariance["model"])),
                length("length_x_m"),
                length("length_y_m")
            )
        } else {
            String::new()
        };
        let detail = format!(
            "Rms height {}, {} marginal law.{lengths}",
            model["rms_height_m"].as_f64().map_or("–".into(), |v| Dimension::Length.show(v)),
            in_words(word(&model["marginal"]["name"])),
        );
        answers.push(answer("What are the twins made from?", kind, detail));
    }
    if let (Some(count), Some(nx), Some(ny)) =
        (comparison["count"].as_u64(), comparison["points"][0].as_u64(), comparison["points"][1].as_u64())
    {
        let side = |axis: usize, points: u64| {
            comparison["pitch_m"][axis].as_f64().map_or("–".into(), |p| Dimension::Length.show(p * points as f64))
        };
        let detail = format!("On {} × {}. Seed {}.", side(0, nx), side(1, ny), comparison["seed"]);
        answers.push(answer("What was drawn?", format!("{count} maps of {nx} × {ny} points"), detail));
    }
    answers
}
