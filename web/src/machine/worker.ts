// The worker of the machine in a report.

import { cycle, ensemble, initSync, limits, portrait, reattachment } from "../../build/oscillator/asperity_wasm";
import type { MotionCall } from "../messages";
import { moved, serve } from "../worker";

serve(initSync, (call) => moved({ cycle, limits, ensemble, portrait, reattachment }, call as MotionCall, JSON.parse((call as MotionCall).settings)));
