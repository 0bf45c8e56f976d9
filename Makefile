# Everything here needs Python 3.11 or later and make; the rest is installed into .venv at the root.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
LOCK := requirements/dev.lock
READY := $(VENV)/ready
BENCH_VENV := .venv-bench
BENCH_BIN := $(BENCH_VENV)/$(notdir $(BIN))
BENCH_LOCK := requirements/bench.lock
BENCH_READY := $(BENCH_VENV)/ready
WORKERS ?= 2
OUT ?= out/pictures
# Generated tests draw the same examples each time, also where they go through sets.
export PYTHONHASHSEED := 0
# The tests start hundreds of interpreters: without bytecode each compiles all of dampyr, and each worker all of the tests.
unexport PYTHONDONTWRITEBYTECODE
# The workers share the cores: with threads of its own, OpenBLAS takes 200 times as long for an exponential of a small matrix.
export OPENBLAS_NUM_THREADS := 1

.PHONY: help demo test prove endure quick check docs site bench pictures kernels lock clean compiler octave chromium axe blas wine rumoca firmware firmware-tools

help:
	@echo "make demo    a simulated campaign, from records to a building in an earthquake, as one page in out/demo"
	@echo "make test    the tests, without the long proofs"
	@echo "make prove   the long proofs (fixed seeds)"
	@echo "make endure  statistics of many repeats and the bench in real time, hours on a machine with nothing else to do;"
	@echo "             NAME=kills: the tests whose names hold that"
	@echo "make check   style, types, names, the layers of the packages, and no copyright notice of others"
	@echo "make quick   the quick part of that: style, names and copyright, some seconds"
	@echo "make firmware   the Arduino Uno's program, out/firmware/dampyr-uno.hex, with its size (BAUD=115200, DIRECTION_PIN=1)"
	@echo "make docs    the generated lists and pages of docs, written again"
	@echo "make site    the documentation as one site, out/site/index.html, without a network"
	@echo "make bench   timings on this machine, printed and never asserted (BENCH=million: that one)"
	@echo "make pictures  every page of the console as PNG and every report as PDF, in OUT=$(OUT)"
	@echo "make kernels   the compiled kernels that a wheel takes along, of this Python and kind of machine, in three minutes"
	@echo "make lock    resolve $(LOCK) and $(BENCH_LOCK) again (needs uv)"
	@echo "make clean   remove .venv, .venv-bench, out and all caches"

define environment
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "dampyr needs Python 3.11 or later, and $(PYTHON) is not; name another one: make PYTHON=python3.12 ..." >&2; \
	  exit 1; }
	$(PYTHON) -m venv --clear $(1)
	$(2)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $(LOCK)
	$(2)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps -e .
endef

# The environment is made again whenever the lock is newer than it.
$(READY): $(LOCK)
	$(call environment,$(VENV),$(BIN))
	@touch $(READY)

