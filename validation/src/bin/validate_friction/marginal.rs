//! Marginal distributions: coverage of the intervals of their parameters, and how often tests reject the right family.

use std::fmt::Write;

use asperity::distribution::fit::{Family, Fit, fit};
use asperity::distribution::goodness::ProcessNull;
use asperity::stats::Moments;
use rayon::prelude::*;

use crate::planted::Planted;

/// Number of draws for a p-value.
const DRAWS: usize = 299;

pub(crate) fn section(runs: usize) -> String {
    let mut text = String::from(
        "## Marginal distributions\n\nFamilies of distributions are fitted to records of known distributions. *Holds* is the percentage \
         of the 95 % intervals that contain the parameter, with the percentages above and below it in brackets; *bias* is in standard \
         deviations of the estimate, and *se* is the standard error over this standard deviation. The likelihood of a bound is irregular if \
         the shape parameter at this end is at most 2: the error of the bound is then of order n^{−1/shape}, the bound has no interval, and \
         the intervals of the shapes treat it as known. Just above 2 it is hardly regular: with 200 ℓ the intervals of b and of the \
         bounds are too narrow, and tests of goodness of fit reject too seldom; with 2,000 ℓ those of the bounds still hold in 90 % only.\n\n| process | fit | parameter | intervals | holds | bias | se |\n|---|---|---|---|---|---|---|\n",
    );
    let known = Family::Beta { low: 0.0, high: 1.0 };
    let of = |distribution, strips, periodic| Planted { distribution, lengths: 200, strips, periodic, window: 0.0 };
    for (strips, periodic) in [(1, false), (3, false), (20, false), (20, true)] {
        parameters(&mut text, of("beta:2.1,5", strips, periodic), known, &[2.1, 5.0], runs);
    }
    let free = [2.1, 5.0, 0.0, 1.0];
    parameters(&mut text, of("beta:2.1,5", 1, false), Family::BetaFreeBounds, &free, runs);
    let long = Planted { lengths: 2000, ..of("beta:2.1,5", 1, false) };
    parameters(&mut text, long, Family::BetaFreeBounds, &free, runs);
    parameters(&mut text, of("gamma:4,0.05", 1, false), Family::Gamma, &[4.0, 0.05], runs);
    parameters(&mut text, of("lognormal:-1,0.3", 3, false), Family::Lognormal, &[-1.0, 0.3], runs);
    parameters(&mut text, of("weibull:3,0.3", 20, false), Family::Weibull, &[3.0, 0.3], runs);

    text.push_str(
        "\nPercentage of the records of the right family that a test rejects at 5 %, and at 10 %.\n\n| process | fit | order | \
         Kolmogorov–Smirnov | Anderson–Darling |\n|---|---|---|---|---|\n",
    );
    for (planted, family) in [
        (of("beta:2.1,5", 1, false), known),
        (of("beta:2.1,5", 20, true), known),
        (of("beta:2.1,5", 1, false), Family::BetaFreeBounds),
        (of("normal:3,1", 1, false), Family::Normal),
        (of("normal:3,1", 20, false), Family::Normal),
        (Planted { window: 2.4, ..of("normal:3,1", 1, false) }, Family::Normal),
        (Planted { window: 2.4, ..of("normal:3,1", 20, true) }, Family::Normal),
        (of("lognormal:-1,0.3", 3, false), Family::ShiftedLognormal),
        (of("gamma:4,0.05", 3, false), Family::Gamma),
    ] {
        level(&mut text, planted, family, runs);
    }
    text
}

/// Returns the name of a family on the page.
fn in_words(family: Family) -> String {
    match family {
        Family::Beta { .. } => "Beta, known bounds".to_owned(),
        Family::BetaFreeBounds => "Beta, free bounds".to_owned(),
        Family::ShiftedLognormal => "shifted lognormal".to_owned(),
        other => format!("{other:?}").to_lowercase(),
    }
}

fn fitted(planted: Planted, family: Family, run: u64) -> (Vec<Vec<f64>>, Option<Fit>) {
    let records = planted.records(run);
    let fit = fit(family, &records.concat()).ok();
    (records, fit)
}

fn views(records: &[Vec<f64>]) -> Vec<&[f64]> {
    records.iter().map(Vec::as_slice).collect()
}

fn parameters(text: &mut String, planted: Planted, family: Family, truth: &[f64], runs: usize) {
    let found: Vec<_> = (0..runs as u64)
        .into_par_iter()
        .filter_map(|run| {
            let (records, fit) = fitted(planted, family, run);
            Some(fit?.estimates(&views(&records), planted.periodic))
        })
        .collect();
    for (k, truth) in truth.iter().enumerate() {
        let values = Moments::from_values(found.iter().map(|p| p[k].value));
        let with: Vec<_> = found.iter().filter_map(|p| p[k].estimate).collect();
        let percentage = |f: &dyn Fn(f64, f64) -> bool| {
            100.0 * with.iter().filter(|e| f(e.interval.low, e.interval.high)).count() as f64 / with.len() as f64
        };
        let se = Moments::from_values(with.iter().map(|e| e.standard_error.powi(2))).mean.sqrt();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.0} % of {} | {:.1} % (↑{:.1} ↓{:.1}) | {:+.2} | {:.2} |",
            planted.name(),
            in_words(family),
            found.first().map_or("", |p| p[k].name),
            100.0 * with.len() as f64 / found.len() as f64,
            found.len(),
            percentage(&|low, high| low <= *truth && *truth <= high),
            percentage(&|low, _| low > *truth),
            percentage(&|_, high| high < *truth),
            (values.mean - truth) / values.std,
            se / values.std
        );
    }
}

fn level(text: &mut String, planted: Planted, family: Family, runs: usize) {
    let found: Vec<[f64; 3]> = (0..runs as u64)
        .into_par_iter()
        .filter_map(|run| {
            let (records, fit) = fitted(planted, family, run);
            let null = ProcessNull::new(&views(&records), planted.periodic, DRAWS, run).ok()?;
            let goodness = null.goodness(&fit?, &records.concat()).ok()?;
            let darling = goodness.anderson_darling.map_or(1.0, |a| a.p_value);
            Some([goodness.kolmogorov_smirnov.p_value, darling, null.order() as f64])
        })
        .collect();
    let below = |k: usize, p: f64| 100.0 * found.iter().filter(|f| f[k] <= p).count() as f64 / found.len() as f64;
    let _ = writeln!(
        text,
        "| {} | {} | {:.1} | {:.1} %, {:.1} % | {:.1} %, {:.1} % |",
        planted.name(),
        in_words(family),
        found.iter().map(|f| f[2]).sum::<f64>() / found.len() as f64,
        below(0, 0.05),
        below(0, 0.1),
        below(1, 0.05),
        below(1, 0.1)
    );
}
