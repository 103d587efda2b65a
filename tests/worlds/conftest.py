"""What tests of the ``worlds`` commands share."""

import pytest

from swarmscout.cli.worlds import app


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    """Types words after ``swarmscout worlds`` in an empty folder; returns what is printed."""
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> str:
        app(list(words), result_action="return_value", exit_on_error=False, print_error=False)
        return capsys.readouterr().out

    return run
