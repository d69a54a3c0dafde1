//! The report of partial runs.

use asperity_results::{
    FrictionResult, LevelResult, MotionKind, PressureResult, Results, SurfaceResult, VibrationResult,
};

use crate::documents::{elements, text};
use crate::synthetic::{changed, full_run, surface_run};
use asperity_report::{Run, render};

#[test]
fn a_study_of_the_surface_alone_has_no_later_section() {
    let report = render(&surface_run()).unwrap();
    assert!(report.figures.iter().all(|figure| figure.name.starts_with("height_") || figure.name == "surface_sample"));
    assert_eq!(report.figures.len(), 6);
    for id in ["pressure", "friction", "vibration", "answers"] {
        assert!(!report.html.contains(&format!("id=\"{id}\"")), "no section {id}");
    }
    assert!(!report.html.contains("Bowden"));
}

#[test]
fn an_empty_run_is_a_page_without_figures() {
    let report = render(&Run::default()).unwrap();
    assert!(report.figures.is_empty());
    assert!(report.html.contains("</html>") && report.html.contains("Gaus"));
}

#[test]
fn each_table_and_field_can_be_there_alone() {
    let full = full_run();
    // Bands are drawn around the distributions of another table.
    for (name, table) in full.tables.iter().filter(|(name, _)| *name != "pressure_bands") {
        let tables = [(name.clone(), table.clone())].into();
        let report = render(&Run { tables, ..Run::default() }).unwrap();
        // The fits of the heights are a table of the page; the levels of friction and the damping sweep are two figures.
        let wanted = match name.as_str() {
            "height_fits" => 0,
            "friction_levels" | "cycles_over_damping" => 2,
            _ => 1,
        };
        assert_eq!(report.figures.len(), wanted, "{name}");
        assert!(text(&report.html).contains(&format!("<code>tables/{name}.csv</code>")), "{name}");
        report.figures.iter().for_each(|figure| assert!(elements(&figure.svg) > 0));
    }
    for (name, field) in &full.fields {
        let fields = [(name.clone(), field.clone())].into();
        let report = render(&Run { fields, ..Run::default() }).unwrap();
        assert_eq!(report.figures.len(), 1, "{name}");
        elements(&report.figures[0].svg);
    }
}

#[test]
fn every_column_of_every_table_may_be_undefined() {
    let full = full_run();
    for (name, table) in &full.tables {
        for hidden in 0..table.columns().len() {
            let table = changed(table, |columns| columns[hidden].1.fill(f64::NAN));
            let run = Run { tables: [(name.clone(), table)].into(), ..Run::default() };
            for figure in render(&run).unwrap().figures {
                elements(&figure.svg);
                assert!(!figure.svg.contains("NaN"), "{name}, column {hidden}");
            }
        }
        let holes = changed(table, |columns| {
            columns.iter_mut().for_each(|(_, values)| values.iter_mut().step_by(3).for_each(|v| *v = f64::NAN));
        });
        for figure in render(&Run { tables: [(name.clone(), holes)].into(), ..Run::default() }).unwrap().figures {
            elements(&figure.svg);
        }
        let one = changed(table, |columns| columns.iter_mut().for_each(|(_, values)| values.truncate(1)));
        for figure in render(&Run { tables: [(name.clone(), one)].into(), ..Run::default() }).unwrap().figures {
            elements(&figure.svg);
            assert!(!figure.svg.contains("NaN"), "{name} with one row");
        }
    }
}

#[test]
fn undefined_results_are_dashes_and_never_errors() {
    let kind = MotionKind::None;
    let results = Results {
        surface: Some(SurfaceResult::default()),
        pressure: Some(PressureResult::default()),
        friction: Some(FrictionResult { levels: vec![LevelResult::default()], ..FrictionResult::default() }),
        vibration: Some(VibrationResult { kind, ..VibrationResult::default() }),
        ..Results::default()
    };
    let report = render(&Run { results, ..Run::default() }).unwrap();
    assert!(report.html.contains("<h2>Surface</h2>") && !report.html.contains("NaN"));
}
