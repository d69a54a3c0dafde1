// Runs a test program that was compiled for WASI: node scripts/wasi.mjs PROGRAM ARGUMENTS
import { readFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { WASI } from "node:wasi";

const [program, ...rest] = process.argv.slice(2);
const wasi = new WASI({
    version: "preview1",
    args: [program, ...rest],
    env: { RUST_BACKTRACE: "1", TMPDIR: "/tmp" },
    preopens: { "/tmp": tmpdir(), ".": process.cwd() },
});
const { instance } = await WebAssembly.instantiate(await readFile(program), wasi.getImportObject());
process.exitCode = wasi.start(instance);
