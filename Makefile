# make demo: set up and watch the robot align; make test, make lint: what CI runs.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: setup demo test test-wheel lint format wheel clean clean-compiled

setup: $(STAMP)

$(STAMP): requirements.lock pyproject.toml .ci/check-system
	@bash .ci/check-system $(PYTHON)
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@$(BIN)/vipr compile
	@touch $@

demo: setup
	$(BIN)/vipr run align --seed 1 --out out/demo

test: setup
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 -q

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

wheel: setup
	rm -rf build dist
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist .

test-wheel: wheel
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --target build/site dist/vipr-*.whl
	PYTHONPATH=build/site VIPR_INSTALLED=build/site OPENBLAS_NUM_THREADS=1 \
	$(BIN)/python -m pytest -n 2 -q tests/test_packaging.py tests/test_laws.py tests/models

clean:
	rm -rf $(VENV) build dist out *.egg-info

# What numba keeps of compiled functions (systems/compiled.py), of earlier sources too.
clean-compiled:
	find systems -type d -path '*__pycache__/compiled-*' -prune -exec rm -r {} +
