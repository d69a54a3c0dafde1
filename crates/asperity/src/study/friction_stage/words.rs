//! Assumptions and warnings of the friction stage, in sentences.

use crate::friction::statistics::{HeavyTail, ISOLATED_FRACTION, WANTED_CONTACT_CELLS};
use crate::friction::strip::Strips;
use crate::friction::{DISTANCES, LevelControl, RoughBody, SolvedLevel, TwoBodyFriction};
use crate::stats::Interval;
use crate::study::check::FrictionStudy;
use crate::study::file::WindowShape;
use crate::study::output::left_out;
use crate::study::sentence;

/// Probability of a drift under stationarity below which it is warned about.
const UNLIKELY: f64 = 0.01;
/// Sentence on strips that do not tell the correlation families apart.
const UNTOLD: &str = " The record cannot tell the rough and the smooth correlation family apart: the exponential is used, and the \
                      interval covers the integral scales of both.";

pub(super) fn sentences(
    study: &FrictionStudy,
    strips: &Strips<'_>,
    mean_compliance_m_per_pa: Option<f64>,
    lead: &SolvedLevel,
) -> Vec<String> {
    let boundary = match mean_compliance_m_per_pa {
        None => "free, windows nearer to an end than the strip is wide left out".to_owned(),
        Some(m_per_pa) => {
            format!("periodic, of mean compliance {} under a fixed plane", sentence::compliance(m_per_pa))
        }
    };
    let window = &lead.window;
    let name = lead.control.name();
    let correlation = match &lead.window_study {
        _ if study.body != RoughBody::Track => None,
        None => Some(format!("At {name} friction does not vary, so it has no correlation.")),
        Some(study) => Some(format!(
            "A moving window correlates neighbouring values by itself, so a correlation length is only stated with its \
             window. Windows of {} together leave a length of {} (95 %: {} to {}; {} family) at {name}{}.{}",
            study.windows.iter().map(|seen| sentence::si(seen.window_m, "m")).collect::<Vec<_>>().join(", "),
            sentence::si(study.length_m, "m"),
            sentence::si(study.interval.low, "m"),
            sentence::si(study.interval.high, "m"),
            study.model.name().replace('_', " "),
            if study.window_only() { ": the correlation is due to the window alone" } else { " beside the window" },
            if study.families.told_apart() { "" } else { UNTOLD }
        )),
    };
    let shape = match study.window_shape {
        WindowShape::Rectangle => "a window",
        WindowShape::Ellipse => "an elliptic window",
    };
    let width = match lead.strips.tracks {
        1 if window.width_m() > strips.problem.grid().height_m() * (1.0 - 1e-9) => "the width of the strip".to_owned(),
        1 => sentence::si(window.width_m(), "m"),
        tracks => format!("{}, {tracks} side by side", sentence::si(window.width_m(), "m")),
    };
    let mut sentences = vec![
        format!(
            "{}, over {shape} of {} × {width}, moved by {}.",
            strips.problem.law.describe(),
            sentence::si(window.length_m(), "m"),
            sentence::si(window.step_m(), "m"),
        ),
        format!(
            "{} strips of {} ({boundary}) were solved, the same at every level. They hold all Fourier modes of their grid, \
             since a truncated expansion cannot hold the variance of a long strip.",
            strips.realisations,
            sentence::size(study.size_m[0], study.size_m[1]),
        ),
        "The friction coefficient is that at the mean load, μ̄ + (F − μ̄N)/N̄, where a window counts by the load it carries; the \
         plain quotient F/N of each window has a section of its own."
            .into(),
        body_sentence(study.body, lead),
    ];
    sentences.extend(correlation);
    if study.levels.iter().any(|level| matches!(level, LevelControl::Penetration(_))) {
        sentences.push(
            "A percentile is of the ensemble: one plane in space, to which strips are pressed more or less. A penetration is \
             counted from the highest point of each strip, so that the plane differs from strip to strip."
                .into(),
        );
    }
    sentences
}

/// Returns a sentence on the rough body, and on what the windows vary over.
fn body_sentence(body: RoughBody, lead: &SolvedLevel) -> String {
    let sentence = match body {
        RoughBody::Track => "The track is rough and the slider smooth: friction fluctuates along the path.",
        RoughBody::Slider => {
            "The slider is rough and the track smooth. A part carries its contacts along, so its friction coefficient is constant; \
             the standard deviation between windows is that between parts. Friction has no correlation along the path, vibrations \
             see the constant mean, and friction_process.json is not written."
        }
        RoughBody::Both => match &lead.two_bodies {
            Some(found) => return two_bodies_sentence(found, &lead.control.name()),
            None => {
                "Both bodies are rough. The standard deviation between windows contains differences between parts and the \
                 fluctuation along the path, which free strips do not separate. Friction therefore has no known correlation along \
                 the path, and friction_process.json is not written."
            }
        },
    };
    sentence.into()
}

