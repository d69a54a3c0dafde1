// Bundles the scripts. `node build.mjs` writes the script of reports into `asperity-report`, which carries it; `check` fails if the
// scripts there are others, or if the module there has other functions than the bindings of the oscillator as they are.
// `node build.mjs explorer` compiles the bindings and writes the explorer, one file, to dist/explorer.html; `page` writes it
// with the bindings as they are. `node build.mjs oscillator` compiles the bindings of the oscillator alone, and `node build.mjs
// machine` also writes them into `asperity-report`, with the script of their worker.

import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { gunzipSync, gzipSync } from "node:zlib";
import { build } from "esbuild";

const COMMON = { bundle: true, minify: true, format: "iife", target: "es2022", charset: "utf8", legalComments: "inline" };

/** The tool that makes the JavaScript side of the bindings, where `just web` installs it or on the path. */
const TOOL = "target/tools/bin/wasm-bindgen";

/** What `asperity-report` carries. */
const CARRIED = "../crates/asperity-report/src/page";

/** Bundle of the page of a report. */
const figures = async () => (await build({ ...COMMON, entryPoints: ["src/report.ts"], write: false })).outputFiles[0].text;

/** Bundle of the worker of the machine in a report, and the module that it calls. */
const worker = () => script("src/machine/worker.ts", { "import.meta.url": '""' });
const MODULE = "build/oscillator/asperity_wasm_bg.wasm";

async function check() {
  for (const [name, text, target] of [["figures.js", await figures(), "build"], ["oscillator.js", await worker(), "machine"]]) {
    if (readFileSync(`${CARRIED}/${name}`, "utf8") !== text) throw new Error(`${CARRIED}/${name} is not current; run \`npm run ${target}\``);
  }
  // The bytes depend on the profile and the compiler.
  const functions = async (bytes) => JSON.stringify(WebAssembly.Module.exports(await WebAssembly.compile(bytes)).map(({ name }) => name).sort());
  const carried = gunzipSync(readFileSync(`${CARRIED}/oscillator.wasm.gz`));
  if ((await functions(carried)) !== (await functions(readFileSync(MODULE)))) throw new Error("oscillator.wasm.gz is not current; run `npm run machine`");
}

/** Profile of cargo for the bindings; `dev` compiles in less than half the time. */
const PROFILE = process.env.WASM_PROFILE ?? "wasm";

/** Compiles the bindings for the browser into `folder`, with the features of cargo's `flags`. */
function bindings(folder, flags = []) {
  const run = (program, ...given) => execFileSync(program, given, { cwd: "..", stdio: ["ignore", "inherit", "inherit"] });
  run("cargo", "build", "--quiet", "--package", "asperity-wasm", "--lib", "--target", "wasm32-unknown-unknown", "--profile", PROFILE, ...flags);
  run(
    existsSync(`../${TOOL}`) ? TOOL : "wasm-bindgen",
    "--target=web",
    "--remove-name-section",
    "--remove-producers-section",
    `--out-dir=web/${folder}`,
    `target/wasm32-unknown-unknown/${PROFILE === "dev" ? "debug" : PROFILE}/asperity_wasm.wasm`,
  );
}

/** Returns the text of a bundle. */
async function script(entry, define) {
  const { outputFiles } = await build({ ...COMMON, entryPoints: [entry], define, write: false });
  // Inside of an HTML element a script must not contain the end of one.
  return outputFiles[0].text.replaceAll("</script", "<\\/script");
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

async function machine() {
  writeFileSync(`${CARRIED}/oscillator.js`, await worker());
  writeFileSync(`${CARRIED}/oscillator.wasm.gz`, gzipSync(readFileSync(MODULE), { level: 9 }));
}

/** Inputs of a study, from the bindings. */
async function inputs() {
  const { initSync, inputs } = await import("./build/asperity_wasm.js");
  initSync({ module: readFileSync("build/asperity_wasm_bg.wasm") });
  return inputs();
}

async function page() {
  const [, version] = readFileSync("../Cargo.toml", "utf8").match(/^version = "(.*)"$/m);
  const worker = await script("src/explorer/worker.ts", { "import.meta.url": '""' });
  const main = await script("src/explorer/page.ts", { WORKER: JSON.stringify(worker), VERSION: JSON.stringify(version), INPUTS: await inputs() });
  const style = (await build({ ...COMMON, entryPoints: ["src/explorer/style.css"], write: false })).outputFiles[0].text.trim();
  const module = gzipSync(readFileSync("build/asperity_wasm_bg.wasm"), { level: 9 }).toString("base64");
  const policy = [
    "default-src 'none'",
    `script-src ${hash(main)} 'wasm-unsafe-eval'`,
    `style-src ${hash(style)}`,
    "img-src data:",
    "worker-src blob:",
    "base-uri 'none'",
    "form-action 'none'",
  ].join("; ");
  const html = readFileSync("src/explorer/page.html", "utf8")
    .replace("</title>", () => `</title>\n<meta http-equiv="Content-Security-Policy" content="${policy}">\n<style>${style}</style>`)
    .replace("</body>", () => `<script type="text/plain" id="module">${module}</script>\n<script>${main}</script>\n</body>`);
  mkdirSync("dist", { recursive: true });
  writeFileSync("dist/explorer.html", html);
}

const size = (path) => `${path}: ${(readFileSync(path).length / 1e6).toFixed(2)} MB`;

switch (process.argv[2]) {
  case undefined:
    writeFileSync(`${CARRIED}/figures.js`, await figures());
    break;
  case "check":
    await check();
    break;
  case "explorer":
    bindings("build");
    await page();
    console.log(size("dist/explorer.html"));
    break;
  case "page":
    await page();
    break;
  case "oscillator":
    bindings("build/oscillator", ["--no-default-features"]);
    console.log(size(MODULE));
    break;
  case "machine":
    bindings("build/oscillator", ["--no-default-features"]);
    await machine();
    break;
  default:
    throw new Error(`no target ${process.argv[2]}`);
}
