#!/usr/bin/env bash
# Feeds a reader with mutated files, under clang's libFuzzer, AddressSanitizer and UndefinedBehaviorSanitizer.
# Usage: tools/dev/fuzz.sh TARGET SECONDS [EXECUTIONS]   ends after that many of either; TARGET: a name of
#          tests/fuzz/targets.cpp, or `all` (SECONDS each)
#        tools/dev/fuzz.sh --coverage TARGET              lines of each reader that its inputs so far come to
# What is found lies in build-fuzz/found/TARGET/ and goes to tests/fuzz/corpus/TARGET/ once it is mended; a line for each
# run is added to build-fuzz/table.md. The coverage of inputs is kept in build-fuzz/inputs/TARGET/ for the next time.
set -euo pipefail
cd "$(dirname "$0")/../.."
source tools/dev/setup.sh
[ $# -ge 2 ] && [ $# -le 3 ] || { sed -n '2,7s/^# //p' "$0" >&2; exit 2; }

install_packages "${packages[@]}" libgtest-dev python3-numpy python3-openvdb python3-nibabel python3-tifffile python3-pydicom python3-pil \
  clang llvm libclang-rt-14-dev

# build_fuzzed FOLDER CMAKE_OPTION...: the fuzzed readers, in FOLDER. Little is optimised: the build takes longer than most runs.
build_fuzzed() {
  local folder=$1
  shift
  say "building with libFuzzer in $folder/"
  mkdir -p "$folder"
  cmake -S . -B "$folder" -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang -DSLICEMORPH_TESTS=ON \
    -DSLICEMORPH_FUZZ=ON "$@" >"$folder/configure.log" 2>&1 || { cat "$folder/configure.log" >&2; exit 1; }
  cmake --build "$folder" --parallel "$(build_jobs)" --target slicemorph_fuzz
}

# targets WANTED: the names of targets, one a line.
targets() {
  if [ "$1" = all ]; then sed -n 's/^      {"\([a-z-]*\)", ".*/\1/p' tests/fuzz/targets.cpp; else echo "$1"; fi
}

# The sources that only the target's reader has, as a pattern of paths.
sources_of() {
  case $1 in
    texture) echo 'io/mesh/picture_texture' ;;
    glb) echo 'io/mesh/gl(b_reader|b_accessor|tf)' ;;
    obj | off | ply | stl) echo "io/mesh/$1_" ;;
    vdb) echo 'io/vdb/vdb_(check|reader)' ;;
    info-vdb) echo 'io/file_info' ;;
    exr-slices) echo 'io/exr/exr_(check|slice_header|slice_reader)' ;;
    tiff) echo 'io/image/(stack_reader|picture_)' ;;
    dicom) echo 'io/image/dicom_' ;;
    nifti | analyze) echo 'io/image/nifti_' ;;
    nrrd) echo 'io/image/(nrrd_|data_files)' ;;
    metaimage) echo 'io/image/(metaimage_|data_files)' ;;
    rtstruct | csl) echo "io/contours/$1_" ;;
    positions-*) echo 'io/points/' ;;
    job) echo 'tools/job/(job_file|guidance_file|toml_reader|key_times|option_)' ;;
    landmarks) echo 'tools/job/landmarks' ;;
    planes) echo 'tools/job/(plane_file|number_line)' ;;
    plan) echo 'tools/job/plan_file' ;;
  esac
}

coverage() {
  build_fuzzed build-coverage -DCMAKE_CXX_FLAGS="-O1 -DNDEBUG -fprofile-instr-generate -fcoverage-mapping"
  local target folder=build-coverage/profiles inputs
  for target in $(targets "$1"); do
    rm -rf "$folder/$target" && mkdir -p "$folder/$target"
    inputs=()
    for kept in "build-fuzz/inputs/$target" "build-fuzz/seeds/$target" "tests/fuzz/corpus/$target"; do
      [ ! -d "$kept" ] || inputs+=("$kept")
    done
    SLICEMORPH_FUZZ_TARGET=$target LLVM_PROFILE_FILE="$PWD/$folder/$target/%m.profraw" TMPDIR=/dev/shm \
      build-coverage/slicemorph_fuzz -runs=0 "${inputs[@]}" >"$folder/$target/log" 2>&1
    llvm-profdata merge -o "$folder/$target/profile" "$folder/$target/"*.profraw
    # The last line is the sum: lines, those missed, the share covered.
    mapfile -t sources < <(git ls-files '*.cpp' | grep -E "^$(sources_of "$target")")
    echo "| $target | $(llvm-cov report build-coverage/slicemorph_fuzz -object build-coverage/libslicemorph_itk.so \
      -object build-coverage/libslicemorph_pictures.so -instr-profile "$folder/$target/profile" "${sources[@]}" |
      awk '/^TOTAL/ { print $8, "lines,", $10 }') |" | tee -a build-coverage/table.md
  done
}

fuzz() {
  local seconds=$2 executions=${3:--1} failed=0 target found inputs dictionary log value
  build slicemorph
  build_fuzzed build-fuzz -DCMAKE_CXX_FLAGS="-O1 -DNDEBUG" -DSLICEMORPH_SANITIZE=address,undefined,fuzzer-no-link
  [ -d build-fuzz/seeds ] || /usr/bin/python3 tests/fuzz/make_seeds.py build/slicemorph build-fuzz/seeds
  # Scratch files in memory. No leak check: OpenVDB and TBB keep objects until exit. What is asked for in one piece is limited.
  export TMPDIR=/dev/shm
  export ASAN_OPTIONS=detect_leaks=0:detect_container_overflow=0:allocator_may_return_null=0:hard_rss_limit_mb=0
  for target in $(targets "$1"); do
    found=build-fuzz/found/$target inputs=build-fuzz/inputs/$target
    mkdir -p "$found" "$inputs" "build-fuzz/seeds/$target"
    dictionary=tests/fuzz/dictionaries/$target.dict
    say "$target, $seconds seconds"
    log=build-fuzz/$target.log
    SLICEMORPH_FUZZ_TARGET=$target build-fuzz/slicemorph_fuzz "$inputs" "build-fuzz/seeds/$target" "tests/fuzz/corpus/$target" \
      -max_total_time="$seconds" -runs="$executions" -timeout=10 -rss_limit_mb=3000 -malloc_limit_mb=1500 -max_len=40000 \
      -artifact_prefix="$found/" -print_final_stats=1 -detect_leaks=0 \
      $([ -f "$dictionary" ] && echo "-dict=$dictionary") >"$log" 2>&1 || failed=1
    value() { sed -n "$1" "$log" | tail -1; }
    echo "| $(date -u +%F) | $(git rev-parse --short HEAD) | $target | $(value 's/^stat::number_of_executed_units: *//p') |" \
      "$(value 's/^Done .* in \([0-9]*\) second.*/\1/p') | $(value 's/.* cov: \([0-9]*\) .*/\1/p') | $(find "$found" -type f | wc -l) |" |
      tee -a build-fuzz/table.md
  done
  return $failed
}

if [ "$1" = --coverage ]; then coverage "$2"; else fuzz "$@"; fi
