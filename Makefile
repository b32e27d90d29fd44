# treelet from a fresh checkout: needs python3 (with venv), a C++20 compiler and make.
# Everything else goes into .venv, CMake and Ninja too where the system's are missing or old.

PYTHON ?= python3
MESH ?=
ARGS ?=

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
STAMPS := $(VENV)/.stamps
# One compiler for both the C++ and the Python build: unless told, the latter would take the one that
# Python itself was compiled with, which need not be on this machine.
ifeq ($(origin CXX),default)
  CXX := $(shell command -v c++ || command -v g++ || command -v clang++)
endif
export CXX
export PATH := $(CURDIR)/$(BIN):$(PATH)

# A C++ compiler of this project takes up to 1 GB: leave no machine without memory.
CORES := $(shell getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
GIGABYTES := $(shell awk '/MemAvailable/ {print int($$2 / 1048576) + 1}' /proc/meminfo 2>/dev/null || echo 8)
JOBS ?= $(shell echo "$(CORES) $(GIGABYTES)" | awk '{print ($$1 < $$2) ? $$1 : $$2}')
export CMAKE_BUILD_PARALLEL_LEVEL := $(JOBS)
export CTEST_PARALLEL_LEVEL := $(JOBS)

CPP_DIRS := $(wildcard src python/bindings tests bench examples)
PYTHON_DIRS := $(wildcard python tests tools bench examples docs/conf.py)
CPP_NAMES := -name '*.h' -o -name '*.inl' -o -name '*.cpp' -o -name '*.cu' -o -name '*.cuh'
CPP_FILES = $(shell find $(CPP_DIRS) $(CPP_NAMES))
EXTENSION_INPUTS := CMakeLists.txt $(wildcard cmake/*) \
  $(shell find $(wildcard src python/bindings) $(CPP_NAMES))

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo test test-cpp test-python test-cuda lint format bench bench-peers sanitize sanitize-address sanitize-thread cuda gpu docs wheel install clean

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "  Variables: PYTHON=python3.12  JOBS=2  MESH=path.ply (demo)  ARGS=... (demo, bench, bench-peers, gpu, test-python)"

demo: $(STAMPS)/package ## Build trees of a scene (or MESH=path.ply), trace, plot: results in out/
	$(BIN)/treelet demo $(if $(MESH),"$(MESH)") $(ARGS)

test: test-cpp test-python test-cuda ## Run the C++ and the Python tests

test-cpp: $(STAMPS)/native
	@$(call configured,release)
	cmake --build --preset release
	ctest --preset release

test-python: $(STAMPS)/package
	$(BIN)/python -m pytest $(ARGS)

# Kernels run on the host here and in test-cpp: no GPU is needed (tests/emulator/README.md).
test-cuda: $(STAMPS)/package
	@cmake --preset release --log-level=WARNING > /dev/null  # again: it may find nanobind now
	cmake --build --preset release --target treelet_emulated_python
	$(BIN)/python tests/python/run_emulated.py build/release/emulated \
	  tests/python/test_cuda_arrays.py tests/python/test_cuda_array_checks.py tests/python/test_cuda_bench.py \
	  tests/python/test_cuda_host_rays.py tests/python/test_cuda_hit_lists.py tests/python/test_cuda_offset.py \
	  tests/python/test_cuda_point_queries.py \
	  tests/python/test_cuda_streams.py tests/python/test_render_cuda.py tests/python/test_cli_cuda.py

lint: $(STAMPS)/lint ## Check formatting, style, layering and sizes
	$(BIN)/ruff check $(PYTHON_DIRS)
	$(BIN)/ruff format --check $(PYTHON_DIRS)
	$(BIN)/clang-format --dry-run -Werror $(CPP_FILES)
	$(BIN)/python tools/check_layers.py
	$(BIN)/python tools/check_sizes.py
	$(BIN)/python tools/check_device_code.py

format: $(STAMPS)/lint ## Rewrite the sources in the project's format
	$(BIN)/ruff check --fix $(PYTHON_DIRS)
	$(BIN)/ruff format $(PYTHON_DIRS)
	$(BIN)/clang-format -i $(CPP_FILES)

bench: $(STAMPS)/package ## Measure this machine
	$(BIN)/treelet bench $(ARGS)

bench-peers: $(STAMPS)/package ## Race Embree (4, or the one in the embreex package): lines in out/peers
	@$(call configured,peers)
	cmake --build --preset peers
	$(BIN)/python bench/peers/run.py --harness build/peers/bench/peers/treelet_peers $(ARGS)

sanitize: sanitize-address sanitize-thread ## Run the C++ tests, without the slow ones, under the sanitizers

sanitize-address: $(STAMPS)/native
	@$(call configured,asan)
	cmake --build --preset asan
	ctest --preset asan

sanitize-thread: $(STAMPS)/native
	@$(call configured,tsan)
	cmake --build --preset tsan
	ctest --preset tsan

# Tracing spills what is alive across the call of the exact triangle test, which few triangles need.
SPILLS := --allow-spill 'trace_rays*' 'do_each_item*' 'visit_exactly*' '*triple_product*' '*exact_volume*'

cuda: $(STAMPS)/cuda ## Compile the CUDA code, which needs no GPU, and list what its kernels use
	@$(call configured,cuda)
	cmake --build --preset cuda
	$(BIN)/python tools/kernel_resources.py build/cuda $(SPILLS)

gpu: ## Test and measure on this machine's GPU, with what is installed (CUDA, CMake, nanobind, ...)
	$(PYTHON) tools/gpu.py $(ARGS)

docs: $(STAMPS)/docs ## Build the documentation in out/docs; a warning or a broken link is an error
	$(BIN)/python -m sphinx -b html -W --keep-going -q docs out/docs/html
	@echo "Open out/docs/html/index.html"

# In an environment of their own, from the source distribution alone: whatever that lacks is found missing here.
wheel: $(STAMPS)/wheel ## Build the source distribution and from it the wheel, and check that: results in dist/
	rm -rf dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/python tools/check_wheel.py dist/treelet-*.whl

install: $(STAMPS)/package ## Build the Python package into .venv (editable)

clean: ## Remove everything that make made, .venv included
	rm -rf build dist out $(VENV)

# Configures build/<preset> once; later changes are noticed by the build itself.
configured = test -f build/$(1)/build.ninja || cmake --preset $(1) --log-level=WARNING > /dev/null

$(STAMPS)/venv:
	@echo "Setting up $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv $(VENV) || { \
	  echo "Could not create a virtual environment: Python 3.10 or later with venv is needed" \
	       "(Debian, Ubuntu: apt install python3-venv)." >&2; exit 1; }
	@$(PIP) install --upgrade "pip>=25.1"
	@mkdir -p $(STAMPS) && touch $@

$(STAMPS)/native: $(STAMPS)/venv tools/missing_build_tools.py
	@missing="$$($(BIN)/python tools/missing_build_tools.py)"; \
	 test -z "$$missing" || { echo "Installing $$missing into $(VENV)"; $(PIP) install $$missing; }
	@touch $@

$(STAMPS)/lint: $(STAMPS)/venv pyproject.toml
	@$(PIP) install --group lint
	@touch $@

$(STAMPS)/wheel: $(STAMPS)/native pyproject.toml
	@$(PIP) install --group wheel
	@touch $@

$(STAMPS)/docs: $(STAMPS)/package pyproject.toml
	@$(PIP) install --group docs
	@touch $@

$(STAMPS)/cuda: $(STAMPS)/native pyproject.toml
	@$(PIP) install --group cuda
	@touch $@

$(STAMPS)/build-requirements: $(STAMPS)/native pyproject.toml
	@$(PIP) install --group build
	@touch $@

# Editable, so that Python changes need no rebuild; without isolation and with a build folder that
# stays, so that C++ changes recompile only what they touch.
$(STAMPS)/package: $(STAMPS)/build-requirements $(EXTENSION_INPUTS)
	@echo "Building the Python package"
	@$(PIP) install --no-build-isolation --config-settings=build-dir=build/python \
	  --editable ".[test]"
	@touch $@
