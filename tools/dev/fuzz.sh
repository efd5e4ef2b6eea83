#!/usr/bin/env bash
# Feeds a reader with mutated files, under clang's libFuzzer, AddressSanitizer and UndefinedBehaviorSanitizer.
# Usage: tools/dev/fuzz.sh TARGET SECONDS   TARGET: a name of tests/fuzz/targets.cpp, or `all` (SECONDS each)
# What is found lies in build-fuzz/found/TARGET/ and goes to tests/fuzz/corpus/TARGET/ once it is mended; a line for each
# target is added to build-fuzz/table.md. The coverage of inputs is kept in build-fuzz/inputs/TARGET/ for the next time.
set -euo pipefail
cd "$(dirname "$0")/../.."
source tools/dev/setup.sh
[ $# = 2 ] || { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
wanted=$1 seconds=$2

install_packages "${packages[@]}" libgtest-dev python3-numpy python3-openvdb python3-nibabel python3-tifffile python3-pydicom python3-pil \
  clang libclang-rt-14-dev
build slicemorph
say "building with libFuzzer in build-fuzz/"
mkdir -p build-fuzz
cmake -S . -B build-fuzz -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang -DSLICEMORPH_TESTS=ON -DSLICEMORPH_FUZZ=ON \
  -DSLICEMORPH_SANITIZE=address,undefined,fuzzer-no-link >build-fuzz/configure.log 2>&1 || { cat build-fuzz/configure.log >&2; exit 1; }
cmake --build build-fuzz --parallel "$(build_jobs)" --target slicemorph_fuzz
[ -d build-fuzz/seeds ] || /usr/bin/python3 tests/fuzz/make_seeds.py build/slicemorph build-fuzz/seeds

targets=("$wanted")
[ "$wanted" = all ] && mapfile -t targets < <(sed -n 's/^      {"\([a-z-]*\)", ".*/\1/p' tests/fuzz/targets.cpp)
# Scratch files in memory. No leak check: OpenVDB and TBB keep objects until exit. What is asked for in one piece is limited.
export TMPDIR=/dev/shm
export ASAN_OPTIONS=detect_leaks=0:detect_container_overflow=0:allocator_may_return_null=0:hard_rss_limit_mb=0
failed=0
for target in "${targets[@]}"; do
  found=build-fuzz/found/$target inputs=build-fuzz/inputs/$target
  mkdir -p "$found" "$inputs" "build-fuzz/seeds/$target"
  dictionary=tests/fuzz/dictionaries/$target.dict
  say "$target, $seconds seconds"
  log=build-fuzz/$target.log
  SLICEMORPH_FUZZ_TARGET=$target build-fuzz/slicemorph_fuzz "$inputs" "build-fuzz/seeds/$target" "tests/fuzz/corpus/$target" \
    -max_total_time="$seconds" -timeout=10 -rss_limit_mb=3000 -malloc_limit_mb=1500 -max_len=40000 -artifact_prefix="$found/" -print_final_stats=1 \
    $([ -f "$dictionary" ] && echo "-dict=$dictionary") >"$log" 2>&1 || failed=1
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -1)
  echo "| $target | ${runs:-0} | ${edges:-0} | $(find "$found" -type f | wc -l) |" | tee -a build-fuzz/table.md
done
exit $failed
