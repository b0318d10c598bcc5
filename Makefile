# Every target first makes .venv and installs what it needs into it (.ci/setup), and does that only once.
# PYTHON=/path/to/python3 chooses the Python; without it a suitable one is looked for.

SHELL := /bin/bash
BIN := .venv/bin
DEMO := runs/demo
QUICK := $(addprefix tests/,anatomy base device mechanics/test_equations_of_motion.py metrics reality test_refusals.py \
	project/test_imports.py project/test_ownable.py project/test_dependencies.py envs/test_rewards_and_ends.py)
STUDIES := headline calibration long clinic imaged agents cohorts robustness force_sensors sensors rates ladder
DEMO_TRAIN := train apg --steps 96000 --residual-on universal --comfort-budget-s 0.0333 --output $(DEMO)/apg --continue
DEMO_COMPARE := compare $(DEMO)/apg random --all-maneuvers --with-replay --cohort one_sided --episode-s 10 --comfort-budget-s 0.0333 --seed 500 --output $(DEMO)

SMALL := $(if $(FULL),,$(addprefix JAWENV_NOTEBOOK_,PATIENTS=4 EPISODE_S=5 QUICK=1))
export PYTHON
# Compiled sources are kept in .venv and here: without them each of the many processes starts three times as slowly.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help live demo notebooks docs site tables check test lint bench sbom clean
.NOTPARALLEL:

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-9s  %s\n", $$1, $$2 }' Makefile

live: ## a page on which you move the jaw of a patient
	@COMPILE=1 .ci/setup
	$(BIN)/jawenv live --open

demo: ## train an agent that adapts, and compare it with every maneuver: runs/demo/report.html
	@COMPILE=1 .ci/setup train eval
	$(BIN)/python -m training $(DEMO_TRAIN)
	$(BIN)/python -m eval $(DEMO_COMPARE)

notebooks: ## open the notebooks in JupyterLab
	@.ci/setup train eval notebooks
	$(BIN)/jupyter lab eval/notebooks

docs: ## build the site with small notebooks and examples: runs/site/index.html and tour.html; FULL=1 plays them whole, and films the maneuvers
	@.ci/setup train eval docs
	@echo "$(if $(FULL),takes 15 minutes or more,takes some minutes; FULL=1 makes the site as it is published)"
	$(SMALL) $(BIN)/python docs/site/notebook_pages.py
	$(SMALL) $(BIN)/python docs/site/example_pages.py
	$(if $(FULL),$(BIN)/python docs/site/gallery.py)
	$(SMALL) $(BIN)/python docs/site/build.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	$(BIN)/python docs/site/tour.py

site: ## one page to send a link to, which opens from disk: runs/site/tour.html
	@.ci/setup train eval
	$(BIN)/python docs/site/tour.py

tables: ## play the studies whose tables the documentation shows, and renew these: docs/tables
	@.ci/setup train eval
	for study in $(STUDIES); do $(BIN)/python -m eval study $$study && cp runs/study/$$study/study.md docs/tables/$$study.md || exit 1; done
	$(BIN)/python -m research.honesty all > runs/honesty.md && cp runs/honesty.md docs/tables/honesty.md

check: lint ## lint, types and the quick tests, which share one compiled filter: half a minute once compiled
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -q -n 2 $(QUICK)

test: lint ## lint, types and all tests
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist worksteal

lint: ## ruff and mypy
	@.ci/setup train eval docs dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

bench: ## measure speed, memory growth and start-up
	@.ci/setup train eval dev
	$(BIN)/python tests/benchmarks/bench.py

sbom: ## list what is installed, with versions and licences, as CycloneDX: runs/sbom/jawenv.cdx.json
	@.ci/setup train eval
	$(BIN)/python -m venv --clear runs/sbom/.tool
	runs/sbom/.tool/bin/python -m pip install --quiet --disable-pip-version-check cyclonedx-bom==7.5.0
	runs/sbom/.tool/bin/cyclonedx-py environment $(BIN)/python --pyproject pyproject.toml --mc-type library \
		--output-reproducible --output-file runs/sbom/jawenv.cdx.json

clean: ## remove build products and caches; .venv and runs/ stay
	rm -rf build dist *.egg-info .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find . -path ./.venv -prune -o -type d \( -name __pycache__ -o -name .ipynb_checkpoints \) -prune -exec rm -rf {} +
