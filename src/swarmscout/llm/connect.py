"""From settings to a dispatcher: provider, retries, cassette, limits."""

from __future__ import annotations

import os
from collections.abc import Mapping

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Model
from swarmscout.core.paths import expanded
from swarmscout.llm.cassette import Cassette, Tape
from swarmscout.llm.dispatcher import Dispatcher
from swarmscout.llm.embedded import Embedded, servers_at_once
from swarmscout.llm.openai_model import OpenAIModel
from swarmscout.llm.prices import load_prices
from swarmscout.llm.retry import RetryingModel, Sender
from swarmscout.llm.settings import LlmSettings, find_endpoint

__all__ = ["connect", "make_model"]


def connect(
    settings: LlmSettings,
    *,
    model: Model | None = None,
    environ: Mapping[str, str] | None = None,
) -> Dispatcher:
    """Make the dispatcher that answers a mission's questions.

    Args:
        settings: the scenario's.
        model: a model of one's own; None: the one that settings and environment name.
        environ: environment variables; None: the process's.

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
        return Dispatcher(model, _limits(settings), name)
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
    params: dict[str, object] = {
        "temperature": settings.temperature,
        "structured": settings.structured,
    }
    if settings.effort:
        params["effort"] = settings.effort
    return Dispatcher(Cassette(tape, settings.mode, model, name, params), _limits(settings), name)


def make_model(settings: LlmSettings, environ: Mapping[str, str]) -> tuple[Model, str]:
    """The model that settings and environment name, and its name.

    Raises:
        ModelError: none is configured, or it is not installed.
    """
    endpoint = find_endpoint(settings, environ)
    sender: Sender
    call_s = settings.call_s
    if endpoint.provider == "embedded":
        # A time limit would make decisions depend on the machine's speed.
        call_s = float("inf")
        sender = Embedded(
            settings.embedded_model,
            endpoint.model,
            threads=settings.threads,
            temperature=settings.temperature,
            structured=settings.structured,
            servers=servers_at_once(),
        )
    else:
        sender = OpenAIModel(
            endpoint,
            temperature=settings.temperature,
            structured=settings.structured,
            effort=settings.effort,
        )
    prices = load_prices(settings.prices)
    model = RetryingModel(sender, endpoint.model, prices, tries=settings.tries, call_s=call_s)
    return model, endpoint.model


def _limits(settings: LlmSettings) -> LlmSettings:
    # A request that waits for a busy local server would spend its decision's time on waiting.
    if settings.provider == "embedded":
        return settings.model_copy(update={"concurrency": servers_at_once()})
    return settings


def _check_price(settings: LlmSettings, environ: Mapping[str, str]) -> None:
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
        f"cassette '{tape.path}' holds answers of {', '.join(models)}: choose with --llm-model"
    )
