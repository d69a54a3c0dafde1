//! The report of partial runs.

use asperity_results::{
    FrictionResult, LevelResult, MotionKind, PressureResult, Results, SurfaceResult, VibrationResult,
};

use crate::documents::{elements, text};
use crate::synthetic::{WITHOUT_FIGURE, changed, full_run, surface_run};
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
        let is_drawn = !WITHOUT_FIGURE.contains(&name.as_str());
        assert_eq!(report.figures.len(), usize::from(is_drawn), "{name}");
        assert_eq!(text(&report.html).contains(&format!("<code>tables/{name}.csv</code>")), is_drawn, "{name}");
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
fn answers_alone_have_their_figures() {
    let Results { friction, vibration, .. } = full_run().results;
    let mut run = Run { results: Results { friction, vibration, ..Results::default() }, ..Run::default() };
    let report = render(&run).unwrap();
    let names: Vec<&str> = report.figures.iter().map(|figure| figure.name.as_str()).collect();
    let folded = ["friction_cutoff", "friction_levels", "friction_shape", "cycles_over_damping"];
    assert_eq!(names, [&["sustained_over_damping"], &folded[..]].concat());
    for source in ["friction_cutoff", "friction_levels", "cycles_over_damping"] {
        assert!(text(&report.html).contains(&format!("<code>tables/{source}.csv</code>")), "{source}");
    }
    // Numbers of single levels, all intervals and all levels but one may be undefined.
    let friction = run.results.friction.as_mut().unwrap();
    friction.cutoff.as_mut().unwrap().points.iter_mut().for_each(|point| point.mean_interval = None);
    for level in &mut friction.levels {
        (level.mean_interval, level.std_interval, level.process.at_mean_load.std_interval) = (None, None, None);
    }
    for row in 0..friction.levels.len() {
        let level = &mut run.results.friction.as_mut().unwrap().levels[row];
        (level.mean, level.std, level.skewness, level.coefficient_of_variation) = (None, None, None, None);
        for figure in render(&run).unwrap().figures {
            elements(&figure.svg);
            assert!(!figure.svg.contains("NaN"), "{} without level {row}", figure.name);
        }
    }
    let vibration = run.results.vibration.as_mut().unwrap();
    for upscaling in [&mut vibration.paper, &mut vibration.area] {
        upscaling.damping.truncate(1);
    }
    for figure in render(&run).unwrap().figures {
        elements(&figure.svg);
        assert!(!figure.svg.contains("NaN"), "{} at one damping ratio", figure.name);
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
    assert!(report.html.contains("<summary>Surface: parameters") && !report.html.contains("NaN"));
}
