//! Tests of output folders: foreign files are never lost, and no partial folder remains.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::support::{Finished, MANIFEST, listing, run_in, written};
#[cfg(target_os = "linux")]
use crate::support::{run_and_signal, send, start, start_in, wait_for, wait_until};

const STUDY: &str = "seed = 5\n[surface]\ncovariance = \"exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                     correlation_length = \"20 um\"\n";
const SPECIFICATION: &str = crate::outputs::SPECIFICATION;
const PROCESS: &str = r#"{
  "format": "asperity friction process", "version": 1, "mean": 0.2, "std": 0.01,
  "marginal": {"beta": {"a": 2.1, "b": 5.0, "low": 0.18, "high": 0.24}},
  "correlation": {"model": "exponential", "length_m": 250e-6}
}"#;
const VIBRATION: &str = "--static-friction 0.1 --stribeck 4.2 --belt-velocity 0.003 --damping-ratio 0.17";
const NOISE: &str = "--friction-std 0.001 --correlation-length 0.01 --marginal beta:2.1,5 --seed 3";
const INPUTS: [&str; 5] = ["map.x3p", "process.json", "record.csv", "spec.toml", "study.toml"];

/// A folder with a study, a specification, a map and a friction record.
fn bench() -> TempDir {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fs::write(at.join("study.toml"), STUDY).unwrap();
    fs::write(at.join("spec.toml"), SPECIFICATION).unwrap();
    fs::write(at.join("process.json"), PROCESS).unwrap();
    for line in [
        "surface generate spec.toml --out map.x3p",
        "friction simulate process.json --length 50mm --step 50um --seed 3 --out record.csv",
    ] {
        assert_eq!(run_in(at, line).code, 0);
    }
    assert_eq!(listing(at), INPUTS);
    folder
}

/// Every command that writes a folder, without the name of the folder.
fn commands() -> [String; 6] {
    [
        "run study.toml --out".to_owned(),
        "surface generate spec.toml --count 2 --out".to_owned(),
        "surface fill map.x3p --seed 1 --count 2 --out".to_owned(),
        "surface twin map.x3p --count 1 --translation plain --covariance exponential --out".to_owned(),
        "friction fit record.csv --column mu --distance-column position --report".to_owned(),
        format!("vibration ensemble {VIBRATION} {NOISE} --trajectories 3 --duration 5 --report"),
    ]
}

#[test]
fn force_never_removes_a_file_that_asperity_did_not_write() {
    let folder = bench();
    let at = folder.path();
    let thesis = |folder: &str| at.join(folder).join("thesis.txt");
    for line in commands() {
        fs::create_dir(at.join("mine")).unwrap();
        fs::write(thesis("mine"), "years of work").unwrap();
        run_in(at, &format!("{line} mine")).refuses(2, &["mine", "not empty"]);
        run_in(at, &format!("{line} mine --force")).refuses(2, &["mine", "asperity did not write it"]);
        // The same file in a folder that asperity wrote.
        assert_eq!(run_in(at, &format!("{line} own")).code, 0, "{line}");
        fs::rename(thesis("mine"), thesis("own")).unwrap();
        run_in(at, &format!("{line} own --force")).refuses(2, &["own", "thesis.txt"]);
        assert_eq!(fs::read_to_string(thesis("own")).unwrap(), "years of work");
        fs::remove_file(thesis("own")).unwrap();
        // Without that file the folder is replaced.
        let before = fs::read(at.join("own").join(MANIFEST)).unwrap();
        fs::remove_file(at.join("own").join(&written(&at.join("own"))[0])).ok();
        assert_eq!(run_in(at, &format!("{line} own --force")).code, 0, "{line}");
        let after = fs::read(at.join("own").join(MANIFEST)).unwrap();
        assert_eq!(before.iter().filter(|b| **b == b'\n').count(), after.iter().filter(|b| **b == b'\n').count());
        fs::remove_dir_all(at.join("own")).unwrap();
        fs::remove_dir_all(at.join("mine")).unwrap();
        assert_eq!(listing(at), INPUTS, "{line}");
    }
}

