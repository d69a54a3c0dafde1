// Makes a drawing of asperity-report interactive: values under the pointer and the arrow keys, curves on and off, zoom.

import { digits, power } from "./format";

/** Coordinates in the drawing: along x and y, or of both ends of something. */
type Point = [number, number];

const SPACE = "http://www.w3.org/2000/svg";
/** Coordinates are written in tenths of a pixel. */
const RESOLUTION = 0.1;
/** Largest magnification; these tenths begin to show. */
const MOST = 40;
/** Least length of a drag that zooms along an axis, in pixels. */
const LEAST_DRAG = 8;
const INK = "#222222";
const PAIR = /(-?[\d.]+),(-?[\d.]+)/g;

const both = (of: (which: 0 | 1) => number): Point => [of(0), of(1)];
/** The place at a part of the way between two ends, and the part of a place. */
const between = ([a, b]: Point, part: number) => a + part * (b - a);
const partOf = ([a, b]: Point, place: number) => (place - a) / (b - a);

function set(element: Element, attributes: Record<string, string | number>) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
}

/** Adds an element to a parent. */
function add(parent: Element, tag: string, attributes: Record<string, string | number>, text = ""): Element {
  const element = document.createElementNS(SPACE, tag);
  set(element, attributes);
  element.textContent = text;
  parent.append(element);
  return element;
}

/** One axis of a chart. A place is a coordinate of the drawing without zoom. */
class Axis {
  readonly label: string;
  private readonly spacing: string;
  /** Values at both ends, or their logarithms. */
  private readonly values: Point;
  private readonly texts: string[];
  private readonly ticks: Node[];
  /** Places of both ends of the part that is shown. */
  private view: Point;

  constructor(
    private readonly isX: boolean,
    private readonly group: SVGGElement,
    /** Places of both ends, the lower or left one first. */
    readonly ends: Point,
    /** Places of both ends of the other axis; the ticks are at the first. */
    private readonly across: Point,
  ) {
    const { label = "", spacing = "", from, to } = group.dataset;
    const value = (end?: string) => (spacing === "log" ? Math.log10(Number(end)) : Number(end));
    [this.label, this.spacing, this.values, this.view] = [label, spacing, [value(from), value(to)], ends];
    this.texts = [...group.querySelectorAll("text")].map(({ textContent }) => textContent ?? "");
    this.ticks = [...group.childNodes];
  }

  /** Equal axes, such as those of stacked charts, show the same part. */
  equals({ isX, values, ends }: Axis): boolean {
    return [isX, values, ends].join() === [this.isX, this.values, this.ends].join();
  }

  get zoomed(): boolean {
    return this.view !== this.ends;
  }

  /** Returns where a place is shown. */
  shown(place: number): number {
    return between(this.ends, partOf(this.view, place));
  }

  /** Returns the place that is shown at a coordinate. */
  placeAt(shown: number): number {
    return between(this.view, partOf(this.ends, shown));
  }

  /** Returns a coordinate between the ends. */
  inside(shown: number): number {
    return Math.min(Math.max(shown, Math.min(...this.ends)), Math.max(...this.ends));
  }

  private value(place: number): number {
    const scaled = between(this.values, partOf(this.ends, place));
    return this.spacing === "log" ? 10 ** scaled : scaled;
  }

  private placeOf(value: number): number {
    return between(this.ends, partOf(this.values, this.spacing === "log" ? Math.log10(value) : value));
  }

  /** Returns the value of a place with its label, in the digits that the drawing resolves. */
  text(place: number): string {
    const value = this.value(place);
    if (this.spacing === "names") return this.texts[Math.round(value)] ?? "";
    const next = this.value(place + RESOLUTION);
    return `${this.label}: ${this.spacing === "log" ? digits(value, 4) : fixed(value, next - value)}`;
  }

  /** Shows the part between two coordinates as they are shown, or all. */
  zoom(part?: Point) {
    const [first, last] = this.ends;
    const [a, b] = part ? both((end) => this.inside(this.placeAt(part[end]))) : this.ends;
    const magnified = (last - first) / (b - a);
    if (magnified > MOST) return;
    this.view = magnified < 1.001 ? this.ends : [a, b];
    this.group.replaceChildren(...(this.zoomed ? [] : this.ticks));
    if (this.zoomed) for (const [place, text] of this.round()) this.draw(this.shown(place), text);
  }

