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

/** What the pixels of a figure show: of each chart, the share of its plot that differs from the most common colour, the names of its curves,
 * and those of curves with a halo whose colour no pixel has. */
const drawn = async (figure) => {
  const svg = figure.querySelector(".drawing svg");
  const image = new Image();
  image.src = `data:image/svg+xml,${encodeURIComponent(new XMLSerializer().serializeToString(svg))}`;
  await image.decode();
  const { width, height } = svg.viewBox.baseVal;
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0, width, height);
  return [...svg.querySelectorAll(".chart")].map((chart) => {
    const [left, top, right, bottom] = chart.dataset.plot.split(" ").map(Number);
    const { data } = context.getImageData(left, top, right - left, bottom - top);
    const counts = new Map();
    for (let i = 0; i < data.length; i += 4) {
      const colour = [0, 1, 2].map((k) => data[i + k]).join();
      counts.set(colour, (counts.get(colour) ?? 0) + 1);
    }
    const has = (colour) => [...counts.keys()].some((own) => own.split(",").every((c, k) => Math.abs(c - parseInt(colour.slice(2 * k + 1, 2 * k + 3), 16)) < 12));
    const curves = [...chart.querySelectorAll("[data-series]:not([data-series='']) > polyline")];
    const halo = (curve) => curve.parentElement.previousElementSibling?.querySelector("polyline[opacity='0.85']");
    const covered = curves.filter((curve) => halo(curve) && !has(curve.getAttribute("stroke")));
    const names = (found) => [...new Set(found.map((curve) => curve.parentElement.dataset.series))];
    // A line across the plot has two points, and the outlines of bars are no curves.
    const bent = curves.filter((curve) => curve.points.length > 2 && !curve.parentElement.querySelector("polygon"));
    return { share: 1 - Math.max(...counts.values()) / (data.length / 4), curves: names(bent), covered: names(covered) };
  });
};

/** Opens the folded entries of a page. */
const unfold = (tab) => tab.evaluate(() => document.querySelectorAll("details").forEach((element) => (element.open = true)));

/** Most printed pages of a report whose details are folded. */
const PRINTED = 6;

/** Checks that the verdict fills one screen, that a page prints on few sheets, and that its links open the folded entries. */
async function folded(browser, file) {
  const { context, tab } = await open(browser, pathToFileURL(resolve(file)).href, { viewport: { width: 1280, height: 900 } });
  const strip = (await tab.locator("nav.chain").count()) > 0 && (await tab.locator("nav.chain").boundingBox());
  check(!strip || strip.y < 900, `${file}: the pictures of the chain begin at ${strip.y} px, below the first screen`);
  await tab.keyboard.press("Tab");
  check(await tab.evaluate(() => document.activeElement.closest("nav.bar") !== null), `${file}: the first key Tab does not lead to the bar`);
  const path = pictures && `${pictures}/${basename(resolve(file, ".."))}.pdf`;
  const pdf = await tab.pdf({ ...(path && { path }), preferCSSPageSize: true });
  const sheets = pdf.toString("latin1").match(/\/Type\s*\/Page[^s]/g).length;
  check(sheets <= PRINTED, `${file} prints on ${sheets} sheets`);
  for (const link of await tab.locator(".further a").all()) {
    const entry = tab.locator(await link.getAttribute("href"));
    check(!(await entry.isVisible()), `${file}: ${await link.getAttribute("href")} is not folded`);
    await link.click();
    await entry.waitFor({ state: "visible" });
  }
  await context.close();
}

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
  await unfold(tab);
  await started(tab);
  await tab.waitForTimeout(300);
  await tab.evaluate(axe);
  const { violations } = await tab.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  await context.close();
  return violations;
}

