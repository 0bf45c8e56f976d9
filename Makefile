# Everything here needs Python 3.11 or later and make; the rest is installed into .venv at the root.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
LOCK := requirements/dev.lock
READY := $(VENV)/ready
WORKERS ?= 2

.PHONY: help demo test prove check bench lock clean compiler

help:
	@echo "make demo    a simulated campaign, from records to a building in an earthquake, as one page in out/demo"
	@echo "make test    the tests, without the long proofs"
	@echo "make prove   the long proofs (fixed seeds)"
	@echo "make check   style, types and the layers of the house"
	@echo "make bench   timings on this machine, printed and never asserted"
	@echo "make lock    resolve $(LOCK) again (needs uv)"
	@echo "make clean   remove .venv, out and all caches"

# The environment is made again whenever the lock is newer than it.
$(READY): $(LOCK)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "dampyr needs Python 3.11 or later, and $(PYTHON) is not; name another one: make PYTHON=python3.12 ..." >&2; \
	  exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $(LOCK)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps -e .
	@touch $(READY)

# The C export is compiled in a test. Without a compiler that test is skipped, and says so.
compiler:
	@command -v gcc >/dev/null 2>&1 || command -v cc >/dev/null 2>&1 || { \
	  [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -qq >/dev/null 2>&1 && \
	  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq gcc libc6-dev >/dev/null 2>&1; } || \
	  echo "no C compiler was found or installed; the test that compiles the C export will be skipped"

demo: $(READY)
	$(BIN)/dampyr demo --out out/demo

test: $(READY) compiler
	$(BIN)/python -m pytest -n $(WORKERS) -m "not prove"

prove: $(READY) compiler
	$(BIN)/python -m pytest -n $(WORKERS) -m prove

check: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(READY)
	$(BIN)/python -m benchmarks

lock:
	@command -v uv >/dev/null 2>&1 || { echo "make lock needs uv: pip install uv" >&2; exit 1; }
	uv pip compile pyproject.toml --group dev --constraint requirements/constraints.txt \
	  --universal --python-version 3.11 --generate-hashes --upgrade \
	  --no-emit-index-url --no-emit-find-links --no-annotate --custom-compile-command "make lock" \
	  --quiet --output-file $(LOCK)

clean:
	rm -rf $(VENV) out build dist .pytest_cache .ruff_cache .mypy_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
