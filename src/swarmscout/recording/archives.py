"""Several files in one: zip archives whose bytes hold no clock."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["array_files", "zipped"]


def zipped(files: Mapping[str, bytes], stored: Mapping[str, bytes] | None = None) -> bytes:
    """A zip archive.

    Args:
        files: what is in it, by name; compressed quickly rather than well.
        stored: what is in it as it is, because it is compressed already.
    """
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        # A ZipInfo's date is 1980 unless another one is given; a bare name would get today's.
        for name, data in files.items():
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED, compresslevel=1)
        for name, data in (stored or {}).items():
            archive.writestr(zipfile.ZipInfo(name), data)
    return packed.getvalue()


def array_files(arrays: Mapping[str, ArrayLike]) -> dict[str, bytes]:
    """What an archive must hold so that ``numpy.load`` gives arrays by their names.

    ``numpy.savez_compressed`` makes such archives, too, but compresses for twice the time.
    """
    files = {}
    for name, array in arrays.items():
        file = io.BytesIO()
        np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
        files[f"{name}.npy"] = file.getvalue()
    return files
