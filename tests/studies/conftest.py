"""Small studies that run in a second or two."""

import textwrap

import pytest
from in_this_process import InThisProcess
from small_studies import SMALL

from swarmscout.studies.study import Study


@pytest.fixture
def engine():
    return InThisProcess()


@pytest.fixture
def write_study(tmp_path):
    """Write a study's file; without a text the small one."""

    def write(text=SMALL, name="study.toml", trials=2):
        file = tmp_path / name
        file.write_text(textwrap.dedent(text).replace("{trials}", str(trials)), encoding="utf-8")
        return file

    return write


@pytest.fixture
def make_study(tmp_path, write_study):
    """A study of a text, whose results go to ``out``."""

    def make(text=SMALL, trials=2, out="out"):
        return Study.load(write_study(text, trials=trials), tmp_path / out)

    return make