async function examine(browser, file, width, colorScheme) {
  const page = pathToFileURL(resolve(file)).href;
  const { context, tab, faults } = await open(browser, page, { viewport: { width, height: 800 }, colorScheme });
  const what = `${file} at ${width} px, ${colorScheme}`;
  const wide = await tab.evaluate(() => document.documentElement.scrollWidth);
  check(wide <= width, `${what}: the page is ${wide} px wide`);
  await unfold(tab);
  const figures = await tab.locator("figure[id]").all();
  for (const figure of figures) {
    await figure.scrollIntoViewIfNeeded();
    await figure.locator(".chart[tabindex]").first().waitFor();
    const name = await figure.getAttribute("id");
    for (const { share, curves, covered } of await figure.evaluate(drawn)) {
      check(share > 0.004, `${what}: ${name} is empty: ${share}`);
      check(curves.length <= 6, `${what}: ${name} has ${curves.length} curves in a panel`);
      check(covered.length === 0, `${what}: ${name} has curves under their halos: ${covered}`);
    }
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

/** The number at the end of a text of the page. */
function number(text) {
  const plain = text.replace(/^.*: /, "").replaceAll("−", "-");
  const [, factor = "1", power] = plain.match(/^(?:(.*) · )?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)$/) ?? [undefined, plain, ""];
  return Number(factor) * 10 ** Number([...power].map((c) => (c === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c))).join(""));
}

/** The name of the curve and the numbers in the text that states a point. */
function stated(text) {
  const [name, x = "", y = ""] = text.split("; ");
  return { name, x: number(x), y: number(y) };
}

