#!/usr/bin/env bash
# Installs what Spall is built with, runs with and draws with, from Debian 12's own packages.
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config
  openmpi-bin libopenmpi-dev libpetsc-real-dev libhdf5-openmpi-dev libmetis-dev
  libeigen3-dev libfmt-dev libcli11-dev libtomlplusplus-dev
  libgtest-dev libbenchmark-dev clang-format-14
  clang-14 libclang-rt-14-dev valgrind valgrind-mpi
  debhelper reuse
  python3 python3-pyflakes python3-pycodestyle python3-h5py python3-numpy python3-matplotlib
  chromium chromium-driver python3-selenium
  doxygen python3-sphinx python3-breathe python3-myst-parser furo python3-sphinxcontrib.programoutput
  pybind11-dev python3-dev python3-venv python3-pip python3-mpi4py python3-pandas
)
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' ||
    missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || {
    echo "these packages are missing and there is no sudo to install them: ${missing[*]}" >&2
    exit 1
  }
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq --no-install-recommends "${missing[@]}"
