//! Pressure distributions of all cells, as fields and entries of `results.json`.

use crate::pressure::{FieldDistributions, GlobalExpansion, Homogeneity, MethodError};
use crate::study::Field;
use crate::study::result::{GlobalExpansionEntry, HomogeneityEntry, MapsEntry, finite};
use crate::study::series::map_field;

/// Returns the maps, in pascal and fractions.
pub(super) fn fields(distributions: &FieldDistributions) -> Vec<(&'static str, Field)> {
    let field = |unit, values: &ndarray::Array2<f64>| map_field(distributions.grid, unit, values.clone());
    let mut fields = vec![
        ("contact_probability", field("1", &distributions.contact_probability)),
        ("pressure_mean", field("Pa", &distributions.mean_pa)),
    ];
    for quantile in &distributions.quantiles {
        if let Some(name) = quantile_name(quantile.probability) {
            fields.push((name, field("Pa", &quantile.pressure_pa)));
        }
    }
    if let Ok(global) = &distributions.global {
        fields.push(("expansion_error", field("1", &global.leave_one_out_error)));
    }
    fields
}

fn quantile_name(probability: f64) -> Option<&'static str> {
    match (100.0 * probability).round() as u32 {
        10 => Some("pressure_quantile_10"),
        50 => Some("pressure_quantile_50"),
        90 => Some("pressure_quantile_90"),
        _ => None,
    }
}

pub(super) fn entry(distributions: &FieldDistributions) -> MapsEntry {
    let largest = |values: &ndarray::Array2<f64>| values.iter().copied().fold(f64::NAN, f64::max);
    let half_widths = (&distributions.contact_probability_high - &distributions.contact_probability_low) * 0.5;
    MapsEntry {
        samples: distributions.samples,
        kept_samples: distributions.kept_samples,
        contact_probability_largest_half_width: finite(largest(&half_widths)),
        mean_largest_se_pa: finite(largest(&distributions.mean_se_pa)),
    }
}

pub(super) fn homogeneity(found: &Result<Homogeneity, MethodError>) -> HomogeneityEntry {
    match found {
        Ok(found) => HomogeneityEntry {
            cells: Some(found.cells),
            samples: Some(found.samples),
            contact_p_value: finite(found.contact_p_value),
            mean_p_value: finite(found.mean_p_value),
            p_value: finite(found.p_value),
            plausible: Some(found.is_plausible()),
            failure: None,
        },
        Err(reason) => HomogeneityEntry { failure: Some(reason.to_string()), ..HomogeneityEntry::default() },
    }
}

pub(super) fn global_expansion(found: &Result<GlobalExpansion, MethodError>) -> GlobalExpansionEntry {
    match found {
        Ok(found) => {
            let errors: Vec<f64> = found.leave_one_out_error.iter().copied().filter(|e| e.is_finite()).collect();
            GlobalExpansionEntry {
                variables: Some(found.variables),
                degree: Some(found.degree),
                coefficients: Some(found.coefficients),
                leave_one_out_error: finite(errors.iter().sum::<f64>() / errors.len() as f64),
                failure: None,
            }
        }
        Err(reason) => GlobalExpansionEntry { failure: Some(reason.to_string()), ..GlobalExpansionEntry::default() },
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use super::*;
    use crate::map::Grid;
    use crate::pressure::QuantileMap;

    fn distributions(
        global: Result<GlobalExpansion, MethodError>,
        homogeneity: Result<Homogeneity, MethodError>,
    ) -> FieldDistributions {
        let grid = Grid::with_size(2, 2, 1.0, 1.0).unwrap();
        let probabilities = |by: f64| array![[0.25, 0.5], [0.5, 0.75]] + by;
        let quantile =
            |probability| QuantileMap { probability, pressure_pa: Array2::from_elem((2, 2), 1e6 * probability) };
        FieldDistributions {
            grid,
            samples: 40,
            kept_samples: 30,
            contact_probability: probabilities(0.0),
            contact_probability_low: probabilities(-0.125),
            contact_probability_high: probabilities(0.125),
            mean_pa: Array2::from_elem((2, 2), 1e6),
            mean_se_pa: array![[1e5, 2e5], [f64::NAN, 1e5]],
            quantiles: [0.1, 0.5, 0.9].map(quantile).into(),
            global,
            homogeneity,
        }
    }

    #[test]
    fn maps_are_fields_in_their_units_and_means_go_over_the_cells_that_vary() {
        let global = GlobalExpansion {
            variables: 2,
            degree: 1,
            coefficients: 3,
            leave_one_out_error: array![[0.5, f64::NAN], [1.0, 0.75]],
        };
        let differ = Homogeneity { cells: 4, samples: 40, contact_p_value: 0.5, mean_p_value: 0.02, p_value: 0.04 };
        let distributions = distributions(Ok(global), Ok(differ));
        let found = fields(&distributions);
        let names: Vec<(&str, &str)> = found.iter().map(|(name, field)| (*name, field.unit())).collect();
        let wanted = [
            ("contact_probability", "1"),
            ("pressure_mean", "Pa"),
            ("pressure_quantile_10", "Pa"),
            ("pressure_quantile_50", "Pa"),
            ("pressure_quantile_90", "Pa"),
            ("expansion_error", "1"),
        ];
        assert_eq!(names, wanted);
        let entry = entry(&distributions);
        assert_eq!(global_expansion(&distributions.global).leave_one_out_error, Some(0.75));
        assert_eq!((entry.contact_probability_largest_half_width, entry.mean_largest_se_pa), (Some(0.125), Some(2e5)));
        let found = homogeneity(&distributions.homogeneity);
        assert_eq!((found.p_value, found.plausible), (Some(0.04), Some(false)));
    }

    #[test]
    fn a_failed_result_gives_a_reason_and_no_field() {
        let few = MethodError::TooFewSamples { samples: 3, wanted: 40 };
        let distributions = distributions(Err(few.clone()), Err(few));
        assert!(fields(&distributions).iter().all(|(name, _)| *name != "expansion_error"));
        let alike = serde_json::to_value(homogeneity(&distributions.homogeneity)).unwrap();
        let expansion = serde_json::to_value(global_expansion(&distributions.global)).unwrap();
        for (entry, number) in [(alike, "p_value"), (expansion, "leave_one_out_error")] {
            assert!(entry[number].is_null(), "{entry}");
            assert_eq!(entry["failure"], "3 samples are too few; at least 40 are needed");
        }
    }
}
