"""The server answers its own page only."""

from __future__ import annotations

import http.client
import json
import socket
import time

import pytest
from conftest import HANG_S

from swarmscout.cli.serving import open_page
from swarmscout.core.errors import ViewError
from swarmscout.viewing.player import server as serving
from swarmscout.viewing.player.page import PAGE_FILES
from swarmscout.viewing.player.server import PlayerServer, Recorded


@pytest.fixture(scope="module")
def server():
    with PlayerServer([Recorded(b"some data")], port=0) as running:
        yield running


def ask(server, path, method="GET", **headers):
    address = server.url.removeprefix("http://").rstrip("/")
    connection = http.client.HTTPConnection(address, timeout=HANG_S)
    connection.request(
        method, path, headers={name.replace("_", "-"): v for name, v in headers.items()}
    )
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer, body


def test_files_data_and_nothing_else(server):
    for name, kind in PAGE_FILES.items():
        answer, body = ask(server, f"/{name}")
        assert (answer.status, answer.headers["Content-Type"]) == (200, kind)
        assert len(body) > 100
    assert json.loads(ask(server, "/runs.json")[1]) == [
        {"data": "run/0/data", "live": None, "belief": "run/0/belief"}
    ]
    assert ask(server, "/run/0/data")[1] == b"some data"
    answer, body = ask(server, "/", method="HEAD")
    assert (answer.status, body) == (200, b"")
    for path in (
        "/run/1/data",
        "/../pyproject.toml",
        "/vendor/vendor.toml",
        "/page.py",
        "/%2e%2e/",
    ):
        assert ask(server, path)[0].status == 404
    assert ask(server, "/", method="POST")[0].status == 501


def test_headers_keep_the_page_to_itself(server):
    headers = ask(server, "/")[0].headers
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
    assert "Access-Control-Allow-Origin" not in headers


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"Host": "localhost:1"}, 200),
        ({"Host": "[::1]:5"}, 200),
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example:80"}, 403),
        ({"Host": ""}, 403),
        ({"Host": "[bad"}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Host": "localhost:7", "Origin": "http://localhost:7"}, 200),
        ({"Host": "localhost:7", "Origin": "http://localhost:8"}, 403),
        ({"Sec_Fetch_Site": "cross-site"}, 403),
        ({"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}, 200),
    ],
)
def test_only_its_own_page_may_ask(server, headers, status):
    for path in ("/", "/run/0/data"):
        assert ask(server, path, **headers)[0].status == status


def test_it_binds_loopback(server):
    assert server.url.startswith("http://127.0.0.1:")


def test_a_port_that_is_taken_is_one_clear_line(server):
    port = int(server.url.rstrip("/").rpartition(":")[2])
    with pytest.raises(ViewError, match=f"cannot listen on 127.0.0.1, port {port}: .*--port"):
        PlayerServer([], port=port)
    with pytest.raises(ViewError, match="port 70000 is impossible"):
        PlayerServer([], port=70000)
    with pytest.raises(ViewError, match=r"cannot listen on 203\.0\.113\.1"):
        PlayerServer([], host="203.0.113.1", port=0)


@pytest.mark.parametrize("drip", [b"G", b"GET / HTTP/1.1\r\nHost: localhost\r\nX: "])
def test_a_connection_that_drips_is_dropped(monkeypatch, server, drip):
    monkeypatch.setattr(serving._Handler, "timeout", 1.0)
    port = int(server.url.rstrip("/").rpartition(":")[2])
    began = time.monotonic()
    with socket.create_connection(("127.0.0.1", port)) as slow:
        slow.sendall(drip)
        while time.monotonic() - began < HANG_S:  # Each byte comes well before the limit.
            try:
                slow.sendall(b"x")
            except OSError:
                break
            time.sleep(0.1)
        else:
            pytest.fail("it was never dropped")
    assert ask(server, "/")[0].status == 200


def test_it_says_what_an_address_opens(server, capsys):
    assert server.opened is None
    open_page(server, browser=False)
    assert capsys.readouterr().err == ""
    with PlayerServer([Recorded(b"some data")], host="0.0.0.0", port=0) as wide:
        assert wide.url.startswith("http://127.0.0.1:")  # An address that a browser can open.
        assert ask(wide, "/")[0].status == 200
        assert ask(wide, "/", Host=f"{socket.gethostname()}:80")[0].status == 200
        assert ask(wide, "/", Host="evil.example")[0].status == 403
        open_page(wide, browser=False)
    output = capsys.readouterr()
    assert wide.url in output.out
    for word in ("open to the network", "no password", "no encryption", socket.gethostname()):
        assert word in output.err
