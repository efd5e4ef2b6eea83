#!/usr/bin/env bash
# Lets calls of the system fail under the program, one after the other, and sees what it leaves: a line for each kind of
# fault is printed as the table of SECURITY.md has it. Takes an hour and more.
# Usage: tools/dev/inject_faults.sh [CASE...]   CASE: a part of the name of a case of tests/tools/injected_faults_test.py
set -euo pipefail
cd "$(dirname "$0")/../.."
source tools/dev/setup.sh
install_packages "${packages[@]}" "${test_packages[@]}"
cmake_options=(-DSLICEMORPH_TESTS=ON)
build slicemorph fault_calls
say "injecting faults"
SLICEMORPH_ALL_TESTS=1 /usr/bin/python3 tests/tools/injected_faults_test.py build/slicemorph build/tests/libfault_calls.so . "$@"
