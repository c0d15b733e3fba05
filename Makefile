# Two commands do everything on a fresh machine: `make train` and `make test`. Each sets up what it needs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DEV := $(VENV)/.installed-dev
CLUSTER := $(VENV)/.installed-cluster
TOOLS := $(VENV)/tools/.installed
PIP_OPTIONS ?=
export OMP_NUM_THREADS ?= 1

.PHONY: help setup dev kernels cluster train test test-all test-cluster lint format docs pages datasets bench bench-quick perf reproduce pictures design-pictures report \
	studies kill \
	fuzz soak lock audit wheel package clean

help: ## show this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

setup: $(STAMP) ## make .venv with what training, evaluation and pictures need, at the tested versions

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(v < (3, 11) and f"pnt_gym needs Python 3.11 or newer, {sys.executable} is {v.major}.{v.minor}; use make PYTHON=/path/to/python3.11")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q $(PIP_OPTIONS) -c constraints.txt -e ".[rl,report,video,onnx]"
	@$(BIN)/python -W ignore -m pnt_gym.cells.base.canvas
	@touch $(STAMP)

dev: $(DEV) ## add to it what tests, checks, the papers and the documentation need

$(DEV): $(STAMP)
	$(BIN)/python -m pip install -q $(PIP_OPTIONS) -c constraints.txt -e ".[dev]"
	@touch $(DEV)

kernels: setup ## make the machine code that the tests need, once (about a minute)
	$(BIN)/python -m tests.tools.kernels

train: setup ## train on PnTConveyor-v0, then compare with the analytic planner (minutes on 2 cores)
	$(BIN)/python -m agents.train --env PnTConveyor-v0

test: dev ## run the tests, but for those that are marked as nightly
	$(BIN)/python -m pytest -n auto --dist loadfile

test-all: dev ## run all tests, the nightly ones as well
	$(BIN)/python -m pytest -n auto --dist loadfile -m ""

cluster: $(CLUSTER) ## add Ray to .venv

test-cluster: cluster ## run the tests on two machines of a Ray cluster, one of which dies
	$(BIN)/python -m pytest tests/cluster -n 2 --dist loadfile

$(CLUSTER): $(DEV)
	$(BIN)/python -m pip install -q $(PIP_OPTIONS) -c constraints.txt -e ".[cluster]"
	@touch $(CLUSTER)

lint: dev ## style, types, and the one-way flow between rooms
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

format: dev ## rewrite the code in the project's style
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: dev ## the documentation site, into docs/_build/html; a warning is an error, and the tour is run
	$(BIN)/python -m sphinx -b html -E -W --keep-going -q docs docs/_build/html

pages: setup ## the made parts of the pages in docs/: from docstrings, levels, registry, help and results
	$(BIN)/python -m docs.pages

datasets: dev ## the four Minari datasets of docs/datasets.md anew, 10,000 throws each, into runs/datasets (minutes)
	rm -rf runs/datasets/pnt_gym
	for words in "" "--controller analytic --noise 0.3" "--controller expert" \
		"--env PnTAdapt-v0 --level day --controller static --noise 0 0.1 0.3 1"; do \
		$(BIN)/python -m agents.dataset --root runs/datasets $$words || exit 1; done

bench: setup ## the benchmarks of results/ (hours; stop and resume)
	for plan in $(filter-out %_quick.yaml, $(wildcard configs/benchmark*.yaml)); do \
		$(BIN)/python -m agents.benchmark --config $$plan || exit 1; done
	$(BIN)/python -m agents.report

bench-quick: setup ## small benchmarks, minutes
	$(BIN)/python -m agents.benchmark --config configs/benchmark_quick.yaml
	$(BIN)/python -m agents.benchmark --config configs/benchmark_line_quick.yaml

perf: dev ## planner and environment speed and the checks of physics in results/; a line's choices against the planner
	$(BIN)/python benchmarks/perf.py planner --json results/perf_planner.json
	$(BIN)/python benchmarks/perf.py envs --json results/perf_envs.json
	$(BIN)/python benchmarks/perf.py shares --json results/perf_shares.json
	$(BIN)/python -m agents.benchmark --config configs/studies/physics.yaml
	$(BIN)/python -m agents.benchmark --config configs/studies/fidelity.yaml
	$(BIN)/python benchmarks/line_exactness.py

