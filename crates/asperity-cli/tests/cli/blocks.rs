//! Tests of stored blocks: interrupted runs go on, parts make the whole, and damage is found.

use std::fs;
use std::path::{Path, PathBuf};
#[cfg(target_os = "linux")]
use std::process::{Command, Stdio};
use std::sync::LazyLock;
#[cfg(target_os = "linux")]
use std::time::Duration;

use asperity_testing::{METHODS, StudyText};

use crate::support::{BLOCKS, folder_with_study, listing, run_in};
#[cfg(target_os = "linux")]
use crate::support::{Finished, run_and_signal, whole_listing};

/// All stages but the verdict, in two seconds.
static STUDY: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(5, &["surface", "material", "pressure", "friction", "vibration"])
        .with("pressure", METHODS)
        .with("pressure", "fine_solves = 120\nreference_samples = 250\nvariables = 4\ndegree = 2")
        .with("friction", "percentiles = [50.0]")
        .with("vibration", "damping_ratio = 0.4\nstribeck = 4.2\ndamping_sweep = [0.3, 0.5, 3]")
        .with("vibration", "trajectories = 16\nduration = 20.0")
        .to_string()
});

/// Returns the study without friction and vibration, which takes half a second.
fn short() -> &'static str {
    STUDY.split("[friction]").next().unwrap()
}

/// Returns the files of a run that equal studies give equal bytes.
fn results(run: &Path) -> Vec<(String, Vec<u8>)> {
    let names = |folder: &str| -> Vec<String> {
        listing(&run.join(folder)).into_iter().map(|name| format!("{folder}/{name}")).collect()
    };
    let names = names("tables").into_iter().chain(names("fields")).chain(["results.json".to_owned()]);
    names.map(|name| (name.clone(), fs::read(run.join(&name)).unwrap())).collect()
}

/// Asserts that a run has the results of another, and names the first file that differs.
fn assert_same(run: &Path, wanted: &[(String, Vec<u8>)], case: &str) {
    let found = results(run);
    assert_eq!(found.len(), wanted.len(), "{case}");
    for ((name, found), (_, wanted)) in found.iter().zip(wanted) {
        assert!(found == wanted, "{case}: {name} differs");
    }
}

/// Returns the files of blocks in a folder of blocks.
fn block_files(folder: &Path) -> Vec<PathBuf> {
    let stages = listing(folder).into_iter().map(|name| folder.join(name)).filter(|path| path.is_dir());
    stages.flat_map(|stage| listing(&stage).into_iter().map(move |name| stage.join(name))).collect()
}

/// Returns the results of the study, computed in one piece without interruption.
fn whole(at: &Path) -> Vec<(String, Vec<u8>)> {
    let found = run_in(at, "run study.toml --out whole/run");
    assert_eq!(found.code, 0, "{found:?}");
    results(&at.join("whole/run"))
}

#[test]
#[ignore = "slow"]
fn parts_make_the_whole() {
    let folder = folder_with_study(STUDY.split("[vibration]").next().unwrap());
    let at = folder.path();
    let wanted = whole(at);
    for (number, threads) in [(1, 1), (2, 3)] {
        let line = format!("run study.toml --shard {number}/2 --out parts/{number} --threads {threads} --json");
        let part = run_in(at, &line).json(0);
        assert_eq!((part["complete"].as_bool(), part["part"].as_u64()), (Some(false), Some(number)));
        let rounds = part["rounds"].as_array().unwrap();
        // Pressure and friction need nothing of each other.
        for task in ["pressure/reference", "pressure/sobol", "friction"] {
            let round = rounds.iter().find(|round| round["task"] == task).unwrap();
            let (expected, missing) = (round["expected"].as_u64().unwrap(), round["missing"].as_u64().unwrap());
            assert_eq!(missing, expected / 2, "{round}");
        }
    }
    let status = run_in(at, "status parts/2 --json").json(0);
    assert_eq!((status["part"].as_u64(), status["parts"].as_u64()), (Some(2), Some(2)));
    assert_eq!(status["complete"], false);
    let rounds = status["rounds"].as_array().unwrap();
    let reference = rounds.iter().find(|round| round["task"] == "pressure/reference").unwrap();
    assert_eq!((reference["done"].as_u64(), reference["missing"].as_u64()), (Some(125), Some(125)));
    // The parts do not hold the rounds that follow.
    run_in(at, "merge parts/1 parts/2 --out parts/all").refuses(3, &["blocks are missing", "--finish"]);
    assert!(!at.join("parts/all").exists());
    // Beside the merged blocks, the parts compute what follows.
    let mut merged = 3;
    for _ in 0..500 {
        for number in [1, 2] {
            assert_eq!(run_in(at, &format!("run study.toml --shard {number}/2 --out parts/{number}")).code, 0);
        }
        merged = run_in(at, "merge parts/1 parts/2 --out parts/all").code;
        if merged != 3 {
            break;
        }
    }
    assert_eq!(merged, 0);
    assert_same(&at.join("parts/all"), &wanted, "parts, round by round");
}

