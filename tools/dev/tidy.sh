#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) over all sources, those of a folder as one.
# Usage: ./tools/dev/tidy.sh [PART OF A PATH...]
# Two readers are left out: Debian's headers of ITK were generated for g++ alone and refuse clang.
set -euo pipefail
cd "$(dirname "$0")/../.."
source tools/dev/setup.sh

install_packages "${packages[@]}" clang-tidy clang
cmake -S . -B build-tidy -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang -DSLICEMORPH_TESTS=OFF \
  -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >build-tidy.log 2>&1 ||
  { cat build-tidy.log >&2; exit 1; }
rm -f build-tidy.log
python3 - "$@" <<'END' | xargs -P "$(nproc)" -n 1 clang-tidy --quiet -p build-tidy
import json
import sys
noClang = ("/io/image/metaimage_reader.cpp", "/io/image/nrrd_header.cpp", "/io/image/dicom_reader.cpp")
for entry in json.load(open("build-tidy/compile_commands.json")):
    if not entry["file"].endswith(noClang) and all(part in entry["file"] for part in sys.argv[1:]):
        print(entry["file"])
END
