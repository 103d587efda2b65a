"""A rule's parameters are checked by their types before it is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from swarmscout.core.errors import SelectorError
from swarmscout.core.parameters import check_arguments
from swarmscout.destinations.registry import SELECTORS, make_selector, selectors


@dataclass
class Annotated:
    weight: float = 1.0
    count: int = 3
    name: str = "a"
    on: bool = True
    free: Any = None


class ByDefault:
    def __init__(self, weight=1.0, count=3, name="a", on=True, free=None):
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
    ],
)
def test_types(kind: type, key: str, good: list[Any], bad: list[Any]) -> None:
    for value in good:
        check_arguments("selector 'mine'", kind, {key: value}, SelectorError)
    for value in bad:
        with pytest.raises(
            SelectorError, match=f"selector 'mine': {key} = .*: should be"
        ) as caught:
            check_arguments("selector 'mine'", kind, {key: value}, SelectorError)
        assert "\n" not in str(caught.value)
    with pytest.raises(SelectorError, match=f"no parameter '{key}x': did you mean '{key}'"):
        check_arguments("selector 'mine'", kind, {f"{key}x": good[0]}, SelectorError)


def test_names_for_type_checkers_only_do_no_harm() -> None:
    class Odd:
        def __init__(self, weight: NoSuchName = 1.0, **more: Any) -> None:  # type: ignore  # noqa: F821
            pass

    check_arguments("selector 'odd'", Odd, {"weight": 2.0, "other": 3}, SelectorError)


@pytest.mark.parametrize("name", sorted(selectors()))
def test_every_number_of_every_selector_is_checked(name: str) -> None:
    for key in getattr(SELECTORS.load(name), "__dataclass_fields__", {}):
        for value in ("wide", float("nan"), float("inf"), None):
            with pytest.raises(SelectorError, match=f"selector '{name}': {key} = "):
                make_selector(name, {key: value})
