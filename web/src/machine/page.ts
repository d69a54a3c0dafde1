// The machine of a report, which the reader moves with sliders.

import { control, type Control, type Slider } from "../controls";
import { Lane, workers } from "../engine";
import { Figure } from "../figure";
import { digits, percent, quantity } from "../format";
import type { Call, Result } from "../messages";

/** Largest number of runs of an ensemble on the page. */
const RUNS = 200;

interface Parameters {
  static_friction: number;
  law: object;
  damping_ratio: number;
  belt_velocity: number;
  forcing: object | null;
}

/** The content of machine.json. */
interface Machine {
  parameters: Parameters;
  process: ({ std: number } & Record<string, unknown>) | null;
  length_m: number;
  time_s: number;
  trajectories: number;
  [key: string]: unknown;
}

type Key = "damping" | "belt_velocity" | "friction" | "variability";

/** Units of the sliders in those of the values. */
const FACTORS: Partial<Record<Key, number>> = { belt_velocity: 1e-3, variability: 1e-2 };

/** Returns a slider around the value of the machine, which is shown with so many digits. */
function slider(label: string, unit: string, own: number, low: number, high: number, log = true, digits = 4): Slider {
  const value = Number(own.toPrecision(digits));
  return { kind: "slider", label, unit, si: 1, low: Math.min(low, value), high: Math.max(high, value), log, value };
}

function element(host: HTMLElement, selector: string): HTMLElement {
  const found = host.querySelector<HTMLElement>(selector);
  if (!found) throw new Error(`the page has no ${selector}`);
  return found;
}

class Page {
  private readonly sliders: Partial<Record<Key, Slider>>;
  private readonly controls = new Map<Key, Control>();
  private readonly own: Partial<Record<Key, number>>;
  private values: Partial<Record<Key, number>>;
  private readonly figures = new Map<string, Figure>();
  private readonly motion: Lane;
  private readonly runs: Lane;
  private readonly velocity_m_per_s: number;
  private cycle?: Result;
  private limits?: Result;
  private ensemble?: Result;

  constructor(
    private readonly host: HTMLElement,
    private readonly machine: Machine,
    start: Promise<() => Worker>,
  ) {
    const { parameters, process, length_m, time_s } = machine;
    const unit = length_m / time_s;
    this.velocity_m_per_s = unit;
    const mu = parameters.static_friction;
    this.own = {
      damping: parameters.damping_ratio,
      belt_velocity: parameters.belt_velocity * unit,
      friction: mu,
      ...(process && { variability: process.std / mu }),
    };
    this.values = { ...this.own };
    const speed = parameters.belt_velocity * unit * 1e3;
    this.sliders = {
      damping: slider("Damping ratio ζ", "", parameters.damping_ratio, 0, 1, false),
      belt_velocity: slider("Belt speed", "mm/s", speed, speed / 30, speed * 30),
      friction: slider("Mean friction coefficient μ", "", mu, mu / 3, 3 * mu),
      ...(process && { variability: slider("Variability of friction", "%", (100 * process.std) / mu, 0.01, 20, true, 2) }),
    };
    const watcher = {
      busy: () => this.showStatus(),
      progress: (_: string, done: number, total: number) => ((element(host, "progress") as HTMLProgressElement).value = done / total),
      broken: () => undefined,
    };
    this.motion = new Lane(start, watcher, ["cycle", "limits"]);
    this.runs = new Lane(start, watcher, ["ensemble"]);
    const place = element(host, ".controls");
    for (const [key, own] of Object.entries(this.sliders) as [Key, Slider][]) {
      const made = control(key, own, (value) => this.set(key, Number(value)));
      made.show(own.value);
      this.controls.set(key, made);
      place.append(made.element);
    }
    const reset = Object.assign(document.createElement("button"), { type: "button", textContent: "The machine of the study" });
    reset.addEventListener("click", () => this.reset());
    place.append(reset);
    element(host, "#moved-cancel").addEventListener("click", () => {
      this.runs.cancel();
      this.motion.cancel();
    });
    host.hidden = false;
    this.move();
  }

  private set(key: Key, value: number) {
    this.controls.get(key)?.show(value);
    this.values = { ...this.values, [key]: value * (FACTORS[key] ?? 1) };
    this.move();
  }

