// Draws a figure on canvases: values under the pointer or the arrow keys, zoom, logarithmic axes, curves on and off.

import {
  Chart as Canvas,
  type ChartDataset,
  Filler,
  LinearScale,
  LineElement,
  LogarithmicScale,
  type Plugin,
  type Point,
  PointElement,
  type Scale,
  ScatterController,
  Title,
  Tooltip,
  type TooltipItem,
} from "chart.js";
import zoom from "chartjs-plugin-zoom";
import type { Axis, Chart, Colours, Figure, Pen, Series, Values } from "./figure";

Canvas.register(ScatterController, LineElement, PointElement, LinearScale, LogarithmicScale, Filler, Title, Tooltip, zoom);

type Dataset = ChartDataset<"scatter", Point[]>;

const SHAPES: Record<string, string> = {
  disc: "circle",
  ring: "circle",
  frame: "rect",
  diamond: "rectRot",
  open_diamond: "rectRot",
  cross: "crossRot",
  plus: "cross",
};
const HOLLOW = ["ring", "frame", "open_diamond"];

/** The colours of the page, read when a chart is drawn. */
function theme() {
  const style = getComputedStyle(document.documentElement);
  const of = (name: string, otherwise: string) => style.getPropertyValue(name).trim() || otherwise;
  const dark = matchMedia("(prefers-color-scheme: dark)").matches && !matchMedia("print").matches;
  return { ink: of("--ink", "#1d2329"), soft: of("--soft", "#56606a"), line: of("--line", "#d5dade"), card: of("--card", "#fff"), dark };
}

type Theme = ReturnType<typeof theme>;

