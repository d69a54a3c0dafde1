// The figures of the surface, from the results of the module.

import type { Figure, Series } from "../figure";
import type { Result } from "../messages";
import { axis, BLUE, ORANGE, pen, RATIO, scaled } from "../motion";

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
