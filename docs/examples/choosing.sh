# The commands of the page on how to choose: what check says of steps, memory and time.
# SPDX-License-Identifier: BSD-3-Clause
spall check cases/bumper/case.toml
! spall check cases/bumper/case.toml --set phases.impact.step=20ns
! spall check cases/column/case.toml --set phases.collapse.step=50us
spall check --time cases/hello/case.toml
