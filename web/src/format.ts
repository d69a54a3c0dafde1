// Numbers for people: units with prefixes, and four digits.

const PREFIXES: [number, string][] = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
  [1e-12, "p"],
];

const UNITS: [ending: string, unit: string, prefixed: boolean][] = [
  ["_rad_per_m", "rad/m", false],
  ["_m_per_pa", "m/Pa", false],
  ["_rad", "rad", false],
  ["_pa", "Pa", true],
  ["_m", "m", true],
  ["_n", "N", true],
];

function superscript(text: string): string {
  return [...text].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
}

/** Writes a power of ten. */
export function power(exponent: number): string {
  return `10${superscript(String(exponent))}`;
}

/** Writes a number with a true minus sign. */
export function digits(value: number, count = 5): string {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (value !== 0 && (size < 1e-4 || size >= 1e6)) {
    const [factor, exponent] = value.toExponential(count - 1).split("e");
    return `${String(Number(factor)).replace("-", "−")} · ${power(Number(exponent))}`;
  }
  return String(Number(value.toPrecision(count))).replace("-", "−");
}

/** Writes a quantity with a prefix of its unit. */
export function quantity(value: number, unit: string, count = 4): string {
  if (!Number.isFinite(value)) return "–";
  const [factor, prefix] = PREFIXES.find(([factor]) => Math.abs(value) >= factor * (1 - 1e-9)) ?? [1, ""];
  return `${digits(value / factor, count)} ${prefix}${unit}`;
}

/** Returns name, value and interval of a result, by the ending of its key. */
export function row(key: string, value: unknown, interval: unknown): [name: string, value: string, interval: string] {
  const [ending, unit, prefixed] = UNITS.find(([ending]) => key.endsWith(ending)) ?? ["", "", false];
  const text = (number: unknown) => {
    if (typeof number !== "number") return number === null ? "undefined" : String(number);
    if (prefixed) return quantity(number, unit);
    return `${digits(number, 4)}${unit && ` ${unit}`}`;
  };
  const name = key.slice(0, key.length - ending.length).replaceAll("_", " ");
  return [name.charAt(0).toUpperCase() + name.slice(1), text(value), Array.isArray(interval) ? `${text(interval[0])} to ${text(interval[1])}` : ""];
}

/** Writes a fraction as a percentage. */
export function percent(fraction: number): string {
  const value = 100 * fraction;
  return `${value >= 10 || value === 0 ? value.toFixed(0) : digits(value, 2)} %`;
}
