// Draws a map of values with the scale of its colours.

import { quantity } from "../format";

/** Cividis at equal steps: Nuñez, Anderton & Renslow, PLoS ONE 13 (2018) e0199239. */
const CIVIDIS = ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838"];
const MISSING = [127, 127, 127] as const;
const LEVELS = 256;

/** The colours of the scale, red, green and blue of each level. */
const SCALE = Array.from({ length: LEVELS }, (_, level) => {
  const place = (level / (LEVELS - 1)) * (CIVIDIS.length - 1);
  const left = Math.min(Math.floor(place), CIVIDIS.length - 2);
  const channel = (stop: number, at: number) => parseInt((CIVIDIS[stop] ?? "").slice(at, at + 2), 16);
  return [1, 3, 5].map((at) => channel(left, at) + (place - left) * (channel(left + 1, at) - channel(left, at)));
});

export interface MapData {
  nx: number;
  ny: number;
  dx_m: number;
  dy_m: number;
  values: Float64Array;
  unit: string;
  /** Quantity of the values. */
  name: string;
  /** Ends of the scale; the extremes of the values when left out. */
  range?: [number, number];
}

/** Returns the least and the largest value. */
export function extremes(values: Float64Array): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

/** A map on the page, with its size and its scale. */
export class MapView {
  private readonly canvas = document.createElement("canvas");
  private readonly caption = document.createElement("figcaption");
  private readonly scale = document.createElement("p");

  constructor(host: HTMLElement) {
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Map without values yet");
    this.scale.className = "ramp";
    const figure = document.createElement("figure");
    figure.className = "map";
    figure.append(this.canvas, this.scale, this.caption);
    host.append(figure);
  }

  show({ nx, ny, dx_m, dy_m, values, unit, name, range }: MapData) {
    const { canvas } = this;
    [canvas.width, canvas.height] = [nx, ny];
    canvas.style.aspectRatio = String((nx * dx_m) / (ny * dy_m));
    const context = canvas.getContext("2d");
    if (!context) return;
    const [low, high] = range ?? extremes(values);
    const image = context.createImageData(nx, ny);
    const factor = high > low ? (LEVELS - 1) / (high - low) : 0;
    values.forEach((value, index) => {
      const level = Math.min(Math.max(Math.round((value - low) * factor), 0), LEVELS - 1);
      const colour = Number.isNaN(value) ? MISSING : (SCALE[level] ?? MISSING);
      image.data.set([...colour, 255], 4 * index);
    });
    context.putImageData(image, 0, 0);
    const size = `${quantity(nx * dx_m, "m", 3)} × ${quantity(ny * dy_m, "m", 3)}`;
    const ends = [low, high].map((value) => quantity(value, unit, 3)) as [string, string];
    canvas.setAttribute("aria-label", `Map of the ${name}, ${size}, from ${ends[0]} to ${ends[1]}`);
    this.caption.textContent = `${name}, ${size}, ${nx} × ${ny} points`;
    const span = (text: string) => Object.assign(document.createElement("span"), { textContent: text });
    const bar = document.createElement("i");
    this.scale.replaceChildren(span(ends[0]), bar, span(ends[1]));
  }
}
