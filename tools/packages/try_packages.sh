#!/bin/bash
# Makes the Debian packages (build/packages/), installs them in a bare Debian 12, and there runs the README's examples
# and imports the Python module. As root, on Debian 12; takes some minutes and 2 GB below /tmp.
set -eu
cd "$(dirname "$0")/../.."
. tools/dev/setup.sh
install_packages "${packages[@]}" mmdebstrap dpkg-dev
cmake_options=(-DSLICEMORPH_TESTS=OFF)
build all
(cd build && cpack) >build/packages.log 2>&1 || { tail -20 build/packages.log >&2; exit 1; }

root=$(mktemp -d /tmp/slicemorph-root.XXXXXX)
trap 'rm -rf "$root"' EXIT
say "a bare Debian 12 in $root"
mmdebstrap --quiet --variant=apt bookworm "$root"
cp build/packages/*.deb "$root/tmp/"
cp -r assets "$root/root/assets"
# The lines that begin with build/slicemorph in the README's part "Start".
sed -n '/^## Start/,/^## Read on/s/^build\///p' README.md >"$root/root/examples.sh"
[ -s "$root/root/examples.sh" ]
in_root() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive bash -ec "$1"; }

say "installing the packages"
in_root 'apt-get update -qq; apt-get install -y -qq --no-install-recommends /tmp/slicemorph_*.deb >/tmp/apt.log 2>&1 || { tail /tmp/apt.log; exit 1; }'
say "the README's examples"
in_root 'cd /root; set -x; . ./examples.sh; ls -l'
if ls "$root"/tmp/python3-slicemorph_*.deb >/dev/null 2>&1; then
  say "the Python module"
  in_root 'apt-get install -y -qq --no-install-recommends /tmp/python3-slicemorph_*.deb >/tmp/apt.log 2>&1 || { tail /tmp/apt.log; exit 1; }
    cd /; python3 -c "import slicemorph; print(slicemorph.__version__)"'
fi
say "removing them"
in_root 'apt-get purge -y -qq "*slicemorph*" >/dev/null 2>&1; ! find /usr -name "*slicemorph*" | grep .'
say "the packages work in a bare Debian 12"
