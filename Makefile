# Every target makes what it needs: a local .venv with the locked dependencies, nothing global. What a user needs comes
# first (`make reproduce`); what developers and the site need joins it where a target asks for it.
# PYTHON=python3.12 chooses the Python, JOBS=8 the number of test workers.
BIN := .venv/bin
READY := .venv/.ready
DEV_READY := .venv/.dev-ready
SITE_READY := .venv/.site-ready
JOBS ?= 2

export PYRIGHT_PYTHON_IGNORE_WARNINGS = 1
# Where it is set, each worker and each command that a test starts would compile every Python file anew.
export PYTHONDONTWRITEBYTECODE =
# A worker begins with its half of the files, so that few kernels and kept motions are made twice, and helps at the end.
TESTS := $(BIN)/python -m pytest -q -n $(JOBS) --dist worksteal

.PHONY: help venv reproduce test test-slow test-exhaustive mutants torture lint format type bench docs site links all lock clean
.DEFAULT_GOAL := help

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1|\2/p' Makefile | awk -F'|' '{ printf "%-18s %s\n", $$1, $$2 }'

venv: $(READY) ## the local .venv, with vibrocap and what a user of it needs; the others make it too

reproduce: $(READY) ## the paper: figures, claims and one HTML report, in out/
	@$(BIN)/vibrocap reproduce --out out

test: $(DEV_READY) ## the tests, without the slow ones
	@$(TESTS)

test-slow: $(DEV_READY) ## the slow tests alone
	@$(TESTS) -m 'slow and not exhaustive' || [ $$? -eq 5 ] # 5: there is none

test-exhaustive: $(DEV_READY) ## the long rest of tables of which the others run a part: before a release
	@$(TESTS) -m exhaustive

mutants: $(DEV_READY) ## 200 faults planted in copies of the source, and which fast tests notice each: a night
	@mkdir -p build
	@$(BIN)/python tests/mutants.py --out build/mutants.json

torture: $(DEV_READY) ## kills, links, damage, full disks, waits, fuzzed cases and commands (docs/trust.md)
	@$(BIN)/python -m torture

lint: $(DEV_READY) ## style, format and import contracts
	@$(BIN)/ruff check --quiet
	@$(BIN)/ruff format --check --quiet
	@$(BIN)/lint-imports --no-cache --no-logo

format: $(DEV_READY) ## put the code into the form that lint asks for
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

type: $(DEV_READY) ## the types
	@$(BIN)/pyright

bench: $(DEV_READY) ## the speed, side by side with other solvers
	@$(BIN)/python -m benchmarks

docs: $(DEV_READY) ## run every snippet of the documentation
	@$(BIN)/python -m pytest -q tests/test_docs.py

site: $(SITE_READY) ## the documentation as a site, in build/site/html (its tutorials and gallery are run)
	@$(BIN)/python -m website

links: $(SITE_READY) ## the same, and whether its links to other hosts still lead somewhere: asks the network
	@$(BIN)/python -m website --links

all: lint type test docs reproduce ## lint, type, test, docs and reproduce

$(READY): requirements.lock pyproject.toml .ci/environment
	@PYTHON='$(PYTHON)' sh .ci/environment
	@touch $@

$(DEV_READY) $(SITE_READY): .venv/.%-ready: .ci/%-requirements.txt $(READY)
	@sh .ci/environment $<
	@touch $@

$(SITE_READY): $(DEV_READY)

# names, versions and hashes of what is asked for, for all Pythons and systems
LOCK := uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-annotate \
	--no-sources --custom-compile-command 'make lock'

lock: ## resolve the dependencies anew (needs uv)
	@printf '%s\n' 'hatchling>=1.27' 'editables>=0.5' | $(LOCK) pyproject.toml - --fork-strategy fewest \
		--extra plot --extra sweep --output-file requirements.lock
	@$(LOCK) pyproject.toml --fork-strategy fewest --extra dev --extra ref --constraint requirements.lock \
		--output-file .ci/dev-requirements.txt
	@$(LOCK) pyproject.toml --fork-strategy fewest --extra docs --constraint .ci/dev-requirements.txt \
		--output-file .ci/site-requirements.txt
	@printf '%s\n' 'cuda-bindings>=12.9.1,<13' 'nvidia-cuda-nvcc-cu12==12.9.86' | \
		$(LOCK) - --output-file extras/gpu/requirements.txt
	@printf '%s\n' 'fmpy>=0.3.22' 'gymnasium>=1.0' 'mujoco>=3.3' 'ziglang>=0.13' | \
		$(LOCK) - --constraint .ci/dev-requirements.txt --constraint .ci/site-requirements.txt \
		--output-file .ci/exchange-requirements.txt
	@printf '%s\n' 'crc32c==2.8' 'xarray==2026.1.0' 'zarr==3.1.3' | $(LOCK) - --no-deps --output-file .ci/lowest-requirements.txt
	@for version in 0.45 0.50; do echo "llvmlite==$$version.*" | \
		$(LOCK) - --no-deps --output-file .ci/llvmlite-$$version-requirements.txt; done

clean: ## remove results and caches (.venv stays)
	@rm -rf out dist build .pytest_cache .ruff_cache .import_linter_cache .hypothesis .benchmarks
	@find src tests benchmarks examples website -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true
