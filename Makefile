# SPDX-License-Identifier: Apache-2.0
# Every target sets up $(VENV) first if necessary: see .ci/setup.
PYTHON ?= python3
VENV ?= .venv
# The distribution of ROS 2 where none is sourced: jazzy or kilted.
DISTRO ?= jazzy
# Options for the executable behind a target: make demo ARGS="--seed 7"
ARGS ?=
# Tests in parallel: two more than there are processors, as tests of nodes mostly wait.
WORKERS ?= $(shell n=$$(nproc); echo $$((n < 7 ? n + 2 : 8)))

RUN := .ci/with_venv $(VENV)
PYTEST := pytest -n $(WORKERS) --dist loadgroup
QUICK_TESTS = $(RUN) python -m $(PYTEST) -m 'not slow'

# Files below test/ that are not tests: conftest, references, makers.
SHARED_BY_TESTS = $(shell find test -name '*.py' -not -name 'test_*')

# Tests that reach no code of their own: of several rooms at once, in other processes or in copies,
# and those that repeat what others reach over many sensors or figures.
UNTRACED = $(filter-out test/test_reproduce.py,$(wildcard test/test_*.py)) \
	test/faults test/presets test/nodes/test_interface_package.py \
	test/checking/test_rates.py test/plots/test_paper_figures.py

.DEFAULT_GOAL := help
# Tests run alone: what else runs would disturb their timing.
ifndef AT_ONCE
.NOTPARALLEL:
endif

.PHONY: help
help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-14s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))
	@echo 'PYTHON=... picks the interpreter (3.10 or later), ARGS="..." goes to the executable.'

.PHONY: venv
venv: ## set up .venv: ROS 2, all dependencies, and the package, editable
	@.ci/setup '$(PYTHON)' '$(VENV)' '$(DISTRO)'

.PHONY: demo
demo: venv ## score a real drive; balance a pendulum over DDS, replay and score it
	@$(RUN) fuzzy-fusion demo $(ARGS)

.PHONY: reproduce
reproduce: venv ## reproduce the paper's figures, and its claims as a table
	@$(RUN) fuzzy-fusion reproduce $(ARGS)

.PHONY: docs
docs: venv ## regenerate the tables and pictures of README and docs
	@$(RUN) python docs/make_readme.py
	@$(RUN) python docs/make_api.py
	@$(RUN) python docs/make_parameters.py
	@$(RUN) python docs/make_tuning.py
	@$(RUN) python docs/make_limitations.py
	@PYTHONPATH="test$${PYTHONPATH:+:$$PYTHONPATH}" $(RUN) python docs/make_check.py
	@PYTHONPATH="test$${PYTHONPATH:+:$$PYTHONPATH}" $(RUN) python docs/make_presets.py

.PHONY: site
site: venv ## build the documentation as a website, into out/site
	@$(RUN) python -m sphinx -W --keep-going -q -b html docs out/site

.PHONY: bench
bench: venv ## time the estimator, nodes, replay and programs against what they are compared with
	@PYTHONPATH="test$${PYTHONPATH:+:$$PYTHONPATH}" $(RUN) python -m bench $(ARGS)

.PHONY: soak
soak: venv ## fault tests in full: damaged bags, kills, cut links, floods, long runs (hours; ARGS="kills --scale 0.1")
	@$(RUN) python test/soak.py $(ARGS)

.PHONY: test
test: venv ## run every kind of check once, in parallel: before each commit
	@$(MAKE) --no-print-directory --jobs=2 AT_ONCE=yes check-format check-lint check-types compiled
	$(QUICK_TESTS)
	@echo 'make test: format, lint, types and tests have passed'

.PHONY: test-slow
test-slow: check-slow check-coverage ## the remaining tests: more cases, slow tests, and coverage
	@echo 'make test-slow: slow tests and coverage have passed'

.PHONY: check-format
check-format: venv ## check the format of the code
	$(RUN) python -m ruff format --check --quiet --diff .

.PHONY: check-lint
check-lint: venv ## check the code with ruff
	$(RUN) python -m ruff check --quiet .

.PHONY: check-types
check-types: venv ## check types with mypy, strict
	$(RUN) python -m mypy --strict fuzzy_fusion_ros examples .ci/compile.py $(SHARED_BY_TESTS)

# Compile first: otherwise two test processes would compile the same functions at the same time.
.PHONY: compiled
compiled: venv ## compile what replays, fits and sweeps run, unless it is cached
	$(RUN) python .ci/compile.py

.PHONY: check-tests
check-tests: compiled ## run the tests that are not marked slow
	$(QUICK_TESTS)

.PHONY: browser
browser: ## install a browser for the tests of reports (needs apt and root)
	@.ci/browser

.PHONY: check-slow
check-slow: compiled browser ## run the tests that are marked slow
	$(RUN) python -m $(PYTEST) --hypothesis-profile=thorough -m slow

# Tracing makes tests 2.7 times slower: a share of the examples is enough to reach all code.
.PHONY: check-coverage
check-coverage: compiled ## check branch coverage: core/ 100 %, the package 90 %
	$(RUN) python -m coverage erase
	$(RUN) python -m coverage run -m $(PYTEST) -m 'not slow' $(UNTRACED:%=--ignore=%)
	$(RUN) python -m coverage combine --quiet
	$(RUN) python -m coverage report --fail-under=90
	$(RUN) python -m coverage report --fail-under=100 --include='fuzzy_fusion_ros/core/*'

.PHONY: mutants
mutants: venv ## mutation tests: change the code at random, report changes that no test notices (ARGS="core --sample 50")
	@$(RUN) python test/mutate.py $(ARGS)

.PHONY: format
format: venv ## format the code, and fix what ruff can
	$(RUN) python -m ruff check --fix --quiet .
	$(RUN) python -m ruff format .

.PHONY: clean
clean: ## remove builds, caches and measurements; .venv stays
	rm -rf build install log dist *.egg-info .coverage* .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find fuzzy_fusion_ros test -name __pycache__ -prune -exec rm -rf {} +
