//! Times contact solves, and prints JSON. It can write the pressures to a file for an independent check.
//!
//! `cargo run --release -p asperity-benchmarks --bin time_contact -- HEIGHTS key=value …` with
//!
//! | key | default | meaning |
//! |---|---|---|
//! | `points` | | cells along either side of the square map |
//! | `maps` | 1 | maps in the file, solved one after the other, or in parallel with several threads |
//! | `size`, `modulus` | 1, 1 | side of the map in metre, contact modulus E* in pascal |
//! | `boundary` | `periodic` | or `free` |
//! | `mean_pressure` or `penetration` | | in pascal or metre |
//! | `hardness` | | in pascal; elastic when left out |
//! | `tolerance` | 1e-6 | of the solver |
//! | `repeats`, `warm_up` | 5, 1 | timed solves of all maps, and solves before them that are not timed |
//! | `threads` | 1 | of the pool |
//! | `fresh` | false | whether each solve creates kernel, memory and all fields, as a single call from Python does; one thread |
//! | `transforms` | true | whether transforms and applications of the compliance are timed too |
//! | `pressure` | | file for the pressures |
//!
//! HEIGHTS contains `maps` × `points` × `points` little-endian doubles in metre; the file of pressures has the same layout, in pascal.
//! The plans of transforms and the kernel are made once and not timed. The allocation of a solution is timed.
#![expect(clippy::print_stdout, reason = "prints times")]

use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use asperity::contact::{Boundary, ContactProblem, Control, HalfSpace, Solution, Solver};
use asperity::fourier::{RealFft2, good_length};
use asperity::map::Grid;
use asperity_benchmarks::Words;
use ndarray::Array2;
use rayon::prelude::*;
use serde_json::json;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Duration for which transforms are repeated.
const TRANSFORMS_S: f64 = 0.2;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let file: PathBuf = arguments.next().ok_or("usage: time_contact HEIGHTS points=N key=value …")?.into();
    let mut words = Words::parse(arguments)?;
    let points: usize = words.optional("points")?.ok_or("points=N is missing")?;
    let maps: usize = words.or("maps", 1)?;
    let (size_m, modulus_pa): (f64, f64) = (words.or("size", 1.0)?, words.or("modulus", 1.0)?);
    let boundary = match words.or("boundary", "periodic".to_owned())?.as_str() {
        "free" => Boundary::Free,
        "periodic" => Boundary::Periodic { mean_compliance_m_per_pa: size_m / (std::f64::consts::PI * modulus_pa) },
        other => return Err(format!("boundary={other} is neither periodic nor free").into()),
    };
    let control = match (words.optional("mean_pressure")?, words.optional("penetration")?) {
        (Some(pascal), None) => Control::MeanPressure { pascal },
        (None, Some(metre)) => Control::Penetration { metre },
        _ => return Err("one of mean_pressure and penetration is needed".into()),
    };
    let hardness_pa: Option<f64> = words.optional("hardness")?;
    let solver = Solver { tolerance: words.or("tolerance", 1e-6)?, ..Solver::default() };
    let (repeats, warm_up): (usize, usize) = (words.or("repeats", 5)?, words.or("warm_up", 1)?);
    let threads: usize = words.or("threads", 1)?;
    let fresh: bool = words.or("fresh", false)?;
    let transforms: bool = words.or("transforms", true)?;
    let pressure: Option<PathBuf> = words.optional("pressure")?;
    words.finish()?;

    let heights = read(&file, maps, points)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let grid = Grid::with_size(points, points, size_m, size_m)?;
    let start = Instant::now();
    let half_space = pool.install(|| HalfSpace::new(grid, modulus_pa, boundary))?;
    let setup_s = start.elapsed().as_secs_f64();
    let problems = heights
        .iter()
        .map(|heights_m| ContactProblem::new(&half_space, heights_m, control, hardness_pa))
        .collect::<std::result::Result<Vec<_>, _>>()?;
    // Workspaces are reused between solves, as in the peers. Every thread has its own.
    let workspaces: Vec<_> = (0..threads.min(maps)).map(|_| Mutex::new(half_space.workspace())).collect();
    let chunk = maps.div_ceil(workspaces.len().max(1));
    let solve = || {
        let parts = problems.par_chunks(chunk).zip(&workspaces);
        let solved = parts.map(|(problems, workspace)| {
            let mut workspace = workspace.lock().unwrap_or_else(PoisonError::into_inner);
            problems.iter().map(|problem| solver.solve_with(problem, &mut workspace)).collect()
        });
        let solved: std::result::Result<Vec<Vec<Solution>>, _> = solved.collect();
        solved.map(|solutions| solutions.into_iter().flatten().collect::<Vec<_>>())
    };
    let solve_afresh = || -> Result<Vec<Solution>> {
        let one = |heights_m: &Array2<f64>| -> Result<Solution> {
            let half_space = HalfSpace::new(grid, modulus_pa, boundary)?;
            let problem = ContactProblem::new(&half_space, heights_m, control, hardness_pa)?;
            let found = solver.solve_with(&problem, &mut half_space.workspace())?;
            black_box((found.gap_m(), found.plastic_displacement_m(), found.corrected_contact_fraction()));
            Ok(found)
        };
        heights.iter().map(one).collect()
    };
    let mut solutions = Vec::new();
    let mut seconds = Vec::new();
    for run in 0..warm_up + repeats {
        // Free the memory of the last solutions first.
        solutions.clear();
        let start = Instant::now();
        solutions = if fresh { solve_afresh()? } else { pool.install(solve)? };
        if run >= warm_up {
            seconds.push(start.elapsed().as_secs_f64());
        }
    }
    let transform_s = transforms.then(|| pool.install(|| transform_s(points, boundary)));
    let application_s = transforms.then(|| pool.install(|| application_s(&half_space, points)));
    if let Some(path) = pressure {
        write(&path, &solutions)?;
    }
    let worst = |part: fn(&Solution) -> f64| solutions.iter().map(part).fold(0.0, f64::max);
    let fractions = |part: fn(&Solution) -> f64| solutions.iter().map(part).sum::<f64>() / maps as f64;
    let answer = json!({
        "seconds": seconds,
        "setup_s": setup_s,
        "iterations": solutions.iter().map(Solution::iterations).collect::<Vec<_>>(),
        "stop_reasons": solutions.iter().map(|solution| format!("{:?}", solution.stop_reason())).collect::<Vec<_>>(),
        "frank_wolfe": worst(|solution| solution.residual().frank_wolfe),
        "overlap": worst(|solution| solution.residual().overlap),
        "load": worst(|solution| solution.residual().load),
        "contact_fraction": fractions(Solution::contact_fraction),
        "plastic_fraction": fractions(Solution::plastic_fraction),
        "transform_pair_s": transform_s,
        "application_s": application_s,
    });
    println!("{answer}");
    Ok(())
}

