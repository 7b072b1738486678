#!/usr/bin/env bash
# Builds the Debian packages from a copy of the tree, unpacks them, and uses what is in them. Ten minutes on two cores.
# SPDX-License-Identifier: BSD-3-Clause
# usage: try_debian.sh [FOLDER]    FOLDER keeps the packages; needs dpkg-dev, debhelper and the packages of jobs/packages.sh
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../jobs/environment.sh"
tree=$PWD
kept=${1:+$(realpath "$1")}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

mkdir "$work/spall"
git ls-files -z | tar --create --null --files-from=- | tar --extract --directory "$work/spall"
cd "$work/spall"
DEB_BUILD_OPTIONS="parallel=$(nproc) noautodbgsym" dpkg-buildpackage --unsigned-source --unsigned-changes --build=binary
cd "$work"
ls -l ./*.deb
if command -v lintian >/dev/null; then lintian --fail-on error ./*.changes; fi

for package in ./*.deb; do dpkg-deb --extract "$package" root; done
spall=$work/root/usr/bin/spall
[ "$("$spall" --version | cut -d ' ' -f 2)" = "$(sed -n 's/^project(spall VERSION \([0-9.]*\).*/\1/p' "$tree/CMakeLists.txt")," ]
example=$work/root/usr/share/doc/spall/examples/hello/case.toml
"$spall" check "$example"
for level in v2 v4; do # the oldest instructions that packages ask for, and the best of this machine
  SPALL_INSTRUCTIONS=$level mpirun --oversubscribe -n 2 "$spall" run "$example" --out "out_$level" >"log_$level"
  grep -q '^deflection' "log_$level"
done
"$spall" report out_v2
[ -s out_v2/report.html ]
man --warnings --local-file root/usr/share/man/man1/spall.1.gz >/dev/null

# A program outside is built with the library of the packages.
cmake -S "$tree/tests/outside" -B outside -DCMAKE_PREFIX_PATH="$work/root/usr" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build outside
ldd outside/pile > ldd.log
grep -q "$work/root/usr/lib/.*libspall.so" ldd.log
outside/pile >/dev/null

[ -z "$kept" ] || cp ./*.deb "$kept"
echo "the packages do what they must"
