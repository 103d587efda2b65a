"""Where the model is: from environment and scenario, and clear words when it is nowhere."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest

from swarmscout import Scenario
from swarmscout.core.errors import ModelError, ScenarioError
from swarmscout.llm.connect import connect
from swarmscout.llm.settings import LlmSettings, Secret, find_endpoint

AZURE = {
    "AZURE_OPENAI_ENDPOINT": "https://x.openai.azure.com",
    "AZURE_OPENAI_API_KEY": "k",
    "OPENAI_API_VERSION": "2024-10-21",
    "AZURE_OPENAI_DEPLOYMENT": "my-gpt-4o",
}


@pytest.mark.parametrize(
    ("keys", "environ", "expected"),
    [
        ({}, {"OPENAI_API_KEY": "k"}, ("openai", "gpt-4o", "", "")),
        ({"model": "gpt-4.1"}, {"OPENAI_API_KEY": "k"}, ("openai", "gpt-4.1", "", "")),
        ({}, AZURE, ("azure", "my-gpt-4o", "https://x.openai.azure.com", "2024-10-21")),
        (
            {"model": "d", "api_version": "v"},
            AZURE,
            ("azure", "d", "https://x.openai.azure.com", "v"),
        ),
        (
            {"model": "qwen"},
            {"OPENAI_BASE_URL": "http://127.0.0.1:11434/v1"},
            ("server", "qwen", "http://127.0.0.1:11434/v1", ""),
        ),
        (
            {"model": "qwen", "base_url": "http://h:1/v1"},
            {**AZURE, "OPENAI_API_KEY": "k"},
            ("server", "qwen", "http://h:1/v1", ""),
        ),
        ({"provider": "openai"}, {**AZURE, "OPENAI_API_KEY": "k"}, ("openai", "gpt-4o", "", "")),
        ({"provider": "embedded"}, {}, ("embedded", "smollm2-135m-instruct", "", "")),
    ],
)
def test_where_the_model_is(keys: Any, environ: Any, expected: tuple[str, ...]) -> None:
    found = find_endpoint(LlmSettings(**keys), environ)
    assert (found.provider, found.model, found.base_url, found.api_version) == expected


@pytest.mark.parametrize(
    ("keys", "environ", "says"),
    [
        ({}, {}, "no language model is configured: set OPENAI_API_KEY; or AZURE_OPENAI_ENDPOINT"),
        ({}, {}, "--llm embedded"),
        ({"provider": "openai"}, {}, "set OPENAI_API_KEY"),
        (
            {"provider": "azure"},
            {},
            "lacks AZURE_OPENAI_ENDPOINT, AZURE_OPENAI_API_KEY, OPENAI_API_V",
        ),
        ({"provider": "server"}, {}, "needs an address"),
        ({"base_url": "http://h/v1"}, {}, "which model of http://h/v1?"),
        ({"base_url": "ftp://h/v1", "model": "m"}, {}, "not an http(s) address"),
        ({"base_url": "http://h:x/v1", "model": "m"}, {}, "not an http(s) address"),
        ({"base_url": "http://me:pass@h/v1", "model": "m"}, {}, "a user, a password, a query"),
        ({"base_url": "http://h/v1?key=abc", "model": "m"}, {}, "a user, a password, a query"),
        (
            {"max_cost_usd": 1.0, "base_url": "http://h/v1", "model": "mine"},
            {},
            "no price is known for 'mine'",
        ),
        ({"prices": "no.toml"}, {"OPENAI_API_KEY": "k"}, "price file 'no.toml' cannot be read"),
    ],
)
def test_what_is_missing_is_said(keys: Any, environ: Any, says: str) -> None:
    with pytest.raises((ModelError, ScenarioError)) as caught:
        connect(LlmSettings(**keys), environ=environ)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "abc" not in str(caught.value)
    assert "pass@" not in str(caught.value)


@pytest.mark.parametrize("part", ["me:hunter2@h/v1", "h/v1?key=hunter2", "h/v1#hunter2"])
@pytest.mark.parametrize("scheme", ["http://", "https://", ""])
def test_a_secret_in_an_address_is_refused_unseen(part: str, scheme: str) -> None:
    """With any rule and in any mode: run folders keep addresses."""
    for keys in ({}, {"destinations": "nearest"}, {"llm": {"mode": "replay"}}):
        llm = {**keys.get("llm", {}), "base_url": scheme + part}
        with pytest.raises(ScenarioError, match=r"llm\.base_url") as caught:
            Scenario(**{**keys, "llm": llm})
        assert "hunter2" not in str(caught.value)
    with pytest.raises(ModelError, match="OPENAI_BASE_URL") as refused:
        find_endpoint(LlmSettings(model="m"), {"OPENAI_BASE_URL": scheme + part})
    assert "hunter2" not in str(refused.value)


def test_keys_are_copied_carelessly() -> None:
    found = find_endpoint(LlmSettings(), {"OPENAI_API_KEY": " sk-abc\n"})
    assert found.key.reveal() == "sk-abc"
    with pytest.raises(ModelError, match="OPENAI_API_KEY cannot be a key: character 3 is EM DASH"):
        find_endpoint(LlmSettings(), {"OPENAI_API_KEY": "sk—abc"})
    with pytest.raises(ModelError, match="character 3 is SPACE"):
        find_endpoint(LlmSettings(), {"OPENAI_API_KEY": "sk abc"})


@pytest.mark.parametrize("dummy", ["A", "ollama", "m1", "none", "sk-no-key-required", "EMPTY"])
def test_a_placeholder_for_a_key_falsifies_no_record(dummy: str) -> None:
    assert Secret(dummy).hidden_in(f"{dummy} is open") == f"{dummy} is open"
    quoted = f"{dummy}: unknown api-version"
    if len(dummy) < 12:
        assert Secret(dummy).scrubbed(quoted) == quoted
    real = "sk-planted-0123456789abcdefghij"
    assert Secret(real).hidden_in(f"{real} is open") == "*** is open"


def test_a_secret_tells_nobody() -> None:
    secret = Secret("sk-very-secret-key")
    endpoint = find_endpoint(LlmSettings(), {"OPENAI_API_KEY": "sk-very-secret-key"})
    for text in (repr(secret), str(secret), f"{secret!r}", repr(endpoint), str([endpoint])):
        assert "very" not in text
    with pytest.raises(TypeError):
        pickle.dumps(secret)
    with pytest.raises(TypeError):
        copy.copy(secret)
    quoted = "Incorrect API key provided: sk-very*****-key. Or sk-very-secret-key?"
    assert "very" not in secret.scrubbed(quoted)
