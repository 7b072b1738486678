# The commands of the guide to grains.
# SPDX-License-Identifier: BSD-3-Clause
spall check docs/examples/chute.toml
spall run docs/examples/chute.toml --out out/chute
spall report out/chute
/usr/bin/python3 docs/examples/chute_profile.py
spall check cases/repose/case.toml
spall check cases/column/case.toml