fn two_bodies_sentence(found: &TwoBodyFriction, name: &str) -> String {
    let within = |interval: Option<Interval>, shown: &dyn Fn(f64) -> String| {
        interval.map_or_else(String::new, |i| format!(" (95 %: {} to {})", shown(i.low), shown(i.high)))
    };
    let metre = |length_m: f64| sentence::si(length_m, "m");
    format!(
        "Both bodies are rough: the counterface is the slider, the surface the track. At {name} the strips were solved again after up \
         to {DISTANCES} sliding distances. The friction of a window differs between parts by a standard deviation of {}{} and \
         fluctuates along the path with a standard deviation of {} and a correlation length of {}{}. The standard deviation between \
         windows contains both, and the correlation along the strips is not that along the path. friction_process.json, which cannot \
         state differences between parts, is not written.",
        sentence::digits(found.between_parts_std),
        within(found.between_parts_interval, &sentence::digits),
        sentence::digits(found.path_std),
        metre(found.path_length_m),
        within(found.path_length_interval_m, &metre),
    )
}

pub(super) fn level_warnings(solved: &SolvedLevel) -> Vec<String> {
    let (name, statistics) = (solved.control.name(), &solved.statistics);
    let mut warnings = Vec::new();
    let sparse = statistics.contact_cells < WANTED_CONTACT_CELLS || statistics.sparse_fraction > ISOLATED_FRACTION;
    if sparse {
        let heavy = solved.heavy_tail.map_or("", |_| ", and the quotient F/N of single windows has no variance");
        warnings.push(format!(
            "at {name}, {} % of the windows hold fewer than {WANTED_CONTACT_CELLS} contact cells ({} on average): the grid is \
             too coarse or the window too short for that load; the variability of friction is partly the grid's{heavy}",
            sentence::digits(100.0 * statistics.sparse_fraction),
            sentence::digits(statistics.contact_cells)
        ));
    }
    if let Some(tail) = solved.heavy_tail.as_ref().filter(|_| !sparse) {
        let reason = no_variance(tail);
        warnings.push(format!("at {name}, the quotient F/N of single windows has no variance: {reason}"));
    } else if statistics.empty_windows > 0 && !sparse {
        let windows = statistics.empty_windows + statistics.moments.n;
        warnings.push(format!(
            "at {name}, {} of {windows} windows carry no load ({:.2} %); F/N leaves them out",
            statistics.empty_windows,
            100.0 * statistics.empty_windows as f64 / windows as f64
        ));
    }
    if !solved.strips.failures.is_empty() {
        let of = solved.strips.failures.len() + solved.strips.records.len() / solved.strips.tracks.max(1);
        warnings.extend(left_out(&format!("strips at {name}"), solved.strips.failures.len(), of));
    }
    warnings
}

/// Why the quotient F/N has no variance.
pub(super) fn no_variance(tail: &HeavyTail) -> String {
    let sparse = sentence::digits(100.0 * tail.sparse_fraction);
    let contacts = format!("{sparse} % of the windows hold fewer than {WANTED_CONTACT_CELLS} contact cells");
    // The tail index α is 1/ξ; a shape that may be 0 leaves it without an upper end.
    let index = |shape: f64| if shape > 0.0 { sentence::digits(1.0 / shape) } else { "∞".to_owned() };
    match tail.shape {
        None => format!("{contacts}, and F/N of isolated contacts has the tail index 2, where a variance needs more"),
        Some((shape, interval)) => format!(
            "{contacts}, and the tail index of F/N is {} (95 %: {} to {}), where a variance needs more than 2",
            index(shape),
            index(interval.high),
            index(interval.low)
        ),
    }
}

/// Warnings where one length of a model is not all that correlates friction.
pub(super) fn correlation(lead: &SolvedLevel) -> Vec<String> {
    let Some(study) = lead.window_study.as_ref().filter(|study| !study.window_only()) else { return Vec::new() };
    let (name, model) = (lead.control.name(), study.model.name().replace('_', " "));
    let mut warnings = Vec::new();
    if let Some(p) = study.one_length_p.filter(|p| *p < UNLIKELY) {
        warnings.push(format!(
            "at {name}, the length beside the window differs from window to window (p = {p:.1e}, {model} family): one length does \
             not describe the correlation, and the standard deviation over the nominal area depends on the window"
        ));
    }
    if let Some(test) = study.lack_of_fit.filter(|test| test.p_value < UNLIKELY) {
        warnings.push(format!(
            "at {name}, the {model} family does not fit the spectrum of friction (p = {:.1e}): the length beside the window and its \
             interval hold for this family alone",
            test.p_value
        ));
    }
    warnings
}

/// A warning where friction drifts along the strips.
pub(super) fn drift(lead: &SolvedLevel) -> Option<String> {
    let found = lead.analysis.stationarity.as_ref().ok()?;
    let tests = [
        ("the mean drifts along the strip", found.trend),
        ("the two halves of the strip differ in the mean", found.mean_change),
        ("the ends of the strip differ from its middle", found.ends),
        ("the two halves of the strip differ in the variance", found.variance_change),
    ];
    let unlikely: Vec<String> = tests
        .iter()
        .filter(|(_, test)| test.p_value < UNLIKELY / tests.len() as f64)
        .map(|(name, test)| format!("{name} (p = {:.1e})", test.p_value))
        .collect();
    (!unlikely.is_empty())
        .then(|| format!("at {}, friction is not stationary: {}", lead.control.name(), unlikely.join(", ")))
}
