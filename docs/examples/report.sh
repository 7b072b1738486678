# The commands of the page on reports: a run, and two side by side.
# SPDX-License-Identifier: BSD-3-Clause
spall run cases/hello/case.toml --set groups.cloud.packing.count=60
spall run cases/hello/case.toml --set groups.cloud.packing.count=60 --set phases.impact.cohesion=100N --out out/c100
spall run cases/hello/case.toml --set groups.cloud.packing.count=60 --set phases.impact.cohesion=500N --out out/c500
spall report out/hello                # out/hello/report.html
spall report out/c100 out/c500        # out/c100/compared.html: two runs side by side
