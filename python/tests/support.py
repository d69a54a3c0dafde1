"""Places of the files that tests read."""

import os
import pathlib

ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(os.environ.get("ASPERITY_PROGRAM", ROOT / "target" / "debug" / "asperity"))
SCAN = ROOT / "studies" / "brake_disc.x3p"
