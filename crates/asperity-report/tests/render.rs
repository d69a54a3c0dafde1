//! The report of complete, partial and hostile runs.
#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test stops where a document is not what it must be")]

mod documents;
mod synthetic;

use asperity_report::{Field, Input, ReportError, Run, Table, render};
use documents::{elements, resources, text};
use serde_json::{Value, json};
use synthetic::{full_run, surface_run};

#[test]
fn a_complete_run_has_every_figure_and_every_section() {
    let report = render(&full_run()).unwrap();
    let html = text(&report.html);
    let names: Vec<&str> = report.figures.iter().map(|figure| figure.name.as_str()).collect();
    let wanted = [
        "height_raw",
        "height_levelled",
        "surface_sample",
        "height_pdf",
        "height_acf",
        "height_psd",
        "pressure_sample",
        "pressure_cdf",
        "friction_levels",
        "friction_histogram",
        "friction_acf",
        "friction_trace",
        "limit_cycle",
        "reattachment",
        "cycles_over_damping",
    ];
    assert_eq!(names, wanted);
    for id in
        ["answers", "surface", "pressure", "friction", "vibration", "inputs", "assumptions", "provenance", "references"]
    {
        assert!(html.contains(&format!("<section id=\"{id}\"")), "section {id}");
    }
    for wanted in [
        "P(contact) = 0.3200 ± 0.0066",
        "The paper’s effect vanishes at your scale",
        "Yes: a stick-slip limit cycle exists",
        "ζ = 0.20483",
        "window only",
        "210 GPa",
        "Gaus",
        "21 contact cells",
        "tables/pressure_cdf.csv",
    ] {
        assert!(html.contains(wanted), "the page says {wanted:?}");
    }
}

#[test]
fn every_figure_names_the_table_that_holds_its_series() {
    let run = full_run();
    let html = text(&render(&run).unwrap().html);
    for name in run.tables.keys() {
        assert!(html.contains(&format!("<code>tables/{name}.csv</code>")), "tables/{name}.csv");
    }
    for name in run.fields.keys() {
        assert!(html.contains(&format!("<code>fields/{name}</code>")), "fields/{name}");
    }
}

#[test]
fn every_figure_is_a_well_formed_svg_document_with_readable_text() {
    for figure in render(&full_run()).unwrap().figures {
        assert!(elements(&figure.svg) > 20, "{} is drawn", figure.name);
        assert!(figure.svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"640\""), "{}", figure.name);
        assert!(figure.svg.contains("<title>") && figure.svg.contains("aria-label="));
        // Ten units are one pixel; nothing is smaller than 12 px at 640 px.
        for size in figure.svg.split("font-size=\"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
            assert!(size.parse::<f64>().unwrap() >= 119.9, "{}: font size {size}", figure.name);
        }
        let drawn = text(&figure.svg);
        assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{}", figure.name);
    }
}

#[test]
fn the_page_loads_nothing_from_elsewhere() {
    let html = render(&full_run()).unwrap().html;
    for resource in resources(&html) {
        assert!(resource.starts_with('#') || resource.starts_with("data:image/png;base64,"), "{resource:.60}");
    }
    for forbidden in ["<script", "<link", "@import", "url("] {
        assert!(!html.contains(forbidden), "{forbidden}");
    }
}

#[test]
fn equal_runs_give_equal_bytes() {
    assert_eq!(render(&full_run()).unwrap(), render(&full_run()).unwrap());
}

