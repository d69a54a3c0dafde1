//! Tests of the script for Slurm. `sbatch` is a stand-in that runs each job at once; `scripts/test-slurm` submits to a real cluster.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

use asperity_testing::{METHODS, StudyText};
use tempfile::TempDir;

use crate::support::{asperity_in, listing, run_in};

/// A surface with the distribution of its pressure, in half a second.
fn pressed() -> String {
    StudyText::new(5, &["surface", "material", "pressure"])
        .with("pressure", METHODS)
        .with("pressure", "fine_solves = 200\nreference_samples = 400\nvariables = 4\ndegree = 2")
        .to_string()
}

/// Constant friction, stated: a study without a block.
fn without_blocks() -> String {
    StudyText::new(5, &["vibration", "stated friction"])
        .with("vibration", "friction_std = 0.0\ndamping_sweep = [0.3, 0.5, 3]\ntrajectories = 4\nduration = 50.0")
        .to_string()
}

/// Runs all jobs at once in the order of submission, prints their numbers as Slurm does on several clusters, and logs its
/// arguments.
const SBATCH: &str = r#"#!/bin/sh
log=$(dirname "$0")/log
echo "$@" >> "$log"
tasks=1
while [ $# -gt 2 ]; do
    case $1 in --array=1-*) tasks=${1#--array=1-} ;; esac
    shift
done
task=1
while [ "$task" -le "$tasks" ]; do
    SLURM_CPUS_PER_TASK=1 SLURM_ARRAY_TASK_ID=$task sh "$1" "$2" >&2 || exit
    task=$((task + 1))
done
echo "$(wc -l < "$log");cluster"
"#;

/// Submits a script with options of sbatch; returns also the arguments of each submission.
fn submit(at: &Path, script: &str, options: &[&str]) -> (Output, Vec<String>) {
    let (bin, log) = (at.join("bin"), at.join("bin/log"));
    fs::create_dir_all(&bin).unwrap();
    fs::write(bin.join("sbatch"), SBATCH).unwrap();
    fs::set_permissions(bin.join("sbatch"), fs::Permissions::from_mode(0o755)).unwrap();
    fs::write(&log, "").unwrap();
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let output = Command::new("sh").arg(script).args(options).current_dir(at).env("PATH", path).output().unwrap();
    (output, fs::read_to_string(&log).unwrap().lines().map(str::to_owned).collect())
}

#[test]
#[ignore = "slow"]
fn the_jobs_of_a_script_give_the_bytes_of_one_run_whatever_the_paths() {
    let folder = TempDir::new().unwrap();
    let at = folder.path().join("it's a $HOME of \"studies\"");
    fs::create_dir_all(&at).unwrap();
    fs::write(at.join("my study.toml"), pressed()).unwrap();
    assert_eq!(asperity_in(&at, &["run", "my study.toml", "--out", "one run/whole"]).code, 0);
    let options = ["--tasks", "3", "--rounds", "2", "--time", "90.5 min", "--memory", "1.5 GB", "--cpus", "2"];
    let found = asperity_in(&at, &[&["slurm", "my study.toml"][..], &options].concat());
    assert_eq!((found.code, found.stdout.as_str()), (0, ""), "{found:?}");
    assert_eq!(found.stderr, "wrote my study.slurm.sh; next: sh 'my study.slurm.sh'\n");
    let text = fs::read_to_string(at.join("my study.slurm.sh")).unwrap();
    let options = "#!/bin/sh\n#SBATCH --cpus-per-task=2\n#SBATCH --time=91\n#SBATCH --mem=1431M\nasperity=";
    assert!(text.starts_with(options), "{text}");

    let (output, submissions) = submit(&at, "my study.slurm.sh", &["--partition=short"]);
    assert!(output.status.success(), "{output:?}");
    let wanted = [
        "--parsable --job-name=my study-parts --partition=short --kill-on-invalid-dep=yes --array=1-3 my study.slurm.sh part",
        "--parsable --job-name=my study-merge --partition=short --kill-on-invalid-dep=yes --dependency=afterok:1 my study.slurm.sh merge",
        "--parsable --job-name=my study-parts --partition=short --kill-on-invalid-dep=yes --dependency=afterok:2 --array=1-3 \
         my study.slurm.sh part",
        "--parsable --job-name=my study-finish --partition=short --kill-on-invalid-dep=yes --dependency=afterok:3 \
         my study.slurm.sh finish",
    ];
    assert_eq!(submissions, wanted);
    let files = |run: &str| -> Vec<(String, Vec<u8>)> {
        let tables = listing(&at.join(run).join("tables")).into_iter().map(|name| format!("tables/{name}"));
        let names = tables.chain(["results.json".to_owned()]);
        names.map(|name| (name.clone(), fs::read(at.join(run).join(name)).unwrap())).collect()
    };
    assert!(files("runs/my study") == files("one run/whole"));
    assert!(at.join("runs/my study-part-3-of-3").is_dir());
    // A finished run is not computed again.
    let (output, submissions) = submit(&at, "my study.slurm.sh", &[]);
    assert!(output.status.success() && submissions.is_empty(), "{output:?}");
}

#[test]
fn parts_without_a_block_are_merged_also_a_single_one() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fs::write(at.join("brake.toml"), without_blocks()).unwrap();
    for tasks in [1, 5] {
        let line = format!("slurm brake.toml --tasks {tasks} --out runs/of-{tasks} --force");
        assert_eq!(run_in(at, &line).code, 0);
        let (output, submissions) = submit(at, "brake.slurm.sh", &[]);
        assert!(output.status.success() && submissions.len() == 2, "{output:?}");
        assert!(submissions[0].contains(&format!("--array=1-{tasks} ")), "{submissions:?}");
        assert!(at.join(format!("runs/of-{tasks}/COMPLETE")).exists());
    }
}