#[test]
#[ignore = "slow"]
fn a_changed_stage_leaves_the_blocks_of_the_others() {
    // At the median plane friction fluctuates, and the vibration stage has trajectories.
    let study = STUDY.replace("stribeck = 4.2", "stribeck = 4.2\nlevel = 50.0");
    let folder = folder_with_study(&study);
    let at = folder.path();
    whole(at);
    let stages = || listing(&at.join("whole").join(BLOCKS)).into_iter().filter(|name| name != "run.json");
    let before: Vec<String> = stages().collect();
    let changed = study.replace("trajectories = 16", "trajectories = 24");
    fs::write(at.join("study.toml"), &changed).unwrap();
    assert_eq!(run_in(at, "run study.toml --out whole/run --force").code, 0);
    let after: Vec<String> = stages().collect();
    // Pressure and friction are the same; the blocks of the earlier vibration and verdict went with their run.
    let same = after.iter().filter(|stage| before.contains(stage)).count();
    assert_eq!((before.len(), after.len(), same), (4, 4, 2));
    // Without pressure there is nothing to keep of it, unless another run uses it.
    assert_eq!(run_in(at, "run study.toml --out whole/other").code, 0);
    fs::write(at.join("study.toml"), changed.replace("fine_solves = 120", "fine_solves = 132")).unwrap();
    assert_eq!(run_in(at, "run study.toml --out whole/run --force").code, 0);
    assert_eq!(
        listing(&at.join("whole").join(BLOCKS)).len(),
        4 + 1 + 3,
        "{:?}",
        listing(&at.join("whole").join(BLOCKS))
    );
}

#[test]
#[ignore = "slow"]
fn a_finished_run_is_resumed_reproduced_and_never_mixed_with_another() {
    let folder = folder_with_study(short());
    let at = folder.path();
    whole(at);
    // No folder, the finished run, another study.
    assert_eq!(run_in(at, "run study.toml --out whole/new --resume").code, 0);
    assert_eq!(run_in(at, "run study.toml --out whole/run --resume").code, 0);
    assert_eq!(run_in(at, "run study.toml --out whole/run").code, 2);
    run_in(at, "run study.toml --out whole/run --resume --seed 6").refuses(2, &["another study"]);
    assert_eq!(run_in(at, "repro whole/run").stdout, "IDENTICAL\n");
    let table = at.join("whole/run/tables/pressure_cdf.csv");
    let text = fs::read_to_string(&table).unwrap();
    fs::write(&table, text.replacen("0.", "1.", 1)).unwrap();
    let found = run_in(at, "repro whole/run");
    assert!(found.code == 1 && found.stdout.starts_with("tables/pressure_cdf.csv:"), "{found:?}");
    let results = at.join("whole/run/results.json");
    let text = fs::read_to_string(&results).unwrap();
    fs::write(&results, text.replacen("\"seed\": 5", "\"seed\": 6", 1)).unwrap();
    assert_eq!(run_in(at, "repro whole/run").stdout, "results.json: seed 6 before, 5 now\n");
    fs::remove_file(&table).unwrap();
    fs::write(&results, text).unwrap();
    run_in(at, "repro whole/run").refuses(3, &["pressure_cdf.csv: no such file"]);
}

