# The commands of the guide to asteroids.
# SPDX-License-Identifier: BSD-3-Clause
spall check docs/examples/shaped_pile.toml
mpirun -n 2 spall run docs/examples/shaped_pile.toml --out out/asteroid
spall report out/asteroid
spall resume out/asteroid/after_settling.h5 --out out/strong --set "phases.impact.cohesion=50 N"
spall check cases/didymoon/case.toml
spall check cases/dart/case.toml
