//! Validates the contact solver on random problems and writes the results as a page with a figure.
//!
//! `cargo run --release -p asperity-validation --bin validate_contact -- FOLDER`
//!
//! solves 1,000 random problems, checks each solution from its pressure alone, and tabulates how solutions depend on tolerance and grid
//! and how the residual falls. It writes `FOLDER/validation/contact.md` and `FOLDER/figures/contact_convergence.svg`; `just validate` runs
//! it for `docs`. With `--quick` instead of a folder, it solves 60 problems and writes nothing. It fails if any solution is wrong.

#![expect(clippy::print_stderr, reason = "prints progress")]

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use asperity::contact::{Boundary, Control, Solver};
use asperity_validation::contact::CheckedSolution;
use rayon::prelude::*;

mod figure;
mod tables;

type Result<T> = std::result::Result<T, Box<dyn Error>>;
/// Function that returns the group of a problem.
type Group<'a> = dyn Fn(&CheckedSolution) -> &'static str + 'a;

fn main() -> Result<()> {
    let argument = std::env::args().nth(1).ok_or("usage: validate_contact FOLDER, or --quick")?;
    if argument == "--quick" {
        solve(60)?;
        return Ok(());
    }
    let folder = PathBuf::from(argument);
    let checked = solve(1000)?;
    eprintln!("tolerance");
    let tolerances = tables::tolerances()?;
    eprintln!("grid");
    let grids = tables::grids()?;
    eprintln!("convergence");
    let histories = tables::histories()?;
    figure::write(&folder.join("figures/contact_convergence.svg"), &histories)?;
    write(
        &folder.join("validation/contact.md"),
        &[random_problems(&checked), tables::convergence(&histories), tolerances, grids],
    )
}

/// Solves `count` problems; fails if any solution is wrong.
fn solve(count: u64) -> Result<Vec<CheckedSolution>> {
    let solver = Solver::default();
    let done = AtomicU64::new(0);
    let solved: std::result::Result<Vec<CheckedSolution>, String> = (0..count)
        .into_par_iter()
        .map(|number| {
            let checked = CheckedSolution::new(number, solver).map_err(|error| format!("problem {number}: {error}"))?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if done.is_multiple_of(100) {
                eprintln!("{done} of {count} problems");
            }
            Ok(checked)
        })
        .collect();
    let solved = solved?;
    let failures: Vec<String> = solved.iter().filter_map(|checked| checked.failure(solver)).collect();
    for failure in &failures {
        eprintln!("{failure}");
    }
    if failures.is_empty() {
        Ok(solved)
    } else {
        Err(format!("{} of {count} solutions are wrong", failures.len()).into())
    }
}