#[test]
fn parts_of_another_study_or_program_are_not_merged() {
    let folder = folder_with_study(&STUDY);
    let at = folder.path();
    for (number, seed) in [(1, 5), (2, 6)] {
        let line = format!("run study.toml --only friction --shard {number}/2 --out parts/{number} --seed {seed}");
        assert_eq!(run_in(at, &line).code, 0);
    }
    run_in(at, "merge parts/1 parts/2 --out all").refuses(2, &["parts/2 is of another study"]);
    let record = at.join("parts/1").join(BLOCKS).join("1.json");
    let text = fs::read_to_string(&record).unwrap();
    for (key, words) in [("sha256", "another program"), ("functions", "another mathematical library")] {
        let begin = text.find(&format!("\"{key}\": \"")).unwrap() + key.len() + 5;
        let digit = if &text[begin..=begin] == "0" { "1" } else { "0" };
        fs::write(&record, format!("{}{digit}{}", &text[..begin], &text[begin + 1..])).unwrap();
        run_in(at, "merge parts/1 --out all --finish").refuses(2, &[words]);
    }
    fs::write(&record, &text).unwrap();
    assert_eq!(run_in(at, "merge parts/1 --out all --finish").code, 0);
    run_in(at, "merge parts/3 --out other").refuses(3, &["parts/3: no blocks"]);
    let wrong =
        [("--shard 3/2", "part"), ("--shard 0/2", "part"), ("--max-memory 4", "size"), ("--max-time 4", "unit")];
    for (flags, words) in wrong {
        run_in(at, &format!("run study.toml --out new {flags}")).refuses(2, &[words]);
    }
    run_in(at, "run study.toml --out new --max-memory 1kB").refuses(5, &["needs about", "more than 1 kB"]);
    assert!(!at.join("new").exists());
}

#[test]
#[ignore = "slow"]
fn damaged_blocks_are_computed_again() {
    let folder = folder_with_study(&STUDY);
    let at = folder.path();
    let wanted = whole(at);
    let files = block_files(&at.join("whole").join(BLOCKS));
    assert!(files.len() >= 2);
    let intact: Vec<Vec<u8>> = files.iter().map(|file| fs::read(file).unwrap()).collect();
    for case in 0..12 {
        for (place, (file, bytes)) in files.iter().zip(&intact).enumerate() {
            let mut damaged = bytes.clone();
            // Another byte each time, from the first to the last; or the end is missing.
            let byte = (bytes.len() - 1) * case / 11;
            if (case + place) % 3 == 0 {
                damaged.truncate(byte);
            } else {
                damaged[byte] ^= 1 << (place % 8);
            }
            fs::write(file, damaged).unwrap();
        }
        let found = run_in(at, "run study.toml --out whole/run --force");
        assert_eq!(found.code, 0, "{found:?}");
        assert_same(&at.join("whole/run"), &wanted, &format!("damage {case}"));
    }
}

