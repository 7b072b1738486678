#!/usr/bin/env bash
# Builds the Debian source package and its packages from a copy of the tree, and uses what is in them. As root they are
# installed and removed again in a layer over this machine, which stays as it is; else unpacked. Ten minutes on two cores.
# SPDX-License-Identifier: BSD-3-Clause
# usage: try_debian.sh [FOLDER]    FOLDER keeps the packages, and what lies there is not built anew; needs dpkg-dev, debhelper
#                                  and the packages of jobs/packages.sh
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../jobs/environment.sh"
kept=${1:+$(realpath "$1")}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
version=$(sed -n 's/^project(spall VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
export work version

source=$work/spall-$version
mkdir "$source"
git ls-files -z | tar --create --null --files-from=- | tar --extract --directory "$source"
cd "$work"
if [ -z "$kept" ] || ! cp "$kept"/*.deb . 2>/dev/null; then
  tar --create --gzip --exclude="spall-$version/debian" --file "spall_$version.orig.tar.gz" "spall-$version"
  (cd "$source" && DEB_BUILD_OPTIONS="parallel=$(nproc) noautodbgsym" dpkg-buildpackage --unsigned-source --unsigned-changes)
  if command -v lintian >/dev/null; then lintian --fail-on error ./*.changes; fi
  [ -z "$kept" ] || cp ./*.deb ./*.dsc ./*.tar.* "$kept"
fi
ls -l ./*.deb

# Runs what the packages hold, below a folder, or where they were installed.
use_packages() {  # folder, or nothing
  local root=$1 example level
  cd "$work"
  export PATH="$root/usr/bin:$PATH"
  [ "$(command -v spall)" = "$root/usr/bin/spall" ]
  [ "$(spall --version | cut -d ' ' -f 2)" = "$version," ]
  example=$root/usr/share/doc/spall/examples/hello/case.toml
  spall check "$example"
  for level in v2 v4; do # the oldest instructions that packages ask for, and the best of this machine
    SPALL_INSTRUCTIONS=$level mpirun --oversubscribe -n 2 spall run "$example" --out "out_$level" >"log_$level"
    grep -q '^deflection' "log_$level"
  done
  spall report out_v2
  [ -s out_v2/report.html ]
  man --warnings --local-file "$root/usr/share/man/man1/spall.1.gz" >/dev/null

  # A program outside is built with the library of the packages.
  cmake -S "spall-$version/tests/outside" -B outside -DCMAKE_PREFIX_PATH="$root/usr" -DCMAKE_BUILD_TYPE=Release >/dev/null
  cmake --build outside
  ldd outside/pile >ldd.log
  grep -q "$root/\(usr/\)*lib/.*libspall.so" ldd.log
  outside/pile >/dev/null
}

# Inside the layer.
install_and_use() {
  cd "$work"
  apt-get install --yes --no-install-recommends ./*.deb
  use_packages ""
  apt-get purge --yes spall libspall0.1 libspall-dev
  [ ! -e /usr/bin/spall ] && [ ! -e /usr/share/spall ] && [ ! -e /usr/include/spall ]
}
export -f use_packages install_and_use

if [ "$(id -u)" -eq 0 ]; then
  mkdir layer
  unshare --mount bash -euo pipefail -c 'cd layer
    mount -t tmpfs spall .
    mkdir changes scratch all
    mount -t overlay -o lowerdir=/,upperdir=changes,workdir=scratch spall all
    for folder in proc sys dev; do mount --rbind "/$folder" "all/$folder"; done
    mkdir --parents "all$work"
    mount --bind "$work" "all$work"
    chroot all bash -euo pipefail -c install_and_use'
else
  for package in ./*.deb; do dpkg-deb --extract "$package" root; done
  use_packages "$work/root"
fi
echo "the packages do what they must"
