#!/bin/sh
# Try an installed swarmscout from a folder without the clone: sh try_installed.sh FOLDER,
# with PYTHON naming the interpreter (relative to FOLDER).
set -eu
cd "$1"
unset PYTHONPATH
"$PYTHON" - <<'END'
from pathlib import Path

import swarmscout

here = Path(swarmscout.__file__).resolve()
assert "site-packages" in here.parts, f"not the installed package: {here}"
END
"$PYTHON" -m swarmscout --version
"$PYTHON" -m swarmscout list selectors
"$PYTHON" -m swarmscout worlds show lava-tube --out world.png
"$PYTHON" -m swarmscout explore --robots 5 --steps 30 --out run --page
"$PYTHON" -m swarmscout figures run
"$PYTHON" -m swarmscout explore run --out again --quiet
cmp run/map.png again/map.png
"$PYTHON" -m swarmscout view again --export again.html
"$PYTHON" -m swarmscout check nearest >/dev/null
"$PYTHON" -m swarmscout doctor
