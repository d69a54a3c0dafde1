// The description of a figure, as `asperity-report` writes it beside every static one. Values are in the units of the axes.

/** Values of a curve; null where a value is undefined. */
export type Values = (number | null)[];

export interface Axis {
  /** Quantity with its unit. */
  label: string;
  low: number;
  high: number;
  log?: boolean;
  /** Values increase downward. */
  downward?: boolean;
  /** Names at 0, 1, … from the top, in place of numbers. */
  names?: string[];
}

export interface Pen {
  colour: string;
  width: number;
  /** Lengths drawn and left out in turn, in pixels. */
  dash: number[];
  opacity: number;
}

/** A series; without a name it is not in the legend. */
export type Series = { name: string } & (
  | { mark: "line"; x: Values; y: Values; pen: Pen; discs: boolean }
  | { mark: "band"; x: Values; low: Values; high: Values; colour: string }
  | { mark: "bars"; edges: Values; y: Values; colour: string }
  | { mark: "dots"; x: Values; y: Values; colour: string; radius: number; opacity: number }
  | { mark: "symbol"; x: number; y: number; shape: string; colour: string }
  | { mark: "span"; low: number; high: number; y: number; pen: Pen }
  | { mark: "region"; low: number; high: number; colour: string }
  | { mark: "vertical" | "horizontal"; at: number; pen: Pen }
  | { mark: "note"; x: number; y: number; text: string }
  | { mark: "patch"; colour: string }
);

/** An image behind the series, whose colours are values. */
export interface Backdrop {
  /** PNG as a data URI. */
  image: string;
  x: [number, number];
  y: [number, number];
  /** Height over width, where both axes have one scale. */
  aspect?: number;
}

export interface Chart {
  title: string;
  /** Width over height. */
  ratio: number;
  x: Axis;
  y: Axis;
  series: Series[];
  backdrop?: Backdrop;
}

/** Meaning of the colours of the backdrops. */
export interface Colours {
  axis: Axis;
  /** PNG of one column, from the high end to the low one. */
  image: string;
}

export interface Figure {
  columns: number;
  charts: Chart[];
  colours?: Colours;
}