#[test]
#[ignore = "slow"]
fn failed_samples_are_listed_and_computed_again_and_too_many_are_refused() {
    // About a tenth of the solutions do not reach a residual below the resolution of a double.
    let strict = short().replace("percentile = 50.0", "percentile = 50.0\ntolerance = 1e-16");
    let strict = strict.replace("reference_samples = 250", "reference_samples = 400");
    let folder = folder_with_study(&format!("valid_share = 0.7\n{strict}"));
    let at = folder.path();
    let found = run_in(at, "run study.toml --out runs/strict");
    let words = "samples failed; `asperity status runs/strict` lists them";
    assert!(found.code == 0 && found.stderr.contains(words), "{found:?}");
    let stored = fs::read_to_string(at.join("runs/strict/results.json")).unwrap();
    assert!(stored.contains("of 400 contact solutions of the reference failed ("), "{stored}");
    let status = run_in(at, "status runs/strict --json").json(0);
    let rounds = status["rounds"].as_array().unwrap();
    let count = |key: &str| -> u64 { rounds.iter().map(|round| round[key].as_u64().unwrap()).sum() };
    let failures = status["failures"].as_array().unwrap();
    assert_eq!((count("done"), count("missing"), count("failed")), (count("expected"), 0, failures.len() as u64));
    assert!(failures.len() > 20, "{}", failures.len());
    for failure in failures.iter().step_by(failures.len() / 6) {
        let (sample, reason) = (failure["sample"].as_str().unwrap(), failure["reason"].as_str().unwrap());
        assert_eq!((failure["seed"].as_u64(), failure["stage"].as_str()), (Some(5), Some("pressure")));
        assert!(reason.contains("no convergence") || reason.contains("coarser grid"), "{reason}");
        let again = run_in(at, &format!("repro runs/strict --sample {sample}"));
        assert_eq!((again.code, again.stdout), (0, format!("{reason}\nIDENTICAL\n")), "{sample}");
    }
    let valid = (0..400).map(|index| format!("pressure/reference:{index}"));
    let valid = valid.into_iter().find(|sample| failures.iter().all(|failure| failure["sample"] != *sample)).unwrap();
    assert_eq!(run_in(at, &format!("repro runs/strict --sample {valid}")).stdout, "IDENTICAL\n");
    run_in(at, "repro runs/strict --sample pressure/reference:4000").refuses(2, &["indices 0 to 399"]);
    run_in(at, "repro runs/strict --sample pressure").refuses(2, &["TASK:INDEX"]);
    // The default share of valid samples is 95 %; the samples of the refused run are listed, too.
    fs::write(at.join("study.toml"), strict).unwrap();
    assert_eq!(run_in(at, "run study.toml --out runs/refused --json").json(4)["converged"], false);
    let status = run_in(at, "status runs/refused --json").json(0);
    assert!(status["failures"].as_array().unwrap().len() > 20 && status["complete"] == false);
    fs::write(at.join("study.toml"), format!("valid_share = 1.2\n{}", *STUDY)).unwrap();
    run_in(at, "run study.toml --out runs/none").refuses(2, &["study.toml:1: valid_share", "at most 1"]);
}

/// Compiles the library of faults; `None` without a compiler.
#[cfg(target_os = "linux")]
fn faults(at: &Path) -> Option<PathBuf> {
    let (source, library) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/faults.c"), at.join("faults.so"));
    let mut compiler = Command::new("cc");
    let done = compiler.args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library).arg(source).arg("-ldl").status();
    done.is_ok_and(|status| status.success()).then_some(library)
}

/// Runs the study, or a part of it, into `place/run` with faults at calls on files of `place` whose path contains `part`.
#[cfg(target_os = "linux")]
fn faulty(
    at: &Path,
    library: &Path,
    (place, part): (&str, &str),
    call: &str,
    [first, every, error]: [usize; 3],
) -> Finished {
    let shard: &[&str] = if place.starts_with("part-") { &["--shard", "1/2"] } else { &[] };
    Command::new(env!("CARGO_BIN_EXE_asperity"))
        .args(["run", "study.toml", "--out", &format!("{place}/run")])
        .args(shard)
        .current_dir(at)
        .env("LD_PRELOAD", library)
        .env("FAULT_CALL", call)
        .env("FAULT_PATH", part)
        .env("FAULT_AT", first.to_string())
        .env("FAULT_EVERY", every.to_string())
        .env("FAULT_ERROR", error.to_string())
        .stdin(Stdio::null())
        .output()
        .unwrap()
        .into()
}

