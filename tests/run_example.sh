#!/bin/bash
# Runs an example of docs/examples as a reader would, in a folder where cases and docs are at hand.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_example.sh BUILD SOURCE EXAMPLE, in a folder to write in
set -eu
build=$1 source=$2 example=$3
work=example_${example%.*}
rm -rf "$work"
mkdir "$work" && cd "$work"
ln -s "$source/cases" "$source/docs" .
mkdir build && ln -s "$build" build/release # as the README calls it
export PATH="$build:$PATH" PYTHONPATH="$build/python" MPLBACKEND=Agg
case $example in
  *.py) /usr/bin/python3 "docs/examples/$example" ;;
  *.sh) bash -eux "docs/examples/$example" ;;
esac
