# every target sets up what it needs; a fresh machine wants python3 with pip and venv, and make
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
WORKERS ?= 2
# some hundred processes begin in the tests: what one of them compiles, the next finds
export PYTHONDONTWRITEBYTECODE =

.PHONY: setup reproduce picture test lint types layers unit core package browser pages docs bench slow lock clean

setup: $(STAMP)

# uv comes from its own hashed entry in the lock, then installs the rest of it
$(STAMP): requirements.lock pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	sed -n '/^uv==/,/[^\\]$$/p' requirements.lock > $(VENV)/uv.lock
	test -x $(BIN)/uv || $(BIN)/python -m pip install --quiet --require-hashes --no-deps -r $(VENV)/uv.lock
	VIRTUAL_ENV=$(CURDIR)/$(VENV) $(BIN)/uv pip install --quiet --require-hashes --compile-bytecode -r requirements.lock
	VIRTUAL_ENV=$(CURDIR)/$(VENV) $(BIN)/uv pip install --quiet --no-deps --no-build-isolation --editable .
	$(BIN)/python -m compileall -q src reproduction
	touch $@

reproduce: $(STAMP)
	$(BIN)/fascicle reproduce kim2021 --out out/kim2021 --overwrite

# the README and the docs show the reproduction's own Fig. 9 and claims, the explorer and a leg at work
picture: reproduce browser
	cp out/kim2021/figure_09.png docs/_static/readme.png
	cp out/kim2021/claims.json docs/_static/claims.json
	$(BIN)/python docs/explorer_picture.py docs/_static/explorer.gif
	$(BIN)/python docs/walker_leg.py docs/_static/walker_leg.gif

# beside one another: browsers keep a core waiting now and then
test: lint
	$(MAKE) --jobs=4 layers types unit pages

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/pyright

layers: $(STAMP)
	$(BIN)/lint-imports

# of glibc: memory that is given back to the system is asked for again at once, a tenth of the time
KEEPING := MALLOC_MMAP_THRESHOLD_=33554432 MALLOC_TRIM_THRESHOLD_=1000000000 MALLOC_TOP_PAD_=16777216

# Debian's chromium for the browser tests; where it is missing and can't be had, they are skipped
browser:
	@command -v chromium > /dev/null \
		|| { test "$$(id -u)" = 0 && command -v apt-get > /dev/null && apt-get update -qq \
			&& apt-get install -y -qq --no-install-recommends chromium fonts-dejavu-core > /dev/null; } \
		|| echo "no chromium, and it can't be installed: the browser tests are skipped"

unit: $(STAMP) browser
	OPENBLAS_NUM_THREADS=1 $(KEEPING) $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal

# NumPy and the core's dependencies alone, as `pip install fascicle` brings them: tests that need
# no more run here, too
CORE := .venv-core
$(CORE)/.installed: requirements.lock pyproject.toml $(STAMP)
	test -x $(CORE)/bin/python || $(BIN)/python -m venv --without-pip $(CORE)
	sed 's/ *\\$$//; /^ *--hash/d' requirements.lock > $(CORE)/versions.txt
	VIRTUAL_ENV=$(CURDIR)/$(CORE) $(BIN)/uv pip install --quiet --compile-bytecode --constraint $(CORE)/versions.txt \
		numpy scipy attrs pydantic pint tomlkit typer rich pytest hypothesis
	touch $@

core: $(CORE)/.installed
	PYTHONPATH=src OPENBLAS_NUM_THREADS=1 $(CORE)/bin/python -m pytest -q -p no:cacheprovider \
		tests/unit/core tests/unit/io
	.ci/package core

# tests of the core alone, then wheel and sdist in fresh environments, with each extra
package: core
	.ci/package

# compiled as a user's programs are, where `unit` spares the compiler
slow: $(STAMP)
	XLA_FLAGS= OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -m slow

# every page of the docs, executed but for the longest, which `docs/conf.py` lists
pages: $(STAMP)
	$(KEEPING) $(BIN)/python -m sphinx -t short -W --keep-going -q -b html docs docs/_build/pages

# page by page where somebody watches, and nothing else runs; one more at once, as one waits
docs: $(STAMP)
	$(KEEPING) $(BIN)/python -m sphinx -j $$(($(WORKERS) + 1)) -W --keep-going $$(test -t 2 || echo -q) -b html docs docs/_build/html

# takes some ten minutes on a quiet machine
bench: $(STAMP)
	$(BIN)/python benchmarks/run_all.py

# extras that nothing uses yet stay out, so that set-up is quick
lock:
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header \
		--extra docs --extra dev --extra all \
		--output-file requirements.lock pyproject.toml

clean:
	rm -rf out dist docs/_build docs/jupyter_execute .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find src reproduction tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
