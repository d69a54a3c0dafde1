//! Study files of the pressure stage at reduced size, compared with independent numbers.

use std::fs;
use std::path::PathBuf;

use asperity::map::BoundaryKind;
use asperity::study::result::MethodEntry;
use asperity::study::{Outcome, Study};
use asperity_testing::{METHODS, StudyText};

use crate::support::run_all;

/// Returns the text of a study that comes with the code.
fn text(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../studies").join(name);
    fs::read_to_string(path).unwrap()
}

/// Returns the study with fewer solves.
fn reduced(name: &str, fine: usize, reference: usize) -> String {
    let text = text(name);
    assert!(text.contains("fine_solves = 2000\n") && text.contains("reference_samples = 20000\n"));
    text.replace("fine_solves = 2000\n", &format!("fine_solves = {fine}\n"))
        .replace("reference_samples = 20000\n", &format!("reference_samples = {reference}\n"))
}

fn method<'a>(outcome: &'a Outcome, name: &str) -> &'a MethodEntry {
    outcome.results.pressure.as_ref().unwrap().methods.iter().find(|method| method.name.name() == name).unwrap()
}

/// Asserts agreement with a known value, whose rounding and sampling error (20,000 pooled samples) are far below our
/// own errors.
fn assert_near(what: &str, found: f64, se: f64, known: f64) {
    assert!(se < 0.1 * known, "{what}: a standard error of {se} says nothing about {known}");
    assert!((found - known).abs() < 4.0 * se, "{what}: {found} ± {se}, known {known}");
}

/// Compares reference and default method with known P(contact), mean and standard deviation of the pressure.
fn assert_known(outcome: &Outcome, [contact, mean_pa, std_pa]: [f64; 3]) {
    let pressure = outcome.results.pressure.as_ref().unwrap();
    assert_near("P(contact)", pressure.contact_probability, pressure.contact_probability_se.unwrap(), contact);
    let mean_se_pa = pressure.mean_se_pa.unwrap();
    assert_near("mean", pressure.mean_pa, mean_se_pa, mean_pa);
    // The samples cover many sites: the relative error of the standard deviation is about that of the mean.
    assert_near("std", pressure.std_pa, std_pa * mean_se_pa / mean_pa, std_pa);
    let default = method(outcome, "default");
    assert_near("P(contact)", default.contact_probability.unwrap(), default.contact_probability_se.unwrap(), contact);
    assert_near("mean", default.mean_pa.unwrap(), default.mean_se_pa.unwrap(), mean_pa);
}

#[test]
#[ignore = "slow"]
fn case_a_has_its_known_contact_probability_mean_and_std() {
    let outcome = run_all(&reduced("pressure_case_a.toml", 200, 400));
    let expansion = outcome.results.surface.as_ref().unwrap().karhunen_loeve.unwrap();
    assert_eq!(expansion.modes, 101);
    assert!((expansion.captured_variance - 0.9909).abs() < 1e-4, "{}", expansion.captured_variance);
    let pressure = outcome.results.pressure.as_ref().unwrap();
    assert_eq!((pressure.cell, pressure.separation_m), ([32, 32], Some(0.0)));
    let compliance = pressure.mean_compliance_m_per_pa.unwrap();
    assert!((compliance * std::f64::consts::PI - 1.0).abs() < 1e-12, "{compliance}");
    assert_known(&outcome, [0.24675, 1.862, 4.066]);
    // At equal fine solves the default has the smaller error.
    let error = |name: &str| method(&outcome, name).mean_se_pa.unwrap();
    assert!(error("default") < 0.6 * error("monte_carlo"), "{} {}", error("default"), error("monte_carlo"));
}

#[test]
#[ignore = "slow"]
fn case_c_has_its_known_contact_probability_mean_and_std() {
    let outcome = run_all(&reduced("pressure_case_c.toml", 200, 400));
    let expansion = outcome.results.surface.as_ref().unwrap().karhunen_loeve.unwrap();
    assert!(expansion.modes == 8 && expansion.captured_variance < 0.95, "{expansion:?}");
    assert_known(&outcome, [0.3570, 1.351, 2.290]);
}

#[test]
fn truncated_heights_give_less_pressure_than_rescaled_ones() {
    // Everything is proportional to the heights, so the ratio is √(captured variance) for the same normal variables.
    let scaled = run_all(&reduced("pressure_case_c.toml", 20, 20));
    let left = run_all(&reduced("pressure_case_c.toml", 20, 20).replace("rescale = true ", "rescale = false"));
    let (scaled_pa, left_pa) = (scaled.results.pressure.unwrap().mean_pa, left.results.pressure.unwrap().mean_pa);
    let captured = left.results.surface.unwrap().karhunen_loeve.unwrap().captured_variance;
    assert!((left_pa / scaled_pa / captured.sqrt() - 1.0).abs() < 1e-4, "{left_pa} {scaled_pa} {captured}");
}

