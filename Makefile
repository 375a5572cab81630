# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0

.DEFAULT_GOAL := help
PY := .venv/bin/python
export PYTHON
# Matrices are small here: threads of the linear algebra would make them four times slower.
export OPENBLAS_NUM_THREADS ?= 1

help:   ## this list
	@sed -n 's/^\([a-z]*\):.*##/  make \1\t/p' Makefile | expand -t 18

setup:  ## environment and build; nothing to do when nothing changed
	@python=$$(tools/find_python.sh) && PYTHONPATH=tools "$$python" tools/setup_ros.py

run: setup  ## a session of two users carrying a cube over 16 ms links
	@./pmwvc run carry_16ms

live: setup  ## a session to take part in, in the browser
	@./pmwvc run live_alone --view

LIVE := test/browser test/integration

test: setup  ## all tests (15 minutes on two fast cores, 30 on slow ones)
	@echo "all tests, live sessions first and alone: 15 minutes on two fast cores, 30 on slow ones"
	@$(PY) -m pytest $(LIVE); live=$$?; $(PY) -m pytest -n auto $(LIVE:%=--ignore=%) && exit $$live

lint: setup  ## format, lint and type checks
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check .
	@$(PY) -m mypy

bench: setup  ## timing of the loop and of the core, with numbers
	@$(PY) test/bench/run.py

benchmark: setup  ## controllers and channels at four tasks on every network (minutes; BENCHMARK=short)
	@PYTHONPATH=tools:tools/benchmark/rivals $(PY) -m benchmark $(BENCHMARK)

figures: setup  ## the dissertation's figures and numbers, computed again (minutes)
	@PYTHONPATH=tools $(PY) -m reproduction

faults: setup  ## every fault tried, and docs/faults.md written (minutes)
	@PYTHONPATH=tools $(PY) -m faults

mutants: setup  ## defects put into the product: which of them no test notices (an hour; COUNT, SEED)
	@nice env PYTHONPATH=tools $(PY) -m mutants

presses: setup  ## ten minutes of presses on stiff walls, and docs/presses.md written (minutes)
	@$(PY) tools/presses.py

paper: setup  ## the paper's figures and tables, after make benchmark (minutes)
	@PYTHONPATH=tools $(PY) -m paper

film: setup  ## the animated picture of the README, from a live session
	@$(PY) tools/film.py

course: setup  ## the course's numbers, pictures and pages, from runs of its sessions
	@PYTHONPATH=tools $(PY) -m course

docs: setup  ## docs/parameters.md from the parameters
	@$(PY) tools/write_reference.py

lock: setup  ## new lock file after editing tools/requirements.in
	@.venv/bin/uv pip compile -q --system-certs --universal --generate-hashes --no-header \
		--python-version 3.11 tools/requirements.in -o tools/requirements.txt

clean:  ## remove environment, build and caches (sessions stay)
	rm -rf .venv .ros .hypothesis .pytest_cache .ruff_cache .mypy_cache

.PHONY: help setup run live test lint bench benchmark figures faults mutants presses paper film course docs lock clean
