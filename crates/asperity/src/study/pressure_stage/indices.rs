//! Sobol' indices as entries of `results.json` and as a table.

use crate::chaos::SampleEstimate;
use crate::pressure::{Sensitivity, VariableSet};
use crate::study::Table;
use crate::study::pressure_stage::scalars;
use crate::study::result::{IndexEntry, SensitivityEntry, finite, pair};

pub(super) fn entries(sensitivities: &[Sensitivity]) -> Vec<SensitivityEntry> {
    sensitivities.iter().map(entry).collect()
}

fn entry(sensitivity: &Sensitivity) -> SensitivityEntry {
    let prescribed = SensitivityEntry {
        quantity: scalars::name(sensitivity.quantity).into(),
        variables: match sensitivity.variables {
            VariableSet::Local => "local".into(),
            VariableSet::Global => "global".into(),
        },
        ..SensitivityEntry::default()
    };
    let found = match &sensitivity.outcome {
        Ok(found) => found,
        Err(reason) => return SensitivityEntry { failure: Some(reason.to_string()), ..prescribed },
    };
    let both = found.indices.first_order.iter().zip(&found.indices.total);
    SensitivityEntry {
        terms: Some(found.terms),
        cross_validated_error: found.cross_validated_error.and_then(finite),
        indices: found.names.iter().zip(both).map(|(name, (first, total))| index(name, *first, *total)).collect(),
        ..prescribed
    }
}

fn index(name: &str, first: SampleEstimate, total: SampleEstimate) -> IndexEntry {
    IndexEntry {
        name: name.into(),
        first_order: first.value,
        first_order_se: first.standard_error,
        first_order_interval: pair(first.interval),
        total: total.value,
        total_se: total.standard_error,
        total_interval: pair(total.interval),
    }
}

/// Returns a row for each variable of each expansion; its name consists of quantity, variables and variable.
pub(super) fn table(entries: &[SensitivityEntry]) -> Table {
    let rows = || entries.iter().flat_map(|entry| entry.indices.iter().map(move |index| (entry, index)));
    let names = rows().map(|(entry, index)| format!("{}: {}: {}", entry.quantity, entry.variables, index.name));
    let indices: Vec<IndexEntry> = rows().map(|(_, index)| index.clone()).collect();
    Table::with_names(names.collect(), Table::of(&indices).into_columns())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chaos::IndexEstimates;
    use crate::pressure::{Quantity, SensitivityError, SensitivityIndices};
    use crate::stats::Interval;

    #[test]
    fn indices_are_listed_by_variable_and_a_failed_expansion_has_a_reason_and_no_row() {
        let estimate = |value: f64| SampleEstimate {
            value,
            standard_error: 0.01,
            interval: Interval { low: value - 0.02, high: value + 0.02 },
        };
        let found = SensitivityIndices {
            names: vec!["height of the cell".into(), "ring 1".into()],
            indices: IndexEstimates {
                first_order: [0.5, 0.25].map(estimate).into(),
                total: [0.75, 0.5].map(estimate).into(),
                closed: Vec::new(),
                failed: 0,
            },
            terms: 7,
            cross_validated_error: None,
        };
        let sensitivities = [
            Sensitivity { quantity: Quantity::Pressure, variables: VariableSet::Local, outcome: Ok(found) },
            Sensitivity {
                quantity: Quantity::MeanPressure,
                variables: VariableSet::Global,
                outcome: Err(SensitivityError::NoVariables),
            },
        ];
        let entries = entries(&sensitivities);
        let table = table(&entries);
        assert_eq!(table.names(), ["pressure_pa: local: height of the cell", "pressure_pa: local: ring 1"]);
        assert_eq!(table.column("total"), Some(&[0.75, 0.5][..]));
        assert_eq!(table.column("first_order_low"), Some(&[0.48, 0.23][..]));
        let json = serde_json::to_value(&entries).unwrap();
        assert_eq!((&json[0]["terms"], &json[0]["cross_validated_error"]), (&7.into(), &serde_json::Value::Null));
        assert_eq!(json[0]["indices"][1]["total_interval"], serde_json::json!([0.48, 0.52]));
        assert_eq!((&json[1]["quantity"], &json[1]["variables"]), (&"mean_pressure_pa".into(), &"global".into()));
        assert!(json[1]["failure"].is_string() && json[1]["terms"].is_null());
        assert_eq!(json[1]["indices"], serde_json::json!([]));
    }
}
