# Two commands on a fresh machine with python3.11, pip and make:
#   make bench   install, then run a small `paper` suite through simulation, detection, scores, figures and report
#   make test    install, then run the tests
PYTHON ?= python3.11
VENV   ?= .venv
BIN    := $(VENV)/bin
JOBS   ?= 2

.PHONY: bench test lint clean

bench: $(VENV)/.bench-installed
	$(BIN)/obstaclewatch run paper --tier ci -j $(JOBS)

test: $(VENV)/.test-installed
	$(BIN)/python -m pytest -n $(JOBS)

lint: $(VENV)/.test-installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.bench-installed: pyproject.toml constraints.txt | $(BIN)/python
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable .
	touch $@

$(VENV)/.test-installed: pyproject.toml constraints.txt | $(BIN)/python
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[test]'
	touch $@ $(VENV)/.bench-installed

clean:
	rm -rf $(VENV) results build *.egg-info