  private reset() {
    this.values = { ...this.own };
    for (const [key, own] of this.controls) own.show(this.sliders[key]?.value ?? NaN);
    this.move();
  }

  /** Returns the machine with the present values; those of the study unless a slider was moved. */
  private settings(): string {
    const { parameters, process, length_m, time_s, trajectories, ...rest } = this.machine;
    const { damping = NaN, belt_velocity = NaN, friction = NaN, variability = NaN } = this.values;
    return JSON.stringify({
      ...rest,
      trajectories: Math.min(trajectories, RUNS),
      parameters: {
        ...parameters,
        damping_ratio: damping,
        belt_velocity: belt_velocity / this.velocity_m_per_s,
        friction_factor: friction / parameters.static_friction,
      },
      process: process && { ...process, std: variability * friction },
      units: { length_m, time_s, velocity_m_per_s: this.velocity_m_per_s },
    });
  }

  /** Computes the motion with the present values. */
  private move() {
    const settings = this.settings();
    this.portray();
    this.call(this.motion, { what: "limits", settings }, (found) => (this.limits = found));
    if (!this.machine.process) return;
    this.call(this.runs, { what: "ensemble", settings }, (found) => {
      this.ensemble = found;
      this.portray();
    });
  }

  /** Computes the cycle, and draws it with the runs of the last ensemble. */
  private portray() {
    const call = { what: "cycle", settings: this.settings(), runs: this.ensemble?.arrays } as const;
    this.call(this.motion, call, (found) => (this.cycle = found));
  }

  private call(lane: Lane, call: Call, keep: (result?: Result) => void) {
    const problem = element(this.host, ".problem");
    lane.call(
      call,
      (result) => {
        keep(result);
        problem.hidden = true;
        this.show();
      },
      (message) => {
        keep(undefined);
        problem.textContent = message;
        problem.hidden = false;
      },
    );
  }

  private showStatus() {
    element(this.host, ".status").hidden = !this.runs.busy;
  }

  private show() {
    const { cycle, limits, ensemble, host } = this;
    if (!cycle) return;
    const { numbers } = cycle;
    const steady = numbers.limit_cycle ? "vibrates" : "slides steadily";
    const sentences: string[] = [];
    if (ensemble) {
      const { sustained_share, sustained_share_interval: range, trajectories } = ensemble.numbers;
      const [low, high] = range.map(percent);
      element(host, "#moved").textContent = `Vibration persists in ${percent(sustained_share)} of ${trajectories} runs from standstill (95 %: ${low} to ${high}).`;
      sentences.push(`Without fluctuation the machine ${steady}.`);
    } else {
      element(host, "#moved").textContent = `The machine ${steady}.`;
    }
    if (numbers.limit_cycle) sentences.push(`Its frequency is ${quantity(1 / (numbers.period * numbers.time_s), "Hz", 3)}.`);
    const limit = limits?.numbers.limit_damping_ratio;
    if (typeof limit === "number") sentences.push(`Vibration ends at a damping ratio of ${digits(limit, 3)}.`);
    element(host, "#moved-details").textContent = sentences.join(" ");
    host.dataset.numbers = JSON.stringify({ ...limits?.numbers, ...ensemble?.numbers, ...numbers, svg: undefined });
    this.draw("portrait", cycle);
    if (ensemble?.numbers.svg) this.draw("histogram", ensemble);
  }

  private draw(name: string, { numbers }: Result) {
    const figure = this.figures.get(name) ?? new Figure(element(this.host, `.${name}`));
    this.figures.set(name, figure);
    figure.replace(numbers.svg);
  }
}

/** Starts the machine of a report, if there is one and the browser can run it. */
export function start() {
  const host = document.getElementById("machine");
  const text = (id: string) => document.getElementById(id)?.textContent ?? "";
  const data = host?.querySelector("script")?.textContent;
  if (!host || !data) return;
  const start = workers(text("worker"), text("module"));
  start.then(
    () => {
      document.querySelector(".without-script")?.remove();
      return new Page(host, JSON.parse(data), start);
    },
    (error: Error) => {
      const note = document.querySelector(".without-script");
      if (note) note.textContent = `This browser cannot move the machine: ${error.message}`;
    },
  );
}
