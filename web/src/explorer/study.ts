// Writes the parameters as a study file for `asperity run`.

import { type Parameter } from "../controls";
import { fragment, type Key, PARAMETERS, si, type Values } from "./parameters";

/** Standardised distribution of the friction of one window: figure 3 of the paper. */
export const MARGINAL = "beta:2.1,5";
/** Points of a strip, and of the window that slides along it. */
export const STRIP_POINTS: [number, number] = [1024, 128];
export const WINDOW_POINTS = 96;

export interface Scan {
  name: string;
  pixel_m?: number;
  height_unit?: string;
  channel?: string;
}

/** What the study takes from the results of the page. */
export interface Context {
  scan?: Scan;
  /** Distances between the points of the map in metre. */
  pitch_m: [number, number];
  boundary: string;
  mean_pressure_pa?: number;
}

/** Quotes a text for TOML. */
function quoted(text: string): string {
  const escaped = [...text].map((character) => {
    const code = character.codePointAt(0) ?? 0;
    if (character === '"' || character === "\\") return `\\${character}`;
    return code < 0x20 || code === 0x7f ? `\\u${code.toString(16).padStart(4, "0")}` : character;
  });
  return `"${escaped.join("")}"`;
}

/** Writes a number that TOML reads as a float. */
function float(value: number): string {
  const text = String(value);
  return /[.e]/.test(text) ? text : `${text}.0`;
}

/** States the parameters that are inputs, numbers with their unit in ASCII. */
function inputs(values: Values, ...keys: Key[]): string[] {
  return keys.map((key) => {
    const { input = key, unit = "" } = PARAMETERS[key] as Parameter & { input?: string; unit?: string };
    const name = input.slice(input.indexOf(".") + 1);
    const value = values[key];
    return `${name} = ${unit || typeof value === "string" ? quoted(`${value} ${unit.replace("µ", "u")}`.trim()) : float(Number(value))}`;
  });
}

const um = (metre: number) => quoted(`${Number((metre * 1e6).toPrecision(12))} um`);

/** Returns the text of the study. */
export function study(values: Values, { scan, pitch_m: [dx, dy], boundary, mean_pressure_pa }: Context): string {
  const size = (points: [number, number]) => `[${um(points[0] * dx)}, ${um(points[1] * dy)}]`;
  const pressed = values.control === "penetration" ? `penetration = ${um(si(values, "penetration"))}` : `mean_pressure = "${values.pressure} MPa"`;
  const lines = [
    "# Made by the surface explorer of asperity. Check it with `asperity check`, compute it with `asperity run`.",
    `# Address of the page: #${fragment(values)}`,
    `seed = ${values.seed}`,
    "",
    "[surface]",
    ...(scan
      ? [
          `file = ${quoted(scan.name)}`,
          ...(scan.channel === undefined ? [] : [`channel = ${quoted(scan.channel)}`]),
          ...(scan.pixel_m === undefined ? [] : [`pixel_size = ${um(scan.pixel_m)}`]),
          ...(scan.height_unit === undefined ? [] : [`height_unit = ${quoted(scan.height_unit)}`]),
          `level = ${quoted(String(values.level))}`,
        ]
      : [
          'covariance = "self_affine"',
          ...inputs(values, "rms_height", "hurst"),
          `correlation_length = ["${values.length_x} um", "${values.length_y} um"]`,
          'marginal = "normal"',
        ]),
    'generator = "spectral"',
    "",
    "[material]",
    ...inputs(values, "youngs_modulus", "poisson_ratio", "shear_strength", ...(values.elastic ? [] : ["hardness" as const])),
    "",
    "[pressure]",
    `size = ${size([64, 64])}`,
    "points = [64, 64]",
    `boundary = ${quoted(boundary)}`,
    pressed,
    "fine_solves = 200",
    "degree = 2",
    "",
    ...(values.from_surface
      ? [
          "[friction]",
          `strip = ${size(STRIP_POINTS)}`,
          `points = [${STRIP_POINTS.join(", ")}]`,
          `window = ${um(WINDOW_POINTS * dx)}`,
          'boundary = "periodic"',
          values.control === "penetration" ? `penetrations = [${um(si(values, "penetration"))}]` : `mean_pressures = ["${values.pressure} MPa"]`,
          "realisations = 8",
          "",
        ]
      : []),
    "[vibration]",
    ...inputs(values, "mass", "frequency", "damping", "normal_force", "belt_velocity", "stribeck"),
    `nominal_area = "${Number(((si(values, "normal_force") / (mean_pressure_pa ?? si(values, "pressure"))) * 1e6).toPrecision(12))} mm^2"`,
    ...(values.from_surface
      ? inputs(values, "upscaling")
      : [
          ...inputs(values, "static_friction", "friction_length"),
          `friction_std = ${float(Number((Number(values.static_friction) * si(values, "variability")).toPrecision(12)))}`,
          `friction_marginal = ${quoted(MARGINAL)}`,
          'upscaling = "paper"',
        ]),
    `trajectories = ${values.trajectories}`,
    `duration = ${float(Number((2 * Math.PI * Number(values.frequency) * Number(values.duration)).toPrecision(12)))}`,
  ];
  return `${lines.join("\n")}\n`;
}
