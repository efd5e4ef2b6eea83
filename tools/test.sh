#!/usr/bin/env bash
# Builds everything and runs the tests; with SLICEMORPH_ALL_TESTS=1 also those that are left out to stay below ten
# minutes. Usage: ./tools/test.sh [options of ctest, for example -R render]
set -euo pipefail
cd "$(dirname "$0")/.."
source tools/dev/setup.sh

install_packages "${packages[@]}" "${test_packages[@]}"
cmake_options=(-DSLICEMORPH_TESTS=ON)
build all
say "running the tests"
ctest --test-dir build --parallel 2 --output-on-failure "$@"
say "all tests passed"
