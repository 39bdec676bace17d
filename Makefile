# Front door. `make help` lists the targets. Everything lands in build/ and out/.

BUILD    ?= build
PRESET   ?= release
OUT      ?= out
ASSETS   ?= configs/assets/bunny
DIR      ?=
RUN_ARGS ?=
FIGURES  ?=

.DEFAULT_GOAL := help
.PHONY: help packages configure build tools assets pipeline report play test test-asan test-tsan bench bench-atlas bench-large corpus pictures figures validate golden-update \
        lint format clean

help: ## List the targets
	@echo "Bakelight: precomputed radiance transfer, from an asset folder to one pack."
	@echo
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo
	@echo "  make pipeline ASSETS=folder bakes your own assets; RUN_ARGS='--set transfer.order=4' passes options on."

packages:
	@scripts/system-packages build

$(BUILD)/build.ninja: CMakeLists.txt CMakePresets.json | packages
	@cmake --preset $(PRESET) -B $(BUILD) > $(BUILD)-configure.log 2>&1 \
	  || { cat $(BUILD)-configure.log; rm -f $(BUILD)-configure.log; exit 1; }
	@mv $(BUILD)-configure.log $(BUILD)/configure.log

build: packages $(BUILD)/build.ninja ## Build everything into build/, executables in build/bin/
	@cmake --build $(BUILD)

tools: packages $(BUILD)/build.ninja ## Build the tools only, without tests and benchmarks
	@cmake --build $(BUILD) --target tools

assets: ## Fetch the default asset: the Stanford bunny and HDR probes
	@scripts/fetch-assets $(BUILD)/assets

pipeline: tools assets ## Bake and show ASSETS (default: the bunny) into out/
	@$(BUILD)/bin/bakelight run $(ASSETS) --out $(OUT) $(RUN_ARGS)

report: tools assets ## Measure error against run time of the bunny's variants: out/bunny/report.html
	@$(BUILD)/bin/bakelight sweep configs/reports/bunny --out $(OUT) $(RUN_ARGS)

play: pipeline ## Open the baked bunny in a window
	@$(BUILD)/bin/player $(OUT)/bunny/bunny.glb --environment $(BUILD)/assets/probes/sunrise.exr

test: build assets ## Build everything and run the tests
	@scripts/system-packages browser
	@ctest --test-dir $(BUILD) --output-on-failure --no-tests=error -j $$(nproc)

test-asan: packages assets ## Unit tests under address and undefined-behaviour sanitizers (long)
	@$(MAKE) --no-print-directory BUILD=build-asan PRESET=asan test

test-tsan: packages assets ## Unit tests under the thread sanitizer (long)
	@$(MAKE) --no-print-directory BUILD=build-tsan PRESET=tsan test

bench: build assets ## Run the benchmarks: figures as ratios against a rival or a floor of the same run
	@for program in $(BUILD)/bin/bench_*; do $$program || exit 1; done

bench-atlas: build assets ## Our atlas of the bunny beside xatlas's, both judged by the same figures
	@scripts/system-packages validate
	@BAKELIGHT_BENCH_XATLAS=scripts/run-xatlas $(BUILD)/bin/bench_atlas

bench-large: tools ## A million triangles through atlas and the recipe prt, beside their goals (minutes)
	@cmake --build $(BUILD) --target rippled_ball
	@scripts/bench-large --build $(BUILD) $(RUN_ARGS)

corpus: tools ## Every mesh of a folder through the recipes prt and atlas: make corpus DIR=folder
	@test -n "$(DIR)" || { echo "usage: make corpus DIR=folder [RUN_ARGS='--limit 300 --keep out/failed']"; exit 1; }
	@scripts/corpus "$(DIR)" --bin $(BUILD)/bin --json $(OUT)/corpus.json $(RUN_ARGS)

validate: pipeline ## Check the pack with the Khronos glTF validator and assimp
	@scripts/system-packages validate
	@scripts/validate-pack $(OUT)/bunny/bunny.glb

pictures: tools assets ## Make the pictures of the docs into docs/images/
	@scripts/system-packages browser
	@scripts/make-pictures $(BUILD)/bin docs/images

figures: tools assets ## Make the figures of the papers with our assets into out/figures/; FIGURES="1 vase" makes some
	@scripts/system-packages browser
	@cmake --build $(BUILD) --target naive_kernels mean_free_path
	@scripts/make-figures $(BUILD)/bin $(OUT)/figures $(FIGURES)

golden-update: build ## Renew the golden outputs of one stage test: make golden-update CASE=name
	@test -n "$(CASE)" || { echo "usage: make golden-update CASE=name; cases: $$(cd tests/stages && ls -d */ | tr -d / | tr '\n' ' ')"; exit 1; }
	@$(BUILD)/bin/golden --update $(CASE)

lint: packages $(BUILD)/build.ninja ## Formatting, include rules and clang-tidy
	@scripts/system-packages lint
	@tests/lint/check-format
	@tests/lint/check-includes
	@cmake --build $(BUILD) -- --quiet
	@tests/lint/check-tidy $(BUILD)

format: ## Format all C++ files
	@git ls-files '*.cpp' '*.h' | xargs clang-format -i

clean: ## Remove build/ and out/
	@rm -rf $(BUILD) $(OUT)
