"""The player with one mission's data in a single HTML file, to send to a colleague."""

import tempfile
from pathlib import Path

import swarmscout as ss
from swarmscout.viewing.player.export import export_page

STEPS = 100

run = ss.explore("lava-tube-small", robots=8, steps=STEPS)
with tempfile.TemporaryDirectory() as folder:
    page = export_page([run], Path(folder) / "mission.html")
    print(f"{page.name}: {page.stat().st_size / 1e6:.1f} MB; open it in any browser")
