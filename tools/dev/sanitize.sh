#!/usr/bin/env bash
# The engine's unit tests, compiled by clang with AddressSanitizer and UndefinedBehaviorSanitizer.
set -euo pipefail
cd "$(dirname "$0")/../.."
source tools/dev/setup.sh

tests=(numerics_test mesh_parts_test contours_test match_test blend_test rebuild_test)
install_packages "${packages[@]}" "${test_packages[@]}" clang libclang-rt-14-dev
say "building with sanitizers in build-sanitize/"
cmake -S . -B build-sanitize -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang \
  -DSLICEMORPH_SANITIZE=address,undefined >build-sanitize.log 2>&1 || { cat build-sanitize.log >&2; exit 1; }
rm -f build-sanitize.log
cmake --build build-sanitize --parallel "$(build_jobs)" --target "${tests[@]}"
say "running the engine's unit tests with sanitizers"
pattern=$(IFS='|'; echo "${tests[*]}")
# No leak check: OpenVDB and TBB keep objects until exit, and libraries without instrumentation hide what they
# own.
ASAN_OPTIONS=detect_leaks=0:detect_container_overflow=0 \
  ctest --test-dir build-sanitize --parallel 2 --output-on-failure -R "^($pattern)\$"
