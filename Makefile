# make demo   see it work              make test   run every test
# make check  ruff, mypy, imports      make bench  the measured tables       make soak  the full figures
# make docs   build the manual         make site   the same of every version, for hosting
# make protocols  regenerate the MAVLink dialect, C headers, the dissector
# make release build and try what is published    make deb  the Debian package, for this computer's release and processor
# make hashes pin what a payload runs on, by hash, after a change of constraints.txt
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SPEECH ?= ../shared/speech
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet install --constraint constraints.txt
BENCH := --settings S1,S2,S3 --talkers ls3005,ls3331,ls2414,ls3080,ls533 --speech $(SPEECH)
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
COMPILED := PYTHONDONTWRITEBYTECODE=  # hundreds of processes are started

HASHED := --extra capture --extra serial --extra can --extra gpio --extra ground --extra stream --extra voice
.PHONY: demo test check bench soak docs site protocols hashes release deb clean
.DELETE_ON_ERROR:

demo: $(VENV)/.demo
	@if [ -t 1 ]; then page=--page; fi; $(BIN)/ross sitl --out out/demo $$page

test: $(VENV)/.dev
	@sh tests/support/debian_packages.sh || true
	$(ONE_THREAD) $(COMPILED) $(BIN)/python tests/support/lanes.py $(ARGS)

check: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.dev
	$(BIN)/ross study separation $(BENCH) --seed 1 --out out/bench/separation
	$(BIN)/ross study exploration $(BENCH) --explorers joint --seed 3 --out out/bench/exploration
	$(BIN)/ross study missions --places written --draws 4 --seed 0 --turns-unheard --speech $(SPEECH) --out out/bench/rooms
	$(BIN)/python -m ross_sim.study.voiceprint_study --speech $(SPEECH) --out out/bench/voice-prints.csv
	$(PIP) --group bench
	$(BIN)/python -m ross_sim.study.separation_cost --speech $(SPEECH) --out out/bench/costs.csv
	$(BIN)/python -m ross_sim.study.live_separation out/bench/live-separation.csv --speech $(SPEECH)

soak: $(VENV)/.dev
	$(ONE_THREAD) $(BIN)/pytest --numprocesses 2 -m 'soak or random' --hypothesis-profile soak --timeout 7200 $(ARGS)

docs: $(VENV)/.dev
	$(BIN)/sphinx-build -W --keep-going -b html docs docs/_build/html

site: $(VENV)/.dev
	$(BIN)/python docs/site.py

protocols: $(VENV)/.dev
	$(BIN)/python protocols/generate.py

hashes: $(BIN)/python  # of what a payload runs on, for every platform: to be renewed with constraints.txt
	$(PIP) uv
	$(BIN)/uv pip compile pyproject.toml $(HASHED) --constraint constraints.txt --python-version 3.11 --universal \
	  --generate-hashes --no-header --no-annotate --no-emit-index-url --no-emit-find-links --quiet \
	  --output-file requirements-hashed.txt

release: | $(BIN)/python  # into dist/, see .ci/release.py; its tools have an environment of their own
	$(PYTHON) -m venv $(VENV)/release
	$(VENV)/release/bin/python -m pip --disable-pip-version-check --quiet install --upgrade 'pip>=25.1'
	$(VENV)/release/bin/python -m pip --quiet install --constraint constraints.txt --group release
	$(VENV)/release/bin/python .ci/release.py

deb:  # into dist/; EXTRAS and WHEELS as docs/how-to/debian-package.md tells
	sh docs/deploy/build-deb.sh

clean:
	rm -rf $(VENV) out docs/_build dist build

$(VENV)/.demo: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) --editable '.[sim,ground,stream]'
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) --editable '.[all]' --group dev
	$(PIP) --no-deps mavproxy  # without a window it needs nothing of the graphics that it asks for
	@touch $@ $(VENV)/.demo

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or newer is needed; $$($(PYTHON) --version) was found. Try: make PYTHON=python3.11"; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || if [ "$$(id -u)" = 0 ]; then \
	    apt-get update -qq && apt-get install -y -qq python3-venv; \
	  else echo "Python has no venv module here; type: sudo apt-get install python3-venv"; exit 2; fi
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip --disable-pip-version-check --quiet install --upgrade 'pip>=25.1'