  private draw(at: number, text: string) {
    const { isX, group, across } = this;
    const [foot, end] = across;
    const line = (length: number, stroke: string, width: number) =>
      add(group, "line", { ...(isX ? { x1: at, x2: at, y1: foot, y2: foot + length } : { x1: foot, x2: foot + length, y1: at, y2: at }), stroke, "stroke-width": width });
    if (!group.parentElement?.querySelector(".image")) line(end - foot, "#e2e2e2", 0.8);
    line(isX ? 5 : -5, INK, 1);
    const place = isX ? { x: at, y: foot + 15, "text-anchor": "middle" } : { x: foot - 8, y: at, "text-anchor": "end" };
    if (this.texts.length > 0) add(group, "text", { ...place, dy: "0.5ex", "font-size": 13, fill: INK }, text);
  }

  /** Returns the places and the texts of round values in the part that is shown. */
  private round(): [place: number, text: string][] {
    const [low = 0, high = 0] = this.view.map((place) => this.value(place)).sort((a, b) => a - b);
    const whole = (low: number, high: number) => Array.from({ length: Math.max(Math.floor(high) - Math.ceil(low) + 1, 0) }, (_, i) => Math.ceil(low) + i);
    const tick = (value: number, text: string): [number, string] => [this.placeOf(value), text];
    if (this.spacing === "names") return whole(low, high).map((value) => tick(value, this.texts[value] ?? ""));
    if (this.spacing === "log" && high / low >= 20) {
      return whole(Math.log10(low), Math.log10(high)).map((exponent) => tick(10 ** exponent, Math.abs(exponent) < 4 ? digits(10 ** exponent) : power(exponent)));
    }
    const rough = (high - low) / 5;
    const decade = 10 ** Math.floor(Math.log10(rough));
    const step = decade * ([5, 2].find((factor) => factor * decade <= rough) ?? 1);
    return whole(low / step, high / step).map((index) => tick(index * step, fixed(index * step, step)));
  }
}

/** Writes a number with the decimals that differ between steps. */
function fixed(value: number, step: number): string {
  const decimals = Math.max(Math.ceil(-Math.log10(Math.abs(step)) - 1e-9), 0);
  return decimals < 9 && Math.abs(value) < 1e6 ? value.toFixed(decimals).replace("-", "−") : digits(value);
}

/** A shape of a series with its points, which a zoom moves. */
interface Shape {
  element: Element;
  points: Point[];
}

function shape(element: Element): Shape {
  if (element.tagName === "circle") return { element, points: [[Number(element.getAttribute("cx")), Number(element.getAttribute("cy"))]] };
  const text = element.getAttribute(element.tagName === "g" ? "transform" : "points") ?? "";
  return { element, points: [...text.matchAll(PAIR)].map(([, x, y]) => [Number(x), Number(y)]) };
}

/** A curve in pieces of connected points. */
interface Curve {
  name: string;
  pieces: Point[][];
}

let clips = 0;

/** One chart of a drawing. */
class Chart {
  readonly axes: [Axis, Axis];
  private readonly data: SVGGElement;
  private readonly isMap: boolean;
  private readonly shapes: Shape[];
  private readonly curves: Curve[];
  private readonly mark: Element;
  private readonly clip = `plot-${++clips}`;
  private curve = 0;
  private cursor = -1;

  constructor(
    group: SVGGElement,
    private readonly owner: Figure,
  ) {
    const [left = 0, top = 0, right = 0, bottom = 0] = (group.dataset.plot ?? "").split(" ").map(Number);
    const part = (selector: string) => group.querySelector(selector) as SVGGElement;
    this.axes = [new Axis(true, part("[data-axis=x]"), [left, right], [bottom, top]), new Axis(false, part("[data-axis=y]"), [bottom, top], [left, right])];
    this.data = part(".data");
    this.isMap = this.data.matches(".image");
    this.shapes = [...this.data.querySelectorAll(":scope > image, :scope > g > *")].map(shape);
    const curve = ({ dataset, children }: SVGGElement) => ({ name: dataset.series ?? "", pieces: this.pieces([...children].map(shape)) });
    const named = [...this.data.querySelectorAll<SVGGElement>("[data-series]:not([data-series=''])")];
    this.curves = named.map(curve).filter(({ pieces }) => pieces.length > 0);
    add(add(group, "clipPath", { id: this.clip }), "rect", { x: left, y: top, width: right - left, height: bottom - top });
    this.mark = add(group, "g", { class: "found" });
    const texts = [...group.querySelectorAll(":scope > text")].map(({ textContent }) => textContent);
    const names = new Set([...texts, ...this.axes.map(({ label }) => label)]);
    set(group, { role: "img", tabindex: 0, "aria-label": `Chart of ${[...names].filter(Boolean).join(", ")}. Arrow keys show values.` });
    group.addEventListener("keydown", (event) => this.press(event));
    group.addEventListener("blur", () => this.show());
  }

