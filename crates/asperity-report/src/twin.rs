//! The page of a scan and its twins.

mod figures;
pub(crate) mod run;

use asperity_results::{BandMethod, Comparison, StatisticComparison};

use self::run::{TwinRun, distance, inside_share, named, percent, statistics};
use crate::cells::{DASH, shown};
use crate::format::{Dimension, fixed, significant};
use crate::page::Page;
use crate::page::answer::Answer;
use crate::page::data_table::DataTable;
use crate::page::section::Section;
use crate::words::{in_words, length_in_words};
use crate::{Report, ReportError};

/// References of the twins.
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

/// Renders the page of a scan and its twins. It is a pure function; absent tables and fields are left out.
///
/// # Errors
/// The PNG encoder failed.
pub fn render_twins(run: &TwinRun) -> Result<Report, ReportError> {
    let comparison = &run.comparison;
    let lead = format!(
        "Twins were evaluated as the scan was: its missing points were masked out of them and the form was removed. {}",
        band_sentence(comparison)
    );
    let distances = "Distances are from the mean of the twins, in standard deviations of the twins.";
    let sections = [
        Section::new("figures", "Scan and twins", lead, Vec::new(), figures::figures(run)?),
        Section::new("parameters", "Parameters", distances, vec![table(comparison)], Vec::new()),
        Section::sentences("limits", "Limits of these twins", "", &comparison.limits),
        Section::sentences("assumptions", "Assumptions", "", &comparison.assumptions),
        Section::provenance(run.provenance.as_ref()),
        Some(Section::references(REFERENCES.map(str::to_owned))),
    ];
    let page = Page {
        title: format!("Twins of {}", run.name),
        intro: "Random maps with the same statistics as a measured one, compared with it.",
        first_screen: None,
        answers: [likeness(comparison), model(comparison), draws(comparison)].into_iter().flatten().collect(),
        warnings: comparison.warnings.clone(),
        sections: sections.into_iter().flatten().collect(),
        details: Vec::new(),
        script: "",
        machine: None,
    };
    Ok(page.render())
}

/// Returns the statistics as rows.
fn table(comparison: &Comparison) -> DataTable {
    let statistics = statistics(comparison);
    let row = |(key, statistic): &(&str, &StatisticComparison)| {
        let (symbol, meaning) = named(key);
        let dimension = Dimension::of_key(key).1;
        let distance = distance(statistic)
            .map_or_else(|| DASH.into(), |d| format!("{}{}", if d > 0.0 { "+" } else { "" }, fixed(d, 1)));
        let verdict = match statistic.inside {
            Some(true) => "within",
            Some(false) => "outside",
            None => DASH,
        };
        let twins = shown(dimension, statistic.mean, statistic.band);
        vec![meaning, symbol, shown(dimension, statistic.target, None), twins, distance, verdict.into()]
    };
    let headers = ["Parameter", "Symbol", "Scan", "Twins: mean [95 % band]", "Distance", "Scan in band"];
    let rows = statistics.iter().map(row).collect();
    let outside = (0..statistics.len()).filter(|place| statistics[*place].1.inside == Some(false));
    DataTable::new("Scan and twins", &headers, rows).with_highlighted(outside.collect())
}

fn band_sentence(comparison: &Comparison) -> String {
    let count = comparison.count;
    match comparison.band_method {
        BandMethod::StudentT => format!(
            "The band contains the statistic of a further twin with 95 % probability. It is Student’s prediction interval of {count} \
             twins, which assumes normal statistics: positive ones on a logarithmic scale and fractions by their log-odds, so that \
             the band stays in their range. From 39 twins on it ends at order statistics and assumes no distribution."
        ),
        BandMethod::Quantiles => format!(
            "The band contains the statistic of a further twin with 95 % probability. It ends at the order statistics of {count} \
             twins and assumes no distribution."
        ),
        BandMethod::None => "A single twin has no band; draw more.".into(),
    }
}

/// Returns the fraction of the functions in the pointwise bands, for all of them and for each; empty without any.
fn curve_sentences(comparison: &Comparison) -> (String, String) {
    const CURVES: [(&str, &str); 6] = [
        ("height_pdf", "height density"),
        ("acf_x", "autocorrelation along x"),
        ("acf_y", "autocorrelation along y"),
        ("psd_x", "spectrum along x"),
        ("psd_y", "spectrum along y"),
        ("psd_radial", "radial spectrum"),
    ];
    let Some(inside) = comparison.curves_inside_share() else { return (String::new(), String::new()) };
    let each =
        CURVES.iter().filter_map(|(key, name)| Some(format!("{name} {}", percent(inside_share(comparison, key)?))));
    let detail = format!(
        " Points of the curves within: {}. 95 % are expected by chance, with a large variability for density and autocorrelation, \
         whose neighbouring points are correlated.",
        each.collect::<Vec<_>>().join(", ")
    );
    (format!(" and {} of the points of the curves", percent(inside)), detail)
}

fn likeness(comparison: &Comparison) -> Option<Answer> {
    let &Comparison { inside, compared, .. } = comparison;
    let outside = statistics(comparison).into_iter().filter(|(_, statistic)| statistic.inside == Some(false));
    let outside: Vec<String> = outside.map(|(key, _)| named(key).0).collect();
    let chance = significant((0.5 * compared as f64).round() / 10.0, 2);
    let (curves, by_curve) = curve_sentences(comparison);
    let outside = if outside.is_empty() { String::new() } else { format!("Outside: {}. ", outside.join(", ")) };
    (compared > 0).then(|| Answer {
        question: "Is the scan like its twins?",
        answer: format!("{inside} of {compared} statistics{curves} lie within the band of the twins"),
        detail: format!("{outside}About {chance} are expected outside by chance.{by_curve}"),
    })
}

fn model(comparison: &Comparison) -> Option<Answer> {
    let length = |metre: f64| Dimension::Length.show(metre);
    let model = &comparison.model;
    let (answer, lengths) = match &model.covariance {
        Some(covariance) => {
            let meaning = length_in_words(&covariance.model);
            let [x, y] = [covariance.decay_length_x_m, covariance.decay_length_y_m].map(length);
            let decay = match meaning {
                "to 1/e" => String::new(),
                _ => format!("; correlation lengths (to 1/e) {x} and {y}"),
            };
            let [x, y] = [covariance.length_x_m, covariance.length_y_m].map(length);
            let lengths = format!(" Lengths ({meaning}) {x} along x and {y} along y{decay}.");
            (format!("{} covariance", in_words(&covariance.model)), lengths)
        }
        None => (in_words(&model.generator), String::new()),
    };
    let (rms_height, marginal) = (length(model.rms_height_m), in_words(&model.marginal.name));
    let detail = format!("Rms height {rms_height}, {marginal} marginal distribution.{lengths}");
    (!model.generator.is_empty()).then_some(Answer { question: "Which model generates the twins?", answer, detail })
}

fn draws(comparison: &Comparison) -> Option<Answer> {
    let &Comparison { count, points: [nx, ny], pitch_m: [dx_m, dy_m], seed, .. } = comparison;
    let [width, height] = [(nx, dx_m), (ny, dy_m)].map(|(points, pitch)| Dimension::Length.show(points as f64 * pitch));
    (count > 0).then(|| Answer {
        question: "How many twins are there?",
        answer: format!("{count} maps of {nx} × {ny} points"),
        detail: format!("On {width} × {height}. Seed {seed}."),
    })
}
