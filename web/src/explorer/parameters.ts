// The parameters of the page: what they are called, their units and ranges, and how the fragment of the address stores them.

import { accepted, type Choice, type Entry, type Parameter, type Slider, type Switch, type Value } from "../controls";

/** Inputs of a study, by `section.name`: their names for readers, and their defaults. */
declare const INPUTS: Record<string, { label: string; default: number | string | null }>;

/** Returns the label of an input of a study, or of a parameter that has its own. */
function named(name: string): { label: string; input?: string } {
  const input = INPUTS[name];
  return input ? { label: input.label.charAt(0).toUpperCase() + input.label.slice(1), input: name } : { label: name };
}

const slider = (name: string, unit: string, si: number, low: number, high: number, value: number, log = true): Slider => ({
  kind: "slider",
  ...named(name),
  unit,
  si,
  low,
  high,
  log,
  value,
});

const entry = (name: string, unit: string, si: number, low: number, high: number, value = Number(INPUTS[name]?.default ?? NaN)): Entry => ({
  kind: "number",
  ...named(name),
  unit,
  si,
  low,
  high,
  value,
});

/** Words for a machine whose friction varies like that of one window; it is the upscaling of stated friction. */
const ONE_WINDOW = "one window carries all";

/** Groups of parameters in the order of the page. Those of `more` are shown on request. */
export const PARAMETERS = {
  rms_height: slider("surface.rms_height", "µm", 1e-6, 0.05, 20, 0.2),
  length_x: slider("surface.correlation_length[0]", "µm", 1e-6, 2, 100, 20),
  length_y: slider("surface.correlation_length[1]", "µm", 1e-6, 2, 100, 20),
  hurst: slider("surface.hurst", "", 1, 0.05, 0.95, 0.8, false),
  size: entry("Side of the map", "µm", 1e-6, 10, 10000, 256),
  level: {
    kind: "choice",
    label: "Form to remove",
    options: [
      ["plane", "plane"],
      ["none", "none"],
      ["mean", "mean height"],
      ["quadratic", "quadratic"],
    ],
    value: "plane",
  } as Choice,
  control: {
    kind: "choice",
    label: "Pressed by",
    options: [
      ["pressure", "mean pressure"],
      ["penetration", "penetration"],
    ],
    value: "pressure",
  } as Choice,
  pressure: slider("Mean pressure", "MPa", 1e6, 0.5, 2000, 20),
  penetration: slider("Penetration below the highest point", "µm", 1e-6, 0.02, 20, 1),
  hardness: slider("material.hardness", "GPa", 1e9, 0.02, 20, 2),
  elastic: { kind: "switch", label: "Elastic: no hardness", value: false } as Switch,
  youngs_modulus: entry("material.youngs_modulus", "GPa", 1e9, 0.001, 2000, 210),
  poisson_ratio: entry("material.poisson_ratio", "", 1, 0, 0.5),
  shear_strength: entry("material.shear_strength", "MPa", 1e6, 0.01, 10000, 385),
  belt_velocity: slider("vibration.belt_velocity", "mm/s", 1e-3, 0.5, 5000, 23.7),
  damping: slider("vibration.damping_ratio", "", 1, 0, 0.8, 0.17, false),
  from_surface: { kind: "switch", label: "Friction of the surface", value: true } as Switch,
  upscaling: {
    kind: "choice",
    ...named("vibration.upscaling"),
    options: [
      ["area", "mean over the area"],
      ["paper", ONE_WINDOW],
    ],
    value: INPUTS["vibration.upscaling"]?.default,
  } as Choice,
  static_friction: slider("vibration.static_friction", "", 1, 0.01, 1.5, 0.1, false),
  variability: slider(`Variability of friction, ${ONE_WINDOW}`, "%", 1e-2, 0, 20, 1, false),
  friction_length: slider("vibration.friction_correlation_length", "µm", 1e-6, 5, 5000, 250),
  normal_force: entry("vibration.normal_force", "N", 1, 0.001, 1e7, 2500),
  mass: entry("vibration.mass", "kg", 1, 1e-6, 1e6, 1),
  frequency: entry("vibration.natural_frequency", "Hz", 1, 0.01, 1e5, 50.3),
  stribeck: entry("vibration.stribeck", "s/m", 1, 0, 1000, 0.531),
  trajectories: { ...entry("Runs of the ensemble", "", 1, 2, 10000, 100), whole: true } as Entry,
  duration: entry("Duration of a run", "s", 1, 0.001, 10000, 2),
  seed: { ...entry("Seed", "", 1, 0, 2 ** 32, 1), whole: true } as Entry,
} satisfies Record<string, Parameter>;

export type Key = keyof typeof PARAMETERS;
export type Values = { [K in Key]: (typeof PARAMETERS)[K]["value"] };

export const KEYS = Object.keys(PARAMETERS) as Key[];

export function defaults(): Values {
  return Object.fromEntries(KEYS.map((key) => [key, PARAMETERS[key].value])) as unknown as Values;
}

/** Returns the fragment that stores the values. */
export function fragment(values: Values): string {
  const text = (value: Value) => (typeof value === "boolean" ? (value ? "yes" : "no") : String(value));
  return new URLSearchParams(KEYS.map((key) => [key, text(values[key])])).toString();
}

/** Reads a fragment; what it does not state has its default. */
export function fromFragment(text: string): Values {
  const stated = new URLSearchParams(text.replace(/^#/, ""));
  const read = (key: Key) => [key, accepted(PARAMETERS[key], stated.get(key) ?? "")];
  return Object.fromEntries(KEYS.map(read)) as unknown as Values;
}

/** Returns a numeric value in SI units. */
export function si(values: Values, key: Key): number {
  const parameter: Parameter = PARAMETERS[key];
  return "si" in parameter ? Number(values[key]) * parameter.si : NaN;
}