  /** Returns the points of a series that have values: discs and symbols; otherwise edges of areas that the plot does not cut; or lines. */
  private pieces(shapes: Shape[]): Point[][] {
    const points = shapes.filter(({ element }) => /^(circle|g)$/.test(element.tagName)).flatMap(({ points }) => points);
    if (points.length > 0) return [...new Map(points.map((point) => [point.join(), [point]])).values()];
    const isArea = ({ element }: Shape) => element.tagName === "polygon";
    const cut = ([a, b]: Point, [c, d]: Point) => a === c || (b === d && this.axes[1].ends.includes(b));
    const edges = shapes.filter(isArea).flatMap(({ points }) => points.slice(1).map((end, i): Point[] => [points[i] ?? end, end]));
    if (edges.length > 0) return edges.filter(([one, other]) => one && other && !cut(one, other));
    return shapes.map(({ points }) => points);
  }

  /** Reports whether a coordinate lies in the plot or at most a pixel beside it. */
  contains(shown: Point): boolean {
    return this.axes.every((axis, i) => Math.abs(axis.inside(shown[i as 0 | 1]) - shown[i as 0 | 1]) < 1);
  }

  private shown(point: Point): Point {
    return both((axis) => Math.round(100 * this.axes[axis].shown(point[axis])) / 100);
  }

  /** Moves all shapes to the part of the axes that is shown. */
  draw() {
    const zoomed = this.axes.some((axis) => axis.zoomed);
    if (zoomed) set(this.data, { "clip-path": `url(#${this.clip})` });
    else this.data.removeAttribute("clip-path");
    for (const { element, points } of this.shapes) {
      const moved = points.map((point) => this.shown(point));
      const [[x, y] = [0, 0]] = moved;
      if (element.tagName === "circle") set(element, { cx: x, cy: y });
      else if (element.tagName === "g") set(element, { transform: `translate(${x},${y})` });
      else if (element.tagName === "image") {
        const at = (place: number) => both((axis) => this.axes[axis].shown(place));
        const [from, to] = [at(0), at(1)];
        set(element, { transform: `matrix(${to[0] - from[0]},0,0,${to[1] - from[1]},${from.join()})` });
      } else set(element, { points: moved.join(" ") });
    }
    this.show();
  }

  private visible(): Curve[] {
    return this.curves.filter(({ name }) => !this.owner.hidden.has(name));
  }

  /** Shows the values of the point of a curve that is nearest to a shown point, or of this point on a map. */
  point(to: Point) {
    let best = { distance: this.isMap ? 10 : Infinity, name: "", at: this.isMap ? to : undefined };
    for (const { name, pieces } of this.visible()) {
      for (const piece of pieces) {
        let start = this.shown(piece[0] ?? to);
        for (const point of piece.length > 1 ? piece.slice(1) : piece) {
          const end = this.shown(point);
          const [x, y] = both((axis) => end[axis] - start[axis]);
          const part = Math.min(Math.max(((to[0] - start[0]) * x + (to[1] - start[1]) * y) / (x * x + y * y || 1), 0), 1);
          const at = both((axis) => between([start[axis], end[axis]], part));
          const distance = Math.hypot(at[0] - to[0], at[1] - to[1]);
          if (distance < best.distance && this.contains(at)) best = { distance, name, at };
          start = end;
        }
      }
    }
    const { name, at } = best;
    if (at) this.show({ name, point: both((axis) => this.axes[axis].placeAt(at[axis])) });
  }

