# The speed from which on a thin wall fails, between two that are told.
# SPDX-License-Identifier: BSD-3-Clause
spall limit docs/examples/thin_wall.toml --vary 'groups.ball.velocity=[0, 0, "-400 m/s"]..[0, 0, "-1600 m/s"]' --within 30% --jobs 2
cat out/thin_wall-limit/table.csv
