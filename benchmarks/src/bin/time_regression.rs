//! Times polynomial-chaos regressions, and prints JSON. It can write the results to a file for an independent check.
//!
//! `cargo run --release -p asperity-benchmarks --bin time_regression -- CASE key=value …`; all files contain little-endian doubles, row by
//! row. A basis has total degree `degree` in `variables` variables, the first `hermite` of them (default all) standard normal
//! and the others uniform on [−1, 1].
//!
//! | case | keys | timed work |
//! |---|---|---|
//! | `solve` | basis, `points`, `samples`, `responses`, `count` | design matrix, factorisation, all responses |
//! | `fit` | the same | the same, with leave-one-out errors |
//! | `evaluate` | basis, `points`, `samples`, `coefficients` | values of the expansion at all points |
//! | `select` | basis and `points`, or `matrix` and `columns`; `samples`, `response`, `folds`, `max_terms` | design matrix and selection |
//!
//! | key | default | meaning |
//! |---|---|---|
//! | `repeats`, `warm_up` | 5, 1 | timed runs, and runs before them that are not timed |
//! | `threads` | 1 | of the pool |
//! | `output` | | file for coefficients (`[coefficients, responses]`) or values |
#![expect(clippy::print_stdout, reason = "prints times")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use asperity::chaos::{Basis, Candidates, Expansion, LeastSquares, MultiIndexSet, PolynomialFamily, SparseRegression};
use asperity_benchmarks::Words;
use ndarray::Array2;
use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Returns the basis of total degree.
fn basis_of(words: &mut Words) -> Result<Basis> {
    let variables: usize = words.wanted("variables")?;
    let hermite: usize = words.or("hermite", variables)?;
    let families = (0..variables)
        .map(|i| if i < hermite { PolynomialFamily::Hermite } else { PolynomialFamily::Legendre })
        .collect();
    Ok(Basis::new(MultiIndexSet::total_degree(variables, words.wanted("degree")?)?, families)?)
}

/// Reads the points.
fn points_of(words: &mut Words, samples: usize, basis: &Basis) -> Result<Vec<Vec<f64>>> {
    let variables = basis.set().variables();
    let values = read(&words.wanted::<PathBuf>("points")?, samples * variables)?;
    Ok(values.chunks(variables).map(<[f64]>::to_vec).collect())
}

/// Numbers of runs, and the thread pool.
struct Runs {
    repeats: usize,
    warm_up: usize,
    pool: rayon::ThreadPool,
}

impl Runs {
    /// Returns the seconds of each timed run and the result of the last.
    fn time<T: Send>(&self, run: impl Fn() -> Result<T> + Sync) -> Result<(Vec<f64>, T)> {
        let mut seconds = Vec::new();
        let mut last = None;
        for number in 0..self.warm_up + self.repeats.max(1) {
            // Free the memory of the last result first.
            drop(last.take());
            let start = Instant::now();
            let result = self.pool.install(|| run().map_err(|error| error.to_string()))?;
            if number >= self.warm_up {
                seconds.push(start.elapsed().as_secs_f64());
            }
            last = Some(result);
        }
        Ok((seconds, last.ok_or("nothing was run")?))
    }
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let case = arguments.next().ok_or("usage: time_regression CASE key=value …")?;
    let mut words = Words::parse(arguments)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(words.or("threads", 1)?).build()?;
    let runs = Runs { repeats: words.or("repeats", 5)?, warm_up: words.or("warm_up", 1)?, pool };
    let output: Option<PathBuf> = words.optional("output")?;
    let (mut answer, values) = match case.as_str() {
        "solve" => solve(words, &runs, false)?,
        "fit" => solve(words, &runs, true)?,
        "evaluate" => evaluate(words, &runs)?,
        "select" => select(words, &runs)?,
        other => return Err(format!("{other} is not a case").into()),
    };
    if let Some(path) = output {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        std::fs::write(path, bytes)?;
    }
    answer["memory_bytes"] = peak_memory_bytes().into();
    println!("{answer}");
    Ok(())
}