  /** Shows the values of a point, or none. */
  show(found?: { name: string; point: Point }) {
    this.mark.replaceChildren();
    this.owner.say("");
    if (!found) return;
    const [x, y] = this.shown(found.point);
    const lines = [found.name, ...this.axes.map((axis, i) => axis.text(found.point[i as 0 | 1]))].filter(Boolean);
    add(this.mark, "circle", { cx: x, cy: y, r: 5, fill: "none", stroke: INK, "stroke-width": 1.5 });
    const [left, right] = this.axes[0].ends;
    const place = 2 * x > left + right ? { x: x - 10, "text-anchor": "end" } : { x: x + 10, "text-anchor": "start" };
    const first = Math.max(y - 16 * lines.length, this.axes[1].ends[1] + 16);
    lines.forEach((text, line) => add(this.mark, "text", { ...place, y: first + 16 * line, "font-size": 13, fill: INK }, text));
    this.owner.say(lines.join("; "));
  }

  private press(event: KeyboardEvent) {
    const curves = this.visible();
    const points = () => (curves[this.curve]?.pieces ?? []).flat().filter((point, i, all) => point !== all[i - 1]);
    const at = () => {
      const point = points()[this.cursor];
      return point ? this.shown(point) : both((axis) => 0.5 * (this.axes[axis].ends[0] + this.axes[axis].ends[1]));
    };
    const stride = event.shiftKey ? Math.max(1, Math.floor(points().length / 20)) : 1;
    const act = {
      ArrowRight: () => (this.cursor += stride),
      ArrowLeft: () => (this.cursor -= stride),
      Home: () => (this.cursor = 0),
      End: () => (this.cursor = Infinity),
      ArrowUp: () => (this.curve -= 1),
      ArrowDown: () => (this.curve += 1),
      "+": () => this.owner.zoomAround(this, at(), 0.5),
      "-": () => this.owner.zoomAround(this, at(), 2),
      Escape: () => this.owner.reset(),
    }[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
    this.curve = Math.min(Math.max(this.curve, 0), curves.length - 1);
    this.cursor = Math.min(Math.max(this.cursor, 0), points().length - 1);
    const point = points()[this.cursor];
    if (point) this.show({ name: curves[this.curve]?.name ?? "", point });
  }
}

/** A drawing on a page. */
export class Figure {
  readonly hidden = new Set<string>();
  private readonly output = document.createElement("output");
  private readonly resetButton = document.createElement("button");
  private charts: Chart[] = [];

  constructor(private readonly host: HTMLElement) {
    host.classList.add("drawing");
    // Charts take the focus from here on.
    host.removeAttribute("tabindex");
    Object.assign(this.resetButton, { type: "button", textContent: "Reset zoom", hidden: true });
    this.resetButton.addEventListener("click", () => {
      this.reset();
      this.focus(".chart");
    });
    host.append(this.output, this.resetButton);
    // Paper has the whole figure.
    addEventListener("beforeprint", () => this.reset());
    this.start();
  }

  /** Shows another drawing; curves that are off stay off. */
  replace(svg: string) {
    const held = document.activeElement;
    const inside = held !== null && this.host.contains(held);
    this.host.querySelector("svg")?.remove();
    this.host.insertAdjacentHTML("afterbegin", svg);
    this.resetButton.hidden = true;
    this.start();
    if (inside) this.focus(held.matches("[data-entry]") ? `[data-entry="${CSS.escape(held.getAttribute("data-entry") ?? "")}"]` : ".chart");
  }

  /** Moves the focus to a part of the drawing, or to its first chart. */
  private focus(selector: string) {
    const found = this.host.querySelector<SVGElement>(selector) ?? this.host.querySelector<SVGElement>(".chart");
    found?.focus({ preventScroll: true });
  }

  private start() {
    const svg = this.host.querySelector("svg");
    if (!svg) return;
    // The children of an image have no roles.
    set(svg, { role: "group" });
    // Browsers show a title over the values.
    svg.querySelector(":scope > title")?.remove();
    this.charts = [...svg.querySelectorAll<SVGGElement>(".chart")].map((group) => new Chart(group, this));
    for (const entry of svg.querySelectorAll<SVGGElement>("[data-entry]")) this.toggles(entry, entry.dataset.entry ?? "");
    this.listen(svg);
  }

