"""Prices of tokens, as data that users can replace."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

from swarmscout.core.errors import ModelError
from swarmscout.core.paths import expanded

__all__ = ["Prices", "load_prices"]

_DATED = re.compile(r"-\d{4}(-\d{2}-\d{2})?$")


@dataclass(frozen=True, slots=True)
class Prices:
    """Prices by model: US dollars per million tokens read and written."""

    models: dict[str, tuple[float, float]]

    def known(self, name: str) -> tuple[float, float] | None:
        """The price of a model, or None; a dated name has the price of the undated one."""
        return self.models.get(name) or self.models.get(_DATED.sub("", name))

    def cost_usd(
        self, names: Sequence[str], tokens_in: int | None, tokens_out: int | None
    ) -> float | None:
        """The cost of a call; None when the price or a count is not known.

        Args:
            names: the model's names, the most specific one first.
            tokens_in, tokens_out: tokens read and written.
        """
        price = next((found for name in names if (found := self.known(name)) is not None), None)
        if price is None or tokens_in is None or tokens_out is None:
            return None
        return (tokens_in * price[0] + tokens_out * price[1]) / 1e6


def load_prices(file: str = "") -> Prices:
    """Read a price table.

    Args:
        file: a TOML file; empty for the package's own.

    Raises:
        ModelError: the file cannot be read or holds no prices.
    """
    try:
        if file:
            text = expanded(file).read_text(encoding="utf-8")
        else:
            text = (resources.files("swarmscout.llm") / "prices.toml").read_text(encoding="utf-8")
        data = tomllib.loads(text)
        models = {
            str(name): (float(price["input"]), float(price["output"]))
            for name, price in data["models"].items()
        }
    except OSError as error:
        raise ModelError(f"price file '{file}' cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ModelError(f"price file '{file}' is not valid TOML: {error}") from None
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ModelError(
            f"price file '{file}': each model is a table [models.\"name\"] with input and output "
            "in US dollars per million tokens"
        ) from None
    if any(not price >= 0.0 for pair in models.values() for price in pair):
        raise ModelError(f"price file '{file}': a price is below 0")
    return Prices(models)
