// The controls of the explorer.

import { type Control, control, type Value } from "../controls";
import { type Key, KEYS, PARAMETERS, type Values } from "./parameters";

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

  /** Shows or hides a control. */
  reveal(key: Key, visible: boolean) {
    const own = this.controls.get(key);
    if (own) own.element.hidden = !visible;
  }
}
