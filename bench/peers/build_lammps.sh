#!/bin/bash
# Builds LAMMPS from Debian's source package for this machine's own processor; prints the program's path.
# SPDX-License-Identifier: BSD-3-Clause
# usage: build_lammps.sh FOLDER; FOLDER/bench then holds its inputs, such as in.chute. Five minutes on two cores.
set -eu
mkdir -p "$1"
cd "$1"
if [ ! -x build/lmp ]; then
  echo "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" >sources.list
  mkdir -p lists/partial source
  options=(-o "Dir::Etc::sourcelist=$PWD/sources.list" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$PWD/lists")
  apt-get "${options[@]}" update >&2
  apt-get "${options[@]}" --download-only source lammps >&2
  tar xJf lammps_*.orig.tar.xz -C source --strip-components 1
  cp -r source/bench .
  cmake -S source/cmake -B build -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O3 -march=native -DNDEBUG" \
    -DPKG_GRANULAR=ON -DPKG_OPT=ON -DPKG_MOLECULE=ON -DBUILD_MPI=ON -DBUILD_OMP=OFF -DWITH_JPEG=OFF -DWITH_PNG=OFF \
    -DWITH_GZIP=OFF -DWITH_FFMPEG=OFF >&2
  cmake --build build -j "$(nproc)" >&2
fi
echo "$PWD/build/lmp"
