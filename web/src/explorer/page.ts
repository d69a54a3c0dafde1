// The page: parameters in, calls to the workers, results on the cards.

import { Controls } from "./controls";
import { Lane, type Watcher, workers } from "../engine";
import { Figure } from "../figure";
import { digits, percent, quantity, row } from "../format";
import type { Call, Result } from "../messages";
import { defaults, fragment, fromFragment, type Key, si, type Values } from "./parameters";
import { MARGINAL, type Scan, study, STRIP_POINTS, WINDOW_POINTS } from "./study";

/** Points of a stated map along a side. */
const MAP_POINTS = 256;
/** Strips of the friction coefficient. */
const STRIPS = 2;
/** Natural periods of the shortest run: a machine vibrates at the start, and may lose it after some periods. */
const LEAST_PERIODS = 20;
const ALIKE = "Friction does not fluctuate: all runs are alike.";

const SURFACE: Key[] = ["rms_height", "length_x", "length_y", "hurst", "size", "level"];
const CONTACT: Key[] = ["control", "pressure", "penetration", "hardness", "elastic", "youngs_modulus", "poisson_ratio"];
const FRICTION: Key[] = ["shear_strength", "normal_force"];
const CARDS = ["map", "pressure", "portrait", "probability", "friction", "reattachment", "spectrum", "statistics"] as const;
/** Parameters of the table of statistics; the others follow. */
const FIRST_STATISTICS = ["Sq_m", "Sa_m", "Sz_m", "Ssk", "Sku", "Sdq", "Sdr", "Sal_m", "Str", "correlation_length_x_m", "correlation_length_y_m", "hurst"];

type Card = (typeof CARDS)[number];

