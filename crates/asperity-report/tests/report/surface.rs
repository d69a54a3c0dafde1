//! The surface section.

use asperity_results::{MeasuredSurface, ScanOfPart, SurfaceStatistics};

use crate::documents::{text, words};
use crate::stages::surface;
use crate::synthetic::{edit, edit_field, example, full_run};
use asperity_report::render;

#[test]
fn parameters_are_in_groups_with_their_intervals() {
    let html = text(&render(&full_run()).unwrap().html).replace('\u{a0}', " ");
    let html = html.split_once("<caption>Surface parameters").unwrap().1;
    let place = |what: &str| html.find(what).unwrap_or_else(|| panic!("{what:?} is on the page"));
    let wanted = ["Map", "Height", "1.00 µm [0.94, 1.06]", "Hybrid", "Spatial", "Functional, core", "Spectrum"];
    assert!(wanted.map(place).is_sorted(), "{:?}", wanted.map(place));
    // A wavenumber with its wavelength, and no standard error among the properties of the random surface.
    assert!(html.contains("63 rad/mm (99.7 µm)") && html.contains("roll off") && !html.contains("Sq m se"));
}

#[test]
fn fitted_distributions_are_named_by_rank_in_figure_and_table() {
    let run = full_run();
    let drawn = words(&run, "height_pdf");
    for name in ["1. Johnson SU", "2. Beta", "3. normal", "distribution of the study"] {
        assert!(drawn.iter().any(|word| word == name), "{name} in {drawn:?}");
    }
    assert!(!drawn.iter().any(|word| word.contains("Weibull")), "the fourth is not drawn");
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    assert!(
        html.contains("γ = 0.11, δ = 2.3, ξ = 100 nm, λ = 2.1 µm")
            && html.contains("effective sample size of the correlated heights: 412")
    );
    // Older runs have no ranks.
    let mut run = full_run();
    run.tables.remove("height_fits");
    assert!(words(&run, "height_pdf").contains(&"fitted distribution".to_owned()));
}

#[test]
fn correlation_is_shown_up_to_six_lengths_with_its_bands() {
    let mut run = full_run();
    let wide = words(&run, "height_acf");
    for wanted in ["model, x", "model, y", "ℓx = 20 µm", "ℓy = 14 µm", "80"] {
        assert!(wide.iter().any(|word| word == wanted), "{wanted} in {wide:?}");
    }
    // Lengths that differ tenfold have a chart each, up to six of them.
    let scan = SurfaceStatistics {
        correlation_length_x_m: Some(1.1e-6),
        correlation_length_y_m: Some(1.1e-5),
        ..example::scan()
    };
    surface(&mut run).measured = MeasuredSurface::Scan(Box::new(scan));
    let apart = words(&run, "height_acf");
    assert_eq!(apart.iter().filter(|word| *word == "Lag (µm)").count(), 2);
    assert!(!apart.contains(&"80".to_owned()));
    let is_bound = |name: &str| name.ends_with("_low") || name.ends_with("_high");
    edit(&mut run.tables, "height_acf", |columns| columns.retain(|(name, _)| !is_bound(name)));
    assert!(!words(&run, "height_acf").iter().any(|word| word.starts_with("95 %")));
}

#[test]
fn spectra_have_bands_and_a_marked_reliable_range() {
    let mut run = full_run();
    let drawn = words(&run, "height_psd");
    for wanted in ["measured, radial", "model, x", "measured, y", "roll-off"] {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    // Older runs have profiles without bins.
    run.tables.retain(|name, _| !name.starts_with("height_psd_"));
    let drawn = words(&run, "height_psd");
    assert!(drawn.iter().any(|word| word == "measured, x") && !drawn.iter().any(|word| word.starts_with("95 %")));
}

#[test]
fn levelled_heights_and_their_realisation_share_a_colour_scale() {
    let mut run = full_run();
    edit_field(run.fields.get_mut("surface_sample").unwrap(), |values| *values *= 10.0);
    let ticks = |name: &str| {
        let drawn = words(&run, name);
        drawn[drawn.iter().position(|word| word == "x (µm)").unwrap()..].to_owned()
    };
    assert_eq!(ticks("height_levelled"), ticks("surface_sample"));
    assert_ne!(ticks("height_levelled"), ticks("height_raw"));
}

#[test]
fn figures_of_a_part_name_their_scan_and_mark_its_lengths() {
    let mut run = full_run();
    let scans = [("left.x3p", 1.5e-5), ("right.x3p", 2.5e-5)].map(|(file, length_m)| ScanOfPart {
        file: file.into(),
        statistics: SurfaceStatistics { correlation_length_x_m: Some(length_m), ..example::scan() },
    });
    surface(&mut run).measured = example::part(scans.into());
    let report = render(&run).unwrap();
    let sentence = "Measured: left.x3p, the first of 2 scans";
    let saying =
        report.figures.iter().filter(|figure| text(&figure.svg).contains(sentence)).map(|figure| figure.name.as_str());
    let surface = [
        "height_raw",
        "height_levelled",
        "surface_sample",
        "height_pdf",
        "height_acf",
        "height_psd",
        "structure_function",
    ];
    let drawn: Vec<&str> = report.figures.iter().map(|figure| figure.name.as_str()).collect();
    let wanted: Vec<&str> = drawn.into_iter().filter(|name| surface.contains(name)).collect();
    assert!(wanted.len() > 4, "{wanted:?}");
    assert_eq!(saying.collect::<Vec<_>>(), wanted);
    // The mark is on the drawn curve, not at the mean of all scans.
    assert!(words(&run, "height_acf").iter().any(|word| word == "ℓx = 15 µm"));
    let html = text(&report.html);
    assert!(html.contains("Distributions fitted to the heights of left.x3p, ranked") && html.contains(sentence));
    assert!(!text(&render(&full_run()).unwrap().html).contains("Measured:"));
}
