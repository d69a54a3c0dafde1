// Bundles the scripts. `node build.mjs` writes the script of reports into `asperity-report`, which carries it.
// `node build.mjs explorer` compiles the bindings and writes the explorer, one file, to dist/explorer.html.

import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const COMMON = { bundle: true, minify: true, format: "iife", target: "es2022", charset: "utf8", legalComments: "inline" };

async function report() {
  await build({ ...COMMON, entryPoints: ["src/report.ts"], outfile: "../crates/asperity-report/src/page/figures.js" });
}

/** Compiles the bindings for the browser into `folder`, with the features of cargo's `flags`. */
function bindings(folder, flags = []) {
  const run = (program, ...given) => execFileSync(program, given, { cwd: "..", stdio: ["ignore", "inherit", "inherit"] });
  run("cargo", "build", "--quiet", "--package", "asperity-wasm", "--lib", "--target", "wasm32-unknown-unknown", "--profile", "wasm", ...flags);
  run(
    process.env.WASM_BINDGEN ?? "wasm-bindgen",
    "--target=web",
    "--remove-name-section",
    "--remove-producers-section",
    `--out-dir=web/${folder}`,
    "target/wasm32-unknown-unknown/wasm/asperity_wasm.wasm",
  );
}

/** Returns the text of a bundle. */
async function script(entry, define) {
  const { outputFiles } = await build({ ...COMMON, entryPoints: [entry], define, write: false });
  // Inside of an HTML element a script must not contain the end of one.
  return outputFiles[0].text.replaceAll("</script", "<\\/script");
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

async function explorer() {
  if (!process.env.SKIP_BINDINGS) bindings("build");
  const [, version] = readFileSync("../Cargo.toml", "utf8").match(/^version = "(.*)"$/m);
  const worker = await script("src/worker.ts", { "import.meta.url": '""' });
  const page = await script("src/explorer/page.ts", { WORKER: JSON.stringify(worker), VERSION: JSON.stringify(version) });
  const style = (await build({ ...COMMON, entryPoints: ["src/explorer/style.css"], write: false })).outputFiles[0].text.trim();
  const module = gzipSync(readFileSync("build/asperity_wasm_bg.wasm"), { level: 9 }).toString("base64");
  const policy = [
    "default-src 'none'",
    `script-src ${hash(page)} 'wasm-unsafe-eval'`,
    `style-src ${hash(style)}`,
    "worker-src blob:",
    "base-uri 'none'",
    "form-action 'none'",
  ].join("; ");
  const html = readFileSync("src/explorer/page.html", "utf8")
    .replace("</title>", () => `</title>\n<meta http-equiv="Content-Security-Policy" content="${policy}">\n<style>${style}</style>`)
    .replace("</body>", () => `<script type="text/plain" id="module">${module}</script>\n<script>${page}</script>\n</body>`);
  mkdirSync("dist", { recursive: true });
  writeFileSync("dist/explorer.html", html);
  console.log(`dist/explorer.html: ${(html.length / 1e6).toFixed(2)} MB, module ${(module.length / 1e6).toFixed(2)} MB of it`);
}

await (process.argv[2] === "explorer" ? explorer() : report());