# `reality` compares with measurements that are not ours to ship, see docs/reality.md.
STUDIES ?= $(filter-out reality,$(basename $(notdir $(wildcard configs/studies/*.yaml))))

studies: dev ## what plans in configs/studies find out, into results/ (hours; stop and resume): make studies STUDIES="grip cup"
	for study in $(STUDIES); do $(BIN)/python -m agents.benchmark --config configs/studies/$$study.yaml || exit 1; done

reproduce: dev ## the papers' figures computed anew, beside the published ones, into results/ (three minutes of processor time; stop and resume)
	$(BIN)/python -m agents.reproduce all --json results/reproduction.json --figures results/figures
	$(BIN)/python -m agents.report

design-pictures: dev ## pictures of the design page, into docs/pictures; needs Chromium
	$(BIN)/python docs/design_pictures.py

pictures: setup ## pictures and videos of throws, into results/figures and docs/pictures
	$(BIN)/python docs/pictures.py
	$(BIN)/python -m agents.play --env OneJointSort-v0 --controller virtual_goal --picture results/figures/miyashita_throw.webp
	$(BIN)/python -m agents.play --env OneJointSort-v0 --controller virtual_goal --picks 3 --video results/figures/miyashita_sorting.mp4
	$(BIN)/python -m agents.play --env GripperToss-v0 --controller virtual_goal --seed 3 --at 0.6 --picture results/figures/gripper_toss.webp
	$(BIN)/python -m agents.play --env GripperToss-v0 --controller virtual_goal --seed 3 --picks 3 --slow 3 --video results/figures/gripper_toss.mp4

report: setup ## tables, figures and the report from results/*.json, and the made parts of the pages
	$(BIN)/python -m agents.report
	$(BIN)/python -m docs.pages

kill: dev ## kill the commands at every change of a file and at random: is anything lost? (minutes)
	$(BIN)/python benchmarks/kill.py

fuzz: dev ## 10,000 levels, actions, calls, command lines and changed files that nobody thought of (minutes)
	$(BIN)/python benchmarks/fuzz.py

soak: dev ## 100,000 throws in all environments, 100,000 decisions at lines: flat memory, numbers, no walls crossed (an hour)
	$(BIN)/python benchmarks/soak.py throws
	$(BIN)/python benchmarks/soak.py shifts

lock: $(TOOLS) ## write constraints.txt and sbom.cdx.json anew, with the newest versions (asks the package index)
	$(VENV)/tools/bin/uv pip compile -q --config-file .ci/lock.toml pyproject.toml .ci/tools.txt -o constraints.txt
	$(VENV)/tools/bin/python .ci/sbom.py

audit: $(TOOLS) ## known faults of the versions in constraints.txt and of the workflows (asks databases of them)
	$(VENV)/tools/bin/zizmor --persona pedantic .github
	$(VENV)/tools/bin/pip-audit --strict --no-deps --disable-pip --progress-spinner off -r constraints.txt

$(TOOLS): .ci/tools.txt
	$(PYTHON) -m venv $(VENV)/tools
	$(VENV)/tools/bin/python -m pip install -q $(PIP_OPTIONS) -c constraints.txt -r .ci/tools.txt
	@touch $(TOOLS)

wheel: ## build the wheel into dist/ and try it in an environment of its own, outside of the checkout
	rm -rf dist && $(PYTHON) -m venv dist/venv
	dist/venv/bin/python -m pip wheel -q --no-deps -w dist .
	dist/venv/bin/python -m zipfile -l $$(ls dist/*.whl) | grep dist-info/sboms/
	dist/venv/bin/python -m pip install -q $(PIP_OPTIONS) -c constraints.txt "$$(ls dist/*.whl)"
	cd dist && for words in doctor levels demo "evaluate --controller analytic --picks 64"; do venv/bin/pnt-gym $$words || exit 1; done

package: wheel ## the same, and train and keep a dataset there
	dist/venv/bin/python -m pip install -q $(PIP_OPTIONS) -c constraints.txt "$$(ls dist/*.whl)[rl,data]"
	cd dist && venv/bin/pnt-gym train --steps 64 --eval-picks 32
	cd dist && venv/bin/pnt-gym dataset --throws 64 --score-throws 64 --root data

clean: ## remove the environment and caches
	rm -rf $(VENV) .pytest_cache .ruff_cache .hypothesis docs/_build dist build *.egg-info
