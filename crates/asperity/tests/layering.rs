//! The architecture as a test: which module may use which, and who may touch files, generators and transforms.
//!
//! Every source file of the library is read as tokens (comments and literals dropped), every path that leads back into
//! the crate is resolved (`crate::`, chains of `super::`, groups, globs, inline paths), and compared with [`ALLOWED`].
//! Unit tests obey the same table, with the exceptions of [`ALLOWED_IN_TESTS`]: a test that needs two stages belongs into
//! this folder. Examples inside documentation are comments here, so they are free to show the whole chain. Files,
//! environment and clock are forbidden outside tests.

#![expect(clippy::unwrap_used, reason = "a test that cannot read the sources has failed")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Modules of the first layer, each of which may use those before it.
const BASE: &[&str] = &["wide", "monitor", "quantity", "map", "random", "fourier", "stats", "law", "correlation"];

/// Further modules and the paths they may use beside [`BASE`]. `"a::b"` allows module b of a, `"a"` all of it.
const ALLOWED: &[(&str, &[&str])] = &[
    ("surface", &[]),
    ("contact", &[]),
    ("chaos", &[]),
    ("pressure", &["surface", "contact", "chaos"]),
    ("friction", &["surface", "contact"]),
    ("vibration", &["friction::process"]),
    ("study", &["surface", "contact", "chaos", "pressure", "friction", "vibration"]),
];

/// Paths that unit tests alone may use. Estimators of a correlation are tried on fields of known correlation.
const ALLOWED_IN_TESTS: &[(&str, &[&str])] = &[("correlation", &["surface"])];

/// Names that belong to one module: the crate, type or function, and its owner.
const OWNED: &[(&str, &str)] = &[
    ("rand_chacha", "random"),
    ("ChaCha8Rng", "random"),
    ("ChaCha12Rng", "random"),
    ("ChaCha20Rng", "random"),
    ("SeedableRng", "random"),
    ("from_seed", "random"),
    ("seed_from_u64", "random"),
    ("StdRng", "random"),
    ("SmallRng", "random"),
    ("rustfft", "fourier"),
    ("realfft", "fourier"),
    ("pulp", "wide"),
];

/// Parts of the standard library that are out of bounds outside tests, and the modules that may use them all the same:
/// only `study` writes files, and names those in the making after its process.
const RESTRICTED: &[(&str, &[&str])] =
    &[("fs", &["study"]), ("env", &[]), ("time", &[]), ("process", &["study"]), ("net", &[]), ("thread", &[])];

/// A word or a symbol of Rust source.
#[derive(Debug, Clone, PartialEq)]
struct Token {
    text: String,
    line: usize,
}

/// Splits source into identifiers, `::` and single symbols; comments, literals and lifetimes are dropped.
fn tokens(source: &str) -> Vec<Token> {
    let bytes: Vec<char> = source.chars().collect();
    let at = |i: usize| bytes.get(i).copied().unwrap_or('\0');
    let (mut found, mut i, mut line) = (Vec::new(), 0, 1);
    while i < bytes.len() {
        let start = i;
        match at(i) {
            '/' if at(i + 1) == '/' => {
                while i < bytes.len() && at(i) != '\n' {
                    i += 1;
                }
            }
            '/' if at(i + 1) == '*' => {
                let mut depth = 0;
                loop {
                    match (at(i), at(i + 1)) {
                        ('/', '*') => (depth, i) = (depth + 1, i + 2),
                        ('*', '/') => (depth, i) = (depth - 1, i + 2),
                        _ => i += 1,
                    }
                    if depth == 0 || i >= bytes.len() {
                        break;
                    }
                }
            }
            '"' => i = end_of_string(&bytes, i),
            // 'a' is a character, 'a a lifetime.
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => {
                i += if at(i + 1) == '\\' { 3 } else { 2 };
                while i < bytes.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
            }
            '\'' => {
                i += 1;
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
            }
            c if c.is_alphanumeric() || c == '_' => {
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
                let word: String = bytes[start..i].iter().collect();
                if matches!(word.as_str(), "r" | "br" | "cr") && raw_hashes(&bytes, i).is_some() {
                    i = end_of_raw_string(&bytes, i);
                } else if word == "r" && at(i) == '#' {
                    i += 1; // a raw identifier: the name itself is the next word
                } else {
                    found.push(Token { text: word, line });
                }
            }
            ':' if at(i + 1) == ':' => {
                i += 2;
                found.push(Token { text: "::".into(), line });
            }
            c => {
                i += 1;
                if !c.is_whitespace() {
                    found.push(Token { text: c.into(), line });
                }
            }
        }
        line += bytes[start..i.min(bytes.len())].iter().filter(|c| **c == '\n').count();
    }
    found
}

