"""``python -m swarmscout``: the command line."""

from __future__ import annotations

import sys

from swarmscout.cli.app import main

sys.exit(main())
