// Makes reports of every kind with the program `asperity`, and opens them in a browser.
//
// node test/pages.mjs [--pictures DIR]; ASPERITY is the program (default: target/release or target/debug).

import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const root = join(import.meta.dirname, "../..");
const program = process.env.ASPERITY ?? ["release", "debug"].map((profile) => join(root, "target", profile, "asperity")).find(existsSync);
if (!program) throw new Error("build the program `asperity` first, or name it in ASPERITY");
const folder = mkdtempSync(join(tmpdir(), "asperity-pages-"));

/** Names that would be markup, a script, or a formula of a spreadsheet. */
const HOSTILE = `=1+1 <img src=x onerror=alert(1)> "&' ${"x".repeat(150)}`;

const VERDICT = `seed = 3
[vibration]
static_friction = 0.42
friction_std = 0.002
friction_marginal = "beta:2.1,5"
friction_correlation_length = "0.2 mm"
stribeck = 4.2
mass = "15 kg"
natural_frequency = "100 Hz"
normal_force = "10 kN"
nominal_area = "50 cm^2"
damping_ratio = "0.05 ± 0.01"
belt_velocity = { lognormal = ["2 cm/s", 0.2], unknown = true }
trajectories = 40
[verdict]
duration = "1 s"
remedies = [{ input = "vibration.damping_ratio", range = [0.01, 0.5] }]
`;

const asperity = (...given) => execFileSync(program, [...given, "--quiet"], { cwd: folder, stdio: ["ignore", "ignore", "inherit"] });
const machine = ["--static-friction=0.1", "--stribeck=4.2", "--belt-velocity=0.003"];
const noise = ["--damping-ratio=0.17", "--friction-std=0.001", "--correlation-length=0.01", "--marginal=beta:2.1,5", "--seed=3"];

/** Keys of the quickstart that make it smaller, and add what its report leaves out: its page has all figures. */
const SMALLER = [["points = [3072, 80]", "points = [1024, 26]"], ["realisations = 16", "realisations = 4"], ["fine_solves = 600", 'fine_solves = 60\nmethods = ["monte_carlo", "latin_hypercube", "sobol", "polynomial_chaos", "polynomial_chaos_log", "polynomial_chaos_local"]\nreference_samples = 200'],
  ["range = [0.03, 0.15] }]", 'range = [0.03, 0.15] }, { input = "vibration.belt_velocity", range = ["10 mm/s", "0.1 m/s"] }]\nhalf_width = 0.1\nevaluations = 1000']];

let study = readFileSync(join(root, "studies/quickstart.toml"), "utf8");
for (const [key, smaller] of SMALLER) {
  if (!study.includes(key)) throw new Error(`the quickstart has no ${key}`);
  study = study.replace(key, smaller);
}
writeFileSync(join(folder, "quickstart.toml"), study);
copyFileSync(join(root, "studies/brake_disc.x3p"), join(folder, "brake_disc.x3p"));
writeFileSync(join(folder, `${HOSTILE}.toml`), VERDICT);
copyFileSync(join(root, "studies/brake_disc.x3p"), join(folder, `${HOSTILE}.x3p`));
asperity("run", "quickstart.toml", "--out", "run");
asperity("run", `${HOSTILE}.toml`, "--out", "verdict");
asperity("surface", "twin", `${HOSTILE}.x3p`, "--count=2", "--seed=1", "--out", "twins");
asperity("vibration", "ensemble", ...machine, ...noise, "--trajectories=30", "--duration=200", "--report", "ensemble");
asperity("vibration", "basin", ...machine, "--damping-ratio=0.20482", "--report", "basin");
const pages = ["run/report.html", "verdict/report.html", "twins/twins.html", "ensemble/report.html", "basin/report.html"];
execFileSync("node", [join(import.meta.dirname, "report.mjs"), ...pages.map((page) => join(folder, page)), ...process.argv.slice(2)], { stdio: "inherit" });
rmSync(folder, { recursive: true });
