# Two commands do everything on a fresh machine: `make demo` and `make test`.

PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin
BENCH = .venv-bench
MPI = .venv-mpi
MPI_PACKAGES = python3-petsc4py python3-mpi4py openmpi-bin python3-venv
PETSC4PY = /usr/lib/petscdir/petsc*/*-real/lib/python3/dist-packages
# Open MPI starts neither as root nor with more ranks than cores unless it is told to.
MPIRUN = OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OPENBLAS_NUM_THREADS=1 mpirun --oversubscribe
DEMO = demo
RUNS ?= 60000
SEED ?= 0
COUNT ?= 100

# Interpreters in which `make check-install` installs the package.
PYTHONS ?= $(foreach v,3.10 3.11 3.12 3.13 3.14,$(shell python$(v) -c "import sys; print(sys.executable)" 2>/dev/null))

.PHONY: demo test test-mpi lint bench golden fuzz attack docs man check-install clean

# Runs the main job: geodesic distance on the creature of data/, as VTK and PNG.
demo: $(VENV)/.installed
	@mkdir -p $(DEMO)
	$(BIN)/geomhw geodesic data/creature.obj -o $(DEMO)/creature.vtk --png $(DEMO)/creature.png
	@echo "Open $(CURDIR)/$(DEMO)/creature.png, and $(CURDIR)/$(DEMO)/creature.vtk in ParaView."

# One process per core, each with one thread for algebra (OpenBLAS) and for pictures (Mesa's llvmpipe). An idle process
# takes half of another's remaining tests (worksteal), so that neighbors stay together and share fixtures. The program is
# compiled first, since the tests start it hundreds of times, also where PYTHONDONTWRITEBYTECODE is set.
# A single file runs with: python -m pytest tests/identities/test_mesh.py
test: $(VENV)/.developing
	$(BIN)/python -m compileall -q geomhw cli
	OPENBLAS_NUM_THREADS=1 LP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist worksteal

# --engine petsc on 1, 2 and 4 ranks, in an environment that sees Debian's petsc4py, mpi4py and MPI.
test-mpi: $(MPI)/.developing
	for ranks in 1 2 4; do \
	  $(MPIRUN) -n $$ranks $(MPI)/bin/python -m pytest -p no:cacheprovider tests/mpi/ranks || exit 1; done
	$(MPI)/bin/python -m pytest tests/mpi/runs

lint: $(VENV)/.developing
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@mkdir -p build/lint && ln -sfn ../../cli build/lint/geomhw_cli
	$(BIN)/mypy

# Accuracy and times beside potpourri3d's, files beside meshio and libigl, in an environment of their own, on one thread each.
# GEOMHW_REFERENCE names a folder of more meshes.
bench: $(BENCH)/.installed
	OPENBLAS_NUM_THREADS=1 $(BENCH)/bin/python tests/benchmarks/accuracy.py
	OPENBLAS_NUM_THREADS=1 $(BENCH)/bin/python tests/benchmarks/transport.py
	$(BENCH)/bin/python tests/benchmarks/distances.py
	OPENBLAS_NUM_THREADS=1 $(BENCH)/bin/python tests/benchmarks/files.py
	OPENBLAS_NUM_THREADS=1 $(BENCH)/bin/python tests/benchmarks/many_sources.py
	OPENBLAS_NUM_THREADS=1 $(BENCH)/bin/python tests/benchmarks/exact.py

# Renews the results that tests/docs/test_golden.py compares with: after a change that is meant.
golden: $(VENV)/.developing
	$(MAKE) --no-print-directory -C examples/golden renew GEOMHW=$(abspath $(BIN)/geomhw)

# Damaged files through every reader for some minutes, guided by coverage; make fuzz RUNS=1000000 for a night.
fuzz: $(VENV)/.fuzzing
	cd tests && $(abspath $(BIN))/python -m fuzz.run --runs $(RUNS)

# Random meshes, signals, two runs at once, damaged states and hostile files for some minutes; make attack COUNT=1000.
attack: $(VENV)/.developing
	cd tests && $(abspath $(BIN))/python -m attack.run --seed $(SEED) --count $(COUNT)

# The documentation as a site, build/site/index.html: documents, commands, and the library from its docstrings.
docs: $(VENV)/.developing
	$(BIN)/python examples/reference/website.py build/site

# Man pages from the commands, to build/man; for man to find them: MANPATH=$PWD/build: or a copy in share/man/man1.
man: $(VENV)/.installed
	$(BIN)/python examples/reference/man_pages.py build/man/man1

# Builds wheel and sdist, installs each in a clean environment of each Python, and runs the job of `make demo` there.
check-install: $(VENV)/.developing
	rm -rf build/install && mkdir -p build/install
	$(BIN)/python -m build --outdir build/install . >build/install/build.log
	set -e; for python in $(PYTHONS); do for built in build/install/*.whl build/install/*.tar.gz; do \
	  echo "$$python $$built"; rm -rf build/install/venv; $$python -m venv build/install/venv; \
	  build/install/venv/bin/python -m pip install --quiet --disable-pip-version-check $$built; \
	  (cd build/install && venv/bin/geomhw geodesic ../../data/creature.obj -o creature.vtk --png creature.png --quiet); \
	done; done

clean:
	rm -rf $(VENV) $(BENCH) $(MPI) $(DEMO) build dist *.egg-info

$(BIN)/python:
	$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "make: $(PYTHON) -m venv failed; on Debian and Ubuntu: apt install python3-venv" >&2; exit 1; }

$(VENV)/.installed: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/.developing: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	@touch $@ $(VENV)/.installed

# Debian's petsc4py is compiled for Debian's Python, /usr/bin/python3, and for numpy 1.
$(MPI)/.developing: pyproject.toml
	@{ command -v mpirun && ls -d $(PETSC4PY) && /usr/bin/python3 -c "import mpi4py, ensurepip"; } >/dev/null 2>&1 || \
	  { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get update -qq && \
	    apt-get install -y -qq --no-install-recommends $(MPI_PACKAGES) >/dev/null; } || { \
	  echo "make: PETSc and MPI are missing; on Debian and Ubuntu: apt install $(MPI_PACKAGES)" >&2; exit 1; }
	test -x $(MPI)/bin/python || /usr/bin/python3 -m venv --system-site-packages $(MPI) || { rm -rf $(MPI); exit 1; }
	$(MPI)/bin/python -m pip install --quiet --disable-pip-version-check --editable ".[test]" "numpy<2"
	ls -d $(PETSC4PY) | tail -n 1 >"$$($(MPI)/bin/python -c "import sysconfig; print(sysconfig.get_path('purelib'))")/petsc4py.pth"
	@touch $@

# Without atheris, which is not made for every Python, the run mutates files by chance.
$(VENV)/.fuzzing: $(VENV)/.developing
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev,fuzz]" || \
	  echo "make: atheris cannot be installed here; files are damaged by chance alone" >&2
	@touch $@

$(BENCH)/.installed: pyproject.toml
	test -x $(BENCH)/bin/python || $(PYTHON) -m venv $(BENCH) || { rm -rf $(BENCH); exit 1; }
	$(BENCH)/bin/python -m pip install --quiet --disable-pip-version-check --editable . "potpourri3d>=1.4" "pygeodesic>=0.1.9" \
	  "libigl>=2.5" "pymeshlab>=2023.12"
	@touch $@