/** Uses a figure of one chart: legend, zoom, arrow keys, pointer and file. */
async function use(browser, file) {
  const page = pathToFileURL(resolve(file)).href;
  const { context, tab, faults } = await open(browser, page, { viewport: { width: 1280, height: 800 } });
  await unfold(tab);
  const id = await tab.evaluate(() => {
    const fits = (figure) => figure.querySelectorAll(".chart").length === 1 && figure.querySelector(".data:not(.image) [data-series]:not([data-series='']) > polyline");
    return [...document.querySelectorAll("figure[id]")].find(fits)?.id;
  });
  if (id === undefined) return context.close();
  const figure = tab.locator(`#${id}`);
  await figure.scrollIntoViewIfNeeded();
  const chart = figure.locator(".chart[tabindex]");
  await chart.waitFor();
  const data = () => chart.locator(".data").innerHTML();
  const said = async () => stated(await figure.locator("output").textContent());

  const entry = figure.locator("[data-entry][role=button]").first();
  const name = await entry.getAttribute("data-entry");
  const series = chart.locator(`[data-series=${JSON.stringify(name)}]`).first();
  await entry.locator("text").click();
  // A horizontal line has no height and counts as invisible.
  const isShown = () => series.evaluate((element) => getComputedStyle(element).display !== "none");
  check((await entry.getAttribute("aria-pressed")) === "false" && !(await isShown()), `${file}: ${name} is not off`);
  await entry.press("Enter");
  check((await entry.getAttribute("aria-pressed")) === "true" && (await isShown()), `${file}: ${name} is not on again`);

  const before = await data();
  const reset = figure.getByRole("button", { name: "Reset zoom" });
  const drag = async () => {
    const box = await figure.locator(".drawing svg").boundingBox();
    await tab.mouse.move(box.x + 0.4 * box.width, box.y + 0.4 * box.height);
    await tab.mouse.down();
    await tab.mouse.move(box.x + 0.7 * box.width, box.y + 0.6 * box.height, { steps: 4 });
    await tab.mouse.up();
    check((await data()) !== before && (await reset.isVisible()), `${file}: no zoom`);
  };
  for (const end of [() => reset.click(), () => chart.press("Escape"), () => figure.locator(".drawing svg").dblclick()]) {
    await drag();
    await end();
    check((await data()) === before && !(await reset.isVisible()), `${file}: the zoom stays`);
  }

  await chart.press("Home");
  for (let i = 0; i < 3; i++) await chart.press("ArrowRight");
  const first = await said();
  const mark = chart.locator(".found circle");
  const centre = async () => {
    const { x, y, width, height } = await mark.boundingBox();
    return { x: x + width / 2, y: y + height / 2 };
  };
  const close = (found, what) => {
    // A name in place of a number is NaN.
    const near = (axis, tolerance) => Object.is(found[axis], first[axis]) || Math.abs(found[axis] - first[axis]) <= tolerance * Math.abs(first[axis]) + 1e-9;
    check(near("x", 2e-3) && near("y", 2e-2), `${file}, ${id}: ${what} shows ${JSON.stringify(found)} instead of ${JSON.stringify(first)}`);
  };
  for (let i = 0; i < 3; i++) await chart.press("+");
  check((await data()) !== before, `${file}: the keyboard does not zoom`);
  check(JSON.stringify(await said()) === JSON.stringify(first), `${file}: a zoom changes a value`);
  // The numbers of the axes agree with the value of the point between them.
  for (const axis of ["x", "y"]) {
    const group = chart.locator(`[data-axis=${axis}]`);
    const spacing = await group.getAttribute("data-spacing");
    if (spacing === "names") continue;
    const ticks = await group.locator("text").evaluateAll((all, axis) => all.map((text) => [text.textContent, Number(text.getAttribute(axis))]), axis);
    const scale = (value) => (spacing === "log" ? Math.log(value) : value);
    const [[a, from], [b, to]] = [ticks[0], ticks.at(-1)].map(([text, at]) => [scale(number(text)), at]);
    const at = Number(await mark.getAttribute(`c${axis}`));
    const between = a + ((b - a) * (at - from)) / (to - from);
    check(ticks.length > 1 && Math.abs(between - scale(first[axis])) < 0.01 * Math.abs(b - a), `${file}, ${id}: ${axis} is ${between} between ${JSON.stringify(ticks)} instead of ${first[axis]}`);
  }
  const zoomed = await centre();
  await tab.mouse.move(zoomed.x, zoomed.y);
  close(await said(), "the pointer in a zoomed chart");
  await chart.press("Escape");

  const [download] = await Promise.all([tab.waitForEvent("download"), figure.getByRole("button", { name: /^SVG/ }).click()]);
  const path = join(dirname(resolve(file)), "figures", download.suggestedFilename());
  const texts = [await download.path(), path].filter(existsSync).map((own) => readFileSync(own, "utf8"));
  const same = await tab.evaluate((texts) => {
    // The page has narrower figures than the folder, of the same data.
    const [one, other = one] = texts.map((text) => new DOMParser().parseFromString(text, "image/svg+xml").documentElement);
    const contents = (svg) => [svg.querySelector("title").textContent, ...[...svg.querySelectorAll("[data-series]")].map(({ dataset }) => dataset.series)].join();
    return one.tagName === "svg" && contents(one) === contents(other);
  }, texts);
  check(same, `${file}: the saved figure is not ${path}`);
  await tab.emulateMedia({ media: "print" });
  check((await chart.isVisible()) && !(await figure.locator(".save").isVisible()), `${file}: print does not show the figure alone`);
  check(faults.length === 0, `${file}: ${faults.join("; ")}`);
  await context.close();
}

/** Units of the axes of known figures. */
const UNITS = { "": 1, "10⁻³": 1e-3, "rad/m": 1, "rad/mm": 1e3, "rad/µm": 1e6, "µm⁴": 1e-24 };