#[test]
fn force_on_the_folder_of_all_runs_keeps_every_run() {
    let folder = bench();
    let at = folder.path();
    assert_eq!(run_in(at, "run study.toml --out runs/one").code, 0);
    assert_eq!(run_in(at, "run study.toml --out runs/two").code, 0);
    // Nobody typed `--out` for the folder of the study.
    assert_eq!(run_in(at, "run study.toml").code, 0);
    let there =
        "error: runs/study is not empty: a run is already there; `--force` replaces it, `--out DIR` writes elsewhere";
    run_in(at, "run study.toml").refuses(2, &[there]);
    run_in(at, "run study.toml --out runs --force").refuses(2, &["--out runs", "asperity did not write it"]);
    run_in(at, "run study.toml --out spec.toml/a").refuses(2, &["--out", "spec.toml/a", "give a folder"]);
    run_in(at, &format!("run study.toml --out {}", "n".repeat(256))).refuses(2, &["--out", "too long"]);
    run_in(at, "run study.toml --out . --force").refuses(2, &["--out .", "study.toml"]);
    #[cfg(unix)]
    {
        let _listener = std::os::unix::net::UnixListener::bind(at.join("socket")).unwrap();
        run_in(at, "run study.toml --out socket --force").refuses(2, &["--out socket", "give a folder"]);
    }
    run_in(at, "run runs/one/study.toml --out runs/one --force").refuses(2, &["runs/one", "input"]);
    assert!(at.join("runs/one/COMPLETE").is_file() && at.join("runs/two/COMPLETE").is_file());
    // A run folder inside a run folder is not part of it.
    assert_eq!(run_in(at, "run study.toml --out runs/one/more").code, 0);
    run_in(at, "run study.toml --out runs/one --force").refuses(2, &["runs/one", "more/"]);
    assert!(at.join("runs/one/more/COMPLETE").is_file());
}

#[test]
fn a_resumed_run_is_as_asperity_wrote_it() {
    let folder = bench();
    let at = folder.path();
    let resume = || run_in(at, "run study.toml --out out --resume");
    assert_eq!((resume().code, resume().code), (0, 0));
    let results = fs::read_to_string(at.join("out/results.json")).unwrap();
    fs::write(at.join("out/results.json"), results.replace("\"seed\": 5", "\"seed\": 6")).unwrap();
    fs::remove_file(at.join("out/report.html")).unwrap();
    let wanted = ["out is not as asperity wrote it: report.html (missing), results.json (changed);"];
    let found = resume();
    found.refuses(3, &wanted);
    assert_eq!(found.stdout, "");
    fs::write(at.join("out/results.json"), results).unwrap();
    resume().refuses(3, &["report.html (missing);"]);
    // The report is made again, and files of the user do not matter.
    assert_eq!(run_in(at, "report out").code, 0);
    fs::write(at.join("out/notes.txt"), "").unwrap();
    assert_eq!(resume().code, 0);
    fs::remove_file(at.join("out").join(MANIFEST)).unwrap();
    resume().refuses(3, &[MANIFEST]);
}

#[test]
fn temporary_files_of_a_killed_report_do_not_keep_a_run_from_being_replaced() {
    let folder = bench();
    let at = folder.path();
    assert_eq!(run_in(at, "run study.toml --out out").code, 0);
    for place in ["", "fields/"] {
        let name = format!("out/{place}.asperity-{}.tmp", asperity_formats::temporary_suffix());
        fs::write(at.join(name), "half").unwrap();
    }
    assert_eq!(run_in(at, "run study.toml --out out --force").code, 0);
}

