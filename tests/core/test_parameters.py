"""A rule's parameters are checked by their types before it is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from swarmscout.core.errors import SelectorError
from swarmscout.core.parameters import check_parameters
from swarmscout.destinations.registry import BUILT_IN, make_selector


@dataclass
class Annotated:
    weight: float = 1.0
    count: int = 3
    name: str = "a"
    on: bool = True
    free: Any = None
    reach_m: float = 1.0


class ByDefault:
    def __init__(self, weight=1.0, count=3, name="a", on=True, free=None, reach_m=1.0):
        pass


@pytest.mark.parametrize("kind", [Annotated, ByDefault])
@pytest.mark.parametrize(
    ("key", "good", "bad"),
    [
        ("weight", [2, 0.5, -1.0], ["2", True, None, [1.0], np.nan, np.inf, -np.inf, 10**400]),
        ("count", [0, -2], [2.5, "2", True]),
        ("name", ["", "b"], [3, None]),
        ("on", [False], [0, "false"]),
        ("free", [None, "x", 3, [1]], [np.nan]),
        ("reach_m", [0, 3.5, 1e6], [-0.1, 1e7]),
    ],
)
def test_types(kind: type, key: str, good: list[Any], bad: list[Any]) -> None:
    for value in good:
        check_parameters("selector 'mine'", kind, {key: value}, SelectorError, lengths=True)
    for value in bad:
        with pytest.raises(SelectorError, match=f"selector 'mine': {key} = .*: expected") as caught:
            check_parameters("selector 'mine'", kind, {key: value}, SelectorError, lengths=True)
        assert "\n" not in str(caught.value)
    with pytest.raises(SelectorError, match=f"no parameter '{key}x': did you mean '{key}'"):
        check_parameters("selector 'mine'", kind, {f"{key}x": good[0]}, SelectorError)


def test_names_for_type_checkers_only_do_no_harm() -> None:
    class Odd:
        def __init__(self, weight: NoSuchName = 1.0, **more: Any) -> None:  # type: ignore  # noqa: F821
            pass

    check_parameters("selector 'odd'", Odd, {"weight": 2.0, "other": 3}, SelectorError)


@pytest.mark.parametrize("name", sorted(BUILT_IN))
def test_every_number_of_every_selector_is_checked(name: str) -> None:
    for key in getattr(BUILT_IN[name], "__dataclass_fields__", {}):
        for value in ("wide", float("nan"), float("inf"), None):
            with pytest.raises(SelectorError, match=f"selector '{name}': {key} = "):
                make_selector(name, {key: value})
