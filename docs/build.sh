#!/usr/bin/env bash
# usage: docs/build.sh BUILD [BUILDER]   makes the documentation site in build/docs/html, without a warning.
# SPDX-License-Identifier: BSD-3-Clause
#
# BUILD is the build folder whose program and Python module the pages call, such as build/release.
# BUILDER is Sphinx's: html by default, linkcheck looks whether links to other sites are alive.
set -euo pipefail
source "$(dirname "$0")/../jobs/environment.sh"  # goes to the root of the tree

builder=${2:-html}
SPALL_BUILD=$(realpath "$1")
SPALL_DOXYGEN=$PWD/build/docs/xml
export SPALL_BUILD SPALL_DOXYGEN PATH="$SPALL_BUILD:$PATH" PYTHONPATH="$SPALL_BUILD/python"

mkdir -p build/docs
(cat docs/site/Doxyfile && echo "OUTPUT_DIRECTORY = build/docs") | doxygen -
/usr/bin/python3 -m sphinx -b "$builder" -c docs/site -d "build/docs/$builder.doctrees" -W --keep-going -q \
  . "build/docs/$builder"
