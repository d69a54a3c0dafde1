//! The report of a complete run: figures, sections, and escaping.

use asperity_results::ScanOfPart;

use crate::documents::{check_figure, check_page, elements, text, without_scripts};
use crate::stages::{friction, surface};
use crate::synthetic::{WITHOUT_FIGURE, edit, example, full_run, surface_run};
use asperity_report::{Input, Run, render};

#[test]
fn a_complete_run_has_every_section() {
    let html = text(&render(&full_run()).unwrap().html);
    for id in "answers surface pressure friction vibration details".split(' ') {
        assert!(html.contains(&format!("<section id=\"{id}\"")), "section {id}");
        assert!(html.contains(&format!("<li><a href=\"#{id}\">")), "{id} is not in the bar");
    }
    for id in ["certainty", "inputs", "assumptions", "provenance", "references"] {
        assert!(html.contains(&format!("<div id=\"{id}\">")), "entry {id}");
    }
    for wanted in [
        "P(contact) = 0.0200 [0.0190, 0.0210]",
        "it is 0.320 [0.307, 0.333]",
        "μ = 0.225 [0.218, 0.229]",
        "Roughness has no effect at the scale of your machine",
        "Yes: steady sliding is unstable",
        "ζ = 0.2048",
        "due to the window alone",
        "210 GPa",
        "Gaus",
        "21 contact cells",
        "tables/pressure_cdf.csv",
    ] {
        assert!(html.contains(wanted), "{wanted:?} is on the page");
    }
}

#[test]
fn tables_and_further_figures_are_among_the_details() {
    let html = render(&full_run()).unwrap().html;
    let place = |words: &str| html.find(words).unwrap_or_else(|| panic!("{words}"));
    let details = place("<section id=\"details\">");
    for (section, shown, contents) in [
        (
            "surface",
            &["height_levelled", "surface_sample"][..],
            &["Surface parameters", "Distributions fitted to the heights"][..],
        ),
        (
            "pressure",
            &["pressure_sample", "pressure_cdf"],
            &["Methods for the distribution of the pressure", "figure-pressure_accuracy"],
        ),
        (
            "friction",
            &["friction_trace", "friction_histogram"],
            &["Families of the correlation", "figure-friction_pit", "Friction coefficient F/N by level"],
        ),
        ("vibration", &["limit_cycle", "sustained_over_damping"], &["figure-survival"]),
    ] {
        let entry = format!("details-{section}");
        let link = place(&format!("<a href=\"#{entry}\">"));
        assert!(link < details && details < place(&format!("<div id=\"{entry}\">")), "{entry}");
        shown.iter().for_each(|name| assert!(place(&format!("<figure id=\"figure-{name}\"")) < details, "{name}"));
        contents.iter().for_each(|words| assert!(place(words) > details, "{words}"));
    }
    assert!(place("<table>") > details, "a table stands before the details");
}

#[test]
fn every_figure_names_its_tables() {
    let run = full_run();
    let html = text(&render(&run).unwrap().html);
    for name in run.tables.keys().filter(|name| !WITHOUT_FIGURE.contains(&name.as_str())) {
        assert!(html.contains(&format!("<code>tables/{name}.csv</code>")), "tables/{name}.csv");
    }
    for name in run.fields.keys() {
        assert!(html.contains(&format!("<code>fields/{name}</code>")), "fields/{name}");
    }
}

#[test]
fn every_figure_is_a_well_formed_svg_document_with_readable_text() {
    for figure in render(&full_run()).unwrap().figures {
        assert!(figure.svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"170mm\""), "{}", figure.name);
        assert!(figure.svg.contains("<title>") && figure.svg.contains("aria-label="));
        assert!(elements(&figure.svg) > 20, "{} is drawn", figure.name);
        check_figure(&figure);
    }
}

#[test]
fn figures_of_the_page_are_readable_on_a_phone_and_legends_are_short() {
    let html = render(&full_run()).unwrap().html;
    assert!(!html.contains("min-width: 480px") && !html.contains("Data: ."));
    let figures: Vec<&str> =
        html.split("<figure id=").skip(1).map(|rest| rest.split("</figure>").next().unwrap()).collect();
    for figure in figures.iter().copied() {
        let name = &figure[..30];
        let width = figure.split_once("viewBox=\"0 0 ").unwrap().1.split(' ').next().unwrap().parse::<f64>().unwrap();
        for size in figure.split("font-size=\"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
            // Of 390 pixels 348 remain inside of the card.
            assert!(348.0 / width * size.parse::<f64>().unwrap() >= 9.0, "{name}: {size} in {width}");
        }
        // One symbol for each method has a name in the figure of their errors.
        let most = if name.contains("pressure_accuracy") { 9 } else { 6 };
        assert!(figure.matches("data-entry=").count() <= most, "{name}");
    }
    assert!(figures.len() > 10);
}

