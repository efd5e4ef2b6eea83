# Shared by demo.sh and test.sh (to be sourced): what Debian 12 must have, and the build.

packages=(
  g++ cmake make
  libopenvdb-dev libnanovdb-dev libboost-iostreams-dev libboost-system-dev libtbb-dev libopenexr-dev libimath-dev liblog4cplus-dev
  libeigen3-dev libnanoflann-dev libtinygltf-dev libdraco-dev libmeshoptimizer-dev libpng-dev libcli11-dev libtomlplusplus-dev nlohmann-json3-dev
  libinsighttoolkit5-dev libgdcm-dev libnifti2-dev libniftiio-dev libznz-dev zlib1g-dev libbz2-dev libopenimageio-dev libtiff-dev
  libjemalloc-dev python3-dev pybind11-dev
)
test_packages=(libgtest-dev libbenchmark-dev libopenvdb-tools libnanovdb-tools python3-openvdb python3-numpy python3-matplotlib python3-tqdm mypy
  openimageio-tools python3-openimageio python3-nibabel python3-lxml python3-tifffile teem-apps python3-pydicom python3-scipy mricron-data ffmpeg
  dcm2niix dcmtk dicom3tools plastimatch elastix chromium clang-format slurmctld slurmd slurm-client munge
  man-db groff-base dpkg-dev blender)

say() { printf '\n== %s\n' "$*"; }

as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    echo "root is needed for: $*" >&2
    echo "run it as root, or install sudo" >&2
    return 1
  fi
}

# Installs the named packages that are not there yet; asks nothing of apt when all are.
install_packages() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} = 0 ] && return
  say "installing ${missing[*]}"
  as_root apt-get update -q
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
}

# One compiler takes up to 1.2 GB on OpenVDB's headers, so never more than two.
build_jobs() {
  local cores
  cores=$(nproc)
  echo $((cores < 2 ? cores : 2))
}

# build TARGET...: a Release build in build/; further cmake options in the array `cmake_options`.
build() {
  say "building in build/ (some minutes the first time)"
  mkdir -p build
  cmake -S . -B build -DCMAKE_BUILD_TYPE=Release "${cmake_options[@]}" >build/configure.log 2>&1 ||
    { cat build/configure.log >&2; return 1; }
  cmake --build build --parallel "$(build_jobs)" --target "$@"
}
