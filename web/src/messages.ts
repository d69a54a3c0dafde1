// The messages between the page and its workers.

/** Calls of the module, with what they need. */
export type Call =
  | { what: "open"; bytes: ArrayBuffer; name: string; settings: string }
  | { what: "state"; settings: string }
  | { what: "spectrum" }
  | { what: "describe" | "twin"; columns: number }
  | { what: "contact" | "friction"; settings: string }
  | MotionCall;

/** Calls that move a machine. The portrait of its cycle also has the runs of an ensemble. */
export type MotionCall = { what: "cycle" | "limits" | "ensemble"; settings: string; runs?: Result["arrays"] };

export type What = Call["what"];

export interface Start {
  module: WebAssembly.Module;
}

export interface Request {
  id: number;
  call: Call;
}

/** Numbers of an answer, with the drawing of its figure as `svg`, and its arrays by name. */
export interface Result {
  // The module returns the keys of the command line.
  numbers: any;
  arrays: Record<string, Float64Array>;
}

export type Reply =
  | { id: number; result: Result }
  | { id: number; error: string; broken: boolean }
  | { progress: { task: string; done: number; total: number } };