#[test]
fn figure_2_of_the_paper_has_165_coefficients_a_free_patch_and_contact_at_most_half_the_time() {
    let study = Study::parse(&text("paper_fig2.toml"), "paper_fig2.toml").unwrap();
    let (surface, pressure) = (study.file().surface.as_ref().unwrap(), study.file().pressure.as_ref().unwrap());
    let (n, k) = (pressure.variables + pressure.degree, pressure.degree);
    assert_eq!((1..=k).fold(1, |product, i| product * (n - k + i) / i), 165);
    assert_eq!((surface.modes, pressure.boundary, pressure.percentile), (Some(101), BoundaryKind::Free, Some(50.0)));
    let ratio = pressure.size[0].0 / surface.correlation_length.unwrap()[0].0;
    assert!((ratio - 10.0).abs() < 1e-12, "{ratio}");
    let small = reduced("paper_fig2.toml", 100, 200).replace("points = [64, 64]", "points = [32, 32]");
    let outcome = run_all(&small.replace("variables = 8 ", "variables = 2 ").replace("degree = 3", "degree = 1"));
    let pressure = outcome.results.pressure.as_ref().unwrap();
    assert_eq!((pressure.sites, pressure.cell), (1, [16, 16]));
    // 101 terms have 94.0 % of the variance.
    let captured = outcome.results.surface.as_ref().unwrap().karhunen_loeve.as_ref().unwrap().captured_variance;
    assert!((captured - 0.940).abs() < 5e-3, "{captured}");
    let default = method(&outcome, "default");
    let (found, se) = (default.contact_probability.unwrap(), default.contact_probability_se.unwrap());
    assert!(found < 0.5 + 3.0 * se && found > 0.05, "{found} ± {se}");
}

