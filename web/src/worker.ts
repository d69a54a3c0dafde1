// Runs the module on a thread of its own. Ending the worker cancels the call.

import { type Answer, cycle, dimensionless, ensemble, initSync, limits, Surface } from "../build/asperity_wasm";
import type { Call, Reply, Request, Result, Start } from "./explorer/messages";

/** Points of the portrait of a limit cycle. */
const PORTRAIT_POINTS = 240;

let surface: Surface | undefined;

const post = (reply: Reply, moved: Transferable[] = []) => (self as unknown as Worker).postMessage(reply, moved);

Object.assign(globalThis, {
  asperityProgress: (task: string, done: number, total: number) => post({ progress: { task, done, total } }),
});

function taken(answer: Answer): Result {
  const arrays = Object.fromEntries(answer.names().map((name) => [name, answer.take(name)]));
  const numbers = JSON.parse(answer.json());
  answer.free();
  return { numbers, arrays };
}

function open(next: Surface): Result {
  surface?.free();
  surface = next;
  return taken(next.describe());
}

/** Converts a machine and calls the oscillator; the units of the machine join the numbers. */
function oscillator(settings: string, run: (parameters: unknown, length: number, rest: object) => Answer): Result {
  const { machine, ...rest } = JSON.parse(settings) as { machine: object };
  const { parameters, correlation_length, ...units } = taken(dimensionless(JSON.stringify(machine))).numbers;
  const { numbers, arrays } = taken(run(parameters, correlation_length, rest));
  return { numbers: { ...numbers, ...units }, arrays };
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
    case "spectrum":
      return taken(own().spectrum());
    case "twin":
      return taken(own().twin());
    case "contact":
      return taken(own().contact(call.settings));
    case "friction":
      return taken(own().friction(call.settings));
    case "cycle":
      return oscillator(call.settings, (parameters) => cycle(JSON.stringify(parameters), PORTRAIT_POINTS));
    case "limits":
      return oscillator(call.settings, (parameters) => limits(JSON.stringify(parameters)));
    case "ensemble":
      return oscillator(call.settings, (parameters, correlation_length, rest) =>
        ensemble(JSON.stringify({ parameters, correlation_length, ...rest })),
      );
  }
}

self.onmessage = ({ data }: MessageEvent<Start | Request>) => {
  if ("module" in data) {
    initSync({ module: data.module });
    return;
  }
  const { id, call } = data;
  try {
    const result = run(call);
    post(
      { id, result },
      Object.values(result.arrays).map((array) => array.buffer as ArrayBuffer),
    );
  } catch (error) {
    const broken = error instanceof WebAssembly.RuntimeError;
    post({ id, broken, error: broken ? "internal error; the console of the browser says where" : (error as Error).message });
  }
};