fn end_of_string(source: &[char], open: usize) -> usize {
    let mut i = open + 1;
    while i < source.len() && source[i] != '"' {
        i += if source[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// Number of `#` before the quote, if a raw string opens here.
fn raw_hashes(source: &[char], i: usize) -> Option<usize> {
    let hashes = source[i..].iter().take_while(|c| **c == '#').count();
    (source.get(i + hashes) == Some(&'"')).then_some(hashes)
}

fn end_of_raw_string(source: &[char], i: usize) -> usize {
    let hashes = raw_hashes(source, i).unwrap_or(0);
    let mut end = i + hashes + 1;
    while end < source.len() {
        if source[end] == '"' && source[end + 1..].iter().take(hashes).filter(|c| **c == '#').count() == hashes {
            return end + 1 + hashes;
        }
        end += 1;
    }
    end
}

/// One path found in a file: its segments from the root (`crate` or an outer crate), its line, whether test code holds it.
#[derive(Debug, Clone, PartialEq)]
struct Reference {
    path: Vec<String>,
    line: usize,
    in_test: bool,
}

/// All paths of a file that lie in module `home` (empty for the crate root), and all single words.
fn references(source: &str, home: &[String]) -> Vec<Reference> {
    let tokens = tokens(source);
    let word = |i: usize| tokens.get(i).map_or("", |t| t.text.as_str());
    let mut found = Vec::new();
    let mut modules: Vec<(String, usize, bool)> = Vec::new(); // inline modules: name, brace depth, test
    let (mut depth, mut test_attribute, mut i) = (0_usize, false, 0);
    while i < tokens.len() {
        let in_test = modules.iter().any(|m| m.2);
        match word(i) {
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                modules.retain(|m| m.1 <= depth);
            }
            "#" if word(i + 1) == "[" && word(i + 2) == "cfg" && word(i + 4) == "test" => test_attribute = true,
            "mod" if word(i + 2) == "{" => {
                modules.push((word(i + 1).into(), depth + 1, test_attribute));
                test_attribute = false;
            }
            "fn" | "struct" | "enum" | "impl" | "use" | ";" => test_attribute = false,
            _ => {}
        }
        let starts_path = i == 0 || word(i - 1) != "::";
        let is_word = word(i).starts_with(|c: char| c.is_alphabetic() || c == '_');
        if is_word && starts_path {
            let mut here = home.to_vec();
            here.extend(modules.iter().map(|m| m.0.clone()));
            let mut paths = Vec::new();
            expand(&tokens, i, &mut Vec::new(), &mut paths);
            for path in paths {
                found.push(Reference { path: resolve(path, &here), line: tokens[i].line, in_test });
            }
        }
        i += 1;
    }
    found
}

/// Expands the path (or the tree of a `use`) that starts at token `i`; returns the index after it.
fn expand(tokens: &[Token], mut i: usize, prefix: &mut Vec<String>, paths: &mut Vec<Vec<String>>) -> usize {
    let word = |i: usize| tokens.get(i).map_or("", |t| t.text.as_str());
    let base = prefix.len();
    loop {
        if word(i) == "{" {
            i += 1;
            while i < tokens.len() && word(i) != "}" {
                if word(i) == "," {
                    i += 1;
                } else {
                    let before = i;
                    i = expand(tokens, i, prefix, paths);
                    if word(i) == "as" {
                        i += 2;
                    }
                    i = i.max(before + 1);
                }
            }
            i += 1;
            break;
        }
        prefix.push(word(i).into());
        i += 1;
        if word(i) != "::" || word(i + 1) == "<" {
            paths.push(prefix.clone());
            break;
        }
        i += 1;
    }
    prefix.truncate(base);
    i
}

/// Replaces a leading `crate`, `self` or chain of `super` by the module it names: `["crate", "contact", …]`.
fn resolve(path: Vec<String>, here: &[String]) -> Vec<String> {
    let mut absolute = vec!["crate".to_owned()];
    let rest = match path[0].as_str() {
        "crate" => 1,
        "self" => {
            absolute.extend_from_slice(here);
            1
        }
        "super" => {
            let ups = path.iter().take_while(|p| *p == "super").count();
            absolute.extend_from_slice(&here[..here.len().saturating_sub(ups)]);
            ups
        }
        _ => return path,
    };
    absolute.extend(path[rest..].iter().filter(|p| *p != "self").cloned());
    absolute
}

/// What the file of module `home` does that the tables forbid.
fn violations(source: &str, home: &[String]) -> Vec<String> {
    let Some(stage) = home.first() else {
        return Vec::new(); // lib.rs declares the modules
    };
    let mut allowed: Vec<&str> = match BASE.iter().position(|b| b == stage) {
        Some(rank) => BASE[..rank].to_vec(),
        None => BASE.to_vec(),
    };
    if let Some((_, more)) = ALLOWED.iter().find(|(name, _)| name == stage) {
        allowed.extend_from_slice(more);
    } else if !BASE.contains(&stage.as_str()) {
        return vec![format!("module `{stage}` is in no layer: add it to the table")];
    }
    let in_tests: &[&str] = ALLOWED_IN_TESTS.iter().find(|(name, _)| name == stage).map_or(&[], |(_, more)| more);
    let is_test_file = home.iter().any(|part| part == "tests");
    let mut found = BTreeSet::new();
    for Reference { path, line, in_test } in references(source, home) {
        let text = path.join("::");
        let at = format!("{}:{line}", home.join("::"));
        if path[0] == "crate" {
            let target = path.get(1).map_or("*", String::as_str);
            let inside = path[1..].join("::");
            let also = if in_test || is_test_file { in_tests } else { &[] };
            let free = target == stage
                || allowed.iter().chain(also).any(|a| inside == *a || inside.starts_with(&format!("{a}::")));
            if path.len() < 2 || target == "*" {
                // A bare `crate` is `pub(crate)`, or the whole crate under another name.
                if target == "*" && path.len() == 2 {
                    found.insert(format!("{at}: `{text}` opens the whole crate"));
                }
            } else if !free {
                found.insert(format!("{at}: `{text}`, but `{stage}` may use only: {}", allowed.join(", ")));
            }
        }
        if matches!(path[0].as_str(), "std" | "core") && path.len() > 1 && !in_test && !is_test_file {
            for (part, owners) in RESTRICTED {
                if (path[1] == *part || path[1] == "*") && !owners.contains(&stage.as_str()) {
                    found.insert(format!("{at}: `{text}`, but std::{part} is not for `{stage}`"));
                }
            }
        }
        for (name, owner) in OWNED {
            if path.iter().any(|p| p == name) && owner != stage {
                found.insert(format!("{at}: `{text}`, but only `{owner}` may name `{name}`"));
            }
        }
    }
    found.into_iter().collect()
}

fn source_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(source_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// `contact/solver.rs` → ["contact", "solver"]; `lib.rs` → [].
fn module_of(relative: &Path) -> Vec<String> {
    let mut parts: Vec<String> =
        relative.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|last| last == "mod" || last == "lib") {
        parts.pop();
    }
    parts
}

fn manifest(name: &str) -> toml::Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("Cargo.toml");
    fs::read_to_string(path).unwrap().parse().unwrap()
}

fn dependencies(name: &str) -> BTreeSet<String> {
    let manifest = manifest(name);
    ["dependencies", "dev-dependencies", "build-dependencies"]
        .iter()
        .filter_map(|kind| manifest.get(*kind)?.as_table())
        .flat_map(|table| table.keys().cloned())
        .collect()
}

#[test]
fn every_module_uses_only_the_layers_below_it() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = source_files(&source);
    assert!(files.len() > 10, "only {} source files were found", files.len());
    let found: Vec<String> = files
        .iter()
        .flat_map(|file| {
            let home = module_of(file.strip_prefix(&source).unwrap());
            violations(&fs::read_to_string(file).unwrap(), &home)
        })
        .collect();
    assert!(found.is_empty(), "the layering is broken:\n{}", found.join("\n"));
}

