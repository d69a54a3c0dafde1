// The worker of the machine in a report.

import { cycle, ensemble, initSync, limits } from "../../build/oscillator/asperity_wasm";
import { moved, serve } from "../worker";

serve(initSync, (call) => {
  if (call.what !== "cycle" && call.what !== "limits" && call.what !== "ensemble") throw new Error(`no call ${call.what}`);
  return moved({ cycle, limits, ensemble }, call.what, JSON.parse(call.settings));
});
