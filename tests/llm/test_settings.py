"""Where the model is: from environment and scenario, and clear words when it is nowhere."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest

from swarmscout.core.errors import ModelError
from swarmscout.llm.connect import connect
from swarmscout.llm.settings import ModelSettings, Secret, find_endpoint

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
    found = find_endpoint(ModelSettings(**keys), environ)
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
        ({"base_url": "ftp://h/v1", "model": "m"}, {}, "is no http(s) URL"),
        ({"base_url": "http://h:x/v1", "model": "m"}, {}, "is no http(s) URL"),
        ({"base_url": "http://me:pass@h/v1", "model": "m"}, {}, "a user, a password or a query"),
        ({"base_url": "http://h/v1?key=abc", "model": "m"}, {}, "a user, a password or a query"),
        (
            {"max_cost_usd": 1.0, "base_url": "http://h/v1", "model": "mine"},
            {},
            "no price is known for 'mine'",
        ),
        ({"prices": "no.toml"}, {"OPENAI_API_KEY": "k"}, "price file 'no.toml' cannot be read"),
    ],
)
def test_what_is_missing_is_said(keys: Any, environ: Any, says: str) -> None:
    with pytest.raises(ModelError) as caught:
        connect(ModelSettings(**keys), environ=environ)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "abc" not in str(caught.value)
    assert "pass@" not in str(caught.value)


def test_a_secret_tells_nobody() -> None:
    secret = Secret("sk-very-secret-key")
    endpoint = find_endpoint(ModelSettings(), {"OPENAI_API_KEY": "sk-very-secret-key"})
    for text in (repr(secret), str(secret), f"{secret!r}", repr(endpoint), str([endpoint])):
        assert "very" not in text
    with pytest.raises(TypeError):
        pickle.dumps(secret)
    with pytest.raises(TypeError):
        copy.copy(secret)
    told = "Incorrect API key provided: sk-very*****-key. Or sk-very-secret-key?"
    assert "very" not in secret.scrubbed(told)