#[test]
fn every_module_of_the_table_exists() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for name in BASE.iter().chain(ALLOWED.iter().map(|(name, _)| name)) {
        assert!(source.join(format!("{name}.rs")).exists(), "{name} is in the table but not in src");
    }
}

#[test]
fn the_formats_know_no_other_crate_of_the_project() {
    let found: Vec<String> =
        dependencies("asperity-formats").into_iter().filter(|d| d.starts_with("asperity")).collect();
    assert!(found.is_empty(), "asperity-formats depends on {found:?}");
}

#[test]
fn the_library_has_no_terminal_no_page_and_no_interpreter() {
    let front_end =
        ["clap", "indicatif", "ctrlc", "signal-hook", "minijinja", "plotters", "pyo3", "tracing-subscriber"];
    let found: Vec<String> = dependencies("asperity").into_iter().filter(|d| front_end.contains(&d.as_str())).collect();
    assert!(found.is_empty(), "asperity depends on {found:?}");
    let inner: Vec<String> = dependencies("asperity").into_iter().filter(|d| d.starts_with("asperity")).collect();
    assert_eq!(inner, ["asperity-formats"]);
}

fn home(path: &str) -> Vec<String> {
    path.split("::").map(str::to_owned).collect()
}

#[test]
fn the_scanner_finds_every_way_to_name_a_forbidden_module() {
    for (module, source) in [
        ("contact", "use crate::surface::Field;"),
        ("contact", "use crate::{map::Grid, chaos::{self, Basis}};"),
        ("contact::solver", "fn f() -> f64 { let x = 1; crate::friction::mean(x) }"),
        ("contact", "use super::surface;"),
        ("contact::solver", "use super::super::surface::Field;"),
        ("contact::solver", "mod inner { use super::super::super::vibration; }"),
        ("contact", "pub use crate::study::run as go;"),
        ("contact", "use crate::*;"),
        ("contact", "use super::*;"),
        ("contact", "impl crate::surface::RandomSurface for X {}"),
        ("contact", "#[cfg(test)] mod tests { use crate::surface::Field; }"),
        ("contact", "macro_rules! m { () => { $crate::friction::f() } }"),
        ("contact", "let s = \"//\"; use crate::friction::f;"),
        ("contact", "let c = '\"'; use crate::friction::f; let d = '\"';"),
        ("contact", "let c = r#\"\"\"#; use crate::friction::f;"),
        ("vibration", "use crate::friction::window::W;"),
        ("vibration", "use crate::friction::{self, process};"),
        ("vibration", "use crate::friction::*;"),
        ("map", "use crate::fourier::Plan;"),
        ("correlation", "use crate::surface::SpectralField;"),
        ("correlation", "#[cfg(test)] mod tests { use crate::contact::Problem; }"),
        ("random", "use crate::law::Marginal;"),
        ("surface", "use crate::contact::Problem;"),
        ("friction", "use crate::pressure::Law;"),
        ("novelty", "use crate::map::Grid;"),
        ("contact", "use rustfft::FftPlanner;"),
        ("surface", "use rand_chacha::ChaCha8Rng;"),
        ("surface", "use rand::{Rng, SeedableRng};"),
        ("surface", "let rng = Generator::seed_from_u64(1);"),
        ("surface", "use std::fs;"),
        ("surface", "use std::{fmt, fs::File};"),
        ("surface", "fn f() { std::env::var(\"X\"); }"),
        ("study", "use std::time::Instant;"),
        ("study::provenance", "use std::env;"),
    ] {
        assert!(!violations(source, &home(module)).is_empty(), "not found in `{module}`: {source}");
    }
}

