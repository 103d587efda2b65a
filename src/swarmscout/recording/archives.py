"""Several files in one: zip archives whose bytes hold no clock."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["npz", "zipped"]


def zipped(files: Mapping[str, bytes], level: int = 0) -> bytes:
    """A zip archive.

    Args:
        files: what is in it, by name.
        level: 0 stores the files as they are, 1 (quick) to 9 (small) compress them.
    """
    packed = io.BytesIO()
    how = zipfile.ZIP_DEFLATED if level else zipfile.ZIP_STORED
    with zipfile.ZipFile(packed, "w") as archive:
        for name, data in files.items():
            # A ZipInfo's date is 1980 unless another one is given; a bare name would get today's.
            archive.writestr(zipfile.ZipInfo(name), data, how, level or None)
    return packed.getvalue()


def npz(arrays: Mapping[str, ArrayLike]) -> bytes:
    """Arrays as ``numpy.savez_compressed`` writes them, in less than half of its time."""
    files = {}
    for name, array in arrays.items():
        file = io.BytesIO()
        np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
        files[f"{name}.npy"] = file.getvalue()
    return zipped(files, level=1)
