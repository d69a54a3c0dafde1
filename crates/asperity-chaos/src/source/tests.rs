use std::path::Path;
use std::process::Command;

use super::*;
use crate::{Basis, MultiIndexSet};

/// The expansions that are written: mixed families, missing predecessors, zero coefficients; many variables; a constant.
fn examples() -> Vec<Expansion> {
    let mixed = vec![Family::Hermite, Family::Legendre, Family::Hermite, Family::Legendre];
    let complete = MultiIndexSet::total_degree(4, 5).unwrap();
    let list = MultiIndexSet::from_rows(4, [[0, 0, 0, 0], [2, 0, 0, 3], [0, 0, 1, 0]]).unwrap();
    let coefficient = |k: usize| if k % 4 == 3 { 0.0 } else { (k as f64 + 0.5).sin() * 1.1_f64.powi(-(k as i32)) };
    [
        Basis::new(complete, mixed.clone()).unwrap(),
        Basis::new(list, mixed).unwrap(),
        Basis::hermite(60, 2).unwrap(),
        Basis::hermite(1, 0).unwrap(),
    ]
    .into_iter()
    .map(|basis| {
        let coefficients = (0..basis.len()).map(coefficient).collect();
        Expansion::new(basis, coefficients)
    })
    .collect()
}

/// Whether a command of that name runs.
fn runs(command: &str, arguments: &[&str]) -> bool {
    Command::new(command).args(arguments).output().is_ok_and(|output| output.status.success())
}

/// The values a program prints, against those of the expansion at the germs of the test.
fn compare(expansion: &Expansion, command: &mut Command) {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed: Vec<f64> =
        String::from_utf8(output.stdout).unwrap().lines().map(|line| line.parse().unwrap()).collect();
    assert_eq!(printed.len(), TEST_POINTS);
    for (point, found) in printed.into_iter().enumerate() {
        let wanted = expansion.evaluate(&test_germ(expansion.basis().families(), point));
        assert!((found - wanted).abs() <= 1e-13 * wanted.abs(), "{found}, wanted {wanted}");
    }
}

fn compile(source: &Path, program: &Path) {
    let strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1"];
    let output = Command::new("cc").args(strict).arg("-DSURROGATE_TEST").arg(source).arg("-o").arg(program).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_c_function_has_the_values_of_the_expansion() {
    if !runs("cc", &["--version"]) {
        println!("skipped: there is no C compiler");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (number, expansion) in examples().iter().enumerate() {
        let (source, program) = (folder.path().join(format!("{number}.c")), folder.path().join(number.to_string()));
        std::fs::write(&source, expansion.c_source("surrogate").unwrap()).unwrap();
        compile(&source, &program);
        compare(expansion, &mut Command::new(&program));
    }
}

#[test]
fn the_c_program_notices_a_wrong_coefficient() {
    if !runs("cc", &["--version"]) {
        println!("skipped: there is no C compiler");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (source, program) = (folder.path().join("wrong.c"), folder.path().join("wrong"));
    let expansion = &examples()[1];
    let text = expansion.c_source("surrogate").unwrap();
    let coefficient = format!("coefficient[TERMS] = {{{:?}", expansion.coefficients()[0]);
    assert!(text.contains(&coefficient));
    std::fs::write(&source, text.replace(&coefficient, "coefficient[TERMS] = {7.5")).unwrap();
    compile(&source, &program);
    assert_eq!(Command::new(&program).output().unwrap().status.code(), Some(1));
}

#[test]
fn the_python_function_has_the_values_of_the_expansion() {
    if !runs("python3", &["-c", "import numpy"]) {
        println!("skipped: there is no Python with NumPy");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (number, expansion) in examples().iter().enumerate() {
        let source = folder.path().join(format!("surrogate_{number}.py"));
        std::fs::write(&source, expansion.python_source("surrogate").unwrap()).unwrap();
        compare(expansion, Command::new("python3").arg(&source));
    }
}

#[test]
fn the_heading_says_what_the_variables_are() {
    let text = examples()[0].c_source("pressure").unwrap();
    let heading = text.split("*/").next().unwrap();
    for line in
        ["pressure(xi)", "The 4 variables xi are independent", "standard normal", " *     0 2\n", " *     1 3\n"]
    {
        assert!(heading.contains(line), "{line} is not in {heading}");
    }
}

#[test]
fn names_that_no_function_can_have_are_refused() {
    let expansion = &examples()[3];
    for name in ["", "2d", "a-b", "for", "lambda", "main", "ü", "coefficient", "TERMS"] {
        assert_eq!(expansion.c_source(name), Err(SourceError::Name { name: name.to_owned() }));
        assert!(expansion.python_source(name).is_err());
    }
    let infinite = Expansion::new(Basis::hermite(1, 0).unwrap(), vec![f64::INFINITY]);
    assert!(matches!(infinite.c_source("f"), Err(SourceError::NotFinite { term: 0, .. })));
}
