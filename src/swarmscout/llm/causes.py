"""Why a request failed, in one line that says what to do."""

from __future__ import annotations

import json
import os
import re
import socket
import ssl
from collections.abc import Iterator, Mapping
from email.utils import parsedate_to_datetime
from typing import Any
from urllib.parse import urlsplit
from urllib.request import getproxies, proxy_bypass

from swarmscout.core.text import clean_line
from swarmscout.llm.completion import kind_of_status, words_of
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.settings import Endpoint

__all__ = ["all_words", "connection_failed", "is_too_long", "refused", "retry_after"]

_WORDS = 200
_TOO_LONG = re.compile(
    r"context[ _-]?(length|window|size)|maximum context|n_ctx|reduce the length|"
    r"too many (input |prompt )?tokens|"
    r"(prompt|input|request|messages?) (is |are )?too (long|large)|"
    r"exceeds? the (available |maximum |model's )?(context|number of tokens|token limit)"
)
_HEADERS = "OPENAI_API_KEY, OPENAI_ORG_ID or OPENAI_PROJECT_ID"


def all_words(body: Any) -> str:
    """Everything that an error's body says, in lower case, to search in."""
    try:
        return json.dumps(body, ensure_ascii=False, default=str)[:20_000].casefold()
    except (ValueError, RecursionError):
        return ""


def is_too_long(status: int, words: str) -> bool:
    """Whether an error says that the prompt does not fit."""
    return status == 413 or (status != 404 and bool(_TOO_LONG.search(words)))


def refused(status: int, body: Any, headers: Mapping[str, str], endpoint: Endpoint,
            now_s: float) -> TryFailed:  # fmt: skip
    """The failure in an HTTP error.

    Args:
        status: of the reply; body: its JSON, or its text.
        headers: of the reply.
        endpoint: the server; its key is taken out of the server's words.
        now_s: the time, in seconds since 1970.
    """
    said = clean_line(endpoint.key.scrubbed(words_of(body)[:2000]), _WORDS)
    then = f": {said.rstrip('.')}" if said else ""
    searched = all_words(body)
    wait = retry_after(headers, now_s)
    if is_too_long(status, searched):
        return TryFailed(
            "too long",
            "the prompt does not fit into the model's context: lower selector.prompt_tokens, or "
            f"give the model a larger context{then}",
        )
    kind = kind_of_status(status)
    if kind == "unauthorized":
        key = "the server refuses the key" if endpoint.key else "the server wants a key"
        name = "AZURE_OPENAI_API_KEY" if endpoint.provider == "azure" else "OPENAI_API_KEY"
        return TryFailed(kind, f"{key} (401): check {name}{then}")
    if kind == "forbidden":
        return TryFailed(kind, f"the server refuses the request (403){then}")
    if status in (404, 405):
        return TryFailed("not found", _wrong_address(status, endpoint) + then)
    if "content_filter" in searched or "content management policy" in searched:
        return TryFailed(kind, f"the provider's content filter stopped the prompt{then}")
    if 300 <= status < 400:
        return TryFailed(kind, f"the server redirects ({status}): check the address{then}")
    return TryFailed(
        kind, said if kind == "rate limit" and said else f"status {status}{then}", wait
    )


