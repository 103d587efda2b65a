"""The encodings by name: ways to write a leader's view down for a model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from swarmscout.destinations.llm.maps import encode_ascii, encode_cells, encode_rows
from swarmscout.destinations.llm.prompt_data import Encoded
from swarmscout.destinations.llm.tables import encode_clusters, encode_frontiers
from swarmscout.destinations.view import LeaderView

__all__ = ["ENCODINGS", "Encoder"]

Encoder = Callable[[LeaderView, int, NDArray[np.int64], str], Encoded]

ENCODINGS: dict[str, Encoder] = {
    "cells": encode_cells,
    "rows": encode_rows,
    "frontiers": encode_frontiers,
    "clusters": encode_clusters,
    "ascii": encode_ascii,
}
"""``cells`` is the paper's."""
