# The heap of rigid clumps on the page on rigid contact.
# SPDX-License-Identifier: BSD-3-Clause
spall check docs/examples/clumps.toml
spall run docs/examples/clumps.toml --out out/clumps
spall report out/clumps
