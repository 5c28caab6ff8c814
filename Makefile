# make demo   install into .venv and run the main example
# make test   install into .venv with the developers' tools; lint, types, tests
# make bench  all benchmarks as ratios, into benchmarks/RESULTS.md, with peers in an environment of their own
# make check  the same without slow tests, for while one works
# make endurance  runs whose processes are killed, disks that are full, long random interleavings: hours; SEED=7 for others
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
PEERS := benchmarks/.peers
# Bytecode, and the tables of the grammar beside it.
COMPILE = python -m compileall -q graspdsl cli && PYTHONDONTWRITEBYTECODE= $(@D)/bin/python -c \
	"from graspdsl.notation.syntax import grammar; grammar()"

.PHONY: demo experiments bench bench-experiments test check endurance lint types unit clean

# In the engine that is many times faster, and has wheels for every CPython.
demo: $(VENV)/.installed
	$(BIN)/graspdsl run specs/towel_roll_two_contacts.yaml --set scene.world=mujoco

# The experiments are of the bullet world, whose engine has no wheels for CPython 3.12 and later.
WITHOUT_BULLET = from importlib.util import find_spec; print('' if find_spec('pybullet') else '--set scene.world=mujoco')

# The chapter's four experiments, and what of them agrees with the chapter; SEED=7 for other numbers.
experiments: $(VENV)/.installed
	$(BIN)/graspdsl experiments specs/experiments/*.yaml $(if $(SEED),--seed $(SEED)) \
		$$($(BIN)/python -c "$(WITHOUT_BULLET)")

bench: $(PEERS)/.installed
	$(PEERS)/bin/python benchmarks/run_all.py

# The four experiments in one engine and in the other, a sample of their trials: TRIALS=all for all 178.
bench-experiments: $(PEERS)/.installed
	$(PEERS)/bin/python benchmarks/experiments.py $(TRIALS)

test: lint types unit

check: lint types
	$(BIN)/pytest -n auto -m "not slow"

endurance: $(VENV)/.installed-dev
	cd tests && ../$(BIN)/python -m endurance $(if $(SEED),--seed $(SEED))
	$(BIN)/pytest -n 0 tests/endurance/many_interleavings.py $(if $(SEED),--hypothesis-seed $(SEED))

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# The folder cli/ is the package graspdsl.cli: mypy sees the packages as they are installed.
types: $(VENV)/.installed-dev
	rm -rf build/types && mkdir -p build/types/graspdsl
	ln -s $(CURDIR)/graspdsl/* $(CURDIR)/cli build/types/graspdsl/
	cd build/types && ../../$(BIN)/mypy --config-file ../../pyproject.toml --package graspdsl
	cd build/types && ../../$(BIN)/mypy --config-file ../../pyproject.toml --scripts-are-modules ../../benchmarks/*.py ../../docs/*.py ../../docs/examples/*.py

unit: $(VENV)/.installed-dev
	$(BIN)/pytest -n auto --dist worksteal

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --editable .
	$(BIN)/$(COMPILE)
	touch $@

$(VENV)/.installed-dev: pyproject.toml $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	$(BIN)/$(COMPILE)
	touch $@ $(VENV)/.installed

$(PEERS)/.installed: pyproject.toml benchmarks/peers.txt
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/python -m pip install --quiet --editable . --requirement benchmarks/peers.txt
	$(PEERS)/bin/$(COMPILE)
	touch $@

clean:
	rm -rf $(VENV) $(PEERS) build dist *.egg-info
