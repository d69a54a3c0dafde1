//! The report of complete, partial and hostile runs.

use crate::documents::{elements, resources, text};
use crate::synthetic::{example, full_run, surface_run};
use asperity_report::{Field, Input, ReportError, Run, Table, render};
use asperity_results::{
    FrictionResult, KindResult, LevelResult, MeasuredSurface, MethodEntry, PressureResult, Results, ScanOfPart,
    SurfaceResult, SurfaceStatistics, VibrationResult,
};

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
        "contact_probability",
        "pressure_quantiles",
        "expansion_error",
        "pressure_cdf",
        "pressure_intervals",
        "pressure_accuracy",
        "pressure_scalars",
        "pressure_sensitivities",
        "friction_load_curve",
        "friction_cutoff",
        "friction_histogram",
        "friction_pit",
        "friction_qq",
        "friction_acf",
        "friction_windows",
        "friction_spectrum",
        "friction_area_load",
        "friction_levels",
        "friction_shape",
        "friction_trace",
        "limit_cycle",
        "reattachment",
        "cycles_over_damping",
        "sustained_over_damping",
        "survival",
    ];
    assert_eq!(names, wanted);
    for id in [
        "answers",
        "surface",
        "pressure",
        "friction",
        "quotient",
        "vibration",
        "inputs",
        "assumptions",
        "provenance",
        "references",
    ] {
        assert!(html.contains(&format!("<section id=\"{id}\"")), "section {id}");
    }
    for wanted in [
        "P(contact) = 0.0200 [0.0190, 0.0210]",
        "it is 0.3200 ± 0.0066",
        "μ = 0.2249 [0.2227, 0.2271]",
        "The paper’s effect vanishes at your scale",
        "Yes: steady sliding is unstable",
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

fn surface(run: &mut Run) -> &mut SurfaceResult {
    run.results.surface.as_mut().unwrap()
}

fn pressure(run: &mut Run) -> &mut PressureResult {
    run.results.pressure.as_mut().unwrap()
}

fn friction(run: &mut Run) -> &mut FrictionResult {
    run.results.friction.as_mut().unwrap()
}

/// What is written in a figure, piece by piece.
fn words(run: &Run, name: &str) -> Vec<String> {
    let svg = render(run).unwrap().figures.into_iter().find(|figure| figure.name == name).unwrap().svg;
    let pieces =
        svg.split('<').filter_map(|piece| piece.split_once('>')).map(|(_, text)| text.trim().replace('\u{a0}', " "));
    pieces.filter(|text| !text.is_empty()).collect()
}

#[test]
fn the_vibration_says_where_cycles_are_lost_and_how_it_moves() {
    let run = full_run();
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in [
        "0.15160 [0.15140, 0.15180]",
        "Ways out of vibration per τ in it",
        "overtaking the belt without stick",
        "none: vibration takes more than 5 % of the time",
        "0.00826 [0.00787, 0.00867]",
        "99.5 % [98.2, 99.9]",
        "11.370 ± 0.070 %",
        "Points of detachment by upscaling",
        "tables/phase_cloud.csv",
    ] {
        assert!(html.contains(wanted), "the page says {wanted:?}");
    }
    let portrait = words(&run, "limit_cycle");
    for wanted in ["many trajectories", "one stochastic trajectory", "deterministic limit cycle"] {
        assert!(portrait.contains(&wanted.to_owned()), "{wanted} in {portrait:?}");
    }
    let lost = words(&run, "sustained_over_damping");
    assert!(
        lost.contains(&"Sustained vibration, share".to_owned()) && lost.contains(&"Cycles per period 2π".to_owned())
    );
    // Constant friction has no motion; and a run without the length of the trajectories.
    let mut run = full_run();
    run.tables.remove("phase_cloud");
    run.inputs.retain(|input| input.key != "duration");
    run.results.vibration.as_mut().unwrap().paper.motion = None;
    let html = text(&render(&run).unwrap().html);
    assert!(!html.contains("Ways out of vibration"));
    assert!(!words(&run, "limit_cycle").contains(&"many trajectories".to_owned()));
    assert!(!words(&run, "sustained_over_damping").contains(&"Cycles per period 2π".to_owned()));
}

#[test]
fn parameters_stand_in_groups_with_their_intervals() {
    let html = text(&render(&full_run()).unwrap().html).replace('\u{a0}', " ");
    let place = |what: &str| html.find(what).unwrap_or_else(|| panic!("the page says {what:?}"));
    let wanted =
        ["95 % interval", "Height", "1.00 µm", "[0.94, 1.06]", "Spatial", "Hybrid", "Functional, core", "Spectral"];
    assert!(wanted.map(place).is_sorted(), "{:?}", wanted.map(place));
    // A wavenumber with its wavelength, and no standard error among the properties of the random surface.
    assert!(html.contains("63 rad/mm (99.7 µm)") && html.contains("roll off") && !html.contains("Sq m se"));
    // Without intervals there is no column for them.
    let mut run = full_run();
    let mut scan = example::scan();
    scan.intervals.0.clear();
    surface(&mut run).measured = MeasuredSurface::Scan(Box::new(scan));
    assert!(!text(&render(&run).unwrap().html).contains(">95 % interval<"));
}

#[test]
fn fitted_laws_are_named_by_rank_in_figure_and_table() {
    let run = full_run();
    let drawn = words(&run, "height_pdf");
    for name in ["1. Johnson SU", "2. Beta", "3. Normal", "law of the study"] {
        assert!(drawn.iter().any(|word| word == name), "{name} in {drawn:?}");
    }
    assert!(!drawn.iter().any(|word| word.contains("Weibull")), "the fourth is not drawn");
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    assert!(html.contains("γ = 0.11, δ = 2.3, ξ = 100 nm, λ = 2.1 µm") && html.contains("worth 412 independent ones"));
    // Runs from before there were ranks.
    let mut run = full_run();
    run.tables.remove("height_fits");
    assert!(words(&run, "height_pdf").contains(&"fitted law".to_owned()));
}

#[test]
fn correlation_is_shown_up_to_six_lengths_with_its_bands() {
    let mut run = full_run();
    let wide = words(&run, "height_acf");
    for wanted in ["95 % band, x", "95 % band, y", "model, y", "ℓx = 20 µm", "ℓy = 14 µm", "80"] {
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
    let table = run.tables.get_mut("height_acf").unwrap();
    table.columns.retain(|(name, _)| !name.ends_with("_low") && !name.ends_with("_high"));
    assert!(!words(&run, "height_acf").iter().any(|word| word.starts_with("95 %")));
}

#[test]
fn spectra_have_bands_and_a_marked_reliable_range() {
    let mut run = full_run();
    let drawn = words(&run, "height_psd");
    for wanted in ["measured, radial", "model, x", "measured, y", "95 % bands", "outside the reliable band", "roll-off"]
    {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    // Runs from before there were bins still have their profiles.
    run.tables.retain(|name, _| !name.starts_with("height_psd_"));
    let drawn = words(&run, "height_psd");
    assert!(drawn.iter().any(|word| word == "measured, x") && !drawn.iter().any(|word| word.starts_with("95 %")));
}

#[test]
fn levelled_heights_and_their_realisation_share_a_colour_scale() {
    let mut run = full_run();
    run.fields.get_mut("surface_sample").unwrap().values.iter_mut().for_each(|z| *z *= 10.0);
    let ticks = |name: &str| {
        let drawn = words(&run, name);
        drawn[drawn.iter().position(|word| word == "x (µm)").unwrap()..].to_owned()
    };
    assert_eq!(ticks("height_levelled"), ticks("surface_sample"));
    assert_ne!(ticks("height_levelled"), ticks("height_raw"));
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
    // Bands are drawn around the laws of another table.
    for (name, table) in full.tables.iter().filter(|(name, _)| *name != "pressure_bands") {
        let tables = [(name.clone(), table.clone())].into();
        let report = render(&Run { tables, ..Run::default() }).unwrap();
        // The laws of the heights are a table of the page; the levels of friction and the damping sweep are two figures.
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

#[test]
fn methods_of_the_pressure_are_compared_with_their_bands_cost_and_error() {
    let mut run = full_run();
    let seconds = [
        ("pressure/monte_carlo", 1.25),
        ("pressure/coarse", 2.5),
        ("pressure/law/default", 0.25),
        ("pressure/sobol", 3.0),
    ];
    run.provenance.as_mut().unwrap().seconds = seconds.map(|(task, time)| (task.to_owned(), time)).into();
    let drawn = words(&run, "pressure_cdf");
    for wanted in ["default: 95 %, all pressures at once", "default: 95 %, at one pressure", "default of asperity"] {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    let drawn = words(&run, "pressure_accuracy");
    for wanted in
        ["KS distance", "W₁ / std", "|Δ P(contact)|", "Work in fine contact solutions", "expected of Monte Carlo"]
    {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in ["9000 on 16 × 16, 1712 on 32 × 32", ">4 s<", "162.0 MPa [157.9, 166.1]", "400.0 nm [398.0, 402.0]"]
    {
        assert!(html.contains(wanted), "the page says {wanted:?}");
    }
    // A refused method is named with its reason, not as a row of dashes.
    let mut refused = run.clone();
    let methods = &mut pressure(&mut refused).methods;
    let method = methods.iter_mut().find(|method| method.name == "polynomial_chaos").unwrap();
    let (name, failure) = ("polynomial_chaos".to_owned(), Some("20 samples for 165 coefficients".to_owned()));
    *method = MethodEntry { name, fine_solves: 60, failure, ..MethodEntry::default() };
    let html = text(&render(&refused).unwrap().html).replace('\u{a0}', " ");
    assert!(html.contains("Methods without an estimate: polynomial chaos (20 samples for 165 coefficients)."));
    assert!(!html.contains("<th scope=\"row\">polynomial chaos</th>"));
    assert!(!text(&render(&run).unwrap().html).contains("Methods without an estimate"));
    // A law that has nothing to do with the reference leaves the frames of the others alone.
    let method = pressure(&mut run).methods.iter_mut().find(|method| method.name == "polynomial_chaos_log").unwrap();
    (method.mean_pa, method.wasserstein_1_over_std) = (Some(1e20), Some(1e12));
    for (name, largest) in [("pressure_intervals", "165"), ("pressure_accuracy", "5·10⁻²")] {
        let drawn = words(&run, name);
        assert!(drawn.iter().any(|word| word == largest), "{largest} in {drawn:?}");
    }
    // The stiffness, where it was asked for.
    let scalars = words(&run, "pressure_scalars");
    assert!(
        scalars.iter().any(|word| word.contains("Mean gap")) && !scalars.iter().any(|word| word.contains("Stiffness"))
    );
    let columns = &mut run.tables.get_mut("pressure_scalar_laws").unwrap().columns;
    let gaps = columns.iter().find(|(name, _)| name == "mean_gap_m").unwrap();
    let stiffness = gaps.1.iter().map(|gap| 5e19 * gap).collect();
    columns.push(("stiffness_pa_per_m".into(), stiffness));
    let scalars = words(&run, "pressure_scalars");
    assert!(scalars.iter().any(|word| word == "Stiffness (MPa/µm)"), "{scalars:?}");
    // Runs from before there were bands.
    run.tables.remove("pressure_bands");
    run.tables.remove("pressure_scalar_laws");
    assert!(!words(&run, "pressure_cdf").iter().any(|word| word.contains("95 %")));
}

#[test]
fn maps_of_all_cells_say_how_well_they_are_known() {
    let run = full_run();
    let drawn = words(&run, "pressure_quantiles");
    for wanted in ["Mean", "90 % quantile", "Pressure (GPa)"] {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    assert!(!drawn.iter().any(|word| word == "no contact (p = 0)"), "no cell that is drawn has the value zero");
    assert!(!drawn.iter().any(|word| word == "Median"), "what is the same everywhere has no panel");
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in [
        "500 realisations: each value is known to ± 0.044 or better",
        "16 cells apart differ in law by more than chance (p = 0.0062)",
        "Standard errors of the means are 29 MPa at most",
        "The same in every cell, and not shown: the 10 % quantile (0 Pa) and the median (0 Pa).",
        "of total degree 1 in the 8 leading variables, 0.93 on average",
    ] {
        assert!(html.contains(wanted), "the page says {wanted:?}");
    }
    // Without numbers beside them the maps are still there.
    let mut bare = full_run();
    let found = pressure(&mut bare);
    (found.maps, found.homogeneity, found.global_expansion) = (None, None, None);
    found.sensitivities.clear();
    let names = |run: &Run| render(run).unwrap().figures.into_iter().map(|figure| figure.name).collect::<Vec<_>>();
    assert!(names(&bare).contains(&"expansion_error".to_owned()));
    assert!(!names(&bare).contains(&"pressure_sensitivities".to_owned()));
    // Runs from before there were maps.
    bare.fields.retain(|name, _| name == "pressure_sample");
    assert!(!names(&bare).iter().any(|name| name == "pressure_quantiles" || name == "contact_probability"));
    // A patch that is never pressed is drawn as such.
    let mut free = full_run();
    free.fields.get_mut("pressure_mean").unwrap().values.fill(0.0);
    free.fields.get_mut("pressure_quantile_90").unwrap().values.fill(0.0);
    for wanted in ["Median", "no contact (p = 0)"] {
        assert!(words(&free, "pressure_quantiles").iter().any(|word| word == wanted), "{wanted}");
    }
}

#[test]
fn sensitivities_name_every_variable_and_say_what_is_explained() {
    let mut run = full_run();
    let drawn = words(&run, "pressure_sensitivities");
    for wanted in [
        "height of the cell",
        "ring 5",
        "mode 8",
        "Pressure at the cell: heights about the cell",
        "Contact area: leading modes",
        "explained: 83 % of the variance",
        "Sobol’ index",
    ] {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    assert!(
        !drawn.iter().any(|word| word == "Contact area: heights about the cell"),
        "a failed expansion has no panel"
    );
    // An expansion that predicts worse than the mean explains nothing.
    pressure(&mut run).sensitivities[0].cross_validated_error = Some(1.2);
    assert!(words(&run, "pressure_sensitivities").contains(&"explained: 0 % of the variance".to_owned()));
    pressure(&mut run).sensitivities.clear();
    assert!(render(&run).unwrap().figures.iter().all(|figure| figure.name != "pressure_sensitivities"));
}

#[test]
fn friction_is_shown_with_its_intervals_its_window_and_its_boundary() {
    let mut run = full_run();
    let has = |run: &Run, name: &str, wanted: &[&str]| {
        let drawn = words(run, name);
        wanted.iter().for_each(|word| assert!(drawn.iter().any(|own| own == word), "{word} in {drawn:?}"));
    };
    has(
        &run,
        "friction_levels",
        &["F/N of a window", "95 %, F/N", "at the mean load", "75 %", "at load", "Std of μ (10⁻³)"],
    );
    has(&run, "friction_shape", &["CoV of μ", "Skewness of μ", "95 %, at the mean load", "Penetration (µm)"]);
    has(&run, "friction_load_curve", &["Mean pressure (MPa)", "Contact fraction", "95 % interval"]);
    has(&run, "friction_histogram", &["law ranked first (shifted lognormal)", "Beta", "shifted gamma", "normal"]);
    has(&run, "friction_acf", &["window alone (triangle)", "window and exponential", "squared exponential"]);
    has(
        &run,
        "friction_windows",
        &["window alone: 0.614 W", "ℓ without it, 95 %", "ℓ of all windows together", "Window W (µm)"],
    );
    has(&run, "friction_spectrum", &["95 % band", "window alone", "Frequency (1/mm)"]);
    let page = |run: &Run| text(&render(run).unwrap().html).replace('\u{a0}', " ");
    for wanted in [
        "Window of 600 µm × 75 µm on 60 strips 75 µm wide (periodic, of mean compliance 8.28 µm/GPa under a fixed plane).",
        "250 µm [200, 320] (window only)",
        "25.0 µm [21.0, 29.0]",
        "<td>0.061</td>",
        "exceeded once in 100 mm",
        "0.2310 [0.2280, 0.2360]",
        "<td>inside</td><td>600 µm</td><td>0.012</td>",
        "<td>taken out</td><td>0.0 µm [0.0, 8.5]</td>",
        "0.021 (p = 0.41)",
        "Std, “area”",
    ] {
        assert!(page(&run).contains(wanted), "the page says {wanted:?}");
    }
    // A level without a variance has neither moments nor a law of the quotient, and says why.
    let mut heavy = run.clone();
    let lead = &mut friction(&mut heavy).levels[5];
    *lead = LevelResult {
        std: None,
        std_interval: None,
        coefficient_of_variation: None,
        skewness: None,
        excess_kurtosis: None,
        marginal: None,
        gof: None,
        marginal_parameter_intervals: Default::default(),
        return_levels: Vec::new(),
        no_variance: Some("58 % of the windows hold fewer than 30 contact cells".into()),
        ..lead.clone()
    };
    for column in &mut heavy.tables.get_mut("friction_levels").unwrap().columns {
        if column.0.starts_with("std") && !column.0.contains("load") {
            column.1[5] = f64::NAN;
        }
    }
    let said = page(&heavy);
    assert!(said.contains("Level at 3 MPa: F/N has no variance") && said.contains("58 % of the windows"), "{said}");
    assert!(!said.contains("exceeded once") && !said.contains("empirical ()"));
    assert_eq!(words(&heavy, "friction_levels").iter().filter(|text| *text == "at load").count(), 1);
    // What equals the quotient is not drawn twice, and free strips are called so.
    friction(&mut run).mean_compliance_m_per_pa = None;
    assert!(page(&run).contains("75 µm wide (free)."));
    let levels = run.tables.get_mut("friction_levels").unwrap();
    levels.columns.retain(|(name, _)| !name.contains("at_mean_load"));
    assert!(!words(&run, "friction_levels").contains(&"at the mean load".to_owned()));
}

#[test]
fn friction_is_drawn_against_the_cutoff_with_its_floor_and_the_ends_of_the_band() {
    let mut run = full_run();
    let drawn = words(&run, "friction_cutoff");
    for wanted in [
        "Cut-off wavelength (µm)",
        "mean μ, 95 %",
        "half the pitch",
        "plastic floor τ/H",
        "cut-off of the study’s strips",
        "end of the scan’s band",
    ] {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in
        ["The friction coefficient is known only as far as the shortest waves are.", "0.1834 [", "0.21", "31 %"]
    {
        assert!(html.contains(wanted), "the page says {wanted:?}");
    }
    // An elastic study without a scan has neither a floor nor a band.
    let cutoff = friction(&mut run).cutoff.as_mut().unwrap();
    (cutoff.plastic_floor, cutoff.band_end_m, cutoff.halved_pitch) = (None, None, None);
    let drawn = words(&run, "friction_cutoff");
    assert!(!drawn.iter().any(|word| word.contains("floor") || word.contains("scan") || word.contains("half")));
}

#[test]
fn undefined_results_are_dashes_and_never_errors() {
    let kind = KindResult::None;
    let results = Results {
        surface: Some(SurfaceResult::default()),
        pressure: Some(PressureResult::default()),
        friction: Some(FrictionResult { levels: vec![LevelResult::default()], ..FrictionResult::default() }),
        vibration: Some(VibrationResult { kind, ..VibrationResult::default() }),
        ..Results::default()
    };
    let report = render(&Run { results, ..Run::default() }).unwrap();
    assert!(report.html.contains("<td>–</td>"));
}

#[test]
fn figures_of_several_scans_say_which_one_they_show_and_mark_its_lengths() {
    let mut run = full_run();
    let scans = [("left.x3p", 1.5e-5), ("right.x3p", 2.5e-5)].map(|(file, length_m)| ScanOfPart {
        file: file.into(),
        statistics: SurfaceStatistics { correlation_length_x_m: Some(length_m), ..example::scan() },
    });
    surface(&mut run).measured = example::part(scans.into());
    let report = render(&run).unwrap();
    let said = "Measured: left.x3p, the first of 2 scans";
    let saying =
        report.figures.iter().filter(|figure| text(&figure.svg).contains(said)).map(|figure| figure.name.as_str());
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
    // The mark stands on the curve that is drawn, not at the mean of all scans.
    assert!(words(&run, "height_acf").iter().any(|word| word == "ℓx = 15 µm"));
    let html = text(&report.html);
    assert!(html.contains("Laws fitted to the heights of left.x3p, ranked") && html.contains(said));
    assert!(!text(&render(&full_run()).unwrap().html).contains("Measured:"));
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
    pressure(&mut run).methods[0].name = EVIL.into();
    friction(&mut run).levels[0].marginal = Some(example::law(EVIL, &[(EVIL, 1.0)]));
    let scan = || ScanOfPart { file: EVIL.into(), statistics: example::scan() };
    surface(&mut run).measured = example::part(vec![scan(), scan()]);
    surface(&mut run).marginal = example::law(EVIL, &[(EVIL, 1.0)]);
    surface(&mut run).covariance.as_mut().unwrap().model = EVIL.into();
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

#[test]
fn uncertain_parameters_have_a_band_and_their_indices() {
    let mut run = full_run();
    let levels = friction(&mut run).levels.len();
    friction(&mut run).uncertainty = Some(example::uncertainty(levels));
    let columns = [
        ("penetration_m", vec![1.72e-6, 1.35e-6, f64::NAN]),
        ("mean_low", vec![0.19, 0.195, 0.0]),
        ("mean_high", vec![0.23, 0.24, 0.0]),
    ];
    let columns = columns.map(|(name, values)| (name.to_owned(), values)).to_vec();
    run.tables.insert("friction_uncertainty".into(), Table { columns });
    let said = words(&run, "friction_sensitivity");
    for wanted in ["Mean of μ", "Correlation length of μ", "rms height", "explained: 98 % of the variance"] {
        assert!(said.iter().any(|text| text == wanted), "{wanted:?} in {said:?}");
    }
    assert!(!said.iter().any(|text| text == "Std of μ"));
    assert!(words(&run, "friction_levels").iter().any(|text| text == "95 % of the parameters"));
    // Without indices there is no figure, and without the table no band.
    let uncertainty = friction(&mut run).uncertainty.as_mut().unwrap();
    uncertainty.levels.iter_mut().flat_map(|level| &mut level.at_mean_load).for_each(|response| response.sobol.clear());
    run.tables.remove("friction_uncertainty");
    let report = render(&run).unwrap();
    assert!(report.figures.iter().all(|figure| figure.name != "friction_sensitivity"));
    assert!(!words(&run, "friction_levels").iter().any(|text| text == "95 % of the parameters"));
}
