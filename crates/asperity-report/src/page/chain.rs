//! The strip below the verdict: one number of every link of the chain, with a small picture.

use asperity_results::{Field, MachineModel, Portrait, SATURATED, SurfaceResult};

use crate::Run;
use crate::cells::{DASH, percent};
use crate::format::{Dimension, significant, with_error};
use crate::markup::{Html, html};
use crate::plot::range;
use crate::verdict::{is_exact, noun as kind_of_motion};
use crate::words::between;

/// Size of a picture.
const WIDTH: f64 = 100.0;
const HEIGHT: f64 = 40.0;
/// Largest number of points of a curve.
const POINTS: usize = 120;

/// One link of the chain.
struct Link {
    /// Section with the details.
    section: &'static str,
    number: String,
    words: String,
    picture: Option<Html>,
}

/// Returns the links for which the run has results; those with a section among `sections` refer to it.
pub(super) fn strip(run: &Run, sections: &[&str]) -> Html {
    let links = [surface(run), contact(run).or_else(|| pressure(run)), friction(run), vibration(run)];
    let links: Vec<Html> = links.into_iter().flatten().map(|link| link.html(sections)).collect();
    if links.is_empty() {
        return Html::default();
    }
    html!("<nav class=\"chain\" aria-label=\"The chain\">\n{}</nav>\n", links.into_iter().collect::<Html>())
}

impl Link {
    fn html(self, sections: &[&str]) -> Html {
        let picture = self.picture.map_or_else(Html::default, |picture| {
            html!("<svg viewBox=\"0 0 100 40\" preserveAspectRatio=\"none\" aria-hidden=\"true\">{}</svg>", picture)
        });
        let content = html!("{}<strong>{}</strong> {}", picture, self.number, self.words);
        if sections.contains(&self.section) {
            html!("<a class=\"step\" href=\"#{}\">{}</a>\n", self.section, content)
        } else {
            html!("<div class=\"step\">{}</div>\n", content)
        }
    }
}

fn surface(run: &Run) -> Option<Link> {
    let result = run.results.surface.as_ref()?;
    let (metre, words) = rms_height(result)?;
    let field = ["height_levelled", "surface_sample"].into_iter().find_map(|name| run.fields.get(name));
    let picture = field.and_then(|field| {
        let row = field.values().row(field.ny() / 2).to_vec();
        let places: Vec<f64> = (0..row.len()).map(|place| place as f64).collect();
        curve(&places, &row)
    });
    Some(Link { section: "surface", number: format!("rms {}", Dimension::Length.show_short(metre)), words, picture })
}

/// Returns the rms height with its origin.
fn rms_height(surface: &SurfaceResult) -> Option<(f64, String)> {
    if let Some(scan) = surface.scan() {
        return Some((scan.Sq_m, "heights of the scan".into()));
    }
    match (surface.part().and_then(|part| Some((part.scan_count, part.pooled.get("Sq_m")?))), &surface.covariance) {
        (Some((count, pooled)), _) => Some((pooled.value, format!("heights, mean of {count} scans"))),
        (None, covariance) => Some((covariance.as_ref()?.std_m, "heights of the stated surface".into())),
    }
}

fn contact(run: &Run) -> Option<Link> {
    let friction = run.results.friction.as_ref()?;
    let point = &friction.operating_point;
    let plastic = friction.operating_level().map(|level| level.plastic_share).filter(|share| *share > 0.0);
    let plastic = plastic.map_or_else(String::new, |share| format!("; {} of it plastic", percent(share, 2)));
    Some(Link {
        section: if run.results.pressure.is_some() { "pressure" } else { "friction" },
        number: format!("{} in contact", percent(point.contact_fraction, 2)),
        words: format!("at {}{plastic}", Dimension::Pressure.show_short(point.mean_pressure_pa)),
        picture: ["pressure_strip", "pressure_sample"]
            .into_iter()
            .find_map(|name| run.fields.get(name))
            .and_then(patches),
    })
}

fn pressure(run: &Run) -> Option<Link> {
    let pressure = run.results.pressure.as_ref()?;
    let probability = with_error(pressure.contact_probability, pressure.contact_probability_se.unwrap_or(f64::NAN));
    let picture = run.tables.get("pressure_cdf").and_then(|table| {
        let distribution = ["default", "reference"].into_iter().find_map(|name| table.defined_column(name))?;
        curve(table.defined_column("pressure_pa")?, distribution)
    });
    let words = "contact at a point of the patch".into();
    Some(Link { section: "pressure", number: format!("P {probability}"), words, picture })
}