/** Compares the values of a curve with the table of its data, by arrow keys and under the pointer. */
async function compare(browser, file, id, curve, table, columns) {
  const path = join(dirname(resolve(file)), "tables", table);
  if (!existsSync(path)) return;
  const lines = readFileSync(path, "utf8").trim().split("\n").map((line) => line.split(","));
  const places = columns.map((column) => lines[0].indexOf(column));
  const { context, tab } = await open(browser, pathToFileURL(resolve(file)).href, { viewport: { width: 1280, height: 800 } });
  await unfold(tab);
  const figure = tab.locator(`#figure-${id}`);
  await figure.scrollIntoViewIfNeeded();
  const chart = figure.locator(".chart[tabindex]").first();
  const axes = await chart.evaluate((element) => ["x", "y"].map((name) => ({ ...element.querySelector(`[data-axis=${name}]`).dataset })));
  const units = axes.map(({ label }) => UNITS[label.match(/\((.*)\)$/)?.[1] ?? ""]);
  const known = lines.slice(1).map((line) => places.map((place, axis) => Number(line[place]) / units[axis]));
  // A coordinate is rounded to a tenth of a pixel, and the digits that are shown resolve it.
  const plot = (await chart.getAttribute("data-plot")).split(" ").map(Number);
  const part = [0.1 / (plot[2] - plot[0]), 0.1 / (plot[3] - plot[1])];
  const agree = (value, wanted, axis) => {
    const { spacing, from, to } = axes[axis];
    if (spacing === "log") return Math.abs(Math.log(value / wanted)) <= part[axis] * Math.abs(Math.log(to / from)) + 1e-3;
    return Math.abs(value - wanted) <= part[axis] * Math.abs(to - from);
  };
  const verify = (text, what) => {
    const { name, x, y } = stated(text);
    check(name === curve, `${id}: ${what} shows ${name}`);
    check(known.some((row) => agree(x, row[0], 0) && agree(y, row[1], 1)), `${id}: ${what} shows ${x}, ${y}, which is not in ${table}`);
  };
  const texts = await chart.evaluate((element, curve) => {
    const said = element.closest("figure").querySelector("output");
    const press = (key) => element.dispatchEvent(new KeyboardEvent("keydown", { key }));
    press("Home");
    for (let i = 0; i < 9 && !said.textContent.startsWith(`${curve};`); i++) press("ArrowDown");
    const found = [];
    while (found.at(-1) !== said.textContent) {
      found.push(said.textContent);
      press("ArrowRight");
    }
    return found;
  }, curve);
  check(texts.length > 8, `${id}: ${curve} has ${texts.length} points`);
  for (const text of texts) verify(text, "a key");
  // A curve that is off has no values.
  for (const other of await figure.locator("[data-entry][role=button]").all()) if ((await other.getAttribute("data-entry")) !== curve) await other.press("Enter");
  const output = figure.locator("output");
  const point = await chart.locator(".found circle").evaluate((circle) => ["cx", "cy"].map((name) => Number(circle.getAttribute(name))));
  await chart.dispatchEvent("blur");
  check((await output.textContent()) === "", `${id}: a figure without the focus shows the value of a key`);
  const find = () =>
    chart.locator(".data").evaluate((data, [x, y]) => {
      data.scrollIntoView({ block: "center" });
      const place = new DOMPoint(x, y).matrixTransform(data.ownerSVGElement.getScreenCTM());
      return [place.x, place.y];
    }, point);
  // What the page computes meanwhile moves the figure: only a point that kept its place was under the pointer.
  let place = await find();
  for (let tries = 0, kept = false; !kept && tries < 100; tries++) {
    await tab.waitForTimeout(100);
    await tab.mouse.move(...place);
    const now = await find();
    kept = now.join() === place.join() && (await output.textContent()) !== "";
    place = now;
  }
  verify(await output.textContent(), "the pointer");
  await context.close();
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
try {
  for (const file of words) {
    check(statSync(file).size < LARGEST, `${file} is larger than 5 MB`);
    let count = 0;
    for (const [width, scheme] of [[1280, "light"], [390, "dark"]]) count = await examine(browser, file, width, scheme);
    await folded(browser, file);
    await use(browser, file);
    if (basename(dirname(resolve(file))) === "run") {
      await compare(browser, file, "limit_cycle", "deterministic limit cycle", "limit_cycle.csv", ["displacement", "velocity"]);
      await compare(browser, file, "height_psd", "measured, radial", "height_psd_radial.csv", ["wavenumber_rad_per_m", "psd_m4"]);
    }
    await move(browser, file);
    console.log(`${file}: ${count} figures`);
  }
} finally {
  await browser.close();
}