fn write(file: &Path, sections: &[String]) -> Result<()> {
    let head = "# Validation of the contact solver

`just validate` writes this page. Counts of iterations may differ by a few on processors whose Fourier transforms round
differently; nothing else here depends on the machine. [The solver's theory](../contact-solver.md) explains the quantities.
";
    Ok(fs::write(file, format!("{head}\n{}", sections.join("\n")))?)
}

/// Returns the section on random problems.
fn random_problems(checked: &[CheckedSolution]) -> String {
    let worst = |part: &dyn Fn(&CheckedSolution) -> f64| checked.iter().map(part).fold(0.0, f64::max);
    let dense = checked.iter().filter(|c| c.from_dense.is_some()).count();
    let contacts = |range: std::ops::RangeInclusive<f64>| checked.iter().filter(|c| range.contains(&c.contact)).count();
    let mut text = format!(
        "## {} random problems

Nine kinds of surface on grids of 16 × 16 to 256 × 256 cells, also of odd and prime sides and eight times as long as wide, with
cells up to eight times as long as wide; free and periodic boundaries, five controls, with a hardness and without. Lengths, heights
and moduli are drawn over decades, contact from none to all of the cells: between 0.1 and 99 % in {} of the problems. Solves start cold
and end at the default tolerance of 1e-8.

Every solution is checked from its pressure p alone. Independent transforms (of twice the patch, with all of Love's coefficients, or of
the patch) give the displacement, and the residuals are evaluated by their definitions. On grids of up to 600 cells ({dense} problems) the
displacement is also summed directly over all pairs of cells.

- All {} converged, and in all of them 0 ≤ p ≤ H holds exactly.
- Largest residuals: Frank–Wolfe {:.1e}, overlap {:.1e}, prescribed quantity {:.1e}.
- Largest difference between a residual that the solver reports and the one evaluated here: {:.1e}.
- Largest difference from the direct sum, over the largest displacement: {:.1e}.
",
        checked.len(),
        contacts(0.001..=0.99),
        checked.len(),
        worst(&|c| c.found.frank_wolfe),
        worst(&|c| c.found.overlap),
        worst(&|c| c.found.load),
        worst(&CheckedSolution::difference),
        worst(&|c| c.from_dense.unwrap_or(0.0)),
    );
    let boundary = |c: &CheckedSolution| match (c.problem.half_space.boundary(), c.yields) {
        (Boundary::Free, false) => "free, elastic",
        (Boundary::Free, true) => "free, elasto-plastic",
        (Boundary::Periodic { .. }, false) => "periodic, elastic",
        (Boundary::Periodic { .. }, true) => "periodic, elasto-plastic",
    };
    let control = |c: &CheckedSolution| match c.control {
        Control::MeanPressure { .. } => "mean pressure",
        Control::Load { .. } => "load",
        Control::Penetration { .. } | Control::Plane { .. } => "penetration",
        Control::Percentile { .. } => "percentile",
        Control::MeanGap { .. } if boundary(c) == "periodic, elastic" => "mean gap, plane known",
        Control::MeanGap { .. } => "mean gap, plane sought",
    };
    let contact = |c: &CheckedSolution| match 100.0 * c.contact {
        0.0 => "none",
        x if x < 1.0 => "below 1 %",
        x if x < 10.0 => "1 … 10 %",
        x if x < 50.0 => "10 … 50 %",
        x if x < 90.0 => "50 … 90 %",
        x if x < 100.0 => "90 … 100 %",
        _ => "all",
    };
    let plastic = |c: &CheckedSolution| match 100.0 * c.plastic {
        _ if !c.yields => "elastic",
        0.0 => "hardness not reached",
        x if x < 10.0 => "below 10 %",
        x if x < 50.0 => "10 … 50 %",
        x if x < 90.0 => "50 … 90 %",
        _ => "90 … 100 %",
    };
    let cells = |c: &CheckedSolution| match c.problem.half_space.grid().points() {
        n if n <= 1024 => "up to 1,024",
        n if n <= 8192 => "up to 8,192",
        n if n <= 20_000 => "up to 20,000",
        _ => "up to 65,536",
    };
    let (sought, others): (Vec<&CheckedSolution>, Vec<&CheckedSolution>) =
        checked.iter().partition(|c| control(c) == "mean gap, plane sought");
    text += &grouped(checked.iter(), "control", &control);
    text += &format!(
        "\nIf the solver has to search for the plane of a mean gap, the iterations under all planes are added up. The following tables leave out
these {} problems.\n",
        sought.len()
    );
    let tables: [(&str, &Group<'_>); 5] = [
        ("boundary", &boundary),
        ("surface", &|c| c.problem.kind.name()),
        ("cells in contact", &contact),
        ("at the hardness, of these", &plastic),
        ("cells", &cells),
    ];
    for (title, group) in tables {
        text += &grouped(others.iter().copied(), title, group);
    }
    text
}

/// Order of the groups in tables. Groups that are not listed come first, by name.
const ORDER: [&str; 16] = [
    "none",
    "below 1 %",
    "1 … 10 %",
    "elastic",
    "hardness not reached",
    "below 10 %",
    "10 … 50 %",
    "50 … 90 %",
    "90 … 100 %",
    "all",
    "up to 1,024",
    "up to 8,192",
    "up to 20,000",
    "up to 65,536",
    "mean gap, plane known",
    "mean gap, plane sought",
];

/// Returns a table of iterations and residuals by group.
fn grouped<'a>(checked: impl Iterator<Item = &'a CheckedSolution>, title: &str, group: &Group<'_>) -> String {
    let place = |name: &str| ORDER.iter().position(|other| *other == name);
    let mut groups: BTreeMap<(Option<usize>, &str), Vec<&CheckedSolution>> = BTreeMap::new();
    for one in checked {
        groups.entry((place(group(one)), group(one))).or_default().push(one);
    }
    let mut text = format!(
        "\n| {title} | problems | iterations: median | 90 % | most | Frank–Wolfe | overlap | prescribed |\n|---|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    for ((_, name), members) in groups {
        let mut iterations: Vec<usize> = members.iter().map(|c| c.iterations).collect();
        iterations.sort_unstable();
        let quantile = |probability: f64| iterations[(probability * (iterations.len() - 1) as f64).round() as usize];
        let worst = |part: fn(&CheckedSolution) -> f64| members.iter().map(|c| part(c)).fold(0.0, f64::max);
        text += &format!(
            "| {name} | {} | {} | {} | {} | {} | {} | {} |\n",
            members.len(),
            quantile(0.5),
            quantile(0.9),
            quantile(1.0),
            tables::short(worst(|c| c.found.frank_wolfe)),
            tables::short(worst(|c| c.found.overlap)),
            tables::short(worst(|c| c.found.load)),
        );
    }
    text
}
