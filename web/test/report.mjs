// Opens reports in a real browser: every figure draws, nothing is loaded, nothing fails, and the page is accessible.
//
// node test/report.mjs PAGE.html… [--pictures DIR]; CHROMIUM names the browser.

import { readFileSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, resolve } from "node:path";
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

/** What axe finds on a page. Its script needs a context without the policy of the page. */
async function accessibility(browser, page, options) {
  const context = await browser.newContext({ bypassCSP: true, ...options });
  const tab = await context.newPage();
  await tab.goto(page);
  await tab.evaluate(() => document.querySelectorAll("details").forEach((element) => (element.open = true)));
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
    console.log(`${file}: ${count} figures`);
  }
} finally {
  await browser.close();
}
