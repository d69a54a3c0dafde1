//! Sobol' indices of the uncertain parameters of the surface for the moments of friction.

use asperity_results::{Pair, ParameterIndexResult, UncertainResponse};

use crate::Run;
use crate::figures::CaptionedFigure;
use crate::format::{Unit, fixed};
use crate::plot::{Axis, BLACK, BLUE, Chart, Colour, Dash, Mark, ORANGE, Pen};

const NAME: &str = "friction_sensitivity";
/// Height of the rows of a variable, of a bar, and of title and axis together, in pixels.
const ROW: f64 = 25.0;
const BAR: f64 = 9.0;
const HEAD: f64 = 76.0;
/// Distance of the bars from the middle of their row, as a fraction of it.
const SHIFT: f64 = 0.19;
/// Moments with their titles.
const MOMENTS: [(&str, &str); 4] = [
    ("mean", "Mean of μ"),
    ("std", "Std of μ"),
    ("coefficient_of_variation", "CoV of μ"),
    ("correlation_length_m", "Correlation length of μ"),
];

/// The two indices of each parameter.
const INDICES: [(Index, &str, Colour); 2] = [
    (|index| (index.first, index.first_interval), "first order: alone", BLUE),
    (|index| (index.total, index.total_interval), "total: with all others", ORANGE),
];

/// Reads an index with its interval.
type Index = fn(&ParameterIndexResult) -> (f64, Pair);

/// The indices of one moment.
struct Panel<'a> {
    title: &'static str,
    indices: &'a [ParameterIndexResult],
    /// Fraction of the variance that the expansion does not explain.
    error: Option<f64>,
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let friction = run.results.friction.as_ref()?;
    let operating = friction.levels.iter().position(|level| level.leading).unwrap_or(0);
    let responses = &friction.uncertainty.as_ref()?.levels.get(operating)?.at_mean_load;
    let charts = MOMENTS.iter().filter_map(|(name, title)| {
        let is_wanted = |response: &&UncertainResponse| response.name == *name && !response.sobol.is_empty();
        let response = responses.iter().find(is_wanted)?;
        Some(Panel { title, indices: &response.sobol, error: response.loo_error }.chart())
    });
    let charts: Vec<Chart> = charts.collect();
    let title = "Sensitivity of friction to the parameters of the surface";
    let caption = "Sobol’ indices of the moments of μ at the operating point, taken at the mean load, with 95 % intervals: the \
                   fraction of their variance over the uncertain surfaces that a parameter explains alone (first order), and \
                   together with all others (total). Each panel states the fraction of the variance that the expansion explains, by \
                   leave-one-out cross-validation. A moment without a panel does not depend on the parameters or is not \
                   predictable.";
    CaptionedFigure::from_charts(NAME, title, caption, 2.min(charts.len()), &charts, &[NAME])
}

impl Panel<'_> {
    /// Returns the bars of the indices, with the fraction of the variance that they refer to.
    fn chart(&self) -> Chart {
        let Self { title, indices, error } = *self;
        let names = indices.iter().map(|index| index.parameter.replace('_', " ")).collect();
        let label = match error {
            Some(error) => format!("Sobol’ index; {} % explained", fixed((100.0 * (1.0 - error)).max(0.0), 0)),
            None => "Sobol’ index".to_owned(),
        };
        let axis = Axis::linear(&label, Unit::none(), (0.0, 1.0));
        let height = ROW * indices.len() as f64 + HEAD;
        let mut chart = Chart::new(axis, Axis::named(names)).with_title(title).with_height(height);
        for (row, index) in indices.iter().enumerate() {
            for ((of, name, colour), shift) in INDICES.into_iter().zip([-SHIFT, SHIFT]) {
                let (value, [low, high]) = of(index);
                let y = row as f64 + shift;
                let mut span = |name: &str, from: f64, to: f64, pen: Pen| {
                    let [from, to] = [from, to].map(|end| end.clamp(0.0, 1.0));
                    chart.add(name, Mark::Span { from, to, y, pen });
                };
                span(name, 0.0, value, Pen::new(colour, BAR, Dash::Solid));
                span("95 %", low, high, Pen::new(BLACK, 1.2, Dash::Solid));
            }
        }
        chart
    }
}
