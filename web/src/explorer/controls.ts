// The controls of the parameters.

import { accepted, type Key, KEYS, type Parameter, PARAMETERS, type Values } from "./parameters";

/** Positions of a slider. */
const STEPS = 1000;

interface Control {
  element: HTMLElement;
  show(value: number | string | boolean): void;
}

function position({ low, high, log }: { low: number; high: number; log: boolean }, value: number): number {
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
function control(key: Key, changed: (value: number | string | boolean) => void): Control {
  const parameter: Parameter = PARAMETERS[key];
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
      number.addEventListener("change", () => changed(accepted(key, number.value)));
      const entered = make("span", { class: "entered" }, number, unit);
      if (parameter.kind === "number") {
        return { element: make("div", { class: "field" }, label, entered), show: (value) => (number.value = String(value)) };
      }
      const range = make("input", { type: "range", min: "0", max: String(STEPS), "aria-label": parameter.label });
      range.addEventListener("input", () => changed(valueAt(parameter, Number(range.value))));
      const show = (value: number | string | boolean) => {
        number.value = String(value);
        range.value = String(position(parameter, Number(value)));
        range.setAttribute("aria-valuetext", `${value} ${parameter.unit}`.trim());
      };
      return { element: make("div", { class: "slider" }, label, entered, range), show };
    }
  }
}

/** The controls of all parameters, in the elements of the page that name them in `data-parameters`. */
export class Controls {
  private readonly controls = new Map<Key, Control>();

  constructor(changed: (key: Key, value: number | string | boolean) => void) {
    for (const key of KEYS) this.controls.set(key, control(key, (value) => changed(key, value)));
    for (const host of document.querySelectorAll<HTMLElement>("[data-parameters]")) {
      const keys = (host.dataset.parameters ?? "").split(" ") as Key[];
      host.append(...keys.flatMap((key) => this.controls.get(key)?.element ?? []));
    }
  }

  show(values: Values) {
    for (const [key, own] of this.controls) own.show(values[key]);
  }

  /** Shows or hides a control. */
  reveal(key: Key, visible: boolean) {
    const own = this.controls.get(key);
    if (own) own.element.hidden = !visible;
  }
}