/// Reads maps of `points` × `points` little-endian doubles.
fn read(file: &Path, maps: usize, points: usize) -> Result<Vec<Array2<f64>>> {
    let bytes = std::fs::read(file)?;
    let wanted = maps * points * points * size_of::<f64>();
    if bytes.len() != wanted {
        return Err(format!("{} has {} bytes instead of {wanted}", file.display(), bytes.len()).into());
    }
    let (values, _) = bytes.as_chunks();
    let map = |chunk: &[[u8; 8]]| {
        Array2::from_shape_vec((points, points), chunk.iter().map(|b| f64::from_le_bytes(*b)).collect())
    };
    Ok(values.chunks(points * points).map(map).collect::<std::result::Result<_, _>>()?)
}

fn write(file: &Path, solutions: &[Solution]) -> Result<()> {
    let mut out = std::io::BufWriter::new(std::fs::File::create(file)?);
    for value in solutions.iter().flat_map(Solution::pressure_pa) {
        std::io::Write::write_all(&mut out, &value.to_le_bytes())?;
    }
    Ok(std::io::Write::flush(&mut out)?)
}

/// Returns the median time of a forward and an inverse transform of a map, which is padded with zeros on the free boundary.
fn transform_s(points: usize, boundary: Boundary) -> f64 {
    let length = if boundary == Boundary::Free { good_length(2 * points - 1) } else { points };
    let fft = RealFft2::new(length, length);
    let (mut map, mut spectrum, mut work) = (vec![1.0; points * points], fft.spectrum(), fft.workspace());
    median_s(|| {
        fft.forward_padded(&map, points, points, &mut spectrum, &mut work);
        fft.inverse_cropped(&mut spectrum, &mut map, points, points, &mut work);
    })
}

/// Returns the median time of a displacement from a pressure.
fn application_s(half_space: &HalfSpace, points: usize) -> f64 {
    let (pressure, mut displacement) = (vec![1.0; points * points], vec![0.0; points * points]);
    let mut workspace = half_space.workspace();
    median_s(|| half_space.displace(&pressure, &mut displacement, &mut workspace))
}

fn median_s(mut work: impl FnMut()) -> f64 {
    work();
    let (begin, mut seconds) = (Instant::now(), Vec::new());
    while seconds.len() < 3 || begin.elapsed().as_secs_f64() < TRANSFORMS_S {
        let start = Instant::now();
        work();
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
