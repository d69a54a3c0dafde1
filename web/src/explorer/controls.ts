// The controls of the explorer.

import { type Control, control, position, STEPS, type Value } from "../controls";
import { type Key, KEYS, PARAMETERS, type Values } from "./parameters";

const LIMIT = "limit";

/** The controls of all parameters, in the elements of the page that name them in `data-parameters`. */
export class Controls {
  private readonly controls = new Map<Key, Control>();

  constructor(changed: (key: Key, value: Value) => void) {
    for (const key of KEYS) this.controls.set(key, control(key, PARAMETERS[key], (value) => changed(key, value)));
    for (const host of document.querySelectorAll<HTMLElement>("[data-parameters]")) {
      const keys = (host.dataset.parameters ?? "").split(" ") as Key[];
      host.append(...keys.flatMap((key) => this.controls.get(key)?.element ?? []));
    }
  }

  show(values: Values) {
    for (const [key, own] of this.controls) own.show(values[key]);
  }

  /** Marks the limit of the damping ratio on its slider, with a text; no limit removes the mark. */
  markLimit(limit: number | undefined, text: string) {
    const slider = this.controls.get("damping")?.element;
    if (!slider) return;
    const place = position(PARAMETERS.damping, limit ?? NaN) / STEPS;
    slider.querySelector(`.${LIMIT}`)?.remove();
    if (limit === undefined) return;
    const mark = Object.assign(document.createElement("i"), { hidden: place > 1 });
    mark.style.setProperty("--place", String(place));
    const note = Object.assign(document.createElement("p"), { className: LIMIT, id: LIMIT });
    note.append(mark, text);
    slider.append(note);
    slider.querySelector("[type=range]")?.setAttribute("aria-describedby", LIMIT);
  }

  /** Shows or hides a control. */
  reveal(key: Key, visible: boolean) {
    const own = this.controls.get(key);
    if (own) own.element.hidden = !visible;
  }
}
