#!/bin/bash
# Broken inputs by the program: those that test_corpus has laid ready, and command lines. Each ends soon, not
# with 0, and with its message, said once.
# SPDX-License-Identifier: BSD-3-Clause
# usage: corpus.sh SPALL MPIEXEC RANKS CORPUS, in a folder to write in
set -u
spall=$1 mpiexec=$2 ranks=$3 corpus=$(realpath "$4")
work=corpus_by_program_$ranks
rm -rf "$work"
mkdir "$work" && cd "$work" || exit 1
work=$PWD
failures=0
count=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

refuses() {  # message; arguments of the program
  local message=$1 code
  shift
  count=$((count + 1))
  timeout -k 2 30 "$mpiexec" --oversubscribe -n "$ranks" "$spall" "$@" </dev/null >"$work/stdout" 2>"$work/stderr"
  code=$?
  [ $code -ne 0 ] || fail "$*: exit code is 0"
  [ $code -ne 124 ] && [ $code -ne 137 ] || fail "$*: hangs"
  [ $code -lt 128 ] || fail "$*: is ended by a signal"
  [ "$(grep -cF -- "$message" "$work/stderr")" = 1 ] || fail "$*: says '$(cat "$work/stderr")', not '$message'"
}

while IFS='|' read -r number reader file override message; do
  cd "$corpus/$number" || exit 1
  refuses "spall: $message" "$reader" "$file" ${override:+--set "$override"}
done <"$corpus/list"

cd "$work" || exit 1
echo "title = 5" >x.toml
while IFS='|' read -r arguments message; do
  # shellcheck disable=SC2086
  refuses "$message" $arguments
done <<'END'
|A subcommand is required
fly|spall: there is no subcommand 'fly'; `spall --help` lists them
plan x.toml --ranks 0|--ranks: Value 0 not in range 1 to 2147483647
check /dev/null|spall: '/dev/null' is a device or a pipe, not a file
run|case is required
run a b|The following argument was not expected: b
check gone.toml|spall: there is no file 'gone.toml'
check .|spall: '.' is a folder, not a file
check x.toml|spall: x.toml:1:9: title is a number; a text in quotes is wanted
check x.toml --speed 5|The following arguments were not expected: 5 --speed
check x.toml --set|--set: 1 required TEXT missing
resume|restart is required
resume gone.h5|spall: no restart file 'gone.h5'
resume x.toml|spall: 'x.toml' is not a whole restart file: it has no seal
resume .|spall: '.' is not a whole restart file
solve|problem is required
solve gone.h5|spall: there is no file 'gone.h5'
solve .|spall: '.' is a folder, not a file
solve x.toml|spall: H5Fopen of 'x.toml' failed: file signature not found
solve x.toml --tol little|Could not convert: --tol = little
solve x.toml --tol -1|spall: --tol = -1: more than 0 is wanted
solve x.toml --tol nan|spall: --tol = nan: more than 0 is wanted
solve x.toml --prox -1|spall: --prox = -1: 0 or more is wanted
solve x.toml --max-products 0|spall: --max-products = 0: more than 0 is wanted
solve x.toml --method newton|--method: Check newton value
report gone|spall report: 'gone/trajectory.h5' is missing
list|spall: there is no folder 'cases' here
keys now|The following argument was not expected: now
END

echo "$count broken inputs, $failures not as they should be"
[ $count -ge 50 ] || exit 1  # mpirun reads what is left of a list that it is given
exit $((failures > 0))
