// The worker of the explorer.

import { cycle, dimensionless, ensemble, initSync, limits, portrait, reattachment, Surface } from "../../build/asperity_wasm";
import type { Call, Result } from "../messages";
import { moved, serve, taken } from "../worker";

let surface: Surface | undefined;

function open(next: Surface): Result {
  surface?.free();
  surface = next;
  return { numbers: {}, arrays: {} };
}

function run(call: Call): Result {
  const own = () => {
    if (!surface) throw new Error("no surface is open");
    return surface;
  };
  switch (call.what) {
    case "open":
      return open(Surface.from_file(new Uint8Array(call.bytes), call.name, call.settings));
    case "state":
      return open(Surface.stated(call.settings));
    case "describe":
      return taken(own().describe(call.columns));
    case "spectrum":
      return taken(own().spectrum());
    case "twin":
      return taken(own().twin(call.columns));
    case "contact":
      return taken(own().contact(call.settings));
    case "friction":
      return taken(own().friction(call.settings));
    default: {
      const { machine, ...rest } = JSON.parse(call.settings) as { machine: object };
      const { parameters, process, ...units } = taken(dimensionless(JSON.stringify(machine))).numbers;
      return moved({ cycle, limits, ensemble, portrait, reattachment }, call, { parameters, process, units, ...rest });
    }
  }
}

serve(initSync, run);
