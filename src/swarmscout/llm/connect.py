"""From settings to somebody who answers: provider, patience, cassette, limits."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Model
from swarmscout.core.paths import expanded
from swarmscout.llm.cassette import Cassette, Tape
from swarmscout.llm.dispatcher import Asker, Limits
from swarmscout.llm.embedded import Embedded, servers_at_once
from swarmscout.llm.openai_model import OpenAIModel
from swarmscout.llm.prices import load_prices
from swarmscout.llm.retry import Patient, Sender
from swarmscout.llm.settings import ModelSettings, find_endpoint

__all__ = ["connect", "make_model"]


def connect(
    settings: ModelSettings,
    *,
    model: Model | None = None,
    environ: Mapping[str, str] | None = None,
) -> Asker:
    """Make whoever answers a mission's questions.

    Args:
        settings: the scenario's.
        model: somebody's own model; None: the one that settings and environment name.
        environ: the environment; None: the process's.

    Raises:
        ModelError: no model is configured, or a cassette cannot be used; the message says what to
            do.
    """
    environ = os.environ if environ is None else environ
    name = type(model).__name__ if model is not None else ""
    if settings.max_cost_usd is not None and model is None:
        _check_price(settings, environ)
    if not settings.cassette:
        if settings.mode in ("record", "replay", "refresh"):
            raise ModelError(f"mode '{settings.mode}' needs a cassette: set --llm-cassette FILE")
        if model is None:
            model, name = make_model(settings, environ)
        return Asker(model, _limits(settings), name)
    path = expanded(settings.cassette)
    if settings.mode == "replay" and not path.exists():
        raise ModelError(f"cassette '{path}' does not exist: nothing can be replayed")
    tape = Tape(path)
    if settings.mode == "replay":
        model, name = None, settings.model or name or _sole_model(tape)
    elif model is None:
        try:
            model, name = make_model(settings, environ)
        except ModelError:
            if settings.mode != "auto" or not tape.entries:
                raise
            name = settings.model or _sole_model(tape)
    params = {"temperature": settings.temperature, "structured": settings.structured}
    return Asker(Cassette(tape, settings.mode, model, name, params), _limits(settings), name)


def make_model(settings: ModelSettings, environ: Mapping[str, str]) -> tuple[Model, str]:
    """The model that settings and environment name, and its name.

    Raises:
        ModelError: none is configured, or it is not installed.
    """
    endpoint = find_endpoint(settings, environ)
    form: dict[str, Any] = {
        "temperature": settings.temperature,
        "structured": settings.structured,
    }
    sender: Sender
    if endpoint.provider == "embedded":
        sender = Embedded(
            settings.embedded_model,
            endpoint.model,
            threads=settings.threads,
            servers=servers_at_once(),
            **form,
        )
    else:
        sender = OpenAIModel(endpoint, **form)
    prices = load_prices(settings.prices)
    patient = Patient(sender, endpoint.model, prices, tries=settings.tries, call_s=settings.call_s)
    return patient, endpoint.model


def _limits(settings: ModelSettings) -> Limits:
    # Who waits for a busy local server has not begun to ask: that time is not the decision's.
    concurrency = settings.concurrency
    if settings.provider == "embedded":
        concurrency = servers_at_once()
    return Limits(
        concurrency=concurrency,
        decision_s=settings.decision_s,
        breaker_failures=settings.breaker_failures,
        breaker_steps=settings.breaker_steps,
        max_calls=settings.max_calls,
        max_tokens=settings.max_tokens,
        max_cost_usd=settings.max_cost_usd,
    )


def _check_price(settings: ModelSettings, environ: Mapping[str, str]) -> None:
    name = settings.model
    if settings.mode != "replay":
        name = find_endpoint(settings, environ).model
    if name and load_prices(settings.prices).known(name) is None:
        raise ModelError(
            f"llm.max_cost_usd is set and no price is known for '{name}': give a file with "
            "llm.prices, see docs/llm.md"
        )


def _sole_model(tape: Tape) -> str:
    models = tape.models()
    if len(models) == 1:
        return models[0]
    if not models:
        raise ModelError(f"cassette '{tape.path}' is empty: nothing can be replayed")
    raise ModelError(
        f"cassette '{tape.path}' holds answers of {', '.join(models)}: say which with --llm-model"
    )