fn friction(run: &Run) -> Option<Link> {
    let number = |mean: f64| format!("μ {}", significant(mean, 3));
    let Some(friction) = &run.results.friction else {
        let vibration = run.results.vibration.as_ref()?;
        let words = "stated friction coefficient".into();
        return Some(Link { section: "vibration", number: number(vibration.static_friction), words, picture: None });
    };
    let point = &friction.operating_point;
    let picture = run.tables.get("friction_trace").and_then(|table| {
        let column = ["mu_load"].into_iter().chain(table.columns().iter().map(|(name, _)| name.as_str()));
        let mu = column.filter(|name| name.starts_with("mu")).find_map(|name| table.defined_column(name))?;
        curve(table.defined_column("position_m")?, mu)
    });
    Some(Link {
        section: "friction",
        number: number(point.mean),
        words: match point.saturation {
            _ if !point.resolved => "not resolved".into(),
            Some(excess) if excess <= SATURATED => "close to τ/H: roughness hardly matters".into(),
            _ => format!("± {} from window to window", significant(point.std, 2)),
        },
        picture,
    })
}

fn vibration(run: &Run) -> Option<Link> {
    let verdict = run.results.verdict.as_ref().filter(|verdict| !verdict.friction_unresolved)?;
    let cycle = run.tables.get("limit_cycle").map(Portrait::of);
    let picture = cycle.and_then(|cycle| curve(&cycle.displacement, &cycle.velocity));
    let (number, words) = match &verdict.if_vibrating {
        Some(machines) => {
            let hertz = machines.frequency_hz.map(|hertz| between(Dimension::Frequency, hertz).0);
            (hertz.unwrap_or_else(|| DASH.into()), kind_of_motion(verdict).to_lowercase())
        }
        None if is_exact(verdict) && !verdict.nominal.vibrates => ("quiet".into(), "steady sliding".into()),
        None => ("quiet".into(), "no sampled machine vibrates".into()),
    };
    let picture = picture.filter(|_| verdict.nominal.vibrates);
    let section = if verdict.model == MachineModel::ModeCoupling { "mode-coupling" } else { "vibration" };
    Some(Link { section, number, words, picture })
}

/// Draws a curve over the whole picture; `None` without two points.
fn curve(x: &[f64], y: &[f64]) -> Option<Html> {
    let stride = x.len().div_ceil(POINTS).max(1);
    // The last point closes a cycle.
    let places = (0..x.len()).step_by(stride).chain(x.len().checked_sub(1));
    let points: Vec<(f64, f64)> = places
        .filter_map(|place| Some((*x.get(place)?, *y.get(place)?)))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    let (left, right) = range(points.iter().map(|(x, _)| x))?;
    let (low, high) = range(points.iter().map(|(_, y)| y))?;
    if points.len() < 2 || right <= left || high <= low {
        return None;
    }
    let points = points.iter().map(|(x, y)| {
        let x = 2.0 + (WIDTH - 4.0) * (x - left) / (right - left);
        let y = HEIGHT - 3.0 - (HEIGHT - 6.0) * (y - low) / (high - low);
        format!("{x:.1},{y:.1} ")
    });
    Some(html!("<polyline points=\"{}\"/>", points.collect::<String>().trim_end()))
}

/// Draws the cells in contact of a part of a field; `None` without any.
fn patches(field: &Field) -> Option<Html> {
    let rows = field.ny().min(48);
    let columns = field.nx().min(5 * rows / 2);
    let (dx, dy) = (WIDTH / columns.max(1) as f64, HEIGHT / rows.max(1) as f64);
    let mut path = String::new();
    for row in 0..rows {
        for column in 0..columns {
            if field.values()[[row, column]] > 0.0 {
                path += &format!("M{:.1} {:.1}h{dx:.1}v{dy:.1}h-{dx:.1}z", column as f64 * dx, row as f64 * dy);
            }
        }
    }
    (!path.is_empty()).then(|| html!("<path d=\"{}\"/>", path))
}
