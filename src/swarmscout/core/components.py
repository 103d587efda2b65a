"""Components found by union-find, inside kernels."""

from __future__ import annotations

from swarmscout.core.jit import inlined

__all__ = ["root_of"]


@inlined
def root_of(parents, k):  # type: ignore[no-untyped-def]
    """The element that stands for the component of element k; paths get shorter on the way.

    Args:
        parents: int[n], written: a parent of each element, itself for those that stand for theirs.
        k: the element.
    """
    while parents[k] != k:
        parents[k] = parents[parents[k]]
        k = parents[k]
    return k
