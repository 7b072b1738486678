# The commands of the guide to grains.
# SPDX-License-Identifier: BSD-3-Clause
spall check docs/examples/chute.toml
spall run docs/examples/chute.toml --out out/chute
spall report out/chute
/usr/bin/python3 docs/examples/chute_profile.py
spall run docs/examples/chute.toml --set groups.flow.packing.shape=twin --out out/twins --set \
  'shapes.twin={spheres = [{at = [0, 0, 0], radius = 1}, {at = [1, 0, 0], radius = 1}]}' --set 'phases.flow.step="5 us"'
spall report out/twins
spall check cases/repose/case.toml
spall check cases/column/case.toml
