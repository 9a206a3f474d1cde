# `make help` lists the targets. `make test` is what must pass before a change is merged.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo playground test pictures bench fuzz tools cxx vulkan chromium \
	test-format test-lints test-docs test-all test-examples test-benches

# rustup's default place, for shells that have not read its environment.
export PATH := $(PATH):$(HOME)/.cargo/bin
# Mesa asks for this folder, and its device-select layer talks on stderr.
ifeq ($(XDG_RUNTIME_DIR),)
export XDG_RUNTIME_DIR := $(shell d="$${TMPDIR:-/tmp}/antumbra-run-$$(id -u)"; mkdir -p -m 700 "$$d"; echo "$$d")
endif
export NODEVICE_SELECT := 1

# The models of the tests: those of the repository, unless another folder is named. Tests of models that are not in the
# repository are ignored, and counted as such, where the list of all models is not there.
export ANTUMBRA_MODELS ?= $(CURDIR)/assets/models
# What takes minutes and prints tables for people is run by hand.
ALL_MODELS := $(if $(wildcard $(ANTUMBRA_MODELS)/MANIFEST.json),--include-ignored --skip by_hand)

# All features but the windows: nothing here opens one, and they bring 75 crates. That they compile is seen by test-lints.
FEATURES := --features bevy-gizmos,gltf,gltf-meshopt,gltf-basisu,reference,profile

# The same for the library and the playground, which scripts drive in its tests. It is selected together with the library,
# so that nothing is compiled twice, and without its window, which the tests do not open.
comma := ,
BOTH := --no-default-features --features antumbra/default$(comma)antumbra/$(subst $(comma),$(comma)antumbra/,$(lastword $(FEATURES))) \
	--package antumbra --package antumbra_playground

# Pictures of tests are small, so that the software driver compiles shaders for longer than it runs them. This turns off
# LLVM's optimizations (https://docs.mesa3d.org/envvars.html); other drivers do not read it.
test test-all test-examples test-benches: export GALLIVM_PERF ?= nopt

