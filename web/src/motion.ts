// The figures of the oscillator, from the results of the module.

import type { Axis, Figure, Pen, Series, Values } from "./figure";
import type { Result } from "./messages";

/** Colours that people with any colour vision tell apart: Okabe & Ito (2008). */
export const BLUE = "#0072b2";
export const ORANGE = "#d55e00";
const GREY = "#767676";
/** Width of a chart over its height. */
export const RATIO = 1.7;

export const pen = (colour: string, width = 1.8, opacity = 1, dash: number[] = []): Pen => ({ colour, width, opacity, dash });

/** Returns the axis that contains values, with a margin. */
export function axis(label: string, values: Iterable<number>, margin = 0.05): Axis {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (!(low <= high)) [low, high] = [0, 1];
  const extra = margin * (high - low || Math.abs(high) || 1);
  return { label, low: low - extra, high: high + extra };
}

export const scaled = (values: Float64Array, factor: number) => Array.from(values, (value) => value * factor);

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
