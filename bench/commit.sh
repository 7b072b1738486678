#!/bin/sh
# The commit that figures are of; "-dirty" where a file beside texts and results differs from it.
# SPDX-License-Identifier: BSD-3-Clause
cd "$(dirname "$(realpath "$0")")/.."
git diff --quiet HEAD -- . ':!*.md' ':!bench/results' ':!cases/*/*.csv' && dirty= || dirty=-dirty
echo "$(git rev-parse --short HEAD)$dirty"
