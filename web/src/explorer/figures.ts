// The figures of the page, from the results of the module.

import type { Axis, Figure, Pen, Series, Values } from "../figure";
import type { Result } from "./messages";

/** Colours that people with any colour vision tell apart: Okabe & Ito (2008). */
const BLUE = "#0072b2";
const ORANGE = "#d55e00";
const GREY = "#767676";
/** Width of a chart over its height. */
const RATIO = 1.7;

const pen = (colour: string, width = 1.8, opacity = 1, dash: number[] = []): Pen => ({ colour, width, opacity, dash });

/** Returns the axis that contains values, with a margin. */
function axis(label: string, values: Iterable<number>, margin = 0.05): Axis {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (!(low <= high)) [low, high] = [0, 1];
  const extra = margin * (high - low || Math.abs(high) || 1);
  return { label, low: low - extra, high: high + extra };
}

const scaled = (values: Float64Array, factor: number) => Array.from(values, (value) => value * factor);

export function spectrum({ numbers, arrays }: Result): Figure {
  const q = scaled(arrays.q_rad_per_m as Float64Array, 1e-6);
  const psd = scaled(arrays.psd_m4 as Float64Array, 1e24);
  const positive = psd.filter((value) => value > 0);
  const ends = (values: number[], wide: number) => ({ low: Math.min(...values) / wide, high: Math.max(...values) * wide, log: true });
  const [low, high] = [numbers.reliable_low_rad_per_m * 1e-6, numbers.reliable_high_rad_per_m * 1e-6];
  const series: Series[] = [
    { name: "reliable wavenumbers", mark: "region", low, high, colour: BLUE },
    { name: "mean over directions", mark: "line", x: q, y: psd, pen: pen(BLUE), discs: false },
  ];
  const x = { label: "wavenumber q (rad/µm)", ...ends(q, 1.1) };
  return { columns: 1, charts: [{ title: "", ratio: RATIO, x, y: { label: "power spectral density (µm⁴)", ...ends(positive, 2) }, series }] };
}

export function friction({ numbers, arrays }: Result): Figure {
  const s = scaled(arrays.position_m as Float64Array, 1e3);
  const mu = Array.from(arrays.friction as Float64Array);
  const series: Series[] = [
    { name: "one window", mark: "line", x: s, y: mu, pen: pen(BLUE), discs: false },
    { name: "mean", mark: "horizontal", at: numbers.mean, pen: pen(ORANGE, 1.6, 1, [6, 4]) },
  ];
  return {
    columns: 1,
    charts: [{ title: "", ratio: RATIO, x: axis("sliding distance s (mm)", s, 0), y: axis("friction coefficient μ", [...mu, numbers.mean], 0.15), series }],
  };
}

/** Points of one run in the arrays of an ensemble. */
const RUN_POINTS = 72;

/** Separates the curves of runs by gaps. */
function gapped(values: number[]): Values {
  return values.flatMap((value, at) => ((at + 1) % RUN_POINTS === 0 ? [value, null] : [value]));
}

/** Phase portrait of the machine: the limit cycle, and the ends of runs with fluctuating friction. */
export function portrait(cycle: Result, ensemble: Result | undefined, belt_m_per_s: number): Figure {
  const columns = ({ numbers, arrays }: Result) => [
    scaled(arrays.displacement as Float64Array, numbers.length_m * 1e3),
    scaled(arrays.velocity as Float64Array, numbers.velocity_m_per_s * 1e3),
  ];
  const [x = [], v = []] = columns(cycle);
  const [cloudX = [], cloudV = []] = ensemble ? columns(ensemble) : [];
  const belt = belt_m_per_s * 1e3;
  const series: Series[] = [
    { name: "runs with fluctuating friction", mark: "line", x: gapped(cloudX), y: gapped(cloudV), pen: pen(GREY, 0.8, 0.5), discs: false },
    { name: "limit cycle without fluctuation", mark: "line", x, y: v, pen: pen(BLUE, 2.2), discs: false },
    { name: "belt speed", mark: "horizontal", at: belt, pen: pen(ORANGE, 1.4, 1, [6, 4]) },
  ];
  return {
    columns: 1,
    charts: [
      {
        title: "",
        ratio: RATIO,
        x: axis("displacement x (mm)", [...x, ...cloudX]),
        y: axis("velocity (mm/s)", [...v, ...cloudV, belt, 0]),
        series,
      },
    ],
  };
}

/** Histogram of the displacements at re-attachment. */
export function reattachment({ numbers, arrays }: Result, deterministic: number | null): Figure {
  const unit = numbers.length_m * 1e3;
  const centres = scaled(arrays.reattachment as Float64Array, unit);
  const density = scaled(arrays.reattachment_density as Float64Array, 1 / unit);
  const width = (centres[1] ?? 0) - (centres[0] ?? 0);
  const edges = [...centres.map((centre) => centre - width / 2), ...centres.slice(-1).map((centre) => centre + width / 2)];
  const series: Series[] = [{ name: "runs with fluctuating friction", mark: "bars", edges, y: density, colour: BLUE }];
  if (deterministic !== null) {
    series.push({ name: "without fluctuation", mark: "vertical", at: deterministic * unit, pen: pen(ORANGE, 1.6, 1, [6, 4]) });
  }
  const x = axis("displacement at re-attachment (mm)", deterministic === null ? edges : [...edges, deterministic * unit]);
  return { columns: 1, charts: [{ title: "", ratio: RATIO, x, y: { ...axis("density (1/mm)", [0, ...density]), low: 0 }, series }] };
}
