# Every verb of this project; `make help` lists them. They are the same by hand and in CI, and need
# nothing but python3 (3.11 or newer, with venv and headers), a C++17 compiler and make.

PYTHON ?= python3
UV_VERSION := 0.13.9
VENV := .venv
BIN := $(VENV)/bin
UV := $(BIN)/uv

# Tuned for this machine; `OMNIMORPH_NATIVE=OFF make setup` builds a module that travels.
OMNIMORPH_NATIVE ?= ON
# Warnings of our own C++ stop the build here; they do not stop someone who only installs us.
OMNIMORPH_WERROR ?= ON
export OMNIMORPH_NATIVE OMNIMORPH_WERROR

# Where the machine keeps a list of trusted certificates, that list counts, not the one inside uv.
ifneq ($(wildcard /etc/ssl/certs/ca-certificates.crt),)
export UV_SYSTEM_CERTS ?= 1
endif

# Tests on every core; those of one file stay together, as they share what was flown for them. Files
# go as they are sorted: those that take long, of the command line, first.
IN_PARALLEL := --numprocesses auto --dist loadfile --no-loadscope-reorder

# What the installed package is made of.
SOURCES := $(sort pyproject.toml CMakeLists.txt README.md LICENSE $(shell \
	find src core/include core/bindings -type f ! -name '*.pyc' ! -name '*.so'))
CPLUSPLUS := $(shell find core -name '*.hpp' -o -name '*.cpp')

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: setup reproduce test test-slow test-all mutants check format stub bench lock clean help always

setup: $(VENV)/installed  ## make .venv, install the locked packages, build and install omnimorph

reproduce: setup  ## reproduce the paper, claim by claim, in reproduction/report.html
	$(BIN)/omnimorph reproduce --out reproduction

test: setup  ## the quick tests
	$(BIN)/python -m pytest $(IN_PARALLEL) -m "not slow"

test-slow: setup $(VENV)/engines  ## all other tests; need clang, qemu, chromium and ffmpeg (.ci/run has the packages)
	$(BIN)/python -m pytest $(IN_PARALLEL) -m slow

test-all: test test-slow  ## both

mutants: setup  ## make each mistake of tests/mutants in a copy: tests must fail (ONLY="report cli" JOBS=2)
	$(BIN)/python -m tests.mutants.run $(ONLY) $(if $(JOBS),--jobs $(JOBS))

check: setup  ## format, lint, types, import layers
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run -Werror $(CPLUSPLUS)
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

format: setup  ## let ruff and clang-format format, and ruff mend what it can
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(BIN)/clang-format -i $(CPLUSPLUS)

stub: setup  ## write src/omnimorph/_core.pyi, what type checkers know of the compiled module
	$(BIN)/python -m nanobind.stubgen --quiet -m omnimorph._core -o src/omnimorph/_core.pyi

bench: setup  ## measure the speed on this machine
	$(BIN)/omnimorph bench

LOCK := pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	--no-emit-find-links --custom-compile-command "make lock" --upgrade

lock: $(VENV)/uv-$(UV_VERSION)  ## resolve what pyproject.toml and requirements.in name into both locks
	$(UV) $(LOCK) --extra view pyproject.toml requirements.in --output-file requirements.lock
	$(UV) $(LOCK) --constraint requirements.lock requirements-engines.in \
		--output-file requirements-engines.lock

clean:  ## remove everything that was made here
	rm -rf $(VENV) build dist reproduction .hypothesis .import_linter_cache .mypy_cache \
		.pytest_cache .ruff_cache

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

# --- how `setup` gets there: each file below is the mark of a step that is done ----------------

$(VENV)/uv-$(UV_VERSION):
	@$(PYTHON) -c "import sys; sys.version_info >= (3, 11) or sys.exit('Python 3.11 or newer is needed')"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv==$(UV_VERSION)
	@touch $@

$(VENV)/synced: requirements.lock $(VENV)/uv-$(UV_VERSION)
	$(UV) pip sync --quiet --compile-bytecode --python $(BIN)/python --require-hashes requirements.lock
	@touch $@

# What only slow tests need, on top; `setup` leaves it out.
$(VENV)/engines: requirements-engines.lock $(VENV)/synced
	$(UV) pip install --quiet --python $(BIN)/python --require-hashes --requirements $<
	@touch $@

# Rewritten only when it changes, so that a removed file or a turned switch also counts.
$(VENV)/inputs: always $(VENV)/synced
	@printf '%s\n' native=$(OMNIMORPH_NATIVE) werror=$(OMNIMORPH_WERROR) $(SOURCES) > $@.new
	@if cmp -s $@.new $@; then rm $@.new; else mv $@.new $@; fi

$(VENV)/installed: $(VENV)/synced $(VENV)/inputs $(SOURCES)
	$(UV) pip install --quiet --compile-bytecode --python $(BIN)/python --no-deps --no-build-isolation \
		--reinstall-package omnimorph .
	@touch $@
