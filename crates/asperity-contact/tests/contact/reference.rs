//! The contact solver against solutions of other packages, if available.
//!
//! Runs if the environment variable `ASPERITY_REFERENCE` names a folder that contains `contact/reference.json` with its
//! maps. Otherwise the test returns at once.

use std::path::Path;

use asperity_base::map::Grid;
use asperity_contact::{Boundary, ContactProblem, Control, HalfSpace, Solution, Solver};
use ndarray::Array2;
use serde_json::Value;

use crate::contact_check::{Operator, energy, evaluate};

fn map(folder: &Path, name: &Value) -> Array2<f64> {
    let bytes = std::fs::read(folder.join(name.as_str().unwrap())).unwrap();
    asperity_formats::read_bytes(&bytes).unwrap().heights_m
}

#[test]
fn the_solutions_of_other_packages_are_reproduced() {
    let Some(reference) = std::env::var_os("ASPERITY_REFERENCE") else {
        println!("skipped: ASPERITY_REFERENCE names no folder");
        return;
    };
    let folder = Path::new(&reference).join("contact");
    let text = std::fs::read_to_string(folder.join("reference.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let cases = reference["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 27);
    let mut fields = 0;
    for case in cases {
        fields += usize::from(compare(&folder, case));
    }
    assert_eq!(fields, 5);
}

/// Solves one case; returns whether a pressure field was compared.
fn compare(folder: &Path, case: &Value) -> bool {
    let number = |key: &str| case[key].as_f64().unwrap();
    let name = case["case"].as_str().unwrap();
    let heights = map(folder, &case["surface"]);
    let n = heights.nrows();
    let grid = Grid::with_size(n, n, number("L"), number("L")).unwrap();
    let boundary = match case["bc"].as_str().unwrap() {
        "free" => Boundary::Free,
        _ => Boundary::Periodic { mean_compliance_m_per_pa: 0.0 },
    };
    let half_space = HalfSpace::new(grid, number("Estar"), boundary).unwrap();
    let hardness = case["hardness"].as_f64();
    let control = Control::MeanPressure { pascal: number("mean_pressure") };
    let problem = ContactProblem::new(&half_space, &heights, control, hardness).unwrap();
    let tolerance = 1e-10;
    let solution = Solver { tolerance, max_iterations: 2000 }.solve(&problem).unwrap();
    assert!(solution.converged(), "{name}: {:?}", solution.residual());

    let operator = Operator::new(grid, number("Estar"), boundary);
    let found = evaluate(&operator, &problem, &solution);
    assert!(found.frank_wolfe <= 1.01 * tolerance && found.overlap <= 1.01 * tolerance, "{name}: {found:?}");
    assert!(found.prescribed <= tolerance, "{name}: {found:?}");

    // The references have an accuracy of 1e-10 of their quantities (at the hardness: 1e-11 in FW, 3e-7 of H in
    // pressure). Ours is the tolerance times rms height for a plane, and times its gradient E*/(2 dx) for a pressure.
    let rms = problem.rms_height_m();
    let cells = |fraction: f64| fraction * grid.points() as f64;
    let area_cells = cells(solution.contact_fraction() - number("area_fraction"));
    assert!(
        area_cells.abs() <= if hardness.is_some() { 1.001 } else { 1e-6 },
        "{name}: area off by {area_cells} cells"
    );
    assert!(
        (solution.separation_m() - number("separation_d") + problem.mean_height_m()).abs() <= 1e-8 * rms,
        "{name}: separation"
    );
    if let Some(mean_gap) = case["mean_gap"].as_f64() {
        assert!((solution.mean_gap_m() - mean_gap).abs() <= 1e-8 * rms, "{name}: mean gap");
        assert!((solution.max_pressure_pa() / number("max_pressure") - 1.0).abs() <= 1e-7, "{name}: max pressure");
    }
    if let Some(plastic) = case["plastic_fraction"].as_f64() {
        let plastic_cells = cells(solution.plastic_fraction() - plastic);
        assert!(plastic_cells.abs() <= 1.001, "{name}: plastic area off by {plastic_cells} cells");
    }
    // The reference counts heights from zero, here they count from their mean.
    let objective = found.energy - solution.mean_pressure_pa() * problem.mean_height_m();
    let wanted = number("objective");
    assert!((objective / wanted - 1.0).abs() <= 1e-9, "{name}: objective {objective} for {wanted}");
    if let Some(stored) = case["elastic_energy_density"].as_f64() {
        let p: Vec<f64> = solution.pressure_pa().iter().copied().collect();
        let elastic = energy(&p, &operator.displace(&p), &vec![0.0; p.len()], 0.0);
        assert!((elastic / stored - 1.0).abs() <= 1e-8, "{name}: elastic energy {elastic} for {stored}");
    }
    compare_fields(folder, case, &solution)
}

fn compare_fields(folder: &Path, case: &Value, solution: &Solution) -> bool {
    if case["pressure_field"].is_null() {
        return false;
    }
    let pressure = map(folder, &case["pressure_field"]);
    let largest = pressure.iter().copied().fold(0.0, f64::max);
    let difference =
        pressure.iter().zip(solution.pressure_pa()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
    assert!(difference <= 1e-6, "{}: pressure differs by {difference:e} of its maximum", case["case"]);
    true
}
