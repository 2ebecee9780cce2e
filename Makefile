# What a bare machine needs: Python >= 3.11 with pip, and make. Everything else goes into .venv, once.
#
#   make validity   run studies/validity.toml, print where the tip-path-plane model stops, draw the four figures
#   make report1431 every table and figure of NASA TP-1431 into results/tp1431, with a page, index.html (a minute)
#   make test       ruff, mypy, pytest
#   make bench      speed and accuracy beside SciPy, heyoka, numbalsoda, diffrax (five minutes; installs them into .venv)
#   make mutants    break the code on purpose: every break must fail a test
#   make check-boundaries   locks of 10 000 random designs against a brute-force scan (ten to twenty minutes)
#   make prove-storage      kills and failures at every call that writes, 500 kills at random: nothing is lost (half an hour)
#   make prove-files        25 000 damaged databases: no wrong number, no crash, no hang (some tens of minutes)
#   make prove-input        100 000 queries, 20 000 rotor and study files: right answers or sentences (some tens of minutes)
#   make clean      remove .venv, results and caches

VENV := .venv
PYTHON := $(VENV)/bin/python
FLOQUET := $(PYTHON) -m floquet
DATABASE := results/validity.h5
FIGURES := validity-summary root-locus eigenvalues-vs-mu error-vs-mu

.PHONY: help validity report1431 test bench mutants check-boundaries prove-storage prove-files prove-input clean environment test-environment bench-environment
.DEFAULT_GOAL := help

help:
	@sed -n 's/^#   //p' Makefile

validity: $(DATABASE)
	@for kind in $(FIGURES); do $(FLOQUET) plot $(DATABASE) $$kind -o results/$$kind.png || exit; done
	@$(FLOQUET) validity $(DATABASE)

# Everything is written again, so that nothing of an earlier version is left among it.
report1431: environment
	rm -rf results/tp1431
	$(FLOQUET) study --all -o results/tp1431

# Made again when the study, a rotor or the code has changed; what an earlier version left is not mixed with it.
$(DATABASE): studies/validity.toml $(wildcard data/rotors/*.toml floquet/*.py floquet/*/*.py) | environment
	@mkdir -p results && rm -rf $@ $@.parts
	$(FLOQUET) run studies/validity.toml -o $@

test: test-environment
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(PYTHON) -m mypy
	$(PYTHON) -m pytest -n auto

bench: bench-environment
	$(PYTHON) -m benchmarks

mutants: test-environment
	$(PYTHON) tests/mutants.py

check-boundaries: test-environment
	$(PYTHON) -m tests.check_boundaries

prove-storage: test-environment
	$(PYTHON) -m tests.prove_storage

prove-files: test-environment
	$(PYTHON) -m tests.prove_files

prove-input: test-environment
	$(PYTHON) -m tests.prove_input

clean:
	rm -rf $(VENV) results dist build .pytest_cache .hypothesis .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Installed once for each content of pyproject.toml: the stamp is a copy of it, written when the installation is complete.
environment:
	@cmp -s pyproject.toml $(VENV)/installed.toml || { $(call install,.) && cp pyproject.toml $(VENV)/installed.toml; }

test-environment: environment
	@cmp -s pyproject.toml $(VENV)/installed-test.toml || \
		{ $(call install,.[test$(comma)export]) && cp pyproject.toml $(VENV)/installed-test.toml; }

# numbalsoda is not in the extra: without g++ and gfortran its build fails, and would take the others with it.
bench-environment: environment
	@cmp -s pyproject.toml $(VENV)/installed-bench.toml || \
		{ $(call install,.[bench]) && cp pyproject.toml $(VENV)/installed-bench.toml; }
	@$(PYTHON) -c 'import numbalsoda' 2>/dev/null || $(PYTHON) -m pip install numbalsoda || \
		echo "numbalsoda was not built (it needs g++ and gfortran): the benchmark skips it" >&2

comma := ,
define install
echo "installing $(1) into $(VENV)" && python=$$($(find-python)) && \
	{ test -x $(PYTHON) || "$$python" -m venv $(VENV) || "$$python" -m venv --without-pip $(VENV); } && \
	if $(PYTHON) -m pip --version >/dev/null 2>&1; then pip="$(PYTHON) -m pip"; \
	else pip="$$python -m pip --python $(PYTHON)"; fi && $$pip install --editable '$(1)'
endef

define find-python
for python in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	"$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && echo "$$python" && exit; done; \
	echo "floquet needs Python 3.11 or newer, and none of python3, python3.11 ... python is one: install it first" >&2; exit 1
endef