#[test]
fn the_page_loads_nothing_from_elsewhere() {
    check_page(&render(&full_run()).unwrap().html);
}

#[test]
fn only_a_page_with_a_machine_may_run_webassembly_and_workers() {
    let policy = |run: &Run| {
        let html = render(run).unwrap().html;
        html.split_once("Content-Security-Policy\" content=\"").unwrap().1.split_once('"').unwrap().0.to_owned()
    };
    let with = policy(&full_run());
    assert!(with.contains(" 'wasm-unsafe-eval'; worker-src blob:") && !with.contains("unsafe-inline"), "{with}");
    let without = policy(&surface_run());
    assert!(!without.contains("wasm") && without.contains("worker-src 'none'"), "{without}");
}

#[test]
fn sections_begin_with_their_answer_and_the_page_says_how_to_cite() {
    let html = text(&render(&full_run()).unwrap().html).replace('\u{a0}', " ");
    for (section, words) in [
        ("surface", "Sq = 1.00 µm [0.94, 1.06]; heights are correlated over"),
        ("pressure", "estimated probability of contact 32.0 % [30.7, 33.3]"),
        ("friction", "from window to window of"),
        ("vibration", "No vibration persists above ζ ="),
    ] {
        let content = html.split_once(&format!("<section id=\"{section}\">")).unwrap().1;
        assert!(content.split("</section>").next().unwrap().matches("<figure").count() <= 2, "{section}");
        let answer = content.split_once("<p class=\"found\">").unwrap().1.split_once("</p>").unwrap().0;
        assert!(answer.contains(words), "{section}: {answer}");
    }
    let certainty = html.split_once("<div id=\"certainty\">").unwrap().1.split_once("</details>").unwrap().0;
    for words in ["rms height Sq", "[0.94, 1.06]", "random strips:", "limit of the damping ratio", "trajectories"] {
        assert!(certainty.contains(words), "{words}: {certainty}");
    }
    assert!(html.contains("@software{asperity,") && html.contains("@article{gaus2016roughness,"));
}

#[test]
fn no_panel_has_more_than_six_curves() {
    let mut panels = 0;
    for figure in render(&full_run()).unwrap().figures {
        for chart in figure.svg.split("<g class=\"chart\"").skip(1) {
            panels += 1;
            // A line across the plot has two points, and the outlines of bars are no curves.
            let is_curve = |series: &&str| {
                let shapes = series.split("</g>").next().unwrap();
                let mut points = shapes.split("<polyline points=\"").skip(1).filter_map(|rest| rest.split('"').next());
                !shapes.contains("<polygon") && points.any(|points| points.split(' ').count() > 2)
            };
            let series = chart.split("<g data-series=\"").skip(1).filter(is_curve);
            let mut names: Vec<&str> = series.filter_map(|series| Some(series.split_once('"')?.0)).collect();
            names.retain(|name| !name.is_empty());
            names.sort_unstable();
            names.dedup();
            assert!(names.len() <= 6, "{}: {names:?}", figure.name);
        }
    }
    assert!(panels > 20);
}

#[test]
fn hostile_strings_are_escaped_everywhere() {
    const EVIL: &str = "\"><script>alert(1)</script><img src=x onerror=alert(1)> & '";
    let mut run = full_run();
    run.name = EVIL.into();
    run.inputs.push(Input { section: EVIL.into(), key: EVIL.into(), value: EVIL.into() });
    run.results.assumptions.push(EVIL.into());
    run.results.warnings.push(EVIL.into());
    run.provenance.as_mut().unwrap().inputs.insert(EVIL.into(), EVIL.into());
    friction(&mut run).levels[0].marginal = Some(example::law(EVIL, &[(EVIL, 1.0)]));
    let scan = || ScanOfPart { file: EVIL.into(), statistics: example::scan() };
    surface(&mut run).measured = example::part(vec![scan(), scan()]);
    surface(&mut run).marginal = example::law(EVIL, &[(EVIL, 1.0)]);
    surface(&mut run).covariance.as_mut().unwrap().model = EVIL.into();
    edit(&mut run.tables, "pressure_cdf", |columns| columns[2].0 = EVIL.into());
    edit(&mut run.tables, "friction_trace", |columns| columns[1].0 = format!("mu_{EVIL}"));
    let report = render(&run).unwrap();
    assert!(!without_scripts(&report.html).contains("<img"));
    assert!(report.html.contains("&lt;script&gt;"));
    for figure in &report.figures {
        elements(&figure.svg);
        assert!(!figure.svg.contains("<script") && !figure.svg.contains("<img"));
    }
}
