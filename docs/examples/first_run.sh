# Checks a case, runs it on two ranks, makes its report, and reads one number of the result.
# SPDX-License-Identifier: BSD-3-Clause
spall check cases/hello/case.toml
mpirun -n 2 spall run cases/hello/case.toml --set groups.cloud.packing.count=60
spall report out/hello
grep beta out/hello/results.toml
