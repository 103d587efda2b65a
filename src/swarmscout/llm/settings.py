"""Which model is asked and how: the scenario's section ``llm``, and the providers' environment.

Keys come from the environment alone and are kept in a :class:`Secret`.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from swarmscout.core.errors import ModelError
from swarmscout.core.parameters import HIDDEN, Parameters

__all__ = [
    "EMBEDDED_MODEL",
    "EMBEDDED_PROMPT_TOKENS",
    "Endpoint",
    "LlmSettings",
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
"""The ways to configure a model, for the error when there is none."""

_MOST = 1_000_000_000
_DAY_S = 86_400.0


class LlmSettings(Parameters):
    """The language model used by LLM-based selectors (paper, "LLM-based …"; docs/llm.md).

    API keys are read from the environment and are not part of a scenario.
    """

    provider: Literal["auto", "openai", "azure", "server", "embedded"] = Field(
        "auto", description="where the model runs; 'auto': taken from environment variables"
    )
    model: str = Field("", max_length=500, description="the model's name, or Azure's deployment")
    base_url: str = Field(
        "", max_length=2000, description="address of a compatible server, or Azure's endpoint"
    )
    api_version: str = Field("", max_length=100, description="Azure's API version")
    temperature: float = Field(
        0.0, ge=0.0, le=2.0, description="sampling temperature; left out if the server refuses it"
    )
    effort: Literal["", "none", "minimal", "low", "medium", "high", "xhigh"] = Field(
        "", description="how long a reasoning model thinks; '': the model's default"
    )
    answer_tokens: int | None = Field(
        None, ge=10, le=1_000_000, description="longest answer, instead of the selector's"
    )
    structured: Literal["auto", "schema", "off"] = Field(
        "auto", description="answers by JSON schema: until refused, always, or never"
    )
    concurrency: int = Field(8, ge=1, le=256, description="maximum concurrent requests")
    decision_s: float = Field(
        60.0, gt=0.0, le=_DAY_S, description="time limit of a decision, retries included"
    )
    call_s: float = Field(30.0, gt=0.0, le=_DAY_S, description="time limit of one request")
    tries: int = Field(4, ge=1, le=20, description="maximum attempts per request")
    breaker_failures: int = Field(
        5, ge=1, le=_MOST, description="after this many failures in a row …"
    )
    breaker_steps: int = Field(
        20, ge=0, le=_MOST, description="… no requests are sent for this many steps"
    )
    max_calls: int | None = Field(
        None, ge=0, le=_MOST, description="requests per mission; then the rule decides"
    )
    max_tokens: int | None = Field(
        None, ge=0, le=1_000_000_000_000, description="tokens per mission, read and written"
    )
    max_cost_usd: float | None = Field(None, ge=0.0, le=1e9, description="US dollars per mission")
    prices: str = Field("", description="a price table that replaces the package's")
    cassette: str = Field("", description="a file that stores requests and replies")
    mode: Literal["auto", "record", "replay", "refresh"] = Field(
        "auto", description="how the cassette is used"
    )
    embedded_model: str = Field("", description="a GGUF file that replaces the installed model")
    threads: int = Field(1, ge=1, le=256, description="threads of the embedded model")
    latency_steps: int = Field(
        0, ge=0, le=_MOST, description="an answer takes effect this many steps later"
    )

    @field_validator("base_url")
    @classmethod
    def _keeps_no_secret(cls, url: str) -> str:
        """Addresses are kept in run folders, so one with a secret in it is refused, unseen."""
        problem = _problem_of(url)
        if problem:
            raise PydanticCustomError(HIDDEN, problem.replace("{", "(").replace("}", ")"))
        return url


class Secret:
    """A key that no ``repr``, record or pickle shows.

    Args:
        value: the key; only :meth:`reveal` returns it.
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

    def hidden_in(self, text: str) -> str:
        """An answer without the key.

        Placeholders such as ``ollama`` or ``none`` are words that answers may contain, so a key
        shorter than 16 characters or without a digit stays.
        """
        if len(self._value) >= 16 and any(sign.isdigit() for sign in self._value):
            return text.replace(self._value, "***")
        return text

    def scrubbed(self, text: str) -> str:
        """An error message without the key, whole or abridged as servers quote it.

        Short placeholders stay, since messages about a server may contain its name.
        """
        least = 8 if any(sign.isdigit() for sign in self._value) else 12
        if len(self._value) >= least:
            text = text.replace(self._value, "***")
        text = re.sub(r"\b(bearer|basic)\s+[^\s'\",]+", r"\1 ***", text, flags=re.IGNORECASE)
        return re.sub(r"\b(sk|key|api)-(?=[\w.-]{0,80}[\d*])[\w*.-]{6,}", "***", text)


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Where a model is.

    Attributes:
        provider: ``openai``, ``azure``, ``server`` or ``embedded``.
        model: its name, or the deployment's.
        base_url: of the server; empty for OpenAI's own and the embedded one.
        api_version: Azure's.
        key: sent to the server and shown nowhere.
    """

    provider: str
    model: str
    base_url: str = ""
    api_version: str = ""
    key: Secret = field(default=Secret(""), compare=False)


def find_endpoint(settings: LlmSettings, environ: Mapping[str, str]) -> Endpoint:
    """Find the model that settings and environment name.

    Args:
        settings: the scenario's.
        environ: ``OPENAI_API_KEY``, ``OPENAI_BASE_URL``, ``AZURE_OPENAI_ENDPOINT``,
            ``AZURE_OPENAI_API_KEY``, ``AZURE_OPENAI_DEPLOYMENT`` and ``OPENAI_API_VERSION``.

    Raises:
        ModelError: something is missing or malformed; the message says what to set.
    """
    provider = settings.provider
    if provider == "auto":
        provider = _guess(settings, environ)
    if provider == "embedded":
        own = Path(settings.embedded_model).stem if settings.embedded_model else EMBEDDED_MODEL
        return Endpoint("embedded", settings.model or own)
    if provider == "azure":
        return _azure(settings, environ)
    url = settings.base_url or _address(environ, "OPENAI_BASE_URL")
    key = _key(environ, "OPENAI_API_KEY")
    if provider == "openai":
        if not key:
            raise ModelError("provider 'openai' needs a key: set OPENAI_API_KEY")
        return Endpoint("openai", settings.model or "gpt-4o", url, "", key)
    if not url:
        raise ModelError(
            "provider 'server' needs an address: set llm.base_url, --llm URL or OPENAI_BASE_URL"
        )
    if not settings.model:
        raise ModelError(f"which model of {url}? set llm.model (or --llm-model NAME)")
    return Endpoint("server", settings.model, url, "", key)


def _guess(
    settings: LlmSettings, environ: Mapping[str, str]
) -> Literal["openai", "azure", "server"]:
    if settings.base_url:
        return "server"
    if environ.get("AZURE_OPENAI_ENDPOINT"):
        return "azure"
    if environ.get("OPENAI_BASE_URL"):
        return "server"
    if environ.get("OPENAI_API_KEY"):
        return "openai"
    raise ModelError(f"no language model is configured: {HOW}")


def _azure(settings: LlmSettings, environ: Mapping[str, str]) -> Endpoint:
    key = _key(environ, "AZURE_OPENAI_API_KEY")
    found = {
        "AZURE_OPENAI_ENDPOINT": settings.base_url or _address(environ, "AZURE_OPENAI_ENDPOINT"),
        "AZURE_OPENAI_API_KEY": key.reveal(),
        "OPENAI_API_VERSION (or llm.api_version)": settings.api_version
        or environ.get("OPENAI_API_VERSION", "").strip(),
        "AZURE_OPENAI_DEPLOYMENT (or llm.model)": settings.model
        or environ.get("AZURE_OPENAI_DEPLOYMENT", "").strip(),
    }
    missing = [name for name, value in found.items() if not value]
    if missing:
        raise ModelError(f"provider 'azure' lacks {', '.join(missing)}")
    url, _, version, deployment = found.values()
    return Endpoint("azure", deployment, url, version, key)


def _key(environ: Mapping[str, str], name: str) -> Secret:
    """A key from the environment, without the blanks and line ends of a careless copy.

    Raises:
        ModelError: it holds a character that no HTTP header can carry.
    """
    value = environ.get(name, "").strip()
    for place, sign in enumerate(value, start=1):
        if not "!" <= sign <= "~":
            what = unicodedata.name(sign, f"U+{ord(sign):04X}")
            raise ModelError(
                f"{name} cannot be a key: character {place} is {what}, and keys are printable "
                "ASCII without blanks; copy the key again"
            )
    return Secret(value)


def _address(environ: Mapping[str, str], name: str) -> str:
    url = environ.get(name, "").strip()
    problem = _problem_of(url)
    if problem:
        raise ModelError(f"{name}: {problem}")
    return url


def _problem_of(url: str) -> str:
    """What is wrong with a base URL, without quoting it; empty if it can be used."""
    if not url:
        return ""
    try:
        parts = urlsplit(url)
        bad = parts.scheme not in ("http", "https") or not parts.hostname
        parts.port  # noqa: B018 (raises for an impossible port)
    except ValueError:
        return "not an http(s) address: write http://127.0.0.1:11434/v1"
    # What belongs to a secret counts first: "user:password@host" has no scheme.
    if "@" in url or "?" in url or "#" in url:
        return (
            "the address holds a user, a password, a query or a fragment, and addresses are kept "
            "in run folders: leave it out and put the key into OPENAI_API_KEY"
        )
    if bad or not url.isprintable() or " " in url:
        return "not an http(s) address: write http://127.0.0.1:11434/v1"
    return ""
