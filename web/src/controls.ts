// Controls of parameters: sliders, numbers, choices and switches.

export interface Slider {
  kind: "slider";
  label: string;
  /** Input of a study that it states, `section.name`. */
  input?: string;
  /** Unit that people read; empty for a plain number. */
  unit: string;
  /** SI value of one unit. */
  si: number;
  low: number;
  high: number;
  /** Whether equal steps of the slider are equal ratios. */
  log: boolean;
  value: number;
}

export interface Entry extends Omit<Slider, "kind" | "log"> {
  kind: "number";
  whole?: boolean;
}

export interface Choice {
  kind: "choice";
  label: string;
  input?: string;
  options: [value: string, text: string][];
  value: string;
}

export interface Switch {
  kind: "switch";
  label: string;
  value: boolean;
}

/** Value of a control. */
export type Value = number | string | boolean;

export type Parameter = Slider | Entry | Choice | Switch;

/** Positions of a slider. */
export const STEPS = 1000;

export interface Control {
  element: HTMLElement;
  show(value: Value): void;
}

/** Returns the position of a value on its slider. */
export function position({ low, high, log }: { low: number; high: number; log: boolean }, value: number): number {
  const share = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * share);
}

/** Returns the value at a position of a slider, with three digits. */
function valueAt({ low, high, log }: { low: number; high: number; log: boolean }, place: number): number {
  const share = place / STEPS;
  return Number((log ? low * (high / low) ** share : low + share * (high - low)).toPrecision(3));
}

function make<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Record<string, string> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** Makes the control of a parameter; `changed` gets every new value. */
export function control(key: string, parameter: Parameter, changed: (value: Value) => void): Control {
  const id = `control-${key}`;
  const label = make("label", { for: id }, parameter.label);
  switch (parameter.kind) {
    case "switch": {
      const box = make("input", { id, type: "checkbox" });
      box.addEventListener("change", () => changed(box.checked));
      return { element: make("div", { class: "switch" }, box, label), show: (value) => (box.checked = value === true) };
    }
    case "choice": {
      const options = parameter.options.map(([value, text]) => make("option", { value }, text));
      const select = make("select", { id }, ...options);
      select.addEventListener("change", () => changed(select.value));
      return { element: make("div", { class: "field" }, label, select), show: (value) => (select.value = String(value)) };
    }
    default: {
      const unit = make("span", { class: "unit" }, parameter.unit);
      const number = make("input", { id, type: "number", step: "any", min: String(parameter.low), max: String(parameter.high) });
      number.addEventListener("change", () => changed(accepted(parameter, number.value)));
      const entered = make("span", { class: "entered" }, number, unit);
      if (parameter.kind === "number") {
        return { element: make("div", { class: "field" }, label, entered), show: (value) => (number.value = String(value)) };
      }
      const range = make("input", { type: "range", min: "0", max: String(STEPS), "aria-label": parameter.label });
      range.addEventListener("input", () => changed(valueAt(parameter, Number(range.value))));
      const show = (value: Value) => {
        number.value = String(value);
        range.value = String(position(parameter, Number(value)));
        range.setAttribute("aria-valuetext", `${value} ${parameter.unit}`.trim());
      };
      return { element: make("div", { class: "slider" }, label, entered, range), show };
    }
  }
}

/** Returns a value within the range of its parameter, or the default if it is none. */
export function accepted(parameter: Parameter, text: string): Value {
  switch (parameter.kind) {
    case "switch":
      return text === "yes" ? true : text === "no" ? false : parameter.value;
    case "choice":
      return parameter.options.some(([value]) => value === text) ? text : parameter.value;
    default: {
      const value = text.trim() === "" ? NaN : Number(text);
      if (!Number.isFinite(value)) return parameter.value;
      const inside = Math.min(Math.max(value, parameter.low), parameter.high);
      return parameter.kind === "number" && parameter.whole ? Math.round(inside) : inside;
    }
  }
}