/** A colour of the palette for the page: on a dark ground, dark colours become lighter and black becomes the ink. */
function shown(colour: string, { dark, ink }: Theme, opacity = 1): string {
  let rgb = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  if (dark) {
    const [r, g, b] = rgb as [number, number, number];
    const light = (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255;
    if (Math.max(r, g, b) < 40) return shown(hex(ink), { dark: false } as Theme, opacity);
    const share = Math.max(0, 0.55 - light);
    rgb = rgb.map((c) => Math.round(c + (255 - c) * share));
  }
  return `rgba(${rgb.join(",")},${opacity})`;
}

function hex(colour: string): string {
  return colour.length === 4 ? `#${[...colour.slice(1)].map((c) => c + c).join("")}` : colour;
}

/** Writes a number with a true minus sign. */
export function digits(value: number, count = 5): string {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const text =
    value !== 0 && (size < 1e-4 || size >= 1e6)
      ? value.toExponential(count - 2).replace(/\.?0+e/, "e").replace(/e\+?(-?)(\d+)/, (_, sign: string, power: string) => ` · 10${superscript(`${sign}${power}`)}`)
      : String(Number(value.toPrecision(count)));
  return text.replaceAll("-", "−");
}

function superscript(text: string): string {
  return [...text].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
}

function points(x: Values, y: Values): Point[] {
  return x.map((value, i) => ({ x: value ?? NaN, y: value === null ? NaN : (y[i] ?? NaN) }));
}

/** The curves of a series; marks that are not data are drawn by `marks`. */
function datasets(series: Series, page: Theme): Dataset[] {
  const base = { label: series.name, showLine: true, pointRadius: 0, pointHitRadius: 6, borderJoinStyle: "round" as const };
  const pen = ({ colour, width, dash, opacity }: Pen) => ({
    borderColor: shown(colour, page, opacity),
    borderWidth: width,
    borderDash: dash,
    backgroundColor: shown(colour, page),
  });
  switch (series.mark) {
    case "line":
      return [{ ...base, ...pen(series.pen), data: points(series.x, series.y), pointRadius: series.discs ? 3.2 : 0, pointBorderColor: page.card }];
    case "band": {
      const colour = shown(series.colour, page, 0.22);
      const edge = { ...base, borderWidth: 0, backgroundColor: colour, borderColor: colour };
      return [
        { ...edge, data: points(series.x, series.low) },
        { ...edge, data: points(series.x, series.high), fill: "-1" },
      ];
    }
    case "bars": {
      const outline = series.y.flatMap((y, i) => [0, 1].map((end) => ({ x: series.edges[i + end] ?? NaN, y: y ?? NaN })));
      const colour = shown(series.colour, page);
      return [{ ...base, data: outline, fill: "start", borderWidth: 0.8, borderColor: colour, backgroundColor: shown(series.colour, page, 0.3) }];
    }
    case "dots": {
      const colour = shown(series.colour, page, series.opacity);
      return [{ ...base, data: points(series.x, series.y), showLine: false, pointRadius: series.radius, borderWidth: 0, pointBackgroundColor: colour, backgroundColor: colour }];
    }
    case "symbol": {
      const colour = shown(series.colour, page);
      const inner = HOLLOW.includes(series.shape) ? "transparent" : colour;
      return [{ ...base, data: [{ x: series.x, y: series.y }], pointStyle: SHAPES[series.shape] ?? "circle", pointRadius: 5, pointBorderWidth: 1.8, pointBorderColor: colour, pointBackgroundColor: inner, borderColor: colour }];
    }
    case "span": {
      const ends = [series.low, series.high].map((x) => ({ x, y: series.y }));
      return [{ ...base, ...pen(series.pen), data: ends, borderCapStyle: "butt" }];
    }
    default:
      return [];
  }
}

/** Draws the backdrop, regions, lines across the chart and notes. */
function marks(view: Panel): Plugin<"scatter"> {
  const clipped = (canvas: Canvas<"scatter">, draw: (context: CanvasRenderingContext2D) => void) => {
    const { ctx, chartArea: area } = canvas as unknown as Canvas;
    ctx.save();
    ctx.beginPath();
    ctx.rect(area.left, area.top, area.width, area.height);
    ctx.clip();
    draw(ctx);
    ctx.restore();
  };
  return {
    id: "marks",
    beforeDatasetsDraw(canvas) {
      clipped(canvas as Canvas<"scatter">, (context) => {
        const { x, y } = canvas.scales as { x: Scale; y: Scale };
        const area = canvas.chartArea;
        const { backdrop } = view.chart;
        if (backdrop && view.image?.complete) {
          const [left, right] = backdrop.x.map((value) => x.getPixelForValue(value)) as [number, number];
          const [one, other] = backdrop.y.map((value) => y.getPixelForValue(value)) as [number, number];
          context.imageSmoothingEnabled = false;
          context.drawImage(view.image, left, Math.min(one, other), right - left, Math.abs(other - one));
        }
        for (const series of view.visible()) {
          if (series.mark !== "region") continue;
          context.fillStyle = shown(series.colour, view.page, 0.16);
          const [left, right] = [series.low, series.high].map((value) => x.getPixelForValue(Math.min(Math.max(value, x.min), x.max))) as [number, number];
          context.fillRect(left, area.top, right - left, area.height);
        }
      });
    },
    afterDatasetsDraw(canvas) {
      clipped(canvas as Canvas<"scatter">, (context) => {
        const { x, y } = canvas.scales as { x: Scale; y: Scale };
        const area = canvas.chartArea;
        const taken: [number, number, number][] = [];
        for (const series of view.visible()) {
          if (series.mark === "vertical" || series.mark === "horizontal") {
            context.beginPath();
            context.strokeStyle = shown(series.pen.colour, view.page, series.pen.opacity);
            context.lineWidth = series.pen.width;
            context.setLineDash(series.pen.dash);
            if (series.mark === "vertical") {
              const at = x.getPixelForValue(series.at);
              context.moveTo(at, area.bottom);
              context.lineTo(at, area.top);
            } else {
              const at = y.getPixelForValue(series.at);
              context.moveTo(area.left, at);
              context.lineTo(area.right, at);
            }
            context.stroke();
          } else if (series.mark === "note") {
            context.font = "12px system-ui, sans-serif";
            context.textAlign = "center";
            context.textBaseline = "middle";
            const half = context.measureText(series.text).width / 2 + 3;
            const at = Math.min(Math.max(x.getPixelForValue(series.x), area.left + half), area.right - half);
            const shift = view.image || view.chart.y.names ? 0 : 13;
            const above = Math.min(Math.max(y.getPixelForValue(series.y) - shift, area.top + 8), area.bottom - 8);
            // A note that would lie on another one is left out.
            if (taken.some(([x, y, width]) => Math.abs(at - x) < half + width && Math.abs(above - y) < 15)) continue;
            taken.push([at, above, half]);
            if (view.image) {
              context.fillStyle = "rgba(255,255,255,0.85)";
              context.fillRect(at - half, above - 8, 2 * half, 16);
            }
            context.fillStyle = view.image ? "#141414" : view.page.ink;
            context.fillText(series.text, at, above);
          }
        }
      });
    },
    afterEvent(_, { event }) {
      if (view.image && event.x !== null && event.y !== null) view.readMap(event.x, event.y);
    },
  };
}

/** One chart of a figure. */
class Panel {
  readonly canvas: Canvas<"scatter", Point[]>;
  image?: HTMLImageElement;
  page: Theme = theme();
  private pixels?: ImageData;
  private cursor = -1;

  constructor(
    host: HTMLElement,
    public chart: Chart,
    private readonly owner: FigureView,
    ratio: number,
  ) {
    const element = document.createElement("canvas");
    element.tabIndex = 0;
    element.setAttribute("role", "img");
    const holder = document.createElement("div");
    holder.className = "canvas";
    holder.append(element);
    host.append(holder);
    this.describe(element);
    this.loadImage();
    this.canvas = new Canvas<"scatter", Point[]>(element, {
      type: "scatter",
      data: { datasets: [] },
      options: {
        animation: false,
        normalized: true,
        parsing: false,
        responsive: true,
        aspectRatio: ratio,
        scales: this.scales() as never,
        interaction: { mode: "nearest", axis: "xy", intersect: false },
        plugins: {
          tooltip: {
            filter: (item) => item.dataset.label !== "" && Number.isFinite(item.parsed.y),
            callbacks: { title: () => "", label: (item) => this.label(item) },
            displayColors: false,
          },
          zoom: {
            zoom: {
              drag: { enabled: true, threshold: 8 },
              wheel: { enabled: true, modifierKey: "ctrl" },
              pinch: { enabled: true },
              mode: "xy",
              onZoomComplete: () => this.owner.zoomed(),
            },
          },
        },
      },
      plugins: [marks(this)],
    });
    element.addEventListener("keydown", (event) => this.step(event));
    element.addEventListener("dblclick", () => this.owner.reset());
    this.draw();
  }

  visible(): Series[] {
    return this.chart.series.filter((series) => !this.owner.hidden.has(series.name));
  }

  /** Draws the chart again with its present series, axes and colours. */
  draw() {
    this.page = theme();
    const { canvas, page } = this;
    // Chart.js draws the first data set last; here, as in the SVG, later series cover earlier ones.
    canvas.data.datasets = this.visible().flatMap((series) => datasets(series, page)).map((data, place) => ({ ...data, order: -place }));
    canvas.options.scales = this.scales() as never;
    const { title } = this.chart;
    canvas.options.plugins = {
      ...canvas.options.plugins,
      title: { display: title !== "", text: title, color: page.ink, align: "start" },
      tooltip: { ...canvas.options.plugins?.tooltip, backgroundColor: page.ink, bodyColor: page.card },
    };
    canvas.update("none");
    this.fit();
  }

  /** Gives a map one scale along both axes. */
  private fit() {
    const aspect = this.chart.backdrop?.aspect;
    const { width, height, chartArea: area } = this.canvas;
    if (aspect === undefined || !area) return;
    const wanted = width / (Math.min(Math.max(area.width * aspect, 40), 1.3 * width) + height - area.height);
    if (Math.abs(wanted / (width / height) - 1) > 0.01) {
      this.canvas.options.aspectRatio = wanted;
      this.canvas.resize();
    }
  }

  private scales() {
    const scale = (axis: Axis, log: boolean) => ({
      type: log ? ("logarithmic" as const) : ("linear" as const),
      min: log && axis.low <= 0 ? undefined : axis.low,
      max: axis.high,
      reverse: axis.downward ?? false,
      title: { display: axis.label !== "", text: axis.label, color: this.page.ink },
      grid: { color: this.chart.backdrop ? "transparent" : this.page.line },
      border: { color: this.page.soft },
      ticks: {
        color: this.page.ink,
        maxTicksLimit: 8,
        maxRotation: 0,
        // The ends of an axis are seldom round numbers.
        includeBounds: false,
        autoSkip: axis.names === undefined,
        callback: (value: number | string) => tick(axis, Number(value), log),
      },
      ...(axis.names && {
        afterBuildTicks: (own: Scale) => {
          own.ticks = (axis.names ?? []).map((_, value) => ({ value }));
        },
      }),
    });
    return { x: scale(this.chart.x, this.owner.log.x), y: scale(this.chart.y, this.owner.log.y) };
  }

  replace(chart: Chart) {
    this.chart = chart;
    this.describe(this.canvas.canvas);
    this.loadImage();
    this.draw();
  }

  /** Shows the value of the map below a place. */
  readMap(left: number, top: number) {
    const { backdrop, x, y } = this.chart;
    const { colours } = this.owner.figure;
    if (!backdrop || !this.image?.complete || !colours) return;
    const at = { x: this.canvas.scales.x?.getValueForPixel(left) ?? NaN, y: this.canvas.scales.y?.getValueForPixel(top) ?? NaN };
    this.pixels ??= read(this.image);
    const column = Math.floor(((at.x - backdrop.x[0]) / (backdrop.x[1] - backdrop.x[0])) * this.pixels.width);
    const up = (at.y - backdrop.y[0]) / (backdrop.y[1] - backdrop.y[0]);
    const row = Math.floor((y.downward ? up : 1 - up) * this.pixels.height);
    if (!(column >= 0 && column < this.pixels.width && row >= 0 && row < this.pixels.height)) return this.owner.say("");
    const place = 4 * (row * this.pixels.width + column);
    const value = this.owner.valueOf(this.pixels.data.slice(place, place + 3));
    const of = (axis: Axis, number: number) => `${axis.label}: ${digits(number, 4)}`;
    this.owner.say(`${of(x, at.x)}, ${of(y, at.y)}${value}`);
  }

  private loadImage() {
    this.pixels = undefined;
    const source = this.chart.backdrop?.image;
    if (source === undefined) {
      this.image = undefined;
    } else if (this.image?.src !== source) {
      this.image = new Image();
      this.image.onload = () => this.canvas?.draw();
      this.image.src = source;
    }
  }

  private describe(element: HTMLCanvasElement) {
    const { title, x, y, series } = this.chart;
    const names = [...new Set(series.map((one) => one.name))].filter((name) => name !== "").join(", ");
    element.setAttribute("aria-label", `${title || "Chart"}: ${y.label} over ${x.label}. ${names}. Arrow keys show values.`);
  }

  private label(item: TooltipItem<"scatter">): string {
    const { x, y } = this.chart;
    const name = y.names?.[Math.round(item.parsed.y ?? NaN)];
    const ordinate = name ?? `${y.label}: ${digits(item.parsed.y ?? NaN)}`;
    return `${item.dataset.label}: ${x.label}: ${digits(item.parsed.x ?? NaN)}; ${ordinate}`;
  }

  /** Moves the value that is shown from point to point, and from curve to curve. */
  private step(event: KeyboardEvent) {
    const direction = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (direction === undefined) return;
    event.preventDefault();
    const all = this.canvas.data.datasets.flatMap((data, datasetIndex) =>
      data.label === "" ? [] : data.data.flatMap((point, index) => (Number.isFinite(point.y) ? [{ datasetIndex, index }] : [])),
    );
    const stride = event.shiftKey ? Math.max(1, Math.floor(all.length / 20)) : 1;
    this.cursor = Math.min(Math.max(this.cursor + direction * stride, 0), all.length - 1);
    const active = all[this.cursor];
    if (!active) return;
    this.canvas.tooltip?.setActiveElements([active], { x: 0, y: 0 });
    this.canvas.setActiveElements([active]);
    this.canvas.update("none");
    const point = this.canvas.data.datasets[active.datasetIndex]?.data[active.index];
    const name = this.canvas.data.datasets[active.datasetIndex]?.label;
    if (point) this.owner.say(`${name}: ${this.chart.x.label}: ${digits(point.x ?? NaN)}; ${this.chart.y.label}: ${digits(point.y ?? NaN)}`);
  }
}

/** The label of a tick; minor ticks of a logarithmic axis have none. */
function tick(axis: Axis, value: number, log: boolean): string {
  if (axis.names) return axis.names[value] ?? "";
  if (!log) return digits(value, 6);
  const power = Math.log10(value);
  const decades = Math.log10(axis.high / axis.low);
  const first = Number(value.toExponential(0)[0]);
  const major = Math.abs(power - Math.round(power)) < 1e-9;
  if (!(major || (decades < 2 && (first === 2 || first === 5)))) return "";
  return Math.abs(power) <= 3 ? digits(value, 6) : major ? `10${superscript(String(Math.round(power)))}` : "";
}

function read(image: HTMLImageElement): ImageData {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
  const context = canvas.getContext("2d", { willReadFrequently: true }) as CanvasRenderingContext2D;
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

/** A figure on a page: its charts, a legend of buttons, and the value under the pointer. */
export class FigureView {
  readonly hidden = new Set<string>();
  readonly log: { x: boolean; y: boolean };
  private readonly panels: Panel[];
  private readonly legend = document.createElement("ul");
  private readonly tools = document.createElement("div");
  private readonly output = document.createElement("output");
  private readonly resetButton: HTMLButtonElement;
  private scale?: Map<string, number>;

  constructor(
    host: HTMLElement,
    public figure: Figure,
  ) {
    const [first] = figure.charts;
    this.log = { x: first?.x.log ?? false, y: first?.y.log ?? false };
    this.legend.className = "legend";
    this.tools.className = "tools";
    this.output.className = "value";
    this.resetButton = button("Reset zoom", () => this.reset());
    this.resetButton.hidden = true;
    const grid = document.createElement("div");
    grid.className = `panels columns-${figure.columns}`;
    host.append(this.legend, grid);
    if (figure.colours) host.append(this.colourBar(figure.colours));
    host.append(this.output, this.tools);
    this.panels = figure.charts.map((chart) => new Panel(grid, chart, this, Math.min(chart.ratio, host.clientWidth < 480 && !chart.backdrop ? 1.4 : Infinity)));
    this.fillLegend();
    for (const name of ["x", "y"] as const) {
      if (figure.charts.every((chart) => logarithmic(chart, name))) {
        const toggle = button(`Logarithmic ${name}`, () => {
          this.log[name] = !this.log[name];
          toggle.setAttribute("aria-pressed", String(this.log[name]));
          this.draw();
        });
        toggle.setAttribute("aria-pressed", String(this.log[name]));
        this.tools.append(toggle);
      }
    }
    this.tools.append(this.resetButton);
    for (const query of ["(prefers-color-scheme: dark)", "print"]) {
      matchMedia(query).addEventListener("change", () => this.draw());
    }
  }

  /** Shows other data in the same panels. */
  update(figure: Figure) {
    this.figure = figure;
    figure.charts.forEach((chart, i) => this.panels[i]?.replace(chart));
    this.fillLegend();
  }

  destroy() {
    this.panels.forEach((panel) => panel.canvas.destroy());
  }

  draw() {
    this.panels.forEach((panel) => panel.draw());
  }

  zoomed() {
    this.resetButton.hidden = !this.panels.some((panel) => panel.canvas.isZoomedOrPanned());
  }

  reset() {
    this.panels.forEach((panel) => panel.canvas.resetZoom("none"));
    this.zoomed();
  }

  say(text: string) {
    this.output.textContent = text;
  }

  /** The value of a colour of the scale, as text. */
  valueOf(colour: Uint8ClampedArray): string {
    const { colours } = this.figure;
    const place = this.scale?.get(colour.join());
    if (!colours || place === undefined) return "";
    return `; ${colours.axis.label}: ${digits(colours.axis.low + place * (colours.axis.high - colours.axis.low), 3)}`;
  }

  private fillLegend() {
    const all = this.figure.charts.flatMap((chart) => chart.series);
    const named = all.filter((series, place) => series.name !== "" && all.findIndex((other) => other.name === series.name) === place);
    const shownNames = [...this.legend.querySelectorAll("button")].map((element) => element.textContent).join();
    if (shownNames === named.map((series) => series.name).join()) return;
    this.legend.replaceChildren(
      ...named.map((series) => {
        const toggle = button(series.name, () => {
          if (!this.hidden.delete(series.name)) this.hidden.add(series.name);
          toggle.setAttribute("aria-pressed", String(!this.hidden.has(series.name)));
          this.draw();
        });
        toggle.setAttribute("aria-pressed", "true");
        toggle.prepend(sample(series));
        const item = document.createElement("li");
        item.append(toggle);
        if (series.mark === "patch") toggle.replaceWith(...toggle.childNodes);
        return item;
      }),
    );
  }

  private colourBar({ axis, image }: Colours): HTMLElement {
    const bar = document.createElement("p");
    bar.className = "colours";
    const canvas = Object.assign(document.createElement("canvas"), { height: 1 });
    const scale = new Image();
    scale.onload = () => {
      const { data, height } = read(scale);
      const colours = Array.from({ length: height }, (_, row) => data.slice(4 * row, 4 * row + 3));
      this.scale = new Map(colours.map((colour, row) => [colour.join(), 1 - row / (height - 1)]));
      canvas.width = height;
      const pixels = new ImageData(height, 1);
      colours.reverse().forEach((colour, at) => pixels.data.set([...colour, 255], 4 * at));
      canvas.getContext("2d")?.putImageData(pixels, 0, 0);
    };
    scale.src = image;
    const text = (value: string) => Object.assign(document.createElement("span"), { textContent: value });
    const holder = document.createElement("span");
    holder.className = "scale";
    holder.append(canvas);
    bar.append(text(axis.label), text(digits(axis.low, 3)), holder, text(digits(axis.high, 3)));
    return bar;
  }
}

/** Whether an axis may be logarithmic: numbers, all of them positive. */
function logarithmic(chart: Chart, name: "x" | "y"): boolean {
  const axis = chart[name];
  if (axis.names || chart.backdrop || chart.series.length === 0) return false;
  if (axis.log) return true;
  const values = chart.series.flatMap((series): Values => {
    if (series.mark === "line" || series.mark === "dots") return series[name];
    if (series.mark === "band") return name === "x" ? series.x : [...series.low, ...series.high];
    if (series.mark === "bars") return name === "x" ? series.edges : [0];
    return [];
  });
  return values.length > 0 && values.every((value) => value === null || value > 0);
}

function button(text: string, act: () => void): HTMLButtonElement {
  const element = document.createElement("button");
  element.type = "button";
  element.textContent = text;
  element.addEventListener("click", act);
  return element;
}

/** A sample of a series for its legend. */
function sample(series: Series): SVGSVGElement {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  for (const [name, value] of [["width", "28"], ["height", "12"], ["aria-hidden", "true"]] as const) svg.setAttribute(name, value);
  const add = (tag: string, attributes: Record<string, string | number>) => {
    const element = document.createElementNS(space, tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
    svg.append(element);
  };
  const page = theme();
  if ("pen" in series) {
    const { colour, width, dash } = series.pen;
    add("line", { x1: 0, x2: 28, y1: 6, y2: 6, stroke: shown(colour, page), "stroke-width": width, "stroke-dasharray": dash.join(" ") });
    if (series.mark === "line" && series.discs) add("circle", { cx: 14, cy: 6, r: 3.2, fill: shown(colour, page) });
  } else if (series.mark === "dots" || series.mark === "symbol") {
    add("circle", { cx: 14, cy: 6, r: 4, fill: shown(series.colour, page) });
  } else if ("colour" in series) {
    const opacity = series.mark === "patch" ? 1 : 0.4;
    add("rect", { x: 2, y: 0, width: 24, height: 12, fill: shown(series.colour, page), opacity });
  }
  return svg;
}