/// Kills runs at each `step`-th write, sync and rename of files whose path contains `part`, and finishes them; false without a C
/// compiler.
#[cfg(target_os = "linux")]
fn killed_runs_go_on(part: &str, step: usize) -> bool {
    let folder = folder_with_study(short());
    let at = folder.path();
    let Some(library) = faults(at) else { return false };
    let wanted = whole(at);
    for call in ["write", "fsync", "rename"] {
        for first in (1..).step_by(step) {
            let place = format!("{call}-{first}");
            let killed = faulty(at, &library, (&place, part), call, [first, 0, 0]);
            let finished = run_in(at, &format!("run study.toml --out {place}/run --resume"));
            assert_eq!(finished.code, 0, "{place}: {finished:?}");
            assert_same(&at.join(&place).join("run"), &wanted, &place);
            assert_eq!(whole_listing(&at.join(&place)), [BLOCKS, "run"], "{place}");
            fs::remove_dir_all(at.join(&place)).unwrap();
            if killed.code == 0 {
                assert!(first > 3 || step > 1, "{call}: too few calls");
                break;
            }
            assert_eq!(killed.code, -1, "{killed:?}");
        }
    }
    true
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow"]
fn a_run_killed_at_any_write_sync_or_rename_of_its_blocks_goes_on_with_the_same_results() {
    if !killed_runs_go_on(BLOCKS, 1) {
        println!("skipped: no C compiler");
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow"]
fn a_run_killed_while_it_writes_its_folder_goes_on_with_the_same_results() {
    if !killed_runs_go_on("run.partial", 17) {
        println!("skipped: no C compiler");
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow"]
fn a_failing_disk_ends_a_run_with_one_message_and_keeps_the_finished_blocks() {
    const ERRORS: [(usize, &str); 2] = [(28, "the disk is full"), (5, "Input/output error")];
    const CALLS: [(&str, usize); 7] =
        [("write", 1), ("write", 2), ("write", 3), ("write", 7), ("write", 40), ("fsync", 2), ("rename", 3)];
    let folder = folder_with_study(short());
    let at = folder.path();
    let Some(library) = faults(at) else { return println!("skipped: no C compiler") };
    let wanted = whole(at);
    for (error, words) in ERRORS {
        for (call, every) in CALLS {
            let place = format!("{call}-{every}-{error}");
            let found = faulty(at, &library, (&place, &format!("{place}/")), call, [every, every, error]);
            assert!(found.code == 5 && found.stdout.is_empty(), "{place}: {found:?}");
            let errors: Vec<&str> = found.stderr.lines().filter(|line| line.starts_with("error")).collect();
            let is_clear = errors.len() == 1 && errors[0].contains("cannot write") && errors[0].contains(words);
            assert!(is_clear, "{place}: {found:?}");
            assert!(!at.join(&place).join("run").exists(), "{place}");
            // A part does not take its own loss for blocks of other parts.
            let part = faulty(at, &library, (&format!("part-{place}"), "part-"), call, [1, every, error]);
            assert_eq!(part.code, 5, "{place}: {part:?}");
            let finished = run_in(at, &format!("run study.toml --out {place}/run --resume"));
            assert_eq!(finished.code, 0, "{place}: {finished:?}");
            assert_same(&at.join(&place).join("run"), &wanted, &place);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow"]
fn a_signal_or_the_time_limit_ends_a_run_soon_and_keeps_its_blocks() {
    let folder = folder_with_study(&STUDY);
    let at = folder.path();
    let long = STUDY.replace("reference_samples = 250", "reference_samples = 40000");
    fs::write(at.join("study.toml"), long.replace("points = [16, 16]", "points = [128, 128]")).unwrap();
    for signal in ["-INT", "-TERM"] {
        let (found, time) = run_and_signal(at, "run study.toml --out runs/long", signal);
        assert!(found.code == 130 && time < Duration::from_secs(2), "{time:?}: {found:?}");
        assert!(found.stderr.contains("cancelled; the same command goes on from the finished blocks"), "{found:?}");
        assert_eq!(whole_listing(&at.join("runs")), [BLOCKS]);
        assert!(!block_files(&at.join("runs").join(BLOCKS)).is_empty());
    }
    let done = |status: &serde_json::Value| status["rounds"][0]["done"].as_u64().unwrap();
    let before = done(&run_in(at, "status runs/long --json").json(0));
    run_in(at, "run study.toml --out runs/long --max-time 2s").refuses(5, &["stopped after 2 s", "goes on"]);
    let after = done(&run_in(at, "status runs/long --json").json(0));
    assert!(before > 0 && after > before, "{before} {after}");
}