#[test]
fn jobs_that_fail_end_the_submission_and_go_on_later() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fs::write(at.join("brake.toml"), pressed()).unwrap();
    assert_eq!(run_in(at, "slurm brake.toml --tasks 2").code, 0);
    fs::rename(at.join("brake.toml"), at.join("away.toml")).unwrap();
    let (output, submissions) = submit(at, "brake.slurm.sh", &[]);
    assert!(output.status.code() == Some(3) && submissions.len() == 1, "{output:?}");
    fs::rename(at.join("away.toml"), at.join("brake.toml")).unwrap();
    let (output, _) = submit(at, "brake.slurm.sh", &[]);
    assert!(output.status.success() && at.join("runs/brake/COMPLETE").exists(), "{output:?}");
}

#[test]
fn a_wrong_study_or_value_writes_no_script_and_a_script_is_not_replaced_unasked() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fs::write(at.join("wrong.toml"), pressed().replace("rms_height", "rms_hight")).unwrap();
    run_in(at, "slurm wrong.toml --tasks 2").refuses(2, &["wrong.toml:5", "rms_hight"]);
    run_in(at, "slurm none.toml --tasks 2").refuses(3, &["none.toml: no such file"]);
    fs::write(at.join("brake.toml"), pressed()).unwrap();
    run_in(at, "slurm brake.toml").refuses(2, &["--tasks"]);
    for (flag, word) in [("--tasks 0", "at least 1"), ("--tasks 2 --time 4", "unit"), ("--tasks 2 --memory 4", "size")]
    {
        run_in(at, &format!("slurm brake.toml {flag}")).refuses(2, &[word]);
    }
    assert_eq!(listing(at), ["brake.toml", "wrong.toml"]);
    assert_eq!(run_in(at, "slurm brake.toml --tasks 2").code, 0);
    let text = fs::read_to_string(at.join("brake.slurm.sh")).unwrap();
    run_in(at, "slurm brake.toml --tasks 3").refuses(2, &["brake.slurm.sh exists already", "--force"]);
    assert_eq!(fs::read_to_string(at.join("brake.slurm.sh")).unwrap(), text);
    let found = run_in(at, "slurm brake.toml --tasks 3 --force");
    assert_eq!((found.code, found.stderr.as_str()), (0, "replaced brake.slurm.sh; next: sh brake.slurm.sh\n"));
}