#[test]
fn a_study_that_stopped_after_the_surface_has_no_later_section() {
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
    for (name, table) in &full.tables {
        let tables = [(name.clone(), table.clone())].into();
        let report = render(&Run { tables, ..Run::default() }).unwrap();
        assert_eq!(report.figures.len(), 1, "{name}");
        elements(&report.figures[0].svg);
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
        for hidden in 0..table.columns.len() {
            let mut table = table.clone();
            table.columns[hidden].1.fill(f64::NAN);
            let run = Run { tables: [(name.clone(), table)].into(), ..Run::default() };
            for figure in render(&run).unwrap().figures {
                elements(&figure.svg);
                assert!(!figure.svg.contains("NaN"), "{name}, column {hidden}");
            }
        }
        let mut holes = table.clone();
        holes.columns.iter_mut().for_each(|(_, values)| values.iter_mut().step_by(3).for_each(|v| *v = f64::NAN));
        for figure in render(&Run { tables: [(name.clone(), holes)].into(), ..Run::default() }).unwrap().figures {
            elements(&figure.svg);
        }
        let mut one = table.clone();
        one.columns.iter_mut().for_each(|(_, values)| values.truncate(1));
        for figure in render(&Run { tables: [(name.clone(), one)].into(), ..Run::default() }).unwrap().figures {
            elements(&figure.svg);
            assert!(!figure.svg.contains("NaN"), "{name} with one row");
        }
    }
}

/// Every number of the results replaced by null.
fn nulled(value: &Value) -> Value {
    match value {
        Value::Object(entries) => entries.iter().map(|(key, value)| (key.clone(), nulled(value))).collect(),
        Value::Array(items) => items.iter().map(nulled).collect(),
        Value::Number(_) | Value::Bool(_) => Value::Null,
        other => other.clone(),
    }
}

#[test]
fn undefined_results_are_dashes_and_never_errors() {
    let full = full_run();
    let report = render(&Run { results: nulled(&full.results), ..Run::default() }).unwrap();
    assert!(report.html.contains("<td>–</td>"));
    for odd in
        [json!([]), json!("text"), json!({"surface": 3, "pressure": [], "friction": {"levels": {}}, "vibration": "no"})]
    {
        render(&Run { results: odd, ..Run::default() }).unwrap();
    }
}

#[test]
fn hostile_strings_are_escaped_everywhere() {
    const EVIL: &str = "\"><script>alert(1)</script><img src=x onerror=alert(1)> & '";
    let mut run = full_run();
    run.name = EVIL.into();
    run.inputs.push(Input { section: EVIL.into(), key: EVIL.into(), value: EVIL.into() });
    run.assumptions.push(EVIL.into());
    run.provenance[EVIL] = json!(EVIL);
    run.results["surface"][EVIL] = json!(EVIL);
    run.results["pressure"]["methods"][0]["name"] = json!(EVIL);
    run.results["friction"]["levels"][0]["marginal"] = json!({"name": EVIL, "parameters": {EVIL: EVIL}});
    run.results["warnings"] = json!([EVIL]);
    let cdf = run.tables.get_mut("pressure_cdf").unwrap();
    cdf.columns[2].0 = EVIL.into();
    run.tables.get_mut("friction_trace").unwrap().columns[1].0 = format!("mu_{EVIL}");
    let report = render(&run).unwrap();
    assert!(!report.html.contains("<script") && !report.html.contains("<img"));
    assert!(report.html.contains("&lt;script&gt;"));
    for figure in &report.figures {
        elements(&figure.svg);
        assert!(!figure.svg.contains("<script") && !figure.svg.contains("<img"));
    }
}

#[test]
fn a_ragged_table_and_a_field_of_the_wrong_size_are_refused() {
    let table = Table { columns: vec![("a".into(), vec![1.0, 2.0]), ("b".into(), vec![1.0])] };
    let error = render(&Run { tables: [("t".into(), table)].into(), ..Run::default() }).unwrap_err();
    assert_eq!(error, ReportError::RaggedTable { table: "t".into(), column: "b".into(), found: 1, wanted: 2 });
    let field = Field { nx: 2, ny: 2, dx_m: 1e-6, dy_m: 1e-6, values: vec![0.0; 3] };
    let refused =
        |field: &Field| render(&Run { fields: [("f".into(), field.clone())].into(), ..Run::default() }).unwrap_err();
    assert_eq!(refused(&field), ReportError::FieldShape { field: "f".into(), nx: 2, ny: 2, found: 3, wanted: 4 });
    let flat = Field { values: vec![0.0; 4], dx_m: 0.0, ..field };
    assert!(matches!(refused(&flat), ReportError::FieldPitch { .. }));
}
