//! Sobol' indices of the uncertain parameters of the surface for the moments of friction.

use asperity_results::{IndexEntry, ParameterIndexResult, UncertainResponse};

use crate::Run;
use crate::figures::CaptionedFigure;
use crate::figures::pressure::sensitivities::{Panel, draw_panels};

const NAME: &str = "friction_sensitivity";
/// Moments with their titles.
const MOMENTS: [(&str, &str); 4] = [
    ("mean", "Mean of μ"),
    ("std", "Std of μ"),
    ("coefficient_of_variation", "CoV of μ"),
    ("correlation_length_m", "Correlation length of μ"),
];

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let friction = run.results.friction.as_ref()?;
    let operating = friction.levels.iter().position(|level| level.leading).unwrap_or(0);
    let responses = &friction.uncertainty.as_ref()?.levels.get(operating)?.at_mean_load;
    let panels = MOMENTS.iter().filter_map(|(name, title)| {
        let is_wanted = |response: &&UncertainResponse| response.name == *name && !response.sobol.is_empty();
        let response = responses.iter().find(is_wanted)?;
        let indices = response.sobol.iter().map(index).collect();
        Some(Some(Panel { title: (*title).to_owned(), indices, error: response.loo_error }))
    });
    let mut rows: Vec<Vec<Option<Panel>>> = Vec::new();
    for panel in panels {
        match rows.last_mut() {
            Some(row) if row.len() == 1 => row.push(panel),
            _ => rows.push(vec![panel]),
        }
    }
    let title = "Sensitivity of friction to the parameters of the surface";
    let caption = "Sobol’ indices of the moments of μ at the operating point, taken at the mean load, with 95 % intervals: the \
                   fraction of their variance over the uncertain surfaces that a parameter explains alone (first order), and \
                   together with all others (total). Each panel states the fraction of the variance that the expansion explains, by \
                   leave-one-out cross-validation. A moment without a panel does not depend on the parameters or is not \
                   predictable.";
    Some(draw_panels(NAME, title, caption, rows)?.with_tables(&[NAME]))
}

/// Converts an index to the type of the figure of the pressure.
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
