# The commands of the page on more ranks: what a case would be on them.
# SPDX-License-Identifier: BSD-3-Clause
spall plan cases/hello/case.toml --ranks 2,16
mpirun -n 2 spall plan cases/hello/case.toml --ranks 64 --calibrate
spall plan cases/hello/case.toml --ranks 64 --latency "1.5 us" --bandwidth "2 GB/s"
