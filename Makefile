# Two commands on a fresh machine with python3.11, pip and make:
#   make bench   install, then run a small `paper` suite through simulation, detection, scores, figures and report
#   make test    install, then run the tests
# and for those who change it:
#   make gate      `make bench`, then hold the run against the stored baseline and the exact physics
#   make doctor    try every part of the installation on something with a known answer
#   make docs      build the pages, build/docs/index.html; a warning is an error
#   make baseline REASON="what changed"    `make bench`, then make that run the stored baseline
PYTHON ?= python3.11
VENV   ?= .venv
BIN    := $(VENV)/bin
JOBS   ?= 2
INSTALL = $(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt --editable

# What is imported is compiled then, once: of what pip installs most never is, and one that forgets pays at every start.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: bench test gate baseline lint doctor docs clean

bench: $(VENV)/.bench-installed
	$(BIN)/obstaclewatch run paper --tier ci -j $(JOBS)

gate: bench
	$(BIN)/obstaclewatch gate results/paper/latest

baseline:
	@test -n "$(REASON)" || { echo 'usage: make baseline REASON="what changed and why"' >&2; exit 2; }
	$(MAKE) bench
	$(BIN)/obstaclewatch baseline update results/paper/latest --reason "$(REASON)"

# Workers begin at different ends of the tests, so that what one has compiled is there when another needs it.
test: $(VENV)/.test-installed
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal

lint: $(VENV)/.test-installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

doctor: $(VENV)/.bench-installed
	$(BIN)/obstaclewatch doctor

docs: $(VENV)/.docs-installed
	$(BIN)/python -m sphinx --fail-on-warning --keep-going -q -E -b html docs build/docs

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.bench-installed: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) .
	touch $@

$(VENV)/.test-installed: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[test]'
	touch $@ $(VENV)/.bench-installed

# All at once, for those who run everything: one search for what fits together instead of two.
.PHONY: install
install: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[test,docs]'
	touch $(addprefix $(VENV)/,.bench-installed .test-installed .docs-installed)

$(VENV)/.docs-installed: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[docs]'
	touch $@ $(VENV)/.bench-installed

clean:
	rm -rf $(VENV) results build *.egg-info