#[cfg(unix)]
#[test]
fn a_write_protected_run_is_not_replaced() {
    use std::os::unix::fs::PermissionsExt;
    let folder = bench();
    let at = folder.path();
    assert_eq!(run_in(at, "run study.toml --out out").code, 0);
    for place in ["out", "out/fields"] {
        let change = |mode| fs::set_permissions(at.join(place), fs::Permissions::from_mode(mode)).unwrap();
        change(0o555);
        run_in(at, "run study.toml --out out --force").refuses(5, &["cannot write", place, "permission denied"]);
        change(0o755);
    }
    // Nothing was moved aside.
    assert!(listing(at).len() == INPUTS.len() + 1 && at.join("out/COMPLETE").is_file());
}

#[cfg(unix)]
#[test]
fn blocks_that_cannot_be_stored_end_a_run_before_its_work() {
    let folder = bench();
    let at = folder.path();
    let blocks = at.join(".asperity-blocks");
    fs::write(&blocks, "").unwrap();
    run_in(at, "run study.toml --out out").refuses(5, &["cannot write", ".asperity-blocks"]);
    fs::remove_file(&blocks).unwrap();
    std::os::unix::fs::symlink("nowhere", &blocks).unwrap();
    run_in(at, "run study.toml --out out").refuses(5, &["cannot write", ".asperity-blocks"]);
    assert!(!at.join("out").exists());
}

