# Each target sets up what it needs; a set-up that is complete costs nothing.
.DEFAULT_GOAL := help
.PHONY: help setup demo test bench docs lint clean distclean

help: ## this list
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

setup: ## install what is locked into .venv and build the workspace
	@scripts/setup.sh

demo: setup ## replay bags/paper_cycle through the live nodes, write out/demo/report.html
	@.venv/bin/ddh-twin demo

test: ## all tests; a selection with ARGS="-k oil"
	@scripts/setup.sh --tools
	@scripts/test.sh $(ARGS)

bench: setup ## print speed and memory beside other tools, write out/bench.json; FORTRAN=1 installs gfortran for one of them
	@FORTRAN=$(FORTRAN) scripts/bench_tools.sh
	@.venv/bin/ddh-twin bench

docs: setup ## the documents as a site, out/site/index.html
	@scripts/tools.sh
	@.venv/tools/bin/sphinx-build -W --keep-going -q -b html -d out/doctrees docs out/site
	@echo "docs: out/site/index.html"

lint: setup ## ruff
	@.venv/bin/ruff check .

clean: ## remove what make built and wrote; .venv and what else is in out (recordings, states, reports) stay
	rm -rf out/logs out/site out/doctrees out/demo out/bench.json
	[ ! -d out ] || rmdir --ignore-fail-on-non-empty out
	rm -rf ros2_ws/build ros2_ws/install ros2_ws/log .pytest_cache .ruff_cache .hypothesis
	rm -f .venv/ddh/ddh_*.done
	find ddh_twin_py tests -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean ## the same and .venv
	rm -rf .venv
