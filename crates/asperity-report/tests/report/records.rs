//! The figures of a measured friction record, complete, partial and hostile.

use std::collections::BTreeMap;

use asperity_results::Table;

use crate::documents::{check_figure, elements, text};
use crate::synthetic::changed;
use asperity_report::record_figures;

fn table(columns: &[(&str, &dyn Fn(f64) -> f64)]) -> Table {
    let values = |f: &dyn Fn(f64) -> f64| (0..200).map(|i| f(f64::from(i) / 200.0)).collect::<Vec<f64>>();
    Table::new(columns.iter().map(|(name, f)| (*name, values(f))))
}

fn tables() -> BTreeMap<String, Table> {
    let wave = |x: f64| 0.2 + 0.01 * (60.0 * x).sin();
    [
        (
            "friction_record",
            table(&[
                ("position_m", &|x| 0.2 * x),
                ("measured", &|x| if (0.3..0.4).contains(&x) { f64::NAN } else { wave(x) + 0.02 * x }),
                ("trend", &|x| 0.2 + 0.02 * x),
                ("mu", &wave),
            ]),
        ),
        (
            "friction_histogram",
            table(&[
                ("mu", &|x| 0.19 + 0.02 * x),
                ("density", &|x| 100.0 * x * (1.0 - x)),
                ("fitted_density", &|x| if x == 0.0 { f64::INFINITY } else { 101.0 * x * (1.0 - x) }),
                ("normal_density", &|x| 90.0 * x * (1.0 - x)),
            ]),
        ),
        (
            "friction_pit",
            table(&[("probability", &|x| x), ("density", &|_| 1.0), ("low", &|_| 0.8), ("high", &|_| 1.2)]),
        ),
        ("friction_qq", table(&[("fitted", &wave), ("measured", &wave), ("probability", &|x| x)])),
        (
            "friction_acf",
            table(&[("lag_m", &|x| 1e-3 * x), ("acf", &|x| (-4.0 * x).exp()), ("exponential", &|x| (-4.1 * x).exp())]),
        ),
    ]
    .map(|(name, table)| (name.to_owned(), table))
    .into()
}

#[test]
fn every_table_becomes_a_labelled_figure() {
    let figures = record_figures(&tables());
    let wanted: [(&str, &[&str]); 5] = [
        ("friction_record", &["as measured", "trend", "Sliding distance (mm)"]),
        ("friction_histogram", &["distribution of the process", "normal", "Friction coefficient"]),
        ("friction_pit", &["F(μ) of the fitted distribution", "95 % of the bins"]),
        ("friction_qq", &["Quantile of the fitted distribution", "Quantile of the record"]),
        ("friction_acf", &["Lag (", "exponential", "Autocorrelation"]),
    ];
    assert_eq!(figures.len(), wanted.len());
    for (figure, (name, words)) in figures.iter().zip(wanted) {
        assert_eq!(figure.name, name);
        check_figure(figure);
        let drawn = text(&figure.svg);
        assert!(words.iter().all(|word| drawn.contains(word)), "{name}: {words:?}");
    }
}

#[test]
fn absent_and_undefined_data_are_left_out() {
    assert!(record_figures(&BTreeMap::new()).is_empty());
    for (name, table) in tables() {
        for hidden in 0..table.columns().len() {
            let table = changed(&table, |columns| columns[hidden].1.fill(f64::NAN));
            for figure in record_figures(&[(name.clone(), table)].into()) {
                elements(&figure.svg);
                assert!(!figure.svg.contains("NaN"), "{name}, column {hidden}");
            }
        }
    }
}
