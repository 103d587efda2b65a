# %% [markdown]
# Curves of explored area, as cells of a notebook (VS Code and Jupytext read this format).

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import swarmscout as ss

STEPS = 200
runs = {
    name: ss.explore(robots=15, steps=STEPS, destinations=name, record="curves")
    for name in ("multi-criteria", "nearest", "quantile")
}

# %%
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for name, run in runs.items():
    axes.plot(run.coverage["step"], run.coverage["explored_m2"], label=name)
axes.set(xlabel="step", ylabel="explored area (m²)", ylim=(0, None))
axes.legend()

# %%
with tempfile.TemporaryDirectory() as folder:  # In a notebook the figure shows by itself.
    figure.savefig(Path(folder) / "curves.pdf")
    print(f"{(Path(folder) / 'curves.pdf').stat().st_size} bytes")
plt.close(figure)
