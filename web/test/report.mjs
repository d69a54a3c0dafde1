// Opens reports in a real browser: every figure draws, nothing is loaded, nothing fails, and the page is accessible.
//
// The machine of a run has the numbers of its results.json, and follows the sliders.
//
// node test/report.mjs PAGE.html… [--pictures DIR]; CHROMIUM names the browser.

import { existsSync, readFileSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, dirname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const words = process.argv.slice(2);
const at = words.indexOf("--pictures");
const [, pictures] = at < 0 ? [] : words.splice(at, 2);
const LARGEST = 5e6;

function check(holds, message) {
  if (!holds) throw new Error(message);
}

/** Shares of the pixels of each canvas of a figure that differ from its most common colour. */
const drawn = (figure) =>
  [...figure.querySelectorAll(".canvas canvas")].map((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const counts = new Map();
    for (let i = 0; i < data.length; i += 4) {
      const colour = `${data[i]},${data[i + 1]},${data[i + 2]},${data[i + 3]}`;
      counts.set(colour, (counts.get(colour) ?? 0) + 1);
    }
    return 1 - Math.max(...counts.values()) / (data.length / 4);
  });

/** Names of the outlined curves of a figure whose colour no pixel has, because the outline covers them. */
const covered = (figure) => {
  const canvases = [...figure.querySelectorAll(".canvas canvas")];
  const { charts } = JSON.parse(figure.querySelector("script").textContent);
  return charts.flatMap(({ series }, place) => {
    const canvas = canvases[place];
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    const is = (rgb, i) => rgb.every((c, k) => Math.abs(data[i + k] - c) < 12);
    const outlined = series.filter((_, k) => k > 0 && series[k - 1].mark === "line" && series[k - 1].name === "" && series[k - 1].pen.opacity === 0.85);
    return outlined.filter(({ pen }) => {
      const rgb = [1, 3, 5].map((at) => parseInt(pen.colour.slice(at, at + 2), 16));
      for (let i = 0; i < data.length; i += 4) if (is(rgb, i)) return false;
      return true;
    });
  }).map(({ name }) => name);
};

async function open(browser, page, options) {
  const context = await browser.newContext({ acceptDownloads: true, ...options });
  const tab = await context.newPage();
  const faults = [];
  tab.on("console", (message) => ["error", "warning"].includes(message.type()) && faults.push(message.text()));
  tab.on("pageerror", (error) => faults.push(String(error)));
  tab.on("request", (request) => {
    if (!/^(data:|blob:)/.test(request.url()) && request.url() !== page) faults.push(`requests ${request.url()}`);
  });
  await tab.goto(page);
  return { context, tab, faults };
}

/** Shows the machine of a page, and waits for its motion; false without one. */
async function started(tab) {
  const host = tab.locator("#machine");
  if ((await host.count()) === 0) return false;
  await tab.locator("#move").scrollIntoViewIfNeeded();
  await settled(tab);
  return true;
}

const settled = (tab) =>
  tab.waitForFunction(() => document.querySelector("#machine").dataset.numbers && document.querySelector("#machine .status").hidden, undefined, { timeout: 60_000 });

/** Moves the machine of a page, and compares its first numbers with those of the run. */
async function move(browser, file) {
  const page = pathToFileURL(resolve(file)).href;
  const { context, tab, faults } = await open(browser, page, { viewport: { width: 1280, height: 800 } });
  if (!(await started(tab))) return context.close();
  const host = tab.locator("#machine");
  const numbers = async () => JSON.parse(await host.getAttribute("data-numbers"));
  const first = await numbers();
  const results = join(dirname(resolve(file)), "results.json");
  if (existsSync(results)) {
    const { vibration } = JSON.parse(readFileSync(results, "utf8"));
    const close = (found, wanted, tolerance, what) =>
      check(found === wanted || Math.abs(found - wanted) <= tolerance, `${file}: ${what} is ${found} instead of ${wanted}`);
    const { cycle } = vibration;
    for (const key of ["period", "slip_duration", "displacement_min", "displacement_max", "velocity_min", "reattachment_displacement"])
      close(first[key], cycle[key], 1e-9 * Math.abs(cycle[key]), key);
    for (const key of ["critical_damping_ratio", "hopf_damping_ratio", "limit_damping_ratio"])
      close(first[key], vibration[key], 1e-9 * Math.abs(vibration[key]), key);
    const { reattachment } = vibration[vibration.upscaling];
    // Re-attachments of one run are correlated: the error of their mean is at most that of the means of the runs.
    if (first.reattachment_count > 0)
      close(first.reattachment_mean, reattachment.mean, (3 * Math.SQRT2 * reattachment.std) / Math.sqrt(first.trajectories), "mean re-attachment");
  }
  await tab.locator("#machine input[type=range][aria-label='Damping ratio ζ']").focus();
  for (let i = 0; i < 12; i++) await tab.keyboard.press("ArrowRight");
  await settled(tab);
  await tab.waitForFunction((before) => document.querySelector("#machine").dataset.numbers !== before, JSON.stringify(first));
  if (pictures) await tab.locator("#move").screenshot({ path: `${pictures}/${basename(resolve(file, ".."))}-move.png` });
  await tab.getByRole("button", { name: "The machine of the study" }).click();
  await tab.waitForFunction((wanted) => JSON.parse(document.querySelector("#machine").dataset.numbers).period === wanted, first.period);
  const policy = await tab.getAttribute("meta[http-equiv='Content-Security-Policy']", "content");
  check(!/unsafe-inline|'unsafe-eval'|\*|https?:/.test(policy), `${file}: ${policy}`);
  check(faults.length === 0, `${file}: ${faults.join("; ")}`);
  await context.close();
}

/** What axe finds on a page. Its script needs a context without the policy of the page. */
async function accessibility(browser, page, options) {
  const context = await browser.newContext({ bypassCSP: true, ...options });
  const tab = await context.newPage();
  await tab.goto(page);
  await tab.evaluate(() => document.querySelectorAll("details").forEach((element) => (element.open = true)));
  await started(tab);
  await tab.waitForTimeout(300);
  await tab.evaluate(axe);
  const { violations } = await tab.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  await context.close();
  return violations;
}

async function download(tab, button) {
  const [file] = await Promise.all([tab.waitForEvent("download"), button.click()]);
  return { name: file.suggestedFilename(), text: readFileSync(await file.path(), "utf8") };
}

async function examine(browser, file, width, colorScheme) {
  const page = pathToFileURL(resolve(file)).href;
  const { context, tab, faults } = await open(browser, page, { viewport: { width, height: 800 }, colorScheme });
  const what = `${file} at ${width} px, ${colorScheme}`;
  const wide = await tab.evaluate(() => document.documentElement.scrollWidth);
  check(wide <= width, `${what}: the page is ${wide} px wide`);
  await tab.evaluate(() => document.querySelectorAll("details").forEach((element) => (element.open = true)));
  const figures = await tab.locator("figure[id]").all();
  for (const figure of figures) {
    await figure.scrollIntoViewIfNeeded();
    await figure.locator(".canvas canvas").first().waitFor();
    await tab.waitForTimeout(60);
    const shares = await figure.evaluate(drawn);
    const name = await figure.getAttribute("id");
    const most = await figure.evaluate((element) => {
      const { charts } = JSON.parse(element.querySelector("script").textContent);
      const curves = ({ series }) => new Set(series.filter(({ mark }) => mark === "line").map(({ name }) => name).filter((name) => name !== ""));
      return Math.max(...charts.map((chart) => curves(chart).size));
    });
    check(most <= 6, `${what}: ${await figure.getAttribute("id")} has ${most} curves in a panel`);
    const under = colorScheme === "light" ? await figure.evaluate(covered) : [];
    check(under.length === 0, `${what}: ${name} has curves under their outlines: ${under}`);
    check(shares.length > 0 && shares.every((share) => share > 0.004), `${what}: ${name} is empty: ${shares}`);
  }
  const violations = await accessibility(browser, page, { viewport: { width, height: 800 }, colorScheme });
  const serious = violations.filter(({ impact }) => ["serious", "critical"].includes(impact));
  check(serious.length === 0, `${what}: ${JSON.stringify(serious.map(({ id, nodes }) => [id, nodes.slice(0, 3).map((node) => node.html)]))}`);
  if (pictures) {
    const stem = `${pictures}/${basename(resolve(file, ".."))}-${width}-${colorScheme}`;
    await tab.evaluate(() => scrollTo(0, 0));
    await tab.screenshot({ path: `${stem}.png` });
    await tab.screenshot({ path: `${stem}-whole.png`, fullPage: true });
  }
  check(faults.length === 0, `${what}: ${faults.join("; ")}`);
  await context.close();
  return figures.length;
}

/** Uses the tools of the first figure with a named curve. */
async function use(browser, file) {
  const page = pathToFileURL(resolve(file)).href;
  const { context, tab, faults } = await open(browser, page, { viewport: { width: 1280, height: 800 } });
  const id = await tab.evaluate(() => {
    const hasCurve = (element) => {
      const { charts } = JSON.parse(element.querySelector("script").textContent);
      return charts.length === 1 && !charts[0].backdrop && charts[0].series.some(({ mark, name }) => mark === "line" && name !== "");
    };
    return [...document.querySelectorAll("figure[id]")].find(hasCurve)?.id;
  });
  if (id === undefined) return context.close();
  const figure = tab.locator(`#${id}`);
  await figure.scrollIntoViewIfNeeded();
  const canvas = figure.locator(".canvas canvas").first();
  await canvas.waitFor();
  const image = () => canvas.evaluate((element) => element.toDataURL());
  const changed = async (act, what) => {
    const before = await image();
    await act();
    await tab.waitForTimeout(120);
    check((await image()) !== before, `${file}: ${what} changes nothing`);
  };
  const curve = figure.locator(".legend button").first();
  await changed(() => curve.click(), "a curve that is switched off");
  check((await curve.getAttribute("aria-pressed")) === "false", "the state of a switched curve");
  await changed(() => curve.press("Enter"), "a curve that is switched on by a key");
  const box = await canvas.boundingBox();
  await changed(async () => {
    await tab.mouse.move(box.x + 0.4 * box.width, box.y + 0.3 * box.height);
    await tab.mouse.down();
    await tab.mouse.move(box.x + 0.7 * box.width, box.y + 0.6 * box.height, { steps: 4 });
    await tab.mouse.up();
  }, "a zoom");
  await changed(() => figure.getByRole("button", { name: "Reset zoom" }).click(), "its end");
  await canvas.focus();
  await changed(() => tab.keyboard.press("ArrowRight"), "an arrow key");
  check((await figure.locator("output").textContent()).includes(":"), "a value is shown");
  const csv = await download(tab, figure.getByRole("button", { name: /^CSV/ }));
  check(csv.name.endsWith(".csv") && csv.text.split("\n").length > 3, `${file}: ${csv.name} has no rows`);
  const svg = await download(tab, figure.getByRole("button", { name: /^SVG/ }));
  check(svg.text.startsWith("<svg xmlns") && svg.text.includes('width="170mm"'), `${file}: ${svg.name} is no figure`);
  await tab.emulateMedia({ media: "print" });
  check(await figure.locator(".static svg").isVisible(), "print shows the static figure");
  check(!(await canvas.isVisible()), "print hides the interactive figure");
  if (pictures) await tab.pdf({ path: `${pictures}/${basename(resolve(file, ".."))}.pdf`, preferCSSPageSize: true }).catch(() => {});
  check(faults.length === 0, `${file}: ${faults.join("; ")}`);
  await context.close();
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
try {
  for (const file of words) {
    check(statSync(file).size < LARGEST, `${file} is larger than 5 MB`);
    let count = 0;
    for (const [width, scheme] of [[1280, "light"], [390, "dark"]]) count = await examine(browser, file, width, scheme);
    await use(browser, file);
    await move(browser, file);
    console.log(`${file}: ${count} figures`);
  }
} finally {
  await browser.close();
}
