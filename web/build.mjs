// Bundles the scripts. `node build.mjs` writes the script of reports into `asperity-report`, which carries it.

import { build } from "esbuild";

await build({
  entryPoints: ["src/report.ts"],
  outfile: "../crates/asperity-report/src/page/figures.js",
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "inline",
});
