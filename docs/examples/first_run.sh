# Checks a case, runs it on two ranks, makes its report, and reads one number of the result.
# SPDX-License-Identifier: BSD-3-Clause
spall check cases/hello/case.toml
mpirun -n 2 spall run cases/hello/case.toml --set groups.cloud.packing.count=60 --out out/first_run
spall report out/first_run
grep beta out/first_run/results.toml
