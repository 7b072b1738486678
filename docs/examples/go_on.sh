# The commands of the guide to long runs.
# SPDX-License-Identifier: BSD-3-Clause
spall run cases/hello/case.toml --set groups.cloud.packing.count=60 --out out/go_on
spall check out/go_on/after_aggregation.h5
spall resume out/go_on/after_aggregation.h5 --out out/go_on_firm --set "phases.impact.cohesion=10 N"
spall plan cases/hello/case.toml --ranks 2,16