#[test]
#[ignore = "slow"]
fn results_and_tables_agree_for_every_method() {
    let outcome =
        run_all(&reduced("pressure_case_c.toml", 100, 100).replace("percentile =", "stiffness = true\npercentile ="));
    let results = serde_json::to_value(&outcome.results).unwrap();
    let pressure = &results["pressure"];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let table = &outcome.tables["pressure_methods"];
    let refused = pressure["methods"].as_array().unwrap().iter().filter(|m| m["failure"].is_string()).count();
    assert_eq!(table.names().len(), 8 - refused);
    assert_eq!(table.column("mean_low_pa").unwrap()[0], number(&pressure["mean_interval"][0]));
    for method in pressure["methods"].as_array().unwrap() {
        let name = method["name"].as_str().unwrap();
        let coarse = method["coarse_solves"].as_array().unwrap();
        // The smallest possible work is one iteration on the fine grid for about ten of a fine solution.
        for model in coarse {
            let cells = number(&model["nx"]) * number(&model["ny"]) / 4096.0 * number(&model["solves"]);
            let share = number(&model["work_in_fine_solves"]) / cells;
            assert!(share > 0.1 && share < 2.0, "{name}: {share}");
        }
        let own = coarse.iter().map(|model| number(&model["work_in_fine_solves"])).sum::<f64>();
        let work = number(&method["fine_solves"]) + own;
        assert_eq!(number(&method["work_in_fine_solves"]), work, "{name}");
        // A method without estimate has a reason, but neither a row nor a column.
        let row = table.names().iter().position(|row| row == name);
        assert_eq!(outcome.tables["pressure_cdf"].column(name).is_some(), row.is_some(), "{name}");
        let Some(row) = row else {
            assert!(method["failure"].is_string() && method["mean_pa"].is_null(), "{name}");
            assert!(method["quantiles"].as_array().unwrap().is_empty(), "{name}");
            continue;
        };
        assert!(method["failure"].is_null(), "{name}");
        assert_eq!(table.column("work_in_fine_solves").unwrap()[row], work);
        // Intervals of models are corrected for their bias.
        let within = |value: &str, bias: &str, interval: &str| {
            let ends = [0, 1].map(|end| number(&method[interval][end]));
            let unbiased = number(&method[value]) - method[bias].as_f64().unwrap_or(0.0);
            assert!(ends[0] <= unbiased && unbiased <= ends[1], "{name}: {unbiased} in {ends:?}");
        };
        within("contact_probability", "contact_probability_bias", "contact_probability_interval");
        within("mean_pa", "mean_bias_pa", "mean_interval");
        let models = ["polynomial_chaos", "polynomial_chaos_log", "polynomial_chaos_local"];
        assert_eq!(method["mean_bias_pa"].is_number(), models.contains(&name), "{name}");
        assert!(method["interval_failure"].is_null(), "{name}");
        let quantile = &method["quantiles"][2];
        let ends = [0, 1].map(|end| number(&quantile["pressure_pa_interval"][end]));
        let own = number(&quantile["pressure_pa"]);
        assert!(models.contains(&name) || (ends[0] <= own && own <= ends[1]), "{name}: {own} in {ends:?}");
        assert!(ends[0] <= ends[1], "{name}: {ends:?}");
        let band = |what: &str| {
            let column = outcome.tables["pressure_bands"].column(&format!("{name}_{what}")).unwrap();
            column.iter().copied().filter(|v| v.is_finite()).collect::<Vec<f64>>()
        };
        let (cdf, bias, se) = (band("cdf"), band("cdf_bias"), band("cdf_se"));
        let wide = band("simultaneous_high");
        let factor = number(&method["simultaneous_band_factor"]);
        for (i, pointwise) in band("pointwise_high").into_iter().enumerate() {
            assert!(
                pointwise <= wide[i] && (cdf[i] - bias[i] + factor * se[i]).clamp(0.0, 1.0) == wide[i],
                "{name} {i}"
            );
        }
    }
    let scalars = pressure["scalars"].as_array().unwrap();
    let names: Vec<&str> = scalars.iter().map(|scalar| scalar["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["contact_fraction", "mean_pressure_pa", "mean_gap_m", "stiffness_pa_per_m"]);
    for scalar in scalars {
        let law = outcome.tables["pressure_scalar_distributions"].column(scalar["name"].as_str().unwrap()).unwrap();
        assert!(law.is_sorted(), "{scalar}");
        let [low, high] = [0, 1].map(|end| number(&scalar["mean_interval"][end]));
        assert!(low < number(&scalar["mean"]) && number(&scalar["mean"]) < high, "{scalar}");
    }
    // On a surface of mean zero under a plane at zero every cell has the same mean pressure, that of the patch.
    let [cell, patch] = [&pressure["mean_pa"], &scalars[1]["mean"]].map(number);
    let se = number(&pressure["mean_se_pa"]).hypot(number(&scalars[1]["mean_se"]));
    assert!((cell - patch).abs() < 4.0 * se, "{cell} {patch} ± {se}");
}

#[test]
#[ignore = "slow"]
fn maps_give_the_distributions_of_all_cells_and_indices_are_fractions() {
    let outcome = run_all(&reduced("pressure_case_c.toml", 100, 100));
    let results = serde_json::to_value(&outcome.results).unwrap();
    let pressure = &results["pressure"];
    let map = |name: &str, unit: &str| {
        let field = &outcome.fields[name];
        assert_eq!((field.values().dim(), field.unit()), ((64, 64), unit), "{name}");
        field.values()
    };
    // At the studied cell the maps equal the method that they are based on.
    let monte_carlo = method(&outcome, "monte_carlo");
    let quantiles = monte_carlo.quantiles.iter().map(|quantile| quantile.pressure_pa);
    let (contact, mean) = (map("contact_probability", "1"), map("pressure_mean", "Pa"));
    assert_eq!(Some(contact[[32, 32]]), monte_carlo.contact_probability);
    assert!((mean[[32, 32]] / monte_carlo.mean_pa.unwrap() - 1.0).abs() < 1e-9);
    let maps = ["pressure_quantile_10", "pressure_quantile_50", "pressure_quantile_90"].map(|name| map(name, "Pa"));
    for (map, quantile) in maps.into_iter().zip(quantiles) {
        assert!((map[[32, 32]] - quantile).abs() <= 1e-6 * quantile, "{} {quantile}", map[[32, 32]]);
    }
    assert!(map("expansion_error", "1").iter().all(|error| *error > 0.0));
    assert_eq!((&pressure["maps"]["samples"], &pressure["maps"]["kept_samples"]), (&100.into(), &100.into()));
    // A stationary surface on a periodic patch: the p-value for the fixed seed is not below one in a thousand.
    assert!(pressure["homogeneity"]["p_value"].as_f64().unwrap() > 1e-3, "{}", pressure["homogeneity"]);
    // The leading variables are all variables, so they explain part of every cell.
    let global = &pressure["global_expansion"];
    let (degree, error) = (global["degree"].as_u64().unwrap(), global["leave_one_out_error"].as_f64().unwrap());
    assert_eq!(global["coefficients"], (1..=degree).fold(1, |product, i| product * (8 + i) / i), "{global}");
    assert!(global["failure"].is_null() && error > 0.0 && error < 1.0, "{global}");
    let sensitivities = pressure["sensitivities"].as_array().unwrap();
    let of = |key: &str| sensitivities.iter().map(|entry| entry[key].as_str().unwrap()).collect::<Vec<_>>();
    let quantities = ["pressure_pa", "contact_fraction", "mean_pressure_pa"];
    assert_eq!(of("quantity"), quantities.iter().flat_map(|quantity| [*quantity; 2]).collect::<Vec<_>>());
    assert_eq!(of("variables"), ["local", "global"].repeat(3));
    let (table, mut row) = (&outcome.tables["pressure_sensitivities"], 0);
    for entry in sensitivities {
        let indices = entry["indices"].as_array().unwrap();
        assert_eq!(entry["failure"].is_null(), !indices.is_empty(), "{entry}");
        let mut sum = 0.0;
        for index in indices {
            let number = |key: &str| index[key].as_f64().unwrap();
            assert!(number("first_order") <= number("total") + 1e-12 && number("total") <= 1.0 + 1e-12, "{index}");
            assert_eq!(table.column("total").unwrap()[row], number("total"));
            assert!(table.names()[row].ends_with(index["name"].as_str().unwrap()));
            sum += number("first_order");
            row += 1;
        }
        assert!(sum <= 1.0 + 1e-9, "{entry}");
    }
    assert_eq!(table.names().len(), row);
}

#[test]
fn inconsistent_keys_are_errors_with_their_line() {
    let case_c = text("pressure_case_c.toml");
    for (from, to, wanted) in [
        ("boundary = \"periodic\"", "boundary = \"free\"", "only periodic patches have a constant Fourier mode"),
        ("marginal = \"normal\"", "marginal = \"beta:2,5\"", "requires marginal = \"normal\""),
        ("\"karhunen_loeve\"", "\"spectral\"", "requires generator = \"karhunen_loeve\""),
        ("points = [64, 64]", "points = [64, 32]\ncell = [40, 3]", "expected [row, column] below [32, 64]"),
        ("rescale = true", "rescal = true", "did you mean `rescale`?"),
    ] {
        assert!(case_c.contains(from), "{from}");
        let error = Study::parse(&case_c.replace(from, to), "case_c.toml").unwrap_err();
        assert!(error.message.contains(wanted) && error.line > 6, "{error}");
    }
}

#[test]
#[ignore = "slow"]
fn a_strongly_biased_method_gives_a_warning() {
    let study = StudyText::new(1, &["surface", "material", "pressure"])
        .with("surface", "covariance = \"squared_exponential\"\ngenerator = \"spectral\"")
        .with("pressure", METHODS)
        .with("pressure", "points = [24, 24]\nboundary = \"free\"\nfine_solves = 200\nreference_samples = 1000");
    let outcome = run_all(&study.to_string());
    let local = method(&outcome, "polynomial_chaos_local");
    let [low, _] = local.mean_interval.unwrap();
    // If the hidden part of the pressure leaves the sampled range, its expansion lies far below all other methods.
    assert!(local.mean_pa.unwrap() < 0.6 * low, "{local:?}");
    let is_biased = |warning: &&String| warning.contains("is biased");
    let warned: Vec<&String> = outcome.results.warnings.iter().filter(is_biased).collect();
    assert!(warned.len() == 1 && warned[0].contains("polynomial chaos local"), "{warned:?}");
}

#[test]
fn the_default_method_is_the_answer_and_has_the_same_numbers_beside_others() {
    let alone = StudyText::new(3, &["surface", "material", "pressure"])
        .with("surface", "covariance = \"squared_exponential\"\ngenerator = \"spectral\"")
        .with("pressure", "points = [16, 16]\nfine_solves = 40\nvariables = 2\ndegree = 1");
    let beside = alone.clone().with("pressure", METHODS).with("pressure", "reference_samples = 60");
    let [alone, beside] = [alone, beside].map(|study| run_all(&study.to_string()));
    let pressure = alone.results.pressure.as_ref().unwrap();
    let default = method(&alone, "default");
    assert_eq!((pressure.reference_samples, pressure.ks_resolution, pressure.methods.len()), (0, None, 1));
    assert_eq!(Some(pressure.contact_probability), default.contact_probability);
    assert_eq!((Some(pressure.mean_pa), &pressure.quantiles), (default.mean_pa, &default.quantiles));
    assert!(alone.tables["pressure_cdf"].column("reference").is_none());
    // The reference is another sample, and changes no method.
    let compared = method(&beside, "default");
    assert!(compared.ks_distance.is_some() && default.ks_distance.is_none());
    let without_distances = MethodEntry { ks_distance: None, wasserstein_1_over_std: None, ..compared.clone() };
    assert_eq!(*default, without_distances);
    assert_ne!(beside.results.pressure.as_ref().unwrap().contact_probability, pressure.contact_probability);
}