# The C export is compiled in a test. Without a compiler that test is skipped, and says so.
compiler:
	@command -v gcc >/dev/null 2>&1 || command -v cc >/dev/null 2>&1 || { \
	  [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -qq >/dev/null 2>&1 && \
	  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq gcc libc6-dev >/dev/null 2>&1; } || \
	  echo "no C compiler was found or installed; the test that compiles the C export will be skipped"

# The Uno's program is compiled with avr-gcc and tried in simavr. Without these its tests are skipped, and say so.
firmware-tools:
	@{ command -v avr-gcc >/dev/null 2>&1 && [ -f /usr/include/simavr/sim_avr.h ]; } || { \
	  [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -qq >/dev/null 2>&1 && \
	  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends gcc-avr binutils-avr avr-libc libsimavr-dev >/dev/null 2>&1; } || \
	  echo "avr-gcc or simavr was not found or installed; the tests of the Uno's program will be skipped"

firmware: firmware-tools
	@$(MAKE) --no-print-directory -C src/dampyr/rig/firmware/uno OUT=$(CURDIR)/out/firmware $(if $(BAUD),BAUD=$(BAUD)) \
	  $(if $(DIRECTION_PIN),DIRECTION_PIN=$(DIRECTION_PIN))
	@echo "out/firmware/dampyr-uno.hex; docs/how-to/firmware.md says how it is flashed"

# The console's pages are tried in Debian's Chromium. Without it those tests are skipped, and say so.
chromium:
	@command -v chromium >/dev/null 2>&1 || { \
	  [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -qq >/dev/null 2>&1 && \
	  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq chromium fonts-dejavu-core >/dev/null 2>&1; } || \
	  echo "no Chromium was found or installed; the tests of the console's pages will be skipped"

# The MATLAB export is run in GNU Octave. Without it its tests are skipped, and say so.
octave:
	@command -v octave-cli >/dev/null 2>&1 || { \
	  [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -qq >/dev/null 2>&1 && \
	  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends octave >/dev/null 2>&1; } || \
	  echo "no GNU Octave was found or installed; the tests of the MATLAB export will be skipped"

# axe-core checks labels and contrast of the console's pages.
AXE := out/axe/node_modules/axe-core/axe.min.js
axe:
	@[ -f $(AXE) ] || { command -v npm >/dev/null 2>&1 && \
	  npm install --silent --no-save --no-audit --no-fund --ignore-scripts --prefix out/axe axe-core@4.14.1 >/dev/null 2>&1; } || \
	  echo "axe-core was not found or installed (it needs npm); the tests of the console's labels and contrast will be skipped"

# The Windows library of an FMU is loaded in Wine. Without it that proof is skipped, and says so.
wine:
	@command -v wine64 >/dev/null 2>&1 || [ -x /usr/lib/wine/wine64 ] || { \
	  [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -qq >/dev/null 2>&1 && \
	  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends wine64 >/dev/null 2>&1; } || \
	  echo "no Wine was found or installed; the proof of FMUs for Windows will be skipped"

# The Modelica export is compiled by Rumoca. Without it these proofs are skipped, and say so.
rumoca: $(READY)
	@$(BIN)/python -c "import rumoca" >/dev/null 2>&1 || \
	  $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps rumoca==0.10.2 >/dev/null 2>&1 || \
	  echo "Rumoca was not found or installed; the proofs that compile the Modelica export will be skipped"

demo: $(READY)
	$(BIN)/dampyr demo --out out/demo
	@echo "dampyr doctor --warm compiles ahead what further commands need, in about two minutes, once"

test: $(READY) compiler firmware-tools octave blas chromium axe
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -m "not prove and not by_hand"

prove: $(READY) compiler firmware-tools octave blas chromium axe wine rumoca
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -m "prove and not by_hand"

endure: $(READY) compiler firmware-tools octave blas chromium axe wine
	$(BIN)/python -m pytest --endure -o faulthandler_timeout=0 -m "endure or by_hand" $(if $(NAME),-k "$(NAME)")

quick: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python tools/check_names.py
	$(BIN)/python tools/check_copyright.py

check: quick
	$(BIN)/mypy
	$(BIN)/lint-imports

# Of another Python than that of .venv: run the tool with one that has dampyr and its dependencies.
kernels: $(READY)
	$(BIN)/python tools/make_kernels.py

docs: $(READY)
	$(BIN)/python tools/make_docs.py

site: $(READY)
	$(BIN)/python tools/make_site.py

# Benches have an environment of their own: their peers (OpenSees, jax) are large, and nothing else needs them. A peer that
# cannot be installed is told of in the table.
$(BENCH_READY): $(LOCK) $(BENCH_LOCK)
	$(call environment,$(BENCH_VENV),$(BENCH_BIN))
	$(BENCH_BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $(BENCH_LOCK) || \
	  echo "the peers in $(BENCH_LOCK) were not installed; the tables say who is missing" >&2
	@touch $(BENCH_READY)

# OpenSees on Linux is linked with the system's BLAS and LAPACK.
blas:
	@[ "$$(uname -s)" != Linux ] || PATH="$$PATH:/sbin" ldconfig -p 2>/dev/null | grep -q 'liblapack\.so\.3' || { \
	  [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -qq >/dev/null 2>&1 && \
	  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq libblas3 liblapack3 >/dev/null 2>&1; } || \
	  echo "no BLAS and LAPACK were found or installed; OpenSees will be missing from the tables"

bench: $(BENCH_READY) blas
	$(BENCH_BIN)/python -m benchmarks $(BENCH)

# A quarter of an hour: it makes the records, fits and responses that are shown.
pictures: $(READY) chromium
	$(BIN)/python tools/pictures.py $(OUT)

lock:
	@command -v uv >/dev/null 2>&1 || { echo "make lock needs uv: pip install uv" >&2; exit 1; }
	uv pip compile pyproject.toml --group dev --constraint requirements/constraints.txt \
	  --universal --python-version 3.11 --generate-hashes --upgrade \
	  --no-emit-index-url --no-emit-find-links --no-annotate --custom-compile-command "make lock" \
	  --quiet --output-file $(LOCK)
	uv pip compile requirements/bench.in --constraint $(LOCK) \
	  --universal --python-version 3.11 --generate-hashes --upgrade \
	  --no-emit-index-url --no-emit-find-links --no-annotate --custom-compile-command "make lock" \
	  --quiet --output-file $(BENCH_LOCK)

clean:
	rm -rf $(VENV) $(BENCH_VENV) out build dist .pytest_cache .ruff_cache .mypy_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