# Where examples put what they draw in `make test`.
SMALL := target/small
named_in = $(shell sed -n '/^\[\[$(1)\]\]/,/^name/s/^name = "\(.*\)"/\1/p' Cargo.toml)
BENCHES := $(call named_in,bench)
# All test programs but those that run by themselves.
TESTS := $(filter-out bevy gpu,$(call named_in,test)) playground
SHOTS := $(filter-out %/schema.json,$(wildcard examples/shots/*.json))

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | while IFS=$$'\t' read -r name what; do \
		printf '  make %-15s %s\n' "$$name" "$$what"; done

# The example gallery from a package of its own: nothing is built for it that only tests or Bevy need.
# Built once, so that what helps later builds and debuggers is left out.
demo: export CARGO_INCREMENTAL ?= 0
demo: export CARGO_PROFILE_DEV_DEBUG ?= 0
demo: tools vulkan ## draw every technique beside its judgement, into out/gallery/index.html
	@echo "demo: building the example gallery"
	cargo build --package antumbra_demo
	cargo run --quiet --package antumbra_demo -- --out out/gallery
	@echo "Open this page in a browser:"
	@echo "$(CURDIR)/out/gallery/index.html"

SCENE ?= assets/models/interior.glb
playground: tools vulkan ## a window to try and compare the techniques in (SCENE=file.glb or shot.json)
	@echo "playground: building, then opening $(SCENE)"
	cargo build --release --package antumbra_playground
	cargo run --release --quiet --package antumbra_playground -- $(SCENE)

# The cheapest failure first; test-all builds what every step after it uses.
test: tools cxx vulkan chromium test-format test-lints test-docs test-all test-examples test-benches ## everything below
	@echo "make test: all passed"

test-format: ## formatting of all Rust files
	cargo fmt --check

# Features only add, so that the tests are run with all of them; that the others compile is seen here.
test-lints: ## clippy with all features, with those of a renderer, and on the ECS core alone; no warning allowed
	cargo clippy --workspace --all-features --all-targets -- -D warnings
	cargo clippy --features reference --lib -- -D warnings
	cargo clippy --no-default-features --lib --tests -- -D warnings

# With an example, dependencies have the features of test-lints, which has checked them already.
test-docs: ## API documentation, no warning allowed
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --all-features --lib --example own_engine

# Tests of `gpu` that draw models for longer than their shaders are compiled. LLVM's optimizations make them faster.
DRAW_LONG := maps::dungeon occlusion_pictures orthographic::models perspective_map::models reference_match stencil_identity

# Runs the commands of its input, a number of them at a time, and shows what each prints when it ends. What failed is shown
# once more at the end. Two commands keep two cores busy while one compiles shaders, for which it takes one core.
AT_A_TIME = { failures=$$(mktemp); export failures; xargs -P $(1) -I{} $(SHELL) -c 'echo "+ {}"; \
	printed=$$({} 2>&1) && status=0 || status=$$?; printf "%s\n" "+ {}" "$$printed"; \
	[ $$status = 0 ] || { echo "failed: {}"; printf "%s\n" "$$printed" | sed -n "/^failures:/,\$$p"; } >>$$failures; exit $$status' \
	&& status=0 || status=$$?; cat $$failures; rm $$failures; exit $$status; }

# In parts: with --include-ignored, snippets that are no programs would be run too. The first command builds the examples
# that tests run. The three longest parts are first.
test-all: ## all tests and doc tests
	cargo test $(BOTH) --no-run
	{ echo "cargo test $(BOTH) --test bevy -- $(ALL_MODELS)"; \
	echo "cargo test $(BOTH) --no-fail-fast --lib --bins $(addprefix --test ,$(TESTS)) -- $(ALL_MODELS)"; \
	echo "cargo test $(BOTH) --test gpu -- $(addprefix --skip ,$(DRAW_LONG)) $(ALL_MODELS)"; \
	echo "GALLIVM_PERF= cargo test $(BOTH) --test gpu -- $(DRAW_LONG) $(ALL_MODELS)"; \
	echo "cargo test $(FEATURES) --doc"; \
	} | $(call AT_A_TIME,3)

EXAMPLE := cargo run --quiet $(FEATURES) --example

# The gallery is drawn in small by the test `gallery_page`; what its pages judge is judged by the tests as well.
test-examples: ## the examples and every shot file
	{ for shot in $(SHOTS); do echo "$(EXAMPLE) render -- $$shot --out $(SMALL)/$$(basename $$shot .json)"; done; \
	echo "$(EXAMPLE) with_app -- --out $(SMALL)"; \
	echo "$(EXAMPLE) own_engine -- --out $(SMALL)"; \
	echo "$(EXAMPLE) bevy_minimal -- --headless --out $(SMALL)"; \
	echo "$(EXAMPLE) bevy_dungeon -- --headless --out $(SMALL)"; \
	echo "$(EXAMPLE) bevy_split_screen -- --headless --out $(SMALL)"; \
	echo "$(EXAMPLE) bevy_compare -- --headless --out $(SMALL)/bevy_compare --size 96x54 --lights 1 --frames 1"; \
	} | $(call AT_A_TIME,2)

# With the profile of the tests: their answers are asked for here, not their times.
test-benches: ## every bench in its short mode
	cargo bench --profile dev $(FEATURES) $(addprefix --bench ,$(BENCHES)) --no-run
	for bench in $(BENCHES); do \
		echo "cargo bench --profile dev $(FEATURES) --bench $$bench -- --short"; done | $(call AT_A_TIME,2)

bench: tools vulkan ## every bench at length, optimized
	set -x; for bench in $(BENCHES); do cargo bench $(FEATURES) --bench $$bench; done

pictures: tools vulkan ## draw the pictures of the README again
	cargo run --example gallery --features reference -- --readme
	cargo run --package antumbra_playground --no-default-features -- examples/playground/readme/shot.json \
		--script examples/playground/readme/script.jsonl --out assets/readme --size 980x450

# Needs the nightly toolchain and cargo-fuzz (`cargo install cargo-fuzz`).
RUNS ?= 100000
fuzz: ## mutants of the models through import and two frames of the CPU schedule
	mkdir -p fuzz/corpus/gltf && cp -n assets/models/*.glb fuzz/corpus/gltf/
	cargo +nightly fuzz run --sanitizer none gltf -- -runs=$(RUNS) -max_len=262144 -rss_limit_mb=2048 -timeout=10

tools:
	@command -v cargo >/dev/null || { echo "cargo is missing: install Rust 1.95 or newer, https://rustup.rs" >&2; exit 1; }
	@command -v cc >/dev/null || command -v clang >/dev/null || command -v gcc >/dev/null || \
		{ echo "a C linker is missing: install gcc or clang (Debian: apt-get install gcc libc6-dev)" >&2; exit 1; }

# A decoder of compressed glTF data is C++.
cxx:
	@command -v c++ >/dev/null || command -v clang++ >/dev/null || \
		{ echo "a C++ compiler is missing: install g++ or clang (Debian: apt-get install g++)" >&2; exit 1; }

vulkan:
	@scripts/ensure-vulkan.sh

# For the test of the gallery's page.
chromium:
	@scripts/ensure-chromium.sh