#[test]
fn the_scanner_leaves_allowed_uses_alone() {
    for (module, source) in [
        ("contact", "use crate::{map::Grid, fourier::{self, Plan}};"),
        ("contact::solver", "use super::{Problem, Solution}; pub(crate) fn f() {} pub(super) fn g() {}"),
        ("contact::solver", "use crate::contact::half_space; use self::inner::f;"),
        (
            "contact",
            "/// See [`crate::friction`].\n// use crate::friction::f;\n/* crate::study /* nested */ */ fn f() {}",
        ),
        ("contact", "const S: &str = \"crate::friction::f\"; const R: &str = r#\"use crate::study;\"#;"),
        ("contact", "#[cfg(test)] mod tests { use super::*; use std::env; use std::fs; }"),
        ("contact", "fn f<'a>(x: &'a str) -> char { 'x' }"),
        ("contact", "mod inner { use super::Problem; }"),
        ("pressure", "use crate::{surface, contact::Solution, chaos::hermite};"),
        ("vibration", "use crate::friction::process::Record;"),
        ("correlation", "#[cfg(test)] mod tests { use crate::surface::SpectralField; }"),
        ("fourier", "use rustfft::FftPlanner;"),
        ("random", "use rand::SeedableRng; use rand_chacha::ChaCha12Rng;"),
        ("study::store", "use std::fs; use crate::vibration::Ensemble;"),
        ("stats", "use crate::random::Stream; use std::f64::consts::TAU;"),
    ] {
        assert_eq!(violations(source, &home(module)), Vec::<String>::new(), "in `{module}`: {source}");
    }
}

#[test]
fn a_use_after_the_test_module_is_not_a_test() {
    let source = "#[cfg(test)] mod tests { fn f() { if true { } } } fn g() { std::fs::read(\"x\"); }";
    assert_eq!(violations(source, &home("contact")).len(), 1);
}
