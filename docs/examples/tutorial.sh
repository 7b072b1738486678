# The commands of the tutorial, in its order.
# SPDX-License-Identifier: BSD-3-Clause
cp docs/examples/first_case.toml pile.toml
spall check pile.toml
mpirun -n 2 spall run pile.toml
spall report out/pile
spall run pile.toml --set contact.friction=0 --out out/smooth
spall sweep pile.toml --set phases.impact.cohesion=1,1000N --set seed=1..2 --show deflection.beta_along
/usr/bin/python3 docs/examples/tutorial_plot.py
