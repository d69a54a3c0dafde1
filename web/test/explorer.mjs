// Uses dist/explorer.html in a browser, and compares its numbers with those of the program `asperity`.
//
// ASPERITY is the program (default: target/release or target/debug), CHROMIUM the browser (default: /usr/bin/chromium).

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const root = join(import.meta.dirname, "../..");
const built = ["release", "debug"].map((profile) => join(root, "target", profile, "asperity"));
const program = process.env.ASPERITY ?? built.find(existsSync);
assert.ok(program, "build the program `asperity` first, or name it in ASPERITY");
const file = join(root, "web/dist/explorer.html");
const address = pathToFileURL(file).href;
const folder = mkdtempSync(join(tmpdir(), "asperity-explorer-"));
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core"), "utf8");

const asperity = (...given) => execFileSync(program, [...given, "--quiet"], { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
const json = (...given) => JSON.parse(asperity(...given, "--json"));

function close(found, wanted, relative, what) {
  assert.ok(Math.abs(found - wanted) <= relative * Math.abs(wanted), `${what}: ${found} instead of ${wanted}`);
}

/** Passes if two estimates differ by less than three standard errors. */
function agree(found, wanted, error, what) {
  assert.ok(Math.abs(found - wanted) <= 3 * error, `${what}: ${found} instead of ${wanted} ± ${error}`);
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
const complaints = [];
const requests = [];

/** Opens the page with a fragment, and waits for its first results. */
async function open(fragment = "", size = { width: 1280, height: 800 }, scheme = "light") {
  const page = await browser.newPage({ viewport: size, colorScheme: scheme, acceptDownloads: true });
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => requests.push(request.url()));
  await page.goto(`${address}${fragment}`);
  await settled(page);
  return page;
}

/** Waits until nothing is computed. */
async function settled(page) {
  await page.waitForFunction(() => document.querySelector("#status")?.hidden && !document.querySelector(".stale:not(:has(.problem:not([hidden])))"), undefined, { timeout: 30_000 });
}

/** Returns the least of three measured times: others may use the machine too. */
async function least(measure) {
  const times = [];
  for (let i = 0; i < 3; i++) times.push(await measure());
  return Math.min(...times);
}

const numbers = (page, selector) => page.$eval(selector, (element) => JSON.parse(element.dataset.numbers));
const text = (page, selector) => page.textContent(selector);

async function enter(page, id, value) {
  await page.evaluate((id) => document.getElementById(id).closest("details")?.setAttribute("open", ""), `control-${id}`);
  await page.fill(`#control-${id}`, String(value));
  await page.press(`#control-${id}`, "Enter");
}

const tests = {
  async "the page is one file below 4 MB and shows contact and motion"() {
    assert.ok(statSync(file).size < 4e6, `${statSync(file).size} bytes`);
    const seconds = await least(async () => {
      const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
      const start = performance.now();
      await page.goto(address);
      await page.waitForFunction(() => document.querySelector("#sub")?.textContent !== "" && document.querySelector("#pressure svg"));
      const seconds = (performance.now() - start) / 1000;
      await page.close();
      return seconds;
    });
    console.log(`     first contact and motion after ${seconds.toFixed(2)} s`);
  },

  async "the oscillator has the numbers of the command line"() {
    const page = await open("#from_surface=no&static_friction=0.1&belt_velocity=23.7&damping=0.17&variability=1&friction_length=250&trajectories=400&duration=2");
    const [motion, ensemble, limits] = await Promise.all(["#portrait .note", "#probability .note", "#sub"].map((place) => numbers(page, place)));
    const velocity = motion.velocity_m_per_s;
    const machine = ["--static-friction=0.1", `--stribeck=${0.531 * velocity}`, `--belt-velocity=${0.0237 / velocity}`];
    const cycle = json("vibration", "cycle", ...machine, "--damping-ratio=0.17");
    for (const key of ["period", "slip_duration", "reattachment_displacement", "displacement_max", "velocity_min"]) close(motion[key], cycle[key], 1e-9, key);
    assert.equal(motion.kind, cycle.kind);
    const critical = json("vibration", "critical-damping", ...machine);
    for (const key of ["critical_damping_ratio", "hopf_damping_ratio", "limit_damping_ratio"]) close(limits[key], critical[key], 1e-9, key);
    const omega = 2 * Math.PI * 50.3;
    const length = 250e-6 / motion.length_m;
    const random = ["--friction-std=0.001", `--correlation-length=${length}`, "--marginal=beta:2.1,5", "--trajectories=400", `--duration=${2 * omega}`, "--seed=7"];
    const other = json("vibration", "ensemble", ...machine, "--damping-ratio=0.17", ...random);
    agree(ensemble.cycles_mean, other.cycles_mean, Math.hypot(ensemble.cycles_se, other.cycles_se), "mean number of cycles");
    agree(ensemble.vibration_share, other.vibration_share, Math.hypot(ensemble.vibration_share_se, other.vibration_share_se), "share of vibration");
    // Re-attachments of one run are correlated: their mean is compared by the runs, not by the values.
    agree(ensemble.reattachment_mean, other.reattachment_mean, (Math.SQRT2 * other.reattachment_std) / 20, "mean re-attachment");
    await page.close();
  },

  async "contact has the numbers of the command line"() {
    const spec = ['seed = 1', 'size = ["256 um", "256 um"]', "points = [256, 256]", 'boundary = "periodic"', "[surface]", 'generator = "spectral"', 'covariance = "self_affine"', 'rms_height = "1 um"', 'correlation_length = ["20 um", "17 um"]', "hurst = 0.8", 'marginal = "normal"'];
    // Equal lengths would give waves of equal variance, whose order depends on the rounding of the machine.
    writeFileSync(join(folder, "spec.toml"), spec.join("\n"));
    asperity("surface", "generate", "spec.toml", "--out", "stated.x3p");
    const material = ["--youngs-modulus=210GPa", "--poisson-ratio=0.3", "--hardness=2GPa"];
    const keys = ["contact_fraction_corrected", "mean_pressure_pa", "mean_gap_m", "penetration_m"];
    const same = (found, wanted) => {
      for (const key of keys) close(found[key], wanted[key], 10 * found.tolerance, key);
      // A cell at the edge of contact may change sides.
      assert.ok(Math.abs(found.contact_fraction - wanted.contact_fraction) <= 2 / 65536);
    };
    const page = await open("#rms_height=1&length_x=20&length_y=17");
    same(await numbers(page, "#pressure .note"), json("contact", "stated.x3p", ...material, "--boundary=periodic", "--mean-pressure=20MPa"));
    await page.selectOption("#control-control", "penetration");
    await enter(page, "penetration", 1.5);
    await settled(page);
    same(await numbers(page, "#pressure .note"), json("contact", "stated.x3p", ...material, "--boundary=periodic", "--penetration=1.5um"));
    await page.close();
  },

  async "a scan gets the statistics, the contact and a twin"() {
    const spec = ['seed = 5', 'size = ["128 um", "96 um"]', "points = [128, 96]", "[surface]", 'generator = "spectral"', 'covariance = "exponential"', 'rms_height = "0.5 um"', 'correlation_length = "4 um"', 'marginal = "normal"'];
    writeFileSync(join(folder, "scan.toml"), spec.join("\n"));
    asperity("surface", "generate", "scan.toml", "--out", "scan.x3p");
    const page = await open();
    const before = await text(page, "#statistics tr[data-key=Sq_m] td");
    await page.setInputFiles("#file", join(folder, "scan.x3p"));
    await page.waitForSelector("#scan:not([hidden])");
    await settled(page);
    assert.equal(await text(page, "#scan-name"), "scan.x3p");
    assert.notEqual(await text(page, "#statistics tr[data-key=Sq_m] td"), before);
    const statistics = json("surface", "stats", "scan.x3p");
    const shown = parseFloat(await text(page, "#statistics tr[data-key=Sq_m] td"));
    close(shown * (shown > 10 ? 1e-9 : 1e-6), statistics.Sq_m, 1e-3, "Sq");
    assert.equal(await text(page, "#map h2"), "Surface: scan.x3p");
    assert.match(await text(page, "#map svg"), /Scan[^]*Random twin/);
    assert.match(await text(page, "#map .note"), /^128 µm × 96 µm, 128 × 96 points/);
    const contact = await numbers(page, "#pressure .note");
    const wanted = json("contact", "scan.x3p", "--level=plane", "--youngs-modulus=210GPa", "--hardness=2GPa", "--boundary=free", "--mean-pressure=20MPa");
    for (const key of ["contact_fraction_corrected", "mean_gap_m", "penetration_m"]) close(contact[key], wanted[key], 10 * contact.tolerance, key);
    await check(page, "study of a scan");
    await page.close();
  },

  async "a wrong file is an error in words, and the page keeps its state"() {
    const page = await open();
    await page.setInputFiles("#file", join(folder, "scan.x3p"));
    await page.waitForSelector("#scan:not([hidden])");
    await settled(page);
    const before = [await text(page, "#pressure .note"), await text(page, "#scan-name"), await text(page, "#map h2")];
    const hostile = `=1+1 <img src=x onerror=alert(1)>"&'${"x".repeat(4096)}.x3p`;
    await page.setInputFiles("#file", { name: hostile, mimeType: "application/octet-stream", buffer: Buffer.from("PK\x03\x04 no scan") });
    await page.waitForSelector("#file-problem:not([hidden])");
    await settled(page);
    let expected;
    writeFileSync(join(folder, "wrong.x3p"), "PK\x03\x04 no scan");
    try {
      execFileSync(program, ["surface", "stats", "wrong.x3p"], { cwd: folder, encoding: "utf8", stdio: "pipe" });
    } catch (error) {
      expected = error.stderr.trim().replace(/^error: /, "").replace(/^wrong\.x3p: /, "");
    }
    assert.ok((await text(page, "#file-problem")).includes(expected), `${await text(page, "#file-problem")} instead of ${expected}`);
    // What stays on the screen has its name.
    assert.match(await text(page, "#file-problem"), /The page still shows scan\.x3p\.$/);
    assert.deepEqual([await text(page, "#pressure .note"), await text(page, "#scan-name"), await text(page, "#map h2")], before);
    // A matrix of numbers states no pixel size; the page asks for it. Names are text, whatever they contain.
    await page.setInputFiles("#file", { name: hostile, mimeType: "text/plain", buffer: Buffer.from(matrix(48)) });
    await page.waitForFunction(() => /pixel/.test(document.querySelector("#file-problem").textContent));
    await page.selectOption("#height-unit", "um");
    await page.fill("#pixel-size", "2");
    await page.press("#pixel-size", "Enter");
    await page.waitForFunction((name) => document.querySelector("#scan-name").textContent === name, hostile);
    await settled(page);
    assert.equal(await page.$("img"), null);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 1280, "a long name widens the page");
    await page.close();
  },

  async "a slider changes the histogram, and the address keeps the page"() {
    const page = await open("#from_surface=no&trajectories=100&duration=1");
    const state = async () => [await text(page, "#reattachment .note"), await text(page, "#probability .note"), await text(page, "#verdict")];
    const before = await state();
    await page.focus("input[type=range][aria-label='Variability of friction, one window carries all']");
    for (let i = 0; i < 10; i++) await page.keyboard.press("ArrowRight");
    await page.focus("input[type=range][aria-label='Damping ratio']");
    for (let i = 0; i < 10; i++) await page.keyboard.press("ArrowLeft");
    await settled(page);
    const after = await state();
    assert.notDeepEqual(after, before);
    assert.notEqual(after[0], before[0]);
    await page.waitForTimeout(400);
    const kept = page.url();
    await page.reload();
    await settled(page);
    assert.equal(page.url(), kept);
    assert.deepEqual(await state(), after);
    await page.close();
  },

  async "the page says first what it is and what to do, and its controls do not wait for the module"() {
    const page = await browser.newPage();
    await page.addInitScript(() => (WebAssembly.compile = () => new Promise(() => {})));
    await page.goto(address);
    assert.match(await text(page, "main, header p"), /^From a rough surface this page computes [^.]* or move a slider\.$/);
    assert.ok((await page.locator("#controls input:visible").count()) > 15);
    await page.fill("#control-damping", "0.2");
    await page.press("#control-damping", "Enter");
    assert.equal(await page.inputValue("#control-damping"), "0.2");
    await page.close();
  },

  async "no two numbers of the page contradict each other"() {
    const cases = ["", "#upscaling=paper", "#damping=0.5", "#rms_height=1", "#elastic=yes&upscaling=paper", "#from_surface=no", "#from_surface=no&variability=0", "#from_surface=no&variability=0&damping=0.3", "#from_surface=no&damping=0.21", "#from_surface=no&duration=0.01", "#from_surface=no&static_friction=1.5&variability=20"];
    for (const fragment of cases) {
      const page = await open(`${fragment || "#"}&trajectories=40`);
      const [verdict, sub, mark, share] = await Promise.all(["#verdict", "#sub", "#limit", "#share"].map((place) => text(page, place)));
      const [limits, motion] = await Promise.all(["#sub", "#portrait .note"].map((place) => numbers(page, place)));
      const damping = Number(await page.inputValue("#control-damping"));
      const limit = limits.limit_damping_ratio;
      const near = (text) => close(Number(text.match(/\d\.\d+/g).at(-1)), limit, 1e-3, `${fragment}: limit in “${text}”`);
      [mark, sub].forEach(near);
      assert.equal(motion.limit_cycle, damping < limit, fragment);
      assert.match(sub, damping < limit ? /^Constant friction: vibration at/ : /^Constant friction: steady sliding/);
      const place = await page.$eval(".limit i", (mark) => (mark.hidden ? NaN : Number(mark.style.getPropertyValue("--place"))));
      assert.ok(limit > 0.8 ? Number.isNaN(place) : Math.abs(0.8 * place - limit) < 1e-3, `${fragment}: the mark is at ${place}`);
      // Runs are counted where friction fluctuates; elsewhere their card is empty, and the verdict is the one of constant friction.
      if (await page.isVisible("#share")) {
        assert.equal(verdict, `Fluctuating friction: ${share.match(/^[\d.]+ %/)[0]} of runs vibrate.`, fragment);
      } else {
        assert.equal(verdict, `The machine ${damping < limit ? "vibrates" : "slides steadily"} with constant friction.`, fragment);
        assert.match(await text(page, "#probability .problem"), /Friction does not fluctuate|Runs shorter than|clipped/);
        assert.equal(await page.isVisible("#reattachment svg"), false);
      }
      await page.close();
    }
  },

  async "friction varies like that of the nominal area unless one window carries all"() {
    const page = await open();
    const labels = (id) => page.$eval(`#control-${id}`, ({ labels }) => labels[0].textContent);
    assert.equal(await page.inputValue("#control-upscaling"), "area");
    assert.equal(await page.isVisible("#control-variability"), false);
    const cycles = async () => (await numbers(page, "#probability .note")).cycles_mean;
    const averaged = await cycles();
    await page.selectOption("#control-upscaling", { label: "one window carries all" });
    await settled(page);
    assert.ok((await cycles()) < averaged - 5, "one window varies more than the area");
    await page.uncheck("#control-from_surface");
    await settled(page);
    assert.match(await labels("variability"), /one window carries all/);
    assert.equal(await text(page, "#linked"), "The machine has the friction below, not that of the surface.");
    assert.equal(await page.isVisible("#control-upscaling"), false);
    await page.close();
  },

  async "the verdict stays in sight, wide and narrow"() {
    for (const width of [1280, 390]) {
      const page = await open("#from_surface=no&trajectories=20", { width, height: 800 });
      await page.evaluate(() => scrollTo(0, document.body.scrollHeight / 2));
      assert.equal((await page.locator(".bar").boundingBox()).y, 0, `at ${width}`);
      assert.ok(await page.evaluate(() => document.querySelector(".bar").contains(document.elementFromPoint(innerWidth / 2 + 100, 20))), `at ${width}`);
      await page.close();
    }
  },

  async "missing heights of a scan are filled as the command line fills them, and outliers leave the colours"() {
    const page = await open();
    const cells = matrix(48).split("\n").map((row) => row.split(" "));
    for (let i = 0; i < 60; i++) cells[20 + Math.floor(i / 10)][10 + (i % 10)] = "nan";
    cells[40][40] = "90";
    const content = cells.map((row) => row.join(" ")).join("\n");
    writeFileSync(join(folder, "voids.txt"), content);
    await page.setInputFiles("#file", join(folder, "voids.txt"));
    await page.waitForSelector("#file-problem:not([hidden])");
    await page.selectOption("#height-unit", "um");
    await page.fill("#pixel-size", "2");
    await page.press("#pixel-size", "Enter");
    await page.waitForFunction(() => document.querySelector("#scan-name").textContent === "voids.txt");
    await settled(page);
    assert.match(await text(page, "#map .note"), /60 heights \(2\.6 %\) are missing; the contact fills them\./);
    assert.match(await text(page, "#pressure .note"), /60 missing heights were filled/);
    const highest = Math.max(...(await page.$$eval("#map svg > text", (texts) => texts.map(({ textContent }) => Number(textContent.replace("−", "-"))))).filter(Number.isFinite));
    assert.ok(highest < 10, `the colours reach ${highest} µm`);
    asperity("surface", "convert", "voids.txt", "levelled.x3p", "--pixel-size=2um", "--height-unit=um", "--level=plane");
    asperity("surface", "fill", "levelled.x3p", "--seed=1", "--out", "filled.x3p");
    const found = await numbers(page, "#pressure .note");
    const wanted = json("contact", "filled.x3p", "--youngs-modulus=210GPa", "--hardness=2GPa", "--boundary=free", "--mean-pressure=20MPa");
    for (const key of ["contact_fraction_corrected", "mean_gap_m", "penetration_m"]) close(found[key], wanted[key], 10 * found.tolerance, key);
    await page.close();
  },

  async "a result that fails leaves no earlier one on its card"() {
    const page = await open("#trajectories=20");
    // A scan of a few points has statistics and a contact, but no covariance for friction.
    await page.setInputFiles("#file", { name: "small.txt", mimeType: "text/plain", buffer: Buffer.from(matrix(4)) });
    await page.waitForSelector("#file-problem:not([hidden])");
    await page.selectOption("#height-unit", "um");
    await page.fill("#pixel-size", "2");
    await page.press("#pixel-size", "Enter");
    await settled(page);
    assert.match(await text(page, "#friction .problem"), /covariance of the scan/);
    for (const card of ["friction", "portrait", "probability", "reattachment"]) {
      assert.deepEqual([await page.isVisible(`#${card} .problem`), await page.isVisible(`#${card} .note`), await page.isVisible(`#${card} svg`)], [true, false, false], card);
    }
    assert.equal(await text(page, "#verdict"), "The motion of the machine is unknown.");
    assert.deepEqual([await text(page, "#sub"), await text(page, "#linked"), await page.locator("#limit").count()], ["", "", 0]);
    assert.match(await text(page, "#map .note"), /No random twin/);
    assert.equal(await page.isVisible("#map svg"), true);
    await page.close();
  },

  // Their speeds are printed: another machine, or other work beside the test, makes them slower.
  async "portraits and contact follow their sliders"() {
    const page = await open("#from_surface=no&trajectories=50&duration=1");
    // The mean time between five portraits in the best quarter of the record: where others use the machine, some come late.
    const between = await least(() => page.evaluate(async () => {
      const range = document.querySelector("input[type=range][aria-label='Belt speed']");
      const canvas = document.querySelector("#portrait .note");
      const portraits = new Map();
      const observer = new MutationObserver(() => portraits.set(canvas.dataset.numbers, performance.now()));
      observer.observe(canvas, { attributes: true, attributeFilter: ["data-numbers"] });
      const start = performance.now();
      for (let frame = 0; performance.now() - start < 2000; frame++) {
        range.value = String(300 + (frame % 600));
        range.dispatchEvent(new Event("input"));
        await new Promise(requestAnimationFrame);
      }
      observer.disconnect();
      const drawn = [...portraits.values()];
      const between = drawn.slice(4).map((time, i) => (time - drawn[i]) / 4).sort((a, b) => a - b);
      return between[Math.floor(between.length / 4)] / 1000;
    }));
    const rate = 1 / between;
    console.log(`     ${rate.toFixed(0)} portraits per second`);
    assert.ok(rate > 0, "no portraits");
    await settled(page);
    const seconds = await least(() => page.evaluate(async () => {
      const range = document.querySelector("input[type=range][aria-label='Mean pressure']");
      const note = document.querySelector("#pressure .note");
      const start = performance.now();
      const done = new Promise((resolve) => new MutationObserver(resolve).observe(note, { attributes: true, attributeFilter: ["data-numbers"] }));
      range.value = range.value === "700" ? "690" : "700";
      range.dispatchEvent(new Event("input"));
      await done;
      return (performance.now() - start) / 1000;
    }));
    console.log(`     contact of 256 × 256 points in ${seconds.toFixed(2)} s`);
    await page.close();
  },

  async "a curve that is off stays off while its figure is drawn again, and a key shows values"() {
    const page = await open("#from_surface=no&trajectories=50&duration=1");
    const cycle = "limit cycle without fluctuation";
    await page.locator(`#portrait [data-entry='${cycle}']`).press("Enter");
    const damping = page.locator("input[type=range][aria-label='Damping ratio']");
    for (let i = 0; i < 5; i++) await damping.press("ArrowLeft");
    await settled(page);
    assert.equal(await page.getAttribute(`#portrait [data-entry='${cycle}']`, "aria-pressed"), "false");
    assert.equal(await page.getAttribute(`#portrait [data-series='${cycle}']`, "display"), "none");
    // The last bar of a histogram is not empty.
    await page.locator("#reattachment .chart").press("End");
    assert.match(await text(page, "#reattachment output"), /^runs with fluctuating friction; .*: (\d*[1-9]\d*\.\d+|0\.\d*[1-9]\d*)$/);
    await page.locator("#reattachment .chart").press("ArrowDown");
    assert.match(await text(page, "#reattachment output"), /^without fluctuation; Displacement at re-attachment \(.m\): [\d.]+; Density \(1\/.m\): [\d.]+$/);
    await page.close();
  },

  async "the keyboard focus stays in a figure that is drawn again"() {
    const page = await open("#from_surface=no&trajectories=50&duration=1");
    const focused = () => page.evaluate(() => [document.activeElement.closest(".card")?.id, document.activeElement.getAttribute("data-entry") ?? document.activeElement.getAttribute("class")]);
    for (const [selector, wanted] of [["#portrait .chart", "chart"], ["#portrait [data-entry='belt speed']", "belt speed"]]) {
      await page.focus(selector);
      await page.evaluate(() => {
        const range = document.querySelector("input[type=range][aria-label='Belt speed']");
        range.value = String(Number(range.value) + 20);
        range.dispatchEvent(new Event("input"));
      });
      await settled(page);
      assert.deepEqual(await focused(), ["portrait", wanted]);
    }
    await page.focus("#portrait .chart");
    await page.keyboard.press("+");
    await page.click("#portrait button");
    assert.deepEqual(await focused(), ["portrait", "chart"]);
    await page.close();
  },

  async "two fingers zoom a figure"() {
    const page = await browser.newPage({ viewport: { width: 390, height: 800 }, hasTouch: true });
    await page.goto(`${address}#from_surface=no&trajectories=20&duration=1`);
    await settled(page);
    const chart = page.locator("#portrait .chart");
    await chart.scrollIntoViewIfNeeded();
    const { x, y, width, height } = await chart.boundingBox();
    const client = await page.context().newCDPSession(page);
    const send = (type, gap) => client.send("Input.dispatchTouchEvent", { type, touchPoints: gap ? [-1, 1].map((side, id) => ({ x: x + width / 2 + side * gap, y: y + height / 2, id })) : [] });
    await send("touchStart", 20);
    for (let gap = 25; gap <= 60; gap += 5) await send("touchMove", gap);
    await send("touchEnd");
    assert.equal(await page.isVisible("#portrait button"), true);
    await page.close();
  },

  async "cancel ends a long computation, and the next one works"() {
    const page = await open("#from_surface=no&trajectories=100&duration=1");
    await enter(page, "duration", 10000);
    await page.waitForTimeout(500);
    await page.click("#cancel");
    await page.waitForSelector("#status", { state: "hidden" });
    assert.match(await text(page, "#probability .note"), /Cancelled/);
    await enter(page, "duration", 1);
    await settled(page);
    assert.match(await text(page, "#share"), /%/);
    await enter(page, "pressure", 50);
    await settled(page);
    const { mean_pressure_pa } = await numbers(page, "#pressure .note");
    assert.ok(Math.abs(mean_pressure_pa / 50e6 - 1) < 1e-12, `${mean_pressure_pa} Pa`);
    await page.close();
  },

  async "a saved study passes the check of the command line, and runs"() {
    const page = await open("#rms_height=0.31&length_x=21&length_y=17&hurst=0.71&pressure=33&hardness=3&youngs_modulus=190&poisson_ratio=0.29&shear_strength=400&belt_velocity=22&damping=0.16&normal_force=2400&mass=1.1&frequency=51&stribeck=0.5&trajectories=90&duration=3&seed=4&size=300");
    const stated = readFileSync(await check(page, "study of a stated surface"), "utf8");
    // Each value that the page shows is in the file: the side of the map and the duration in seconds in the address.
    const [address, keys] = [stated.match(/#(rms_height=.*)/)[1], stated.replaceAll(/^#.*$/gm, "")];
    const shown = await page.$$eval("#controls [id^=control-]:is(select, [type=number])", (all) => all.filter((e) => !e.closest("[hidden]")).map((e) => [e.id.slice(8), e.value]));
    assert.ok(shown.length > 19, `${shown}`);
    for (const [key, value] of shown) {
      assert.ok(address.includes(`${key}=${value}`), `${key} = ${value} in the address`);
      const found = { size: `${Number(value) / 4} um`, duration: String(2 * Math.PI * 51 * 3).slice(0, 9), control: `mean_${value}` }[key] ?? value;
      assert.match(keys, new RegExp(`[ "\\[_]${RegExp.escape?.(found) ?? found}|^${found}`, "m"), `${key} = ${value}`);
    }
    await page.selectOption("#control-upscaling", "paper");
    await settled(page);
    assert.match(readFileSync(await check(page, "study of one window"), "utf8"), /^upscaling = "paper"$/m);
    await enter(page, "trajectories", 20);
    await enter(page, "duration", 0.5);
    await page.uncheck("#control-from_surface");
    await page.selectOption("#control-control", "penetration");
    await settled(page);
    const saved = await check(page, "study with stated friction");
    asperity("run", saved, "--out", "run", "--force", "--only", "vibration");
    const results = JSON.parse(readFileSync(join(folder, "run/results.json"), "utf8"));
    close(results.vibration.cycle.period, (await numbers(page, "#portrait .note")).period, 1e-6, "period of the run");
    await page.close();
  },

  async "the page is accessible in light and dark, wide and narrow"() {
    for (const scheme of ["light", "dark"]) {
      for (const width of [1280, 390]) {
        const page = await open("#trajectories=50&duration=0.5", { width, height: 800 }, scheme);
        // The policy of the page allows no further script element.
        await page.evaluate(axe);
        await page.evaluate(() => document.querySelectorAll("details").forEach((details) => (details.open = true)));
        const { violations, incomplete } = await page.evaluate(() => axe.run(document));
        assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(" ")}`), [], `${scheme}, ${width}`);
        // The background of a text in a drawing is decided by its pixels.
        const undecided = incomplete.filter(({ id }) => id === "color-contrast").flatMap(({ nodes }) => nodes.map(({ target }) => target[0]));
        assert.deepEqual(await pale(page, undecided), [], `contrast, ${scheme}, ${width}`);
        const small = await page.$$eval("button, summary, select, input, [role=button], .button", (all) =>
          all.filter((element) => element.checkVisibility() && element.id !== "file").map((element) => [element.outerHTML.slice(0, 90), element.getBoundingClientRect()])
            .filter(([, { width, height }]) => Math.min(width, height) < 24).map(([html, { width, height }]) => `${width} × ${height}: ${html}`));
        assert.deepEqual(small, [], `targets, ${scheme}, ${width}`);
        const wide = await page.evaluate(() => document.documentElement.scrollWidth);
        assert.ok(wide <= width, `the page is ${wide} wide at ${width}`);
        if (process.env.PICTURES) await page.screenshot({ path: join(process.env.PICTURES, `${scheme}-${width}.png`), fullPage: width === 390 });
        await page.close();
      }
    }
  },

  async "the page makes no request, and the console stays silent"() {
    const foreign = requests.filter((url) => !url.startsWith(address) && !url.startsWith("blob:"));
    assert.deepEqual(foreign, []);
    assert.deepEqual(complaints, []);
  },
};

function matrix(side) {
  const height = (x, y) => (Math.sin(1.3 * x) + Math.cos(0.7 * y + x * y)).toFixed(4);
  return Array.from({ length: side }, (_, y) => Array.from({ length: side }, (_, x) => height(x, y)).join(" ")).join("\n");
}

/** Returns the texts whose pixels have a contrast below 4.5, and those that are not in a drawing. */
async function pale(page, selectors) {
  const places = await page.evaluate((selectors) => selectors.map((selector) => {
    const element = document.querySelector(selector);
    const { left, top, width, height } = element.getBoundingClientRect();
    return { name: element.textContent, drawn: element.closest(".drawing svg") !== null, left: left + scrollX, top: top + scrollY, width, height };
  }), selectors);
  // The bar would cover the figures below it.
  await page.evaluate(() => (document.querySelector(".bar").style.position = "static"));
  const picture = (await page.screenshot({ fullPage: true })).toString("base64");
  const decoder = await browser.newPage();
  const found = await decoder.evaluate(async ([picture, places]) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${picture}`)).blob());
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const linear = (c) => (c <= 10 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
    const contrast = ({ left, top, width, height }) => {
      const { data } = context.getImageData(left, top, Math.ceil(width), Math.ceil(height));
      const lights = Array.from({ length: data.length / 4 }, (_, i) => 0.2126 * linear(data[4 * i]) + 0.7152 * linear(data[4 * i + 1]) + 0.0722 * linear(data[4 * i + 2]));
      return (Math.max(...lights) + 0.05) / (Math.min(...lights) + 0.05);
    };
    return places.filter((place) => !place.drawn || contrast(place) < 4.5).map((place) => `${place.name}: ${contrast(place)}`);
  }, [picture, places]);
  await decoder.close();
  return found;
}

/** Saves the study of a page, and checks it with the command line. */
async function check(page, what) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  const path = join(folder, "study.toml");
  await download.saveAs(path);
  try {
    execFileSync(program, ["check", path], { cwd: folder, encoding: "utf8", stdio: "pipe" });
  } catch (error) {
    assert.fail(`${what}: ${error.stderr}\n${readFileSync(path, "utf8")}`);
  }
  return path;
}

let failed = 0;
for (const [name, test] of Object.entries(tests)) {
  if (process.argv[2] && !name.includes(process.argv[2])) continue;
  try {
    await test();
    console.log(`ok   ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAIL ${name}\n${error.stack}`);
  }
}
await browser.close();
rmSync(folder, { recursive: true });
process.exit(failed ? 1 : 0);
