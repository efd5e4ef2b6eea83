#!/usr/bin/env bash
# Builds everything and runs all tests. Usage: ./tools/test.sh [options of ctest, for example -R render]
set -euo pipefail
cd "$(dirname "$0")/.."
source tools/setup.sh

install_packages "${packages[@]}" "${test_packages[@]}"
cmake_options=(-DSLICEMORPH_TESTS=ON)
build all
say "running the tests"
ctest --test-dir build --output-on-failure "$@"
say "all tests passed"