fn solve(mut words: Words, runs: &Runs, assess: bool) -> Result<(Value, Vec<f64>)> {
    let basis = basis_of(&mut words)?;
    let samples: usize = words.wanted("samples")?;
    let points = points_of(&mut words, samples, &basis)?;
    let count: usize = words.wanted("count")?;
    let responses = read(&words.wanted::<PathBuf>("responses")?, samples * count)?;
    let responses = Array2::from_shape_vec((samples, count), responses)?;
    words.finish()?;
    let (seconds, (coefficients, condition, parts)) = runs.time(|| {
        let start = Instant::now();
        let design = basis.design_matrix(&points);
        let design_s = start.elapsed().as_secs_f64();
        let least_squares = LeastSquares::new(design)?;
        let factorised_s = start.elapsed().as_secs_f64();
        let coefficients = if assess {
            least_squares.fit_many(responses.view())?.coefficients
        } else {
            least_squares.solve_many(responses.view())?
        };
        let solve_s = start.elapsed().as_secs_f64() - factorised_s;
        Ok((coefficients, least_squares.condition(), [design_s, factorised_s - design_s, solve_s]))
    })?;
    let [design_s, factor_s, solve_s] = parts;
    let answer = json!({
        "seconds": seconds, "design_s": design_s, "factor_s": factor_s, "solve_s": solve_s, "condition": condition,
    });
    Ok((answer, coefficients.into_iter().collect()))
}

fn evaluate(mut words: Words, runs: &Runs) -> Result<(Value, Vec<f64>)> {
    let basis = basis_of(&mut words)?;
    let samples: usize = words.wanted("samples")?;
    let points = points_of(&mut words, samples, &basis)?;
    let coefficients = read(&words.wanted::<PathBuf>("coefficients")?, basis.len())?;
    words.finish()?;
    let expansion = Expansion::new(basis, coefficients);
    let (seconds, values) = runs.time(|| Ok(expansion.evaluate_many(&points)))?;
    Ok((json!({ "seconds": seconds }), values))
}

fn select(mut words: Words, runs: &Runs) -> Result<(Value, Vec<f64>)> {
    let samples: usize = words.wanted("samples")?;
    let response = read(&words.wanted::<PathBuf>("response")?, samples)?;
    let default = SparseRegression::default();
    let regression =
        SparseRegression { folds: words.or("folds", default.folds)?, max_terms: words.optional("max_terms")? };
    let fit_of = |design: &Array2<f64>| Ok(regression.select(&Candidates::new(design.view())?, &response)?);
    let (seconds, fit, columns) = if let Some(path) = words.optional::<PathBuf>("matrix")? {
        let columns: usize = words.wanted("columns")?;
        let matrix = Array2::from_shape_vec((samples, columns), read(&path, samples * columns)?)?;
        words.finish()?;
        let (seconds, fit) = runs.time(|| fit_of(&matrix))?;
        (seconds, fit, columns)
    } else {
        let basis = basis_of(&mut words)?;
        let points = points_of(&mut words, samples, &basis)?;
        words.finish()?;
        let (seconds, fit) = runs.time(|| fit_of(&basis.design_matrix(&points)))?;
        (seconds, fit, basis.len())
    };
    let answer = json!({
        "seconds": seconds,
        "terms": fit.terms.len(),
        "tried": fit.path.len(),
        "leave_one_out": fit.leave_one_out.relative_error,
        "cross_validated": fit.cross_validated,
        "condition": fit.condition,
    });
    Ok((answer, fit.dense(columns)))
}

/// Returns the peak resident memory of the process, or `None` if the system does not report it.
fn peak_memory_bytes() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok().map(|kibibytes| 1024 * kibibytes)
}

fn read(path: &Path, count: usize) -> Result<Vec<f64>> {
    let bytes = std::fs::read(path)?;
    let (values, rest) = bytes.as_chunks::<8>();
    if values.len() != count || !rest.is_empty() {
        return Err(format!("{} has {} bytes, expected {count} doubles", path.display(), bytes.len()).into());
    }
    Ok(values.iter().map(|value| f64::from_le_bytes(*value)).collect())
}
