# The commands of the guide to shields.
# SPDX-License-Identifier: BSD-3-Clause
spall check docs/examples/shield.toml
mpirun -n 2 spall run docs/examples/shield.toml --out out/shield
spall report out/shield
sed -n '/^\[shield_/,/^$/p; /^\[conservation/,/^$/p' out/shield/results.toml
spall check cases/whipple/case.toml
