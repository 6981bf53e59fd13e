# `make demo` and `make test` each make their own environment in .venv; nothing else is needed by hand.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.fric-installed

.PHONY: demo test tests pytest test-long legs lint ruff mypy contract bench fuzz reality docs docs-version figures data clean

$(STAMP): pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --no-compile --editable . --group dev
	touch $@

demo: $(STAMP)
	PATH="$(CURDIR)/$(BIN):$$PATH" sh data/demo.sh

# Bytecode is kept, also where an image sets otherwise: each worker, and each process of the tests, would compile all again.
# Of what is installed only that is compiled which is imported: a third of it.
export PYTHONDONTWRITEBYTECODE :=

# Each worker keeps BLAS to one thread: the threads of two would fight for the cores.
test test-long legs: export OMP_NUM_THREADS := 1

# Sets have the same order each time: what a test sees is no draw.
test test-long legs: export PYTHONHASHSEED := 0

# FRIC_LONG_SECONDS says how many seconds of those marked `long` are run, by their markers, other ones each day: 0 runs none.
# The checks run beside the tests; what each has to say comes in one piece, the tests' dots at once. Any that fails fails all.
# FRIC_LEGS names legs that follow, as tests under another processor's settings; `turn` is the one of this number of commits.
test: $(STAMP)
	$(MAKE) --no-print-directory --jobs 2 --output-sync=target lint tests
	$(if $(FRIC_LEGS),$(BIN)/python -m tests.legs $(FRIC_LEGS))

tests:
	$(MAKE) --no-print-directory --output-sync=none pytest

pytest: $(STAMP)
	MAKEFLAGS= $(BIN)/python -m pytest -n auto --dist worksteal

test-long: $(STAMP)
	$(BIN)/python -m pytest -n auto --dist worksteal -m long

legs: $(STAMP)
	$(BIN)/python -m tests.legs $(LEGS)

lint: ruff mypy contract

ruff: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# Without the collector of garbage, which mypy turns on again itself: it takes a fifth of the time, and mypy has 1.2 GB.
mypy: $(STAMP)
	$(BIN)/python -c "import gc; gc.disable(); gc.enable = gc.disable; from mypy.__main__ import console_entry; console_entry()"

contract: $(STAMP)
	$(BIN)/lint-imports

bench: $(STAMP)
	$(BIN)/python -m benchmarks

fuzz: $(STAMP)
	PYTHONPATH=. $(BIN)/python -m tests.fuzz --count $(or $(COUNT),20000) --workers $(or $(WORKERS),2) $(if $(SEED),--seed $(SEED))
	PYTHONPATH=. $(BIN)/python -m tests.fuzz --kills $(or $(KILLS),100) $(if $(SEED),--seed $(SEED))

reality: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.reality --write docs/reality.md

docs: $(STAMP)
	$(BIN)/typer fric.cli.main utils docs --name fric --title "Commands" --output docs/commands.md
	$(BIN)/python -c 'import fric.flaws; print(fric.flaws.page(), end="")' > docs/codes.md
	$(BIN)/python docs/examples.py
	$(BIN)/python -m pip install --quiet --group docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo 'Open $(CURDIR)/site/index.html'

# The site of this version beside those of others, with a list of them: make docs-version FOLDER=published
docs-version: docs
	$(BIN)/python docs/versions.py $(FOLDER)

figures: $(STAMP)
	PYTHONPATH=. $(BIN)/python docs/figures.py

data: $(STAMP)
	PATH="$(CURDIR)/$(BIN):$$PATH" sh data/make.sh

clean:
	rm -rf .venv build dist demo site
