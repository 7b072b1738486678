#!/usr/bin/env bash
# Installs Spall from a build folder, moves the prefix, and builds and runs a program against it, with
# the shared library and with the static one. usage: outside.sh BUILD SOURCE
set -euo pipefail
build=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'echo "line $LINENO failed" >&2; tail -n 20 "$work"/*.log >&2' ERR
cmake --install "$build" --prefix "$work/first" > "$work/install.log"
mv "$work/first" "$work/prefix"  # no path of the tree or of the first prefix may be in it

cmake -S "$source/tests/outside" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" \
  -DCMAKE_BUILD_TYPE=Release > "$work/configure.log"
cmake --build "$work/build" > "$work/build.log"
# By a file: grep -q leaves a pipe at its first match, and ldd would end by SIGPIPE.
ldd "$work/build/pile" > "$work/ldd.log"
grep -q "$work/prefix/.*libspall.so" "$work/ldd.log"
for program in pile pile_static; do
  for ranks in 1 2; do
    mpirun --oversubscribe -n "$ranks" "$work/build/$program" > "$work/out_$ranks"
  done
  cat "$work/out_1"
  # The pile has fallen: the lowest sphere rests on the plane, the same on 1 and 2 ranks.
  grep -q '^0 0\.1000$' "$work/out_1"
  diff <(grep -v J "$work/out_1" | sort -n) <(grep -v J "$work/out_2" | sort -n)
done

# The installed program runs a case and draws its report.
"$work/prefix/bin/spall" run "$source/cases/hello/case.toml" --out "$work/out" \
  --set phases.aggregation.duration=100 --set phases.evolution.duration=1 \
  --set 'read_out=["1 s"]' > "$work/run.log"
"$work/prefix/bin/spall" report "$work/out" > "$work/report.log"
for file in share/man/man1/spall.1 share/bash-completion/completions/spall share/zsh/site-functions/_spall; do
  test -s "$work/prefix/$file"
done
grep -q '"three": "data:text/javascript' "$work/out/report.html"
if grep -rF -e "$source/" -e "$work/first" "$work/prefix"; then
  echo "what is installed names the source tree or the first prefix" >&2
  exit 1
fi
echo "an outside program was built and run"