function element<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element ${id}`);
  return found as T;
}

function part(card: Card, selector: string): HTMLElement {
  const found = element(card).querySelector<HTMLElement>(selector);
  if (!found) throw new Error(`the card ${card} has no ${selector}`);
  return found;
}

const file = element<HTMLInputElement>("file");
const pixelSize = element<HTMLInputElement>("pixel-size");
const heightUnit = element<HTMLSelectElement>("height-unit");
const channel = element<HTMLSelectElement>("channel");

/** File with what the user states about it. */
interface Source extends Scan {
  bytes: ArrayBuffer;
}

/** Returns what the user states about a file. */
function stated(): Omit<Scan, "name"> {
  const pixel_m = Number(pixelSize.value) * 1e-6;
  return {
    ...(pixel_m > 0 && { pixel_m }),
    ...(heightUnit.value && { height_unit: heightUnit.value }),
    ...(channel.value && { channel: channel.value }),
  };
}

class Page {
  private values: Values = fromFragment(location.hash);
  /** File of the surface; none for a stated surface. */
  private scan?: Source;
  /** File that could not be read. */
  private rejected?: Source;
  /** Whether the worker has the surface. */
  private opened = false;
  private described?: Result;
  private contact?: Result;
  private friction?: Result;
  private cycle?: Result;
  private limits?: Result;
  /** The ensemble of the machine as it is; `null` without one, undefined while it is computed. */
  private ensemble?: Result | null;
  /** The machine that moves. */
  private moving?: object;
  private readonly controls = new Controls((key, value) => this.set(key, value));
  private readonly figures = new Map<Card, Figure>();
  private readonly motion: Lane;
  private readonly surface: Lane;
  /** Friction and twins take longer than a contact, and have a worker of their own. */
  private readonly strips: Lane;
  private readonly runs: Lane;
  private saving?: ReturnType<typeof setTimeout>;

  constructor(start: Promise<() => Worker>) {
    const watcher: Watcher = {
      busy: () => this.showStatus(),
      progress: (task, done, total) => this.showProgress(task, done, total),
      broken: () => (this.opened = false),
    };
    this.motion = new Lane(start, watcher, ["cycle", "limits"]);
    this.surface = new Lane(start, watcher, ["open", "state", "describe", "contact", "spectrum"]);
    this.strips = new Lane(start, watcher, ["open", "state", "friction", "twin"]);
    this.runs = new Lane(start, watcher, ["ensemble"]);
    this.listen();
    this.showControls();
    this.open();
    if (!this.values.from_surface) this.move();
  }

  private listen() {
    file.addEventListener("change", () => {
      const [chosen] = file.files ?? [];
      file.value = "";
      if (chosen) void this.take(chosen);
    });
    for (const name of ["dragenter", "dragover"]) {
      document.addEventListener(name, (event) => {
        event.preventDefault();
        document.body.classList.add("dragging");
      });
    }
    document.addEventListener("dragleave", (event) => {
      if (!event.relatedTarget) document.body.classList.remove("dragging");
    });
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      document.body.classList.remove("dragging");
      const [dropped] = event.dataTransfer?.files ?? [];
      if (dropped) void this.take(dropped);
    });
    for (const input of [pixelSize, heightUnit, channel]) {
      input.addEventListener("change", () => {
        const source = this.rejected ?? this.scan;
        if (source) this.open({ name: source.name, bytes: source.bytes, ...stated() });
      });
    }
    element("close").addEventListener("click", () => {
      this.scan = this.rejected = undefined;
      this.problem();
      this.open();
    });
    element("cancel").addEventListener("click", () => this.cancel());
    element("save").addEventListener("click", () => this.save());
    element("reset").addEventListener("click", () => this.replace(defaults()));
    element("controls").addEventListener("submit", (event) => event.preventDefault());
    addEventListener("hashchange", () => {
      if (location.hash.slice(1) !== fragment(this.values)) this.replace(fromFragment(location.hash));
    });
  }

  /** Changes one parameter, and computes what depends on it. */
  private set(key: Key, value: number | string | boolean) {
    this.values = { ...this.values, [key]: value };
    this.showControls();
    this.remember();
    const ofFriction = key === "seed" || FRICTION.includes(key);
    if (key === "seed" || SURFACE.includes(key)) this.open();
    else if (CONTACT.includes(key)) this.press();
    else if (ofFriction) this.slide();
    // Friction of the surface moves the machine when it is known.
    if (ofFriction ? !this.values.from_surface : !SURFACE.includes(key) && !CONTACT.includes(key)) this.move();
  }

  private replace(values: Values) {
    this.values = values;
    this.showControls();
    this.remember();
    this.open();
    this.move();
  }

  /** Stores the parameters in the address, at most a few times per second. */
  private remember() {
    clearTimeout(this.saving);
    this.saving = setTimeout(() => history.replaceState(null, "", `#${fragment(this.values)}`), 250);
  }

  private async take(chosen: File) {
    const bytes = await chosen.arrayBuffer();
    pixelSize.value = heightUnit.value = "";
    channel.replaceChildren();
    this.open({ name: chosen.name, bytes });
  }

  /** Opens the file or the stated surface; everything on the surface follows. */
  private open(source = this.scan) {
    const { surface, strips } = this;
    const failed = (message: string) => {
      if (!source) {
        this.report(message, "map", "pressure", "spectrum", "statistics");
        return this.loseFriction(message);
      }
      // The page keeps its surface, and names it. The user may state what the file lacks.
      this.rejected = source;
      this.problem(`${source.name}: ${message}\nThe page still shows ${this.scan?.name ?? "the stated surface"}.`);
      if (this.opened) this.current("map", "spectrum", "statistics", "pressure", "friction");
      else this.open();
    };
    const columns = matchMedia("(max-width: 760px)").matches ? 1 : 2;
    const described = (result: Result) => {
      [this.scan, this.rejected, this.opened, this.described] = [source, undefined, true, result];
      this.problem();
      this.showSurface(result);
      surface.call({ what: "spectrum" }, (found) => this.draw("spectrum", found), (error) => this.report(error, "spectrum"));
      strips.call(call, () => undefined, failed);
      const alone = (error: string) => (part("map", ".note").textContent += ` No random twin: ${error}.`);
      strips.call({ what: "twin", columns }, (found) => this.draw("map", found, this.mapNote(found)), alone);
      this.press();
    };
    const done = () => surface.call({ what: "describe", columns }, described, failed);
    this.stale("map", "spectrum", "statistics", "pressure", "friction");
    for (const lane of [surface, strips]) lane.drop(source ? "state" : "open");
    const call = this.opening(source);
    surface.call(call, done, failed);
  }

  /** Returns the call that opens a file or the stated surface. */
  private opening(source: Source | undefined): Call {
    const { values } = this;
    if (source) {
      const { name, bytes, pixel_m, height_unit, channel } = source;
      const settings = { seed: values.seed, level: values.level, height_unit, channel, ...(pixel_m && { pixel_size_m: [pixel_m, pixel_m] }) };
      return { what: "open", bytes, name, settings: JSON.stringify(settings) };
    }
    const side = si(values, "size");
    const settings = {
      seed: values.seed,
      points: [MAP_POINTS, MAP_POINTS],
      size_m: [side, side],
      boundary: "periodic",
      rms_height_m: si(values, "rms_height"),
      correlation_length_m: [si(values, "length_x"), si(values, "length_y")],
      hurst: values.hurst,
    };
    return { what: "state", settings: JSON.stringify(settings) };
  }

  private body() {
    const { values } = this;
    return {
      youngs_modulus_pa: si(values, "youngs_modulus"),
      poisson_ratio: values.poisson_ratio,
      hardness_pa: values.elastic ? null : si(values, "hardness"),
      [values.control === "penetration" ? "penetration_m" : "mean_pressure_pa"]: si(values, values.control as Key),
    };
  }

  /** Presses the map. */
  private press() {
    if (!this.opened) return this.open();
    const { boundary } = this.described?.numbers ?? {};
    const settings = { ...this.body(), boundary };
    this.stale("pressure");
    this.surface.call(
      { what: "contact", settings: JSON.stringify(settings) },
      (result) => {
        this.contact = result;
        this.showContact(result);
      },
      (message) => {
        this.contact = undefined;
        this.report(message, "pressure");
      },
    );
    this.slide();
  }

  /** Slides windows along strips. */
  private slide() {
    if (!this.opened) return this.open();
    const { dx_m, dy_m } = this.described?.numbers ?? {};
    const settings = {
      ...this.body(),
      strip_points: STRIP_POINTS,
      strip_m: [STRIP_POINTS[0] * dx_m, STRIP_POINTS[1] * dy_m],
      window_m: WINDOW_POINTS * dx_m,
      realisations: STRIPS,
      shear_strength_pa: si(this.values, "shear_strength"),
      normal_force_n: si(this.values, "normal_force"),
    };
    this.stale("friction");
    if (this.values.from_surface) this.stale("portrait", "probability", "reattachment");
    this.strips.call(
      { what: "friction", settings: JSON.stringify(settings) },
      (result) => {
        this.friction = result;
        this.showFriction(result);
        if (this.values.from_surface) this.move();
      },
      (message) => this.loseFriction(message),
    );
  }

  /** Shows why the surface has no friction. */
  private loseFriction(why: string) {
    this.friction = undefined;
    this.report(why, "friction");
    this.showLinked();
    if (this.values.from_surface) this.move();
  }

  private machine() {
    const { values } = this;
    const found = this.friction?.numbers;
    if (values.from_surface && !found) return undefined;
    const mean = Number(values.static_friction);
    const averaged = values.from_surface && values.upscaling === "area";
    const own = { mean, std: mean * si(values, "variability"), correlation_length_m: si(values, "friction_length") };
    const friction = values.from_surface ? { ...found, std: averaged ? found.area_std : found.std } : own;
    return {
      mass_kg: si(values, "mass"),
      natural_frequency_rad_per_s: this.angularFrequency(),
      normal_force_n: si(values, "normal_force"),
      damping_ratio: values.damping,
      belt_velocity_m_per_s: si(values, "belt_velocity"),
      static_friction: friction.mean,
      stribeck_s_per_m: values.stribeck,
      friction_correlation_length_m: friction.correlation_length_m ?? found.window_m,
      friction_std: friction.std,
      // The mean of many windows is normal.
      marginal: averaged ? "normal" : MARGINAL,
    };
  }

  private angularFrequency(): number {
    return 2 * Math.PI * Number(this.values.frequency);
  }

  /** Moves the machine. */
  private move() {
    const { values } = this;
    const machine = this.machine();
    // The last runs are of another machine.
    [this.moving, this.ensemble] = [machine, undefined];
    if (!machine) return this.stand("The friction of the surface is unknown.", "portrait", "probability", "reattachment");
    this.portray();
    this.motion.call(
      { what: "limits", settings: JSON.stringify({ machine }) },
      (result) => {
        this.limits = result;
        this.showVerdict();
      },
      () => {
        this.limits = undefined;
        this.showVerdict();
      },
    );
    this.stale("probability", "reattachment");
    const least = LEAST_PERIODS / Number(values.frequency);
    const short = `Runs shorter than ${LEAST_PERIODS} natural periods, ${quantity(least, "s", 3)}, do not show whether vibration persists.`;
    if (machine.friction_std === 0) return this.stand(ALIKE, "probability", "reattachment");
    if (si(values, "duration") < least) return this.stand(short, "probability", "reattachment");
    const request = {
      machine,
      trajectories: values.trajectories,
      duration: this.angularFrequency() * si(values, "duration"),
      seed: values.seed,
    };
    this.runs.call(
      { what: "ensemble", settings: JSON.stringify(request) },
      (result) => {
        if (this.moving !== machine) return;
        this.ensemble = result;
        this.showEnsemble(result);
      },
      (message) => this.moving === machine && this.stand(message, "probability", "reattachment"),
    );
  }

  /** Shows on cards why the machine has no runs. */
  private stand(why: string, ...cards: Card[]) {
    this.ensemble = null;
    this.report(why, ...cards);
    this.showVerdict();
  }

  /** Computes the cycle, and draws it with the runs of its ensemble. */
  private portray() {
    const machine = this.moving;
    if (!machine) return;
    this.motion.call(
      { what: "cycle", settings: JSON.stringify({ machine }), runs: this.ensemble?.arrays },
      (result) => {
        if (!this.moving) return;
        this.cycle = result;
        this.showMotion();
      },
      (message) => {
        this.cycle = undefined;
        this.report(message, "portrait");
        this.showVerdict();
      },
    );
  }

  private cancel() {
    for (const lane of [this.motion, this.surface, this.strips, this.runs]) lane.cancel();
    this.opened = false;
    this.ensemble ??= null;
    this.showVerdict();
    for (const card of CARDS) {
      if (element(card).classList.contains("stale")) part(card, ".note, .problem").textContent = "Cancelled; the card shows earlier parameters.";
    }
  }

  private save() {
    const { numbers } = this.described ?? {};
    if (!numbers) return;
    const text = study(this.values, {
      ...(this.scan && { scan: this.scan }),
      pitch_m: [numbers.dx_m, numbers.dy_m],
      boundary: numbers.boundary,
      mean_pressure_pa: this.friction?.numbers.mean_pressure_pa ?? this.contact?.numbers.mean_pressure_pa,
    });
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/toml" }));
    link.download = "study.toml";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  private showControls() {
    const { values, controls } = this;
    controls.show(values);
    controls.reveal("pressure", values.control === "pressure");
    controls.reveal("penetration", values.control === "penetration");
    controls.reveal("hardness", !values.elastic);
    for (const key of ["static_friction", "variability", "friction_length"] as const) controls.reveal(key, !values.from_surface);
    controls.reveal("upscaling", values.from_surface);
    this.showLinked();
  }

  private showLinked() {
    const { mean, correlation_length_m, std, area_std, nominal_area_m2 } = this.friction?.numbers ?? {};
    const varies = () =>
      `Its standard deviation is ${percent(std / mean)} over one window, ${percent(area_std / mean)} over the nominal area of ` +
      `${digits(nominal_area_m2 * 1e6, 3)} mm²; it correlates over ${quantity(correlation_length_m ?? NaN, "m", 3)}.`;
    const text = mean === undefined ? "" : `The surface gives μ = ${digits(mean, 3)}. ${std > 0 ? varies() : "It does not fluctuate."}`;
    element("linked").textContent = this.values.from_surface ? text : "The machine has the friction below, not that of the surface.";
  }

  private showStatus() {
    const status = element("status");
    const busy = [this.surface, this.strips, this.runs, this.motion].some((lane) => lane.busy);
    if (busy === !status.hidden) return;
    status.hidden = !busy;
    if (!busy) return;
    element("task").textContent = "Computing …";
    element("progress").removeAttribute("value");
  }

  private showProgress(task: string, done: number, total: number) {
    element("task").textContent = `Computing: ${task}`;
    element<HTMLProgressElement>("progress").value = done / total;
  }

  private stale(...cards: Card[]) {
    for (const card of cards) element(card).classList.add("stale");
  }

  private current(...cards: Card[]) {
    for (const card of cards) element(card).classList.remove("stale");
  }

  /** Marks a card as current, with a sentence below. */
  private settle(card: Card, note = "") {
    this.current(card);
    element(card).classList.remove("failed");
    part(card, ".problem").hidden = true;
    const sentence = element(card).querySelector(".note");
    if (sentence) sentence.textContent = note;
  }

  /** Shows an error on cards in place of their earlier results. */
  private report(message: string, ...cards: Card[]) {
    this.current(...cards);
    for (const card of cards) {
      element(card).classList.add("failed");
      const problem = part(card, ".problem");
      problem.classList.toggle("fact", message === ALIKE);
      problem.textContent = message;
      problem.hidden = false;
    }
  }

  /** Shows or hides the error of a file. */
  private problem(message?: string) {
    const problem = element("file-problem");
    problem.hidden = message === undefined;
    problem.textContent = message ?? "";
    element("scale").hidden = !message && !this.scan;
  }

  private draw(card: Card, { numbers }: Result, note = "") {
    const figure = this.figures.get(card) ?? new Figure(part(card, ".host"));
    this.figures.set(card, figure);
    figure.replace(numbers.svg);
    this.settle(card, note);
  }

  private showSurface(result: Result) {
    const { scan } = this;
    const { numbers } = result;
    element("scan").hidden = element("scale").hidden = !scan;
    element("stated").hidden = Boolean(scan);
    this.controls.reveal("size", !scan);
    element("scan-name").textContent = scan?.name ?? "";
    element("scan-format").textContent = numbers.format ?? "";
    const channels: string[] = numbers.channels ?? [];
    element("channel-field").hidden = channels.length < 2;
    channel.replaceChildren(...channels.map((name, at) => new Option(name, String(at + 1), false, name === numbers.channel)));
    part("map", "h2").textContent = scan ? `Surface: ${scan.name}` : "Stated surface";
    this.draw("map", result, this.mapNote(result));
    this.showStatistics(numbers.statistics);
  }

  /** Returns the size of the map and the warnings about it. */
  private mapNote({ numbers: { warnings } }: Result): string {
    const { nx, ny, dx_m, dy_m, statistics, warnings: own = [] } = this.described?.numbers ?? {};
    const missing = statistics.missing_points;
    return [
      `${quantity(nx * dx_m, "m", 3)} × ${quantity(ny * dy_m, "m", 3)}, ${nx} × ${ny} points.`,
      missing > 0 ? `${missing} heights (${percent(missing / (nx * ny))}) are missing; the contact fills them.` : "",
      ...new Set([...own, ...warnings]),
    ].join(" ");
  }

  private showStatistics(statistics: Record<string, unknown>) {
    const own = Object.keys(statistics).filter((key) => !/_(interval|se)$|^(nx|ny|dx_m|dy_m)$/.test(key));
    const keys = [...FIRST_STATISTICS, ...own.filter((key) => !FIRST_STATISTICS.includes(key))];
    const rows = keys.map((key) => {
      const [name, value, interval] = row(key, statistics[key] ?? null, statistics[`${key}_interval`]);
      const line = document.createElement("tr");
      const head = Object.assign(document.createElement("th"), { scope: "row", textContent: name });
      const cells = [value, interval].map((text) => Object.assign(document.createElement("td"), { textContent: text }));
      line.dataset.key = key;
      line.append(head, ...cells);
      return line;
    });
    part("statistics", "tbody").replaceChildren(...rows);
    part("statistics", "table").classList.toggle("plain", rows.every(({ lastChild }) => lastChild?.textContent === ""));
    this.settle("statistics");
  }

  private showContact(result: Result) {
    const { numbers } = result;
    const { contact_fraction_corrected: area, plastic_fraction: plastic, contact_fraction, mean_pressure_pa, penetration_m, whole, filled_points } = numbers;
    const yielded = this.values.elastic ? "" : ` (${percent(contact_fraction > 0 ? plastic / contact_fraction : 0)} of it at the hardness)`;
    const filled = filled_points > 0 ? ` ${filled_points} missing heights were filled with random ones that continue the map.` : "";
    this.draw(
      "pressure",
      result,
      `Contact on ${percent(area)} of the area${yielded} at a mean pressure of ${quantity(mean_pressure_pa, "Pa")} and a penetration of ` +
        `${quantity(penetration_m, "m")}.${whole ? "" : " The centre of the map was pressed."}${filled}`,
    );
    Object.assign(part("pressure", ".note").dataset, { numbers: JSON.stringify({ ...numbers, svg: undefined }) });
  }

  private showFriction(result: Result) {
    const { mean, mean_interval: interval, std, window_m, window_width_m } = result.numbers;
    const range = interval ? ` (95 %: ${digits(interval[0], 3)} to ${digits(interval[1], 3)})` : "";
    const size = `${quantity(window_m, "m", 3)} × ${quantity(window_width_m, "m", 3)}`;
    this.draw("friction", result, `Mean μ = ${digits(mean, 3)}${range}, standard deviation ${digits(std, 2)} over windows of ${size}.`);
    this.showLinked();
  }

  private showMotion() {
    const { cycle } = this;
    if (!cycle) return;
    const { numbers } = cycle;
    const kind = String(numbers.kind).replaceAll("_", "-");
    const note = numbers.limit_cycle
      ? `Without fluctuation: ${kind}, period ${quantity(numbers.period * numbers.time_s, "s")}, in slip for ${percent(numbers.slip_duration / numbers.period)} of it.`
      : "Without fluctuation every motion ends in steady sliding.";
    this.draw("portrait", cycle, note);
    Object.assign(part("portrait", ".note").dataset, { numbers: JSON.stringify({ ...numbers, svg: undefined }) });
    this.showVerdict();
  }

  private showEnsemble(result: Result) {
    const { numbers } = result;
    const [low, high] = numbers.sustained_share_interval as [number, number];
    element("share").textContent = `${percent(numbers.sustained_share)} (95 %: ${percent(low)} to ${percent(high)})`;
    element("share-bar").style.width = `${100 * numbers.sustained_share}%`;
    Object.assign(element("share-range").style, { left: `${100 * low}%`, width: `${100 * (high - low)}%` });
    const failures = numbers.failures ? ` ${numbers.failures} runs failed, the first: ${numbers.first_failure}.` : "";
    const clipped = numbers.clipped_fraction > 1e-6 ? ` ${percent(numbers.clipped_fraction)} of the friction values were clipped to stay positive.` : "";
    this.settle(
      "probability",
      `Percentage of ${numbers.trajectories} runs from standstill that vibrate for at least half of the second half of ${quantity(si(this.values, "duration"), "s", 3)}. ` +
        `On average they vibrate for ${percent(numbers.vibration_share)} of it, with ${digits(numbers.cycles_mean, 3)} cycles of stick-slip ` +
        `(${numbers.cycles_deterministic} without fluctuation).${failures}${clipped}`,
    );
    Object.assign(part("probability", ".note").dataset, { numbers: JSON.stringify({ ...numbers, svg: undefined }) });
    this.draw(
      "reattachment",
      result,
      numbers.svg
        ? `${numbers.reattachment_count} re-attachments: mean ${quantity(numbers.reattachment_mean * numbers.length_m, "m")}, ` +
            `standard deviation ${quantity(numbers.reattachment_std * numbers.length_m, "m")}, skewness ${digits(numbers.reattachment_skewness, 3)}.`
        : "No run sticks again.",
    );
    this.portray();
  }

  private showVerdict() {
    const { moving, cycle, limits, ensemble } = this;
    const verdict = element("verdict");
    const bold = (text: string) => Object.assign(document.createElement("b"), { textContent: text });
    const limit: number | undefined = (moving && limits?.numbers.limit_damping_ratio) ?? undefined;
    this.controls.markLimit(limit, `limit of vibration ${digits(limit ?? NaN, 4)}`);
    Object.assign(element("sub").dataset, { numbers: JSON.stringify(limits?.numbers ?? {}) });
    element("sub").textContent = "";
    verdict.className = "verdict";
    if (!moving || !cycle) return verdict.replaceChildren("The motion of the machine is unknown.");
    const { limit_cycle, period, time_s } = cycle.numbers;
    const share: number | undefined = ensemble?.numbers.sustained_share;
    if (ensemble === undefined) verdict.replaceChildren("Computing the runs with fluctuating friction …");
    else {
      const vibrates = share === undefined ? limit_cycle : share >= 0.5;
      verdict.classList.add(vibrates ? "vibrates" : "quiet");
      if (share === undefined) verdict.replaceChildren("The machine ", bold(vibrates ? "vibrates" : "slides steadily"), " with constant friction.");
      else verdict.replaceChildren("Fluctuating friction: ", bold(`${percent(share)} of runs vibrate.`));
    }
    const end = digits(limit ?? 0, 4);
    const stops = limit ? `, which a damping ratio above ${end} stops` : "";
    const starts = limit ? `; vibration at damping ratios below ${end}` : "";
    element("sub").textContent = `Constant friction: ${limit_cycle ? `vibration at ${quantity(1 / (period * time_s), "Hz", 3)}${stops}` : `steady sliding${starts}`}.`;
  }
}

declare const WORKER: string;
declare const VERSION: string;

element("version").textContent = VERSION;
const start = workers(WORKER, element("module").textContent ?? "");
new Page(start);
start.catch((error: Error) => {
  element("verdict").textContent = `This browser cannot run the explorer: ${error.message}`;
});

