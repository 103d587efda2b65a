"""Which model answers, and how it is reached: scenario keys and the providers' own environment.

Keys come from the environment alone. They are kept in :class:`Secret`, which shows them to nobody.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from swarmscout.core.errors import ModelError

__all__ = [
    "EMBEDDED_MODEL",
    "EMBEDDED_PROMPT_TOKENS",
    "Endpoint",
    "ModelSettings",
    "Secret",
    "find_endpoint",
]

EMBEDDED_MODEL = "smollm2-135m-instruct"

EMBEDDED_PROMPT_TOKENS = 700
"""Longest prompt that a small model on a processor answers within seconds."""

HOW = (
    "set OPENAI_API_KEY; or AZURE_OPENAI_ENDPOINT, AZURE_OPENAI_API_KEY, OPENAI_API_VERSION and "
    "AZURE_OPENAI_DEPLOYMENT; or --llm URL --llm-model NAME for a compatible server; "
    "or try --llm embedded: a small local model that needs no key"
)
"""What can be set when nothing is."""


class Secret:
    """A key that appears in no text.

    Args:
        value: the key; it can be had back as ``reveal()`` and in no other way.
    """

    __slots__ = ("_value",)

    def __init__(self, value: str) -> None:
        self._value = value

    def __repr__(self) -> str:
        return "Secret(***)" if self._value else "Secret(none)"

    def __bool__(self) -> bool:
        return bool(self._value)

    def __reduce__(self) -> str:
        raise TypeError("a secret is not pickled")

    def reveal(self) -> str:
        """The key."""
        return self._value

    def scrubbed(self, text: str) -> str:
        """A text without the key, whole or abridged as servers quote it in their errors."""
        if len(self._value) >= 4:
            text = text.replace(self._value, "***")
        return re.sub(r"\b(sk|key|api)-[\w*.-]{6,}", "***", text)


@dataclass(frozen=True, slots=True)
class ModelSettings:
    """What a scenario says about the model; the section ``llm`` of a scenario explains each."""

    provider: str = "auto"
    model: str = ""
    base_url: str = ""
    api_version: str = ""
    temperature: float = 0.0
    structured: str = "auto"
    concurrency: int = 8
    decision_s: float = 60.0
    call_s: float = 30.0
    tries: int = 4
    breaker_failures: int = 5
    breaker_steps: int = 20
    max_calls: int | None = None
    max_tokens: int | None = None
    max_cost_usd: float | None = None
    prices: str = ""
    cassette: str = ""
    mode: str = "auto"
    embedded_model: str = ""
    threads: int = 1


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Where a model is.

    Attributes:
        provider: ``openai``, ``azure``, ``server`` or ``embedded``.
        model: its name, or the deployment's.
        base_url: of the server; empty for OpenAI's own and the embedded one.
        api_version: Azure's.
        key: shown to nobody.
    """

    provider: str
    model: str
    base_url: str = ""
    api_version: str = ""
    key: Secret = field(default=Secret(""), compare=False)


def find_endpoint(settings: ModelSettings, environ: Mapping[str, str]) -> Endpoint:
    """Put together where the model is.

    Args:
        settings: the scenario's.
        environ: ``OPENAI_API_KEY``, ``OPENAI_BASE_URL``, ``AZURE_OPENAI_ENDPOINT``,
            ``AZURE_OPENAI_API_KEY``, ``AZURE_OPENAI_DEPLOYMENT`` and ``OPENAI_API_VERSION``.

    Raises:
        ModelError: something is missing; the message says what to set.
    """
    provider = settings.provider
    if provider == "auto":
        provider = _guess(settings, environ)
    if provider == "embedded":
        own = Path(settings.embedded_model).stem if settings.embedded_model else EMBEDDED_MODEL
        return Endpoint("embedded", settings.model or own)
    if provider == "azure":
        return _azure(settings, environ)
    url = settings.base_url or environ.get("OPENAI_BASE_URL", "")
    key = Secret(environ.get("OPENAI_API_KEY", ""))
    if provider == "openai":
        if not key:
            raise ModelError("provider 'openai' needs a key: set OPENAI_API_KEY")
        return Endpoint("openai", settings.model or "gpt-4o", _checked(url), "", key)
    if not url:
        raise ModelError(
            "provider 'server' needs an address: set llm.base_url, --llm URL or OPENAI_BASE_URL"
        )
    if not settings.model:
        raise ModelError(f"which model of {_checked(url)}? set llm.model (or --llm-model NAME)")
    return Endpoint("server", settings.model, _checked(url), "", key)


def _guess(settings: ModelSettings, environ: Mapping[str, str]) -> str:
    if settings.base_url:
        return "server"
    if environ.get("AZURE_OPENAI_ENDPOINT"):
        return "azure"
    if environ.get("OPENAI_BASE_URL"):
        return "server"
    if environ.get("OPENAI_API_KEY"):
        return "openai"
    raise ModelError(f"no language model is configured: {HOW}")


def _azure(settings: ModelSettings, environ: Mapping[str, str]) -> Endpoint:
    found = {
        "AZURE_OPENAI_ENDPOINT": settings.base_url or environ.get("AZURE_OPENAI_ENDPOINT", ""),
        "AZURE_OPENAI_API_KEY": environ.get("AZURE_OPENAI_API_KEY", ""),
        "OPENAI_API_VERSION (or llm.api_version)": settings.api_version
        or environ.get("OPENAI_API_VERSION", ""),
        "AZURE_OPENAI_DEPLOYMENT (or llm.model)": settings.model
        or environ.get("AZURE_OPENAI_DEPLOYMENT", ""),
    }
    missing = [name for name, value in found.items() if not value]
    if missing:
        raise ModelError(f"provider 'azure' lacks {', '.join(missing)}")
    url, key, version, deployment = found.values()
    return Endpoint("azure", deployment, _checked(url), version, Secret(key))


def _checked(url: str) -> str:
    """A base URL without secrets in it: it is shown and kept."""
    if not url:
        return ""
    try:
        parts = urlsplit(url)
        bad = parts.scheme not in ("http", "https") or not parts.hostname
        parts.port  # noqa: B018 (raises for what is no port)
    except ValueError:
        bad = True
    if bad:
        raise ModelError("the model's address is no http(s) URL: write http://127.0.0.1:11434/v1")
    if parts.username or parts.password or parts.query:
        raise ModelError(
            "the model's address holds a user, a password or a query: addresses are kept in runs; "
            "put the key into OPENAI_API_KEY"
        )
    return url
