# The commands of the README, in its order.
# SPDX-License-Identifier: BSD-3-Clause
build/release/spall check  cases/hello/case.toml        # bodies, memory, steps; refuses what run refuses at its start
mpirun -n 2 build/release/spall check --time cases/hello/case.toml   # also foretells the time of the first phase
mpirun -n 2 build/release/spall run cases/hello/case.toml --set contact.friction=0.3
build/release/spall plan   cases/hello/case.toml --ranks 16,64       # ghosts, messages, memory and time on more ranks
build/release/spall report out/hello                    # out/hello/report.html: bodies in 3-D, curves, verdicts
build/release/spall list                                # the cases here
build/release/spall keys                                # every key of a case file
build/release/spall check docs/examples/small_pile.toml
build/release/spall run docs/examples/drum.toml
