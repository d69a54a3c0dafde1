//! Which uncertain parameter of the surface matters for which moment of friction.

use serde_json::{Value, json};

use crate::canvas::{Rect, draw};
use crate::figures::pressure::sensitivities::{FOOT, HEAD, ROW, legend, panel};
use crate::figures::{Plate, Stage, csv};
use crate::{ReportError, Run};

const NAME: &str = "friction_sensitivity";
/// Moments in two columns.
const MOMENTS: [(&str, &str); 4] = [
    ("mean", "Mean of μ"),
    ("std", "Std of μ"),
    ("coefficient_of_variation", "CoV of μ"),
    ("correlation_length_m", "Correlation length of μ"),
];

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let friction = &run.results["friction"];
    let levels = friction["levels"].as_array().map_or(&[][..], Vec::as_slice);
    let lead = levels.iter().position(|level| level["leading"] == true).unwrap_or(0);
    let responses = friction["uncertainty"]["levels"][lead]["at_mean_load"].as_array().map_or(&[][..], Vec::as_slice);
    let entry = |name: &str| responses.iter().find(|response| response["name"] == name).and_then(entry);
    let shown: Vec<(&str, Value)> =
        MOMENTS.into_iter().filter_map(|(name, title)| Some((title, entry(name)?))).collect();
    let Some(most) = shown.iter().filter_map(|(_, entry)| entry["indices"].as_array().map(Vec::len)).max() else {
        return Ok(());
    };
    let title = "Which parameter of the surface matters for friction";
    let caption = "Sobol’ indices of the moments of μ at the operating point, taken at the mean load, with 95 % intervals: the share of their variance over \
                   the uncertain surfaces that a parameter explains alone (first order), and together with all others (total). How \
                   much of it the expansion explains at all stands above each panel, by leaving one out; a moment without a panel \
                   does not depend on the parameters, or nothing predicts it.";
    let each = HEAD + ROW * most as f64 + FOOT;
    let rows = shown.len().div_ceil(2);
    let svg = draw((640.0, 48.0 + each * rows as f64), title, caption, |canvas| {
        legend(canvas)?;
        for (place, (label, entry)) in shown.iter().enumerate() {
            let (row, column) = (place / 2, place % 2);
            let outer = Rect::new(320.0 * column as f64, 24.0 + each * row as f64, 320.0, each);
            panel(canvas, outer, entry, label, place + 2 >= shown.len())?;
        }
        Ok(())
    })?;
    let sources = vec![csv(NAME)];
    plates.push(Plate {
        name: NAME,
        stage: Stage::Friction,
        title: title.into(),
        caption: caption.into(),
        sources,
        svg,
    });
    Ok(())
}

/// A moment with its indices as the figure of the pressure has them.
fn entry(response: &Value) -> Option<Value> {
    let indices: Vec<Value> = response["sobol"]
        .as_array()?
        .iter()
        .map(|index| {
            json!({
                "name": index["parameter"].as_str().unwrap_or("–").replace('_', " "),
                "first_order": index["first"], "first_order_interval": index["first_interval"],
                "total": index["total"], "total_interval": index["total_interval"],
            })
        })
        .filter(|index| index["first_order"].is_number() && index["total"].is_number())
        .collect();
    (!indices.is_empty()).then(|| json!({ "indices": indices, "cross_validated_error": response["loo_error"] }))
}
