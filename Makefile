# Every target is one script or command: read it there. `make` alone lists them.
.DEFAULT_GOAL := help
.PHONY: help setup demo check test thorough peers soak faults coverage mutate sanitize tsan fuzz audit zenohc zenohd lint bench wheel clean
# One at a time: the stages build on each other.
.NOTPARALLEL:

help: ## list the targets
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' $(MAKEFILE_LIST) | expand -t 16

setup: ## check this machine, install the Python packages, build the gate
	@scripts/setup

demo: setup ## the robot does its task, in the simulator; ARGS=--realtime shows real pacing
	@.venv/bin/fairlead demo $(ARGS)

check: ## the tests that start no process and no simulator, after a set-up: under two minutes
	@scripts/test -q -n auto --dist loadfile -m "not processes and not simulator and not soak"

test: setup ## the gate's and the Python tests; scripts/test PATH runs some of them
	@scripts/test

thorough: setup ## what make test leaves to CI: longer tests of what it shows in short
	@scripts/test --thorough

peers: setup ## policy clients against published code; OPENPI, GROOT, RLDX, LEROBOT name where it is
	@scripts/peers $(ARGS)

soak: setup ## the long tests: twenty seeds of the task; soundness and usability of the gate
	@scripts/test -m soak
	@.venv/bin/python -m bench.soundness --write

faults: setup ## every fault of docs/faults.md, five to twenty times; ARGS="--row 1 --write"
	@.venv/bin/python -m bench.faults $(ARGS)

coverage: setup ## lines and branches of the gate's core that no test runs; fails below the floor
	@.venv/bin/python -m bench.core_coverage

mutate: setup ## breaks the gate's core in each small way: a test has to notice
	@.venv/bin/python -m bench.mutants

sanitize: setup ## the gate's C++ tests under address and undefined behaviour sanitizers
	@scripts/build-gate --tests --target fairlead-safety-tests --build-dir build/sanitize -- \
		-DFAIRLEAD_SANITIZE=address,undefined
	@ctest --test-dir build/sanitize --output-on-failure --no-tests=error

tsan: setup ## the gate's process and shell under ThreadSanitizer
	@scripts/tsan

fuzz: sanitize ## generated frames, chunks and sequences of events for the gate's core; SECONDS_EACH=120
	@FAIRLEAD_FUZZ_SECONDS=$(or $(SECONDS_EACH),120) FAIRLEAD_SEQUENCE_STEPS=400000 \
		FAIRLEAD_FUZZ_FRAMES=2000000 FAIRLEAD_FOLLOWED_RUNS=100 build/sanitize/fairlead-safety-tests \
		--test-case='fuzz*,random*'

zenohc: setup ## the gate with the official zenoh-c of SOURCE=FOLDER: its tests and the demo
	@scripts/zenohc "$(SOURCE)"

zenohd: setup ## Zenoh's own router, built from the crate registry, between two hosts: runs a goal
	@scripts/zenohd

audit: setup ## known advisories of all packages, bills of materials, licences; same bytes twice
	@scripts/audit

lint: setup ## formatting, lint, strict types
	@scripts/lint

bench: setup ## what the processes and the gate cost, as ratios; wants a quiet machine
	@.venv/bin/python -m bench.loop
	@.venv/bin/python -m bench.gate_core
	@.venv/bin/python -m bench.gate_hop
	@.venv/bin/python -m bench.chunk_async

wheel: setup ## dist/: a wheel that carries the gate, and the source archive
	@scripts/build-wheel

clean: ## remove what was built here (not the caches outside the checkout)
	rm -rf build dist out .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis
