.PHONY: install check web test test-all format reproduce model docs site clean

BIN := .venv/bin
NPM := PYTHON=$(abspath $(BIN))/python web/npm

install:  ## an environment with the pinned versions, and the hooks
	python3 -m venv .venv
	$(BIN)/pip install -c constraints.txt -e ".[dev]"
	$(BIN)/pre-commit install
	$(NPM) ci

check:  ## what CI checks
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/lint-imports
	$(BIN)/basedpyright --pythonpath $(BIN)/python
	$(BIN)/codespell
	PATH="$(CURDIR)/$(BIN):$$PATH" .ci/check_schemas
	$(BIN)/mkdocs build --strict
	$(NPM) run check
	$(NPM) run check-bundles

web:  ## the scripts of the HTML reports, bundled into the package
	$(NPM) run build

test:  ## all tests but the slow ones
	$(BIN)/pytest -n 2

test-all:  ## all tests, those of half an hour too
	$(BIN)/pytest -n 2 -m ""

format:
	$(BIN)/ruff check --fix
	$(BIN)/ruff format
	$(NPM) run format

reproduce:  ## the table in the README
	$(BIN)/plant-bench score --agent expert --repetitions 3
	$(BIN)/plant-bench score --agent plant --repetitions 3
	for agent in plant-unguarded rule-based rule-based-tracks sumo idm cruise; do $(BIN)/plant-bench score --agent $$agent --repetitions 2 || exit; done
	$(BIN)/plant-bench score --agent expert-nearest --repetitions 1

model:  ## the shipped weights again, from nothing; SCALE=0.02 for a trial
	BENCH=$(BIN)/plant-bench models/make_model.sh

docs:  ## pictures of all towns and routes, into docs/pictures
	$(BIN)/plant-bench towns list --pictures docs/pictures/towns
	$(BIN)/plant-bench routes list --pictures docs/pictures/routes
	$(BIN)/plant-bench routes list --suite unseen --pictures docs/pictures/routes

site:  ## the documentation as a site, in site/
	$(BIN)/mkdocs build --strict

clean:  ## what can be made again; reports stay
	rm -rf dist site .pytest_cache .ruff_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
