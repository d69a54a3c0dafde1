//! The sections of the friction coefficient and of the quotient F/N.

use asperity_results::LevelResult;

use crate::documents::{text, words};
use crate::stages::friction;
use crate::synthetic::{example, full_run};
use asperity_report::{Run, render};

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
    has(&run, "friction_histogram", &["ranked first (shifted lognormal)", "Beta", "shifted Gamma", "normal"]);
    has(&run, "friction_acf", &["window alone (triangle)", "window and process", "Matérn"]);
    has(&run, "friction_spectrum", &["95 % band", "window alone", "Frequency (1/mm)"]);
    let page = |run: &Run| text(&render(run).unwrap().html).replace('\u{a0}', " ");
    for wanted in [
        "Window of 600 µm × 75 µm on 60 strips 75 µm wide (periodic, of mean compliance 8.28 nm/MPa under a fixed plane).",
        "Correlation length ℓ of the exponential fit, with the effect of the window</th>",
        "25.0 µm [21.0, 29.0]",
        "<td>0.061</td>",
        ">100 mm</th>",
        "0.2310 [0.2280, 0.2360]",
        "<td>600 µm</td><td>0.012</td>",
        "<td>0 µm [0, 8.5]</td>",
        "p-value of the Kolmogorov–Smirnov distance",
        "Windows average over the nominal area",
    ] {
        assert!(page(&run).contains(wanted), "{wanted:?} is on the page");
    }
    // A level without a variance has neither moments nor a distribution of the quotient, but the reason.
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
    let drawn = page(&heavy);
    assert!(drawn.contains("58 % of the windows hold fewer than 30 contact cells"), "{drawn}");
    assert!(!drawn.contains("exceeded once") && !drawn.contains("empirical ()"));
    assert_eq!(words(&heavy, "friction_levels").iter().filter(|text| *text == "at load").count(), 1);
    // Moments at the mean load that equal the quotient's are not drawn; free strips are called so.
    friction(&mut run).mean_compliance_m_per_pa = None;
    assert!(page(&run).contains("75 µm wide (free)."));
    for level in &mut friction(&mut run).levels {
        let own = &mut level.process.at_mean_load;
        (own.mean, own.mean_interval) = (level.mean.unwrap(), level.mean_interval);
        (own.std, own.std_interval) = (level.std.unwrap(), level.std_interval);
    }
    assert!(!words(&run, "friction_levels").contains(&"at the mean load".to_owned()));
}

#[test]
fn friction_over_the_cutoff_has_its_floor_and_the_ends_of_the_band() {
    let mut run = full_run();
    let drawn = words(&run, "friction_cutoff");
    for wanted in [
        "Cut-off wavelength (µm)",
        "mean μ, 95 %",
        "smallest pitch",
        "the scan itself",
        "plastic floor τ/H",
        "cut-off of the study’s strips",
        "end of the scan’s band",
    ] {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in [
        "The friction coefficient is known only as far as the shortest waves are.",
        "0.1834 [",
        "0.21",
        "0.31",
        "The scan itself, pressed like the random strips, has 0.2214.",
        "500 µm, 500 µm",
    ] {
        assert!(html.contains(wanted), "{wanted:?} is on the page");
    }
    // An elastic study without a scan has neither a floor nor a band.
    friction(&mut run).scan = None;
    let cutoff = friction(&mut run).cutoff.as_mut().unwrap();
    (cutoff.plastic_floor, cutoff.band_end_m, cutoff.finer_pitches) = (None, None, Vec::new());
    let drawn = words(&run, "friction_cutoff");
    assert!(!drawn.iter().any(|word| word.contains("floor") || word.contains("scan") || word.contains("half")));
}

#[test]
fn uncertain_parameters_have_a_band_and_their_indices() {
    let mut run = full_run();
    let levels = friction(&mut run).levels.len();
    friction(&mut run).uncertainty = Some(example::uncertainty(levels));
    let drawn = words(&run, "friction_sensitivity");
    for wanted in ["Mean of μ", "Correlation length of μ", "rms height", "Sobol’ index; 98 % explained"] {
        assert!(drawn.iter().any(|text| text == wanted), "{wanted:?} in {drawn:?}");
    }
    assert!(!drawn.iter().any(|text| text == "Std of μ"));
    assert!(words(&run, "friction_levels").iter().any(|text| text == "95 % of the parameters"));
    // Without indices there is no figure, and without intervals no band.
    let uncertainty = friction(&mut run).uncertainty.as_mut().unwrap();
    uncertainty.levels.iter_mut().flat_map(|level| &mut level.at_mean_load).for_each(|response| response.sobol.clear());
    uncertainty.levels.iter_mut().for_each(|level| level.responses.clear());
    let report = render(&run).unwrap();
    assert!(report.figures.iter().all(|figure| figure.name != "friction_sensitivity"));
    assert!(!words(&run, "friction_levels").iter().any(|text| text == "95 % of the parameters"));
}