#[test]
fn changed_and_hidden_files_links_and_empty_folders_are_foreign() {
    let folder = bench();
    let at = folder.path();
    let line = "run study.toml --out out";
    let force = || run_in(at, &format!("{line} --force"));
    assert_eq!(run_in(at, line).code, 0);
    let study = fs::read_to_string(at.join("out/study.toml")).unwrap();
    fs::write(at.join("out/study.toml"), format!("# my notes\n{study}")).unwrap();
    force().refuses(2, &["study.toml (changed)"]);
    assert!(fs::read_to_string(at.join("out/study.toml")).unwrap().starts_with("# my notes"));
    fs::write(at.join("out/study.toml"), study).unwrap();
    for (number, name) in [".hidden", "a", "b", "c", "fields/mine.csv"].iter().enumerate() {
        fs::write(at.join("out").join(name), "").unwrap();
        force().refuses(2, &[".hidden"]);
        assert!(number < 3 || force().stderr.contains(&format!("and {} more", number - 2)));
    }
    for name in [".hidden", "a", "b", "c", "fields/mine.csv"] {
        fs::remove_file(at.join("out").join(name)).unwrap();
    }
    fs::create_dir(at.join("out/notes")).unwrap();
    force().refuses(2, &["notes/"]);
    fs::remove_dir(at.join("out/notes")).unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("../spec.toml", at.join("out/link")).unwrap();
        force().refuses(2, &["link"]);
        fs::remove_file(at.join("out/link")).unwrap();
        // The destination itself, with and without a slash.
        symlink("out", at.join("latest")).unwrap();
        for name in ["latest", "latest/"] {
            run_in(at, &format!("run study.toml --out {name} --force")).refuses(2, &["--out latest", "symbolic link"]);
        }
        fs::remove_file(at.join("latest")).unwrap();
    }
    // A rendered report counts as written by asperity.
    let page = at.join("out/report.html");
    let mut spoiled = fs::read(&page).unwrap();
    spoiled.extend(b"<!-- -->");
    fs::write(&page, spoiled).unwrap();
    force().refuses(2, &["report.html (changed)"]);
    assert_eq!(run_in(at, "report out").code, 0);
    assert_eq!(force().code, 0);
    // A run of an earlier version has no manifest.
    fs::remove_file(at.join("out").join(MANIFEST)).unwrap();
    force().refuses(2, &["out has no", MANIFEST, "earlier version"]);
    assert_eq!(run_in(at, "report out").code, 0);
    force().refuses(2, &["out has no", MANIFEST]);
    assert!(at.join("out/COMPLETE").is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn sha256sum_accepts_the_manifest() {
    let folder = bench();
    let at = folder.path();
    assert_eq!(run_in(at, "run study.toml --out out").code, 0);
    let Ok(checked) =
        Command::new("sha256sum").args(["--check", "--quiet", MANIFEST]).current_dir(at.join("out")).output()
    else {
        println!("skipped: there is no sha256sum");
        return;
    };
    assert!(checked.status.success(), "{checked:?}");
}

/// Returns the hidden folder of a run in progress.
#[cfg(target_os = "linux")]
fn partial(at: &Path) -> Option<String> {
    listing(at).into_iter().find(|name| name.contains(".partial-") && at.join(name).join(MANIFEST).is_file())
}

#[cfg(target_os = "linux")]
#[test]
fn two_runs_into_one_new_folder_lose_no_result() {
    let folder = bench();
    let at = folder.path();
    // Stop a run midway, so that other runs finish first.
    let slow = |more: &str| {
        let child = start_in(at, &format!("surface generate spec.toml --count 500 --out maps {more}"));
        wait_until("the hidden folder", || partial(at).is_some());
        send("-STOP", &child);
        child
    };
    let continued = |child| {
        send("-CONT", &child);
        wait_for(child)
    };
    let count = |name: &str| written(&at.join(name)).len();
    let first = slow("");
    // The second run begins later and ends earlier. It does not remove the hidden folder of the first.
    assert_eq!(run_in(at, "surface generate spec.toml --count 2 --out maps").code, 0);
    continued(first).refuses(1, &["maps is not replaced: it was written in the meantime", "maps-2"]);
    assert_eq!((count("maps"), count("maps-2")), (2, 500));
    // The same if both may replace an older folder.
    let first = slow("--force");
    assert_eq!(run_in(at, "surface generate spec.toml --count 5 --out maps --force").code, 0);
    continued(first).refuses(1, &["maps-3"]);
    assert_eq!((count("maps"), count("maps-2"), count("maps-3")), (5, 500, 500));
    // A file that appears meanwhile.
    let first = slow("--force");
    fs::write(at.join("maps/thesis.txt"), "years").unwrap();
    continued(first).refuses(1, &["maps-4"]);
    assert_eq!(fs::read_to_string(at.join("maps/thesis.txt")).unwrap(), "years");
    assert_eq!((count("maps"), count("maps-4")), (6, 500));
    assert!(listing(at).iter().all(|name| !name.starts_with('.')), "{:?}", listing(at));
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow"]
fn sigterm_ends_like_ctrl_c_and_leaves_nothing_but_finished_blocks() {
    let folder = bench();
    let at = folder.path();
    let long = STUDY.to_owned()
        + "[material]\nyoungs_modulus = \"210 GPa\"\n[pressure]\nsize = [\"100 um\", \"100 um\"]\npoints = [64, 64]\n\
           percentile = 50.0\nmethods = ['monte_carlo']\nreference_samples = 1000000\n";
    fs::write(at.join("study.toml"), long).unwrap();
    for line in [
        "run study.toml --out deep/out".to_owned(),
        "surface generate spec.toml --count 1000000 --out deep/out".to_owned(),
        "surface twin map.x3p --count 100000 --translation plain --covariance exponential --out deep/out".to_owned(),
        format!("vibration ensemble {VIBRATION} {NOISE} --trajectories 100000000 --duration 1000 --report deep/out"),
    ] {
        // Other tests cover Ctrl-C during other commands.
        let signals = if line.starts_with("surface") { &["-TERM"][..] } else { &["-TERM", "-INT"] };
        for signal in signals {
            let (found, _) = run_and_signal(at, &line, signal);
            assert_eq!((found.code, found.stdout.as_str()), (130, ""), "{line} {signal}: {found:?}");
            assert!(found.stderr.contains("cancelled"), "{line} {signal}: {found:?}");
            if line.starts_with("run") {
                // The finished blocks, from which the run goes on.
                assert_eq!(listing(&at.join("deep")), [""; 0], "{line} {signal}");
                fs::remove_dir_all(at.join("deep")).unwrap();
            }
            assert_eq!(listing(at), INPUTS, "{line} {signal}");
        }
    }
    // `timeout` sends its signal twice in a row.
    let child = start_in(at, "surface generate spec.toml --count 1000000 --out deep/out");
    wait_until("the hidden folder", || at.join("deep").is_dir() && partial(&at.join("deep")).is_some());
    send("-TERM", &child);
    send("-TERM", &child);
    assert_eq!(wait_for(child).code, 130);
    assert_eq!(listing(at), INPUTS);
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_under_nohup_outlives_its_terminal() {
    let folder = bench();
    let at = folder.path();
    let script = "trap '' HUP; exec \"$0\" surface generate spec.toml --count 1000 --out maps";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_asperity")]);
    let child = start(at, shell);
    wait_until("the hidden folder", || partial(at).is_some());
    send("-HUP", &child);
    assert_eq!(wait_for(child).code, 0);
    assert_eq!(written(&at.join("maps")).len(), 1000);
}

#[cfg(target_os = "linux")]
#[test]
fn the_next_run_removes_only_the_remains_of_a_killed_run() {
    let folder = bench();
    let at = folder.path();
    let killed = || {
        let child = start_in(at, "surface generate spec.toml --count 1000000 --out maps");
        wait_until("the first maps", || partial(at).is_some_and(|name| listing(&at.join(name)).len() > 3));
        send("-KILL", &child);
        assert_eq!(wait_for(child).code, -1);
        partial(at).unwrap_or_default()
    };
    let left = killed();
    // A name alone proves nothing: these files are a user's, and one lies in the remaining folder.
    let mine = [".maps.partial-1/thesis.txt", ".asperity-notes.tmp/thesis.txt", ".maps.partial-host-1-1/thesis.txt"];
    for name in mine {
        fs::create_dir(at.join(name).parent().unwrap()).unwrap();
        fs::write(at.join(name), "years").unwrap();
    }
    assert_eq!(run_in(at, "run study.toml --out out").code, 0);
    assert!(!at.join(&left).exists());
    assert!(mine.iter().all(|name| at.join(name).is_file()));
    let left = killed();
    fs::write(at.join(&left).join("thesis.txt"), "years").unwrap();
    assert_eq!(run_in(at, "surface generate spec.toml --count 2 --out maps").code, 0);
    assert_eq!(listing(&at.join(&left)), [MANIFEST, "thesis.txt"]);
    // The next run restores a folder that a killed run was about to replace.
    assert_eq!(run_in(at, "surface generate spec.toml --count 3 --out old").code, 0);
    fs::rename(at.join("old"), at.join(left.replace(".maps.partial-", ".old.replaced-"))).unwrap();
    assert_eq!(run_in(at, "surface generate spec.toml --count 2 --out new").code, 0);
    assert_eq!(written(&at.join("old")).len(), 3);
    fs::rename(at.join("old"), at.join(left.replace(".maps.partial-", ".old.replaced-"))).unwrap();
    assert_eq!(run_in(at, "surface generate spec.toml --count 2 --out old").code, 2);
    assert_eq!(written(&at.join("old")).len(), 3);
    // The same for temporary files.
    let temporary = at.join(left.replace(".maps.partial-", ".asperity-") + ".tmp");
    fs::write(&temporary, "half").unwrap();
    assert_eq!(run_in(at, "surface generate spec.toml --out map.x3p").code, 0);
    assert!(!temporary.exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_study_whose_path_is_no_unicode_runs() {
    use std::os::unix::ffi::OsStrExt;

    let folder = bench();
    let at = folder.path();
    let study = std::ffi::OsStr::from_bytes(b"\xff.toml");
    fs::copy(at.join("study.toml"), at.join(study)).unwrap();
    let run = || {
        Command::new(env!("CARGO_BIN_EXE_asperity"))
            .arg("run")
            .arg(study)
            .args(["--out", "out"])
            .current_dir(at)
            .output()
    };
    let found = run().unwrap();
    assert!(found.status.success() && at.join("out/results.json").is_file(), "{found:?}");
}

/// Runs `asperity` with a small disk in the folder `disk` and lists the disk; `None` if no disk can be made.
#[cfg(target_os = "linux")]
fn on_disk(at: &Path, options: &str, before: &str, line: &str) -> Option<Finished> {
    fs::create_dir_all(at.join("disk")).unwrap();
    let mount = format!("mount -t tmpfs -o {options} tmpfs disk");
    let shell = |script: &str| {
        Command::new("unshare")
            .args(["--mount", "--map-root-user", "sh", "-c", script, env!("CARGO_BIN_EXE_asperity")])
            .current_dir(at)
            .output()
    };
    if !shell(&mount).is_ok_and(|output| output.status.success()) {
        return None;
    }
    let script = format!("{mount} && {before} \"$0\" {line}; code=$?; ls -A disk; exit $code");
    Some(shell(&script).unwrap().into())
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_or_read_only_disk_gives_one_message_in_plain_words() {
    let folder = bench();
    let at = folder.path();
    // A system folder in which no user can create files.
    for line in ["run study.toml --out /proc/out", "surface convert map.x3p /proc/map.npy"] {
        let found = run_in(at, line);
        found.refuses(5, &["cannot write /"]);
        assert!(!found.stderr.contains("os error"), "{found:?}");
    }
    let output = Command::new("sh")
        .args(["-c", "\"$0\" surface stats map.x3p --json > /dev/full", env!("CARGO_BIN_EXE_asperity")])
        .current_dir(at)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(5));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "error: stdout: the disk is full\n");
    // No file may be longer than half a kilobyte (a kilobyte in bash).
    let before = listing(at);
    for line in ["run study.toml --out out", "surface generate spec.toml --out map.npy"] {
        let limited = format!("ulimit -f 1; exec \"$0\" {line}");
        let output =
            Command::new("sh").args(["-c", &limited, env!("CARGO_BIN_EXE_asperity")]).current_dir(at).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(5), "{line}: {errors}");
        assert!(errors.contains("the file would be larger than the system allows"), "{errors}");
        assert_eq!(listing(at), before, "{line}");
    }
    if on_disk(at, "size=64k", "", "--version").is_none() {
        println!("skipped: this system does not permit to mount a small disk");
        return;
    }
    let refuses = |options: &str, before: &str, line: &str, words: &[&str]| {
        let found = on_disk(at, options, before, line).unwrap();
        found.refuses(5, words);
        assert_eq!(found.stderr.matches("error").count(), 1, "{found:?}");
        for leak in ["os error", "No space", "Read-only file system", "ZipError", "Io("] {
            assert!(!found.stderr.contains(leak), "{line}: {found:?}");
        }
    };
    // A read-only disk, and disks with too little space.
    for line in commands() {
        refuses("size=64k,ro", "", &format!("{line} disk/out"), &["disk/out", "read-only"]);
    }
    for line in ["surface generate spec.toml --out disk/map.npy", "surface convert map.x3p disk/map.npy"] {
        refuses("size=64k,ro", "", line, &["disk/map.npy", "read-only"]);
    }
    refuses("size=256k", "", "run study.toml --out disk/out", &["the run needs about", "are free for disk/out"]);
    refuses("size=256k", "", "surface generate spec.toml --count 1000 --out disk/out", &["needs about 6.1 MB"]);
    // A disk that is full from the start, and one that fills up: the files of small maps are larger than their heights.
    let filled = "head -c 1000000 /dev/zero > disk/filler 2> /dev/null;";
    let full = |line: &str| {
        let found = on_disk(at, "size=64k", filled, line).unwrap();
        assert!(found.code == 5 && found.stdout == "filler\n", "{found:?}");
        assert!(found.stderr.contains("the disk is full") && !found.stderr.contains("os error"), "{found:?}");
    };
    full("run study.toml --out disk/out");
    full("surface generate spec.toml --out disk/map.npy");
    fs::write(at.join("spec.toml"), SPECIFICATION.replace("[32, 24]", "[4, 3]")).unwrap();
    let line = "surface generate spec.toml --count 2000 --out disk/out";
    refuses("size=1m", "", line, &["cannot write disk/out/map_", "the disk is full"]);
}
