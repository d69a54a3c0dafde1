// What the workers share: they answer calls to the module on a thread of their own. Ending a worker cancels its call.

import type { Call, MotionCall, Reply, Request, Result, Start } from "./messages";

/** Points of the portrait of a limit cycle. */
const PORTRAIT_POINTS = 240;

interface Answer {
  json(): string;
  names(): string[];
  take(name: string): Float64Array;
  free(): void;
}

/** The calls of the oscillator in a module. */
interface Oscillator {
  cycle(parameters: string, points: number): Answer;
  limits(parameters: string): Answer;
  ensemble(request: string): Answer;
  portrait(x: Float64Array, v: Float64Array, runsX: Float64Array, runsV: Float64Array, lengthM: number, velocityMPerS: number, beltMPerS: number): string;
  reattachment(centres: Float64Array, density: Float64Array, without: number | undefined, lengthM: number): string;
}

/** Units of length, time and velocity in SI. */
interface Units {
  length_m: number;
  time_s: number;
  velocity_m_per_s: number;
}

/** Machine in the variables of the oscillator, with what an ensemble of it needs. */
export interface Motion {
  parameters: { belt_velocity: number };
  process: object | null;
  units: Units;
  [key: string]: unknown;
}

const post = (reply: Reply, moved: Transferable[] = []) => (self as unknown as Worker).postMessage(reply, moved);

/** Takes numbers and arrays out of an answer. */
export function taken(answer: Answer): Result {
  const arrays = Object.fromEntries(answer.names().map((name) => [name, answer.take(name)]));
  const numbers = JSON.parse(answer.json());
  answer.free();
  return { numbers, arrays };
}

const NONE = new Float64Array();
const columns = ({ displacement = NONE, velocity = NONE }: Result["arrays"]) => [displacement, velocity] as const;

/** Moves a machine; its units and the drawing join the numbers. */
export function moved(module: Oscillator, { what, runs = {} }: MotionCall, { units, parameters, ...rest }: Motion): Result {
  const { length_m, velocity_m_per_s } = units;
  const text = JSON.stringify(parameters);
  const answers = {
    cycle: () => module.cycle(text, PORTRAIT_POINTS),
    limits: () => module.limits(text),
    ensemble: () => module.ensemble(JSON.stringify({ parameters, ...rest })),
  };
  const { numbers, arrays } = taken(answers[what]());
  const { reattachment = NONE, reattachment_density = NONE } = arrays;
  const drawings = {
    cycle: () => module.portrait(...columns(arrays), ...columns(runs), length_m, velocity_m_per_s, parameters.belt_velocity * velocity_m_per_s),
    limits: () => "",
    ensemble: () => (reattachment.length > 0 ? module.reattachment(reattachment, reattachment_density, numbers.reattachment_displacement ?? undefined, length_m) : ""),
  };
  return { numbers: { ...numbers, ...units, svg: drawings[what]() }, arrays };
}

/** Answers the calls of the page. */
export function serve(start: (given: { module: WebAssembly.Module }) => unknown, run: (call: Call) => Result) {
  Object.assign(globalThis, {
    asperityProgress: (task: string, done: number, total: number) => post({ progress: { task, done, total } }),
  });
  self.onmessage = ({ data }: MessageEvent<Start | Request>) => {
    if ("module" in data) {
      start({ module: data.module });
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
}
