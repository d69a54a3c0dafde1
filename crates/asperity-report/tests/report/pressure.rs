//! The section of the contact pressure.

use asperity_results::{MethodEntry, PressureMethod};

use crate::documents::{text, words};
use crate::stages::pressure;
use crate::synthetic::{edit_field, full_run};
use asperity_report::{Run, render};

#[test]
fn methods_of_the_pressure_are_compared_with_their_bands_cost_and_error() {
    let mut run = full_run();
    let seconds = [
        ("pressure/monte_carlo", 1.25),
        ("pressure/coarse", 2.5),
        ("pressure/distribution/default", 0.25),
        ("pressure/sobol", 3.0),
    ];
    run.provenance.as_mut().unwrap().seconds = seconds.map(|(task, time)| (task.to_owned(), time)).into();
    let drawn = words(&run, "pressure_cdf");
    // Beside many methods the caption explains the bands.
    assert!(drawn.iter().any(|word| word == "default of asperity") && drawn[1].contains("with 95 % probability"));
    let drawn = words(&run, "pressure_accuracy");
    for wanted in
        ["KS distance", "W₁ / std", "|Δ P(contact)|", "Work in fine contact solutions", "expected of Monte Carlo"]
    {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in ["Work of all solves in fine solves", "162.0 MPa [157.9, 166.1]", "400.0 nm [398.0, 402.0]"] {
        assert!(html.contains(wanted), "{wanted:?} is on the page");
    }
    // A refused method is named with its reason, not as a row of dashes.
    let mut refused = run.clone();
    let methods = &mut pressure(&mut refused).methods;
    let method = methods.iter_mut().find(|method| method.name == PressureMethod::PolynomialChaos).unwrap();
    let (name, failure) = (PressureMethod::PolynomialChaos, Some("20 samples for 165 coefficients".to_owned()));
    *method = MethodEntry { name, fine_solves: 60, failure, ..MethodEntry::default() };
    let html = text(&render(&refused).unwrap().html).replace('\u{a0}', " ");
    assert!(html.contains("Methods without an estimate: polynomial chaos (20 samples for 165 coefficients)."));
    assert!(!html.contains("<th scope=\"col\">polynomial chaos</th>"));
    assert!(!text(&render(&run).unwrap().html).contains("Methods without an estimate"));
    // A method unrelated to the reference does not change the axes of the others.
    let method =
        pressure(&mut run).methods.iter_mut().find(|method| method.name == PressureMethod::PolynomialChaosLog).unwrap();
    (method.mean_pa, method.wasserstein_1_over_std) = (Some(1e20), Some(1e12));
    for (name, largest) in [("pressure_intervals", "165"), ("pressure_accuracy", "0.05")] {
        let drawn = words(&run, name);
        assert!(drawn.iter().any(|word| word == largest), "{largest} in {drawn:?}");
    }
    // Older runs have no bands.
    run.tables.remove("pressure_bands");
    assert!(!words(&run, "pressure_cdf").iter().any(|word| word.contains("95 %")));
}

#[test]
fn maps_of_all_cells_have_their_accuracy() {
    let run = full_run();
    let drawn = words(&run, "pressure_quantiles");
    for wanted in ["Mean", "90 % quantile", "Pressure (GPa)"] {
        assert!(drawn.iter().any(|word| word == wanted), "{wanted} in {drawn:?}");
    }
    assert!(!drawn.iter().any(|word| word == "no contact (p = 0)"), "no drawn cell has the value zero");
    assert!(!drawn.iter().any(|word| word == "Median"), "a constant field has no panel");
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in [
        "500 realisations: the 95 % interval of each value is ± 0.044 or narrower",
        "The distributions of 16 distant cells differ beyond chance (p = 0.0062)",
        "Standard errors of the means are 29 MPa at most",
        "Not shown because it is equal in all cells: the 10 % quantile (0 Pa) and the median (0 Pa).",
        "of total degree 1 in the 8 leading variables, 0.93 on average",
    ] {
        assert!(html.contains(wanted), "{wanted:?} is on the page");
    }
    // The maps do not need the numbers of their captions.
    let mut bare = full_run();
    let found = pressure(&mut bare);
    (found.maps, found.homogeneity, found.global_expansion) = (None, None, None);
    let names = |run: &Run| render(run).unwrap().figures.into_iter().map(|figure| figure.name).collect::<Vec<_>>();
    assert!(names(&bare).contains(&"expansion_error".to_owned()));
    // Older runs have no maps.
    bare.fields.retain(|name, _| name == "pressure_sample");
    assert!(!names(&bare).iter().any(|name| name == "pressure_quantiles" || name == "contact_probability"));
    // A patch without contact has its legend.
    let mut free = full_run();
    for name in ["pressure_mean", "pressure_quantile_90"] {
        edit_field(free.fields.get_mut(name).unwrap(), |values| values.fill(0.0));
    }
    for wanted in ["Median", "no contact (p = 0)"] {
        assert!(words(&free, "pressure_quantiles").iter().any(|word| word == wanted), "{wanted}");
    }
}
