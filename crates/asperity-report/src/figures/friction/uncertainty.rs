//! Which uncertain parameter of the surface matters for which moment of friction.

use asperity_results::{IndexEntry, ParameterIndexResult};

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
    let Some(friction) = &run.results.friction else { return Ok(()) };
    let lead = friction.levels.iter().position(|level| level.leading).unwrap_or(0);
    let level = friction.uncertainty.as_ref().and_then(|uncertainty| uncertainty.levels.get(lead));
    let responses = level.map_or(&[][..], |level| &level.at_mean_load);
    let entry = |name: &str| responses.iter().find(|response| response.name == name && !response.sobol.is_empty());
    let shown: Vec<(&str, Vec<IndexEntry>, Option<f64>)> = MOMENTS
        .into_iter()
        .filter_map(|(name, title)| {
            let response = entry(name)?;
            Some((title, response.sobol.iter().map(index).collect(), response.loo_error))
        })
        .collect();
    let Some(most) = shown.iter().map(|(_, indices, _)| indices.len()).max() else { return Ok(()) };
    let title = "Which parameter of the surface matters for friction";
    let caption = "Sobol’ indices of the moments of μ at the operating point, taken at the mean load, with 95 % intervals: the share of their variance over \
                   the uncertain surfaces that a parameter explains alone (first order), and together with all others (total). How \
                   much of it the expansion explains at all stands above each panel, by leaving one out; a moment without a panel \
                   does not depend on the parameters, or nothing predicts it.";
    let each = HEAD + ROW * most as f64 + FOOT;
    let rows = shown.len().div_ceil(2);
    let svg = draw((640.0, 48.0 + each * rows as f64), title, caption, |canvas| {
        legend(canvas)?;
        for (place, (label, indices, unexplained)) in shown.iter().enumerate() {
            let (row, column) = (place / 2, place % 2);
            let outer = Rect::new(320.0 * column as f64, 24.0 + each * row as f64, 320.0, each);
            panel(canvas, outer, (indices, *unexplained), label, place + 2 >= shown.len())?;
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

/// An index as the figure of the pressure has it.
fn index(of: &ParameterIndexResult) -> IndexEntry {
    IndexEntry {
        name: of.parameter.replace('_', " "),
        first_order: of.first,
        first_order_interval: of.first_interval,
        total: of.total,
        total_interval: of.total_interval,
        ..IndexEntry::default()
    }
}