def connection_failed(error: BaseException, endpoint: Endpoint) -> TryFailed:
    """The failure behind an error of the HTTP client: what the innermost cause says."""
    parts = urlsplit(endpoint.base_url or "https://api.openai.com/v1")
    where = f"{parts.hostname}:{parts.port or (443 if parts.scheme == 'https' else 80)}"
    through = _proxy(parts.scheme, parts.hostname or "")
    causes = list(_causes(error))
    for cause in causes:
        if isinstance(cause, UnicodeEncodeError) or type(cause).__name__ == "LocalProtocolError":
            note = f"a header cannot be sent: check {_HEADERS} for characters that are not ASCII"
            return TryFailed("bad request", note)
        if isinstance(cause, ssl.SSLCertVerificationError):
            return TryFailed(
                "no connection",
                f"the certificate of {where} is not trusted ({clean_line(cause.verify_message)}): "
                "set SSL_CERT_FILE to a file with its authority's certificate",
            )
        if isinstance(cause, ssl.SSLError):
            why = clean_line(str(cause.reason or cause))
            hint = ": is it http:// instead of https://?" if "VERSION" in why else ""
            return TryFailed("no connection", f"no TLS connection to {where} ({why}){hint}")
    for cause in causes:
        if type(cause).__name__ == "ProxyError":
            note = f"the proxy{through} refuses: {clean_line(str(cause))}"
            return TryFailed("no connection", endpoint.key.scrubbed(note))
        if isinstance(cause, socket.gaierror):
            host = "the proxy's host" if through else f"host '{parts.hostname}'"
            return TryFailed("no connection", f"{host} is not known (DNS){through}")
        if isinstance(cause, ConnectionRefusedError):
            what = "the proxy" if through else where
            hint = "" if through else ": is the server running there?"
            return TryFailed("no connection", f"{what} refuses the connection{through}{hint}")
        if isinstance(cause, ConnectionResetError | BrokenPipeError):
            return TryFailed("no connection", f"{where} broke off the connection{through}")
        if type(cause).__name__ == "RemoteProtocolError":
            return TryFailed("no connection", f"{where} closed the connection without an answer")
        if isinstance(cause, OSError) and cause.strerror:
            return TryFailed("no connection", f"{where}: {clean_line(cause.strerror)}{through}")
    kind = type(causes[-1]).__name__ if causes else "unknown"
    return TryFailed("no connection", f"the connection to {where} failed ({kind}){through}")


def retry_after(headers: Mapping[str, str], now_s: float) -> float | None:
    """Seconds that a server asks to wait, in any of the forms in use; None if it does not."""
    for name, unit_s in (("retry-after-ms", 1e-3), ("retry-after", 1.0)):
        value = headers.get(name)
        if value is None:
            continue
        try:
            return max(0.0, float(value) * unit_s)
        except ValueError:
            pass
        try:
            return max(0.0, parsedate_to_datetime(value).timestamp() - now_s)
        except (TypeError, ValueError, OverflowError):
            continue
    return None


def _wrong_address(status: int, endpoint: Endpoint) -> str:
    url = endpoint.base_url
    if endpoint.provider == "azure":
        return f"no deployment '{endpoint.model}' at {url} ({status})"
    if endpoint.provider == "server" and "/v1" not in urlsplit(url).path:
        return f"nothing answers at {url} ({status}): most servers want {url.rstrip('/')}/v1"
    return f"no model '{endpoint.model}' or no such address: {url or 'OpenAI'} ({status})"


def _causes(error: BaseException) -> Iterator[BaseException]:
    """An error and what caused it, from outside to inside."""
    waiting: list[BaseException | None] = [error]
    seen: set[int] = set()
    while waiting:
        one = waiting.pop(0)
        if one is None or id(one) in seen:
            continue
        seen.add(id(one))
        yield one
        if isinstance(one, BaseExceptionGroup):
            waiting += one.exceptions
        waiting += [one.__cause__, one.__context__]


def _proxy(scheme: str, host: str) -> str:
    """Which variable names the proxy that a request goes through, in words; empty if none."""
    proxies = getproxies()
    if is_loopback(host) or proxy_bypass(host):
        return ""
    name = scheme if scheme in proxies else "all"
    if name not in proxies:
        return ""
    spelled = f"{name}_proxy"
    return f" (set by {spelled.upper() if spelled.upper() in os.environ else spelled})"


def is_loopback(host: str) -> bool:
    """Whether a host is this machine: no proxy stands between."""
    from ipaddress import ip_address

    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.casefold() == "localhost" or host.casefold().endswith(".localhost")