  /** Makes an entry of the legend a button that turns its series on and off, if there is one. */
  private toggles(entry: SVGGElement, name: string) {
    const series = [...this.host.querySelectorAll<SVGGElement>("[data-series]")].filter(({ dataset }) => dataset.series === name);
    if (series.length === 0) return;
    const show = () => {
      const off = this.hidden.has(name);
      set(entry, { role: "button", tabindex: 0, "aria-pressed": String(!off) });
      for (const group of series) set(group, { display: off ? "none" : "inline" });
    };
    const toggle = () => {
      if (!this.hidden.delete(name)) this.hidden.add(name);
      show();
    };
    entry.addEventListener("click", toggle);
    entry.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      toggle();
    });
    show();
  }

  private listen(svg: SVGSVGElement) {
    let drag: { chart: Chart; from: Point; box: Element } | undefined;
    const fingers = new Map<number, Point>();
    const place = ({ clientX, clientY }: MouseEvent): Point => {
      const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM()?.inverse());
      return [x, y];
    };
    const show = (at: Point) => {
      const found = this.charts.find((chart) => chart.contains(at));
      for (const chart of this.charts) chart.show();
      found?.point(at);
      return found;
    };
    svg.addEventListener("pointerdown", (event) => {
      const from = place(event);
      const chart = show(from);
      if (event.pointerType === "touch") fingers.set(event.pointerId, from);
      if (!chart || event.pointerType === "touch" || event.button !== 0) return;
      svg.setPointerCapture(event.pointerId);
      drag = { chart, from, box: add(svg, "rect", { class: "box", fill: "#0072b2", opacity: 0.2 }) };
    });
    svg.addEventListener("pointermove", (event) => {
      const to = place(event);
      const before = fingers.get(event.pointerId);
      const [, other] = [...fingers].find(([id]) => id !== event.pointerId) ?? [];
      const chart = other && this.charts.find((chart) => chart.contains(other));
      if (before && chart) {
        const distance = ([x, y]: Point) => Math.max(Math.hypot(x - other[0], y - other[1]), 1);
        fingers.set(event.pointerId, to);
        return this.zoomAround(chart, other, distance(before) / distance(to));
      }
      if (!drag) return show(to);
      const { from, box } = drag;
      const [x, y] = both((axis) => Math.min(from[axis], to[axis]));
      set(box, { x, y, width: Math.abs(to[0] - from[0]), height: Math.abs(to[1] - from[1]) });
    });
    const end = (event: PointerEvent) => {
      const ended = drag;
      drag = undefined;
      fingers.delete(event.pointerId);
      ended?.box.remove();
      if (ended && event.type === "pointerup") this.zoom(ended.chart, ended.from, place(event), LEAST_DRAG);
      show(place(event));
    };
    svg.addEventListener("pointerup", end);
    svg.addEventListener("pointercancel", end);
    svg.addEventListener("pointerleave", () => this.charts.forEach((chart) => chart.show()));
    svg.addEventListener("dblclick", () => this.reset());
    svg.addEventListener("wheel", (event) => {
      const at = place(event);
      const chart = this.charts.find((chart) => chart.contains(at));
      if (!chart || !event.ctrlKey) return;
      event.preventDefault();
      this.zoomAround(chart, at, 1.2 ** Math.sign(event.deltaY));
    });
  }

  /** Shows the part of a chart between two shown points along the axes on which they are further apart; equal axes show the same part. */
  private zoom({ axes }: Chart, one: Point, other: Point, least = 0) {
    axes.forEach((axis, i) => {
      const [first, last] = axis.ends;
      const [a, b] = [one, other].map((point) => point[i as 0 | 1]).sort((a, b) => (a - b) * (last - first)) as Point;
      if (Math.abs(b - a) <= least) return;
      const equal = this.charts.flatMap((chart) => chart.axes).filter((other) => axis.equals(other));
      for (const other of equal) other.zoom([a, b]);
    });
    this.draw();
  }

  /** Shows a part that is larger by a factor around a shown point. */
  zoomAround(chart: Chart, at: Point, factor: number) {
    const corner = (end: 0 | 1) => both((axis) => at[axis] + factor * (chart.axes[axis].ends[end] - at[axis]));
    this.zoom(chart, corner(0), corner(1));
  }

  reset() {
    for (const { axes } of this.charts) axes.forEach((axis) => axis.zoom());
    this.draw();
  }

  private draw() {
    for (const chart of this.charts) chart.draw();
    this.resetButton.hidden = !this.charts.some(({ axes }) => axes.some((axis) => axis.zoomed));
  }

  say(text: string) {
    this.output.textContent = text;
  }
}
