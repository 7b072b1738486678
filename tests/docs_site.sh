#!/bin/bash
# The documentation site builds without a warning; left out, saying so, where its tools are not installed.
# SPDX-License-Identifier: BSD-3-Clause
# usage: docs_site.sh BUILD SOURCE
for tool in doxygen "/usr/bin/python3 -m sphinx"; do
  $tool --version >/dev/null 2>&1 || {
    echo "skipped: there is no '$tool' here; jobs/packages.sh installs it"
    exit 77
  }
done
/usr/bin/python3 -c "import breathe, furo, myst_parser, sphinxcontrib.programoutput" || {
  echo "skipped: a package of Sphinx is missing; jobs/packages.sh installs it"
  exit 77
}
"$2/docs/build.sh" "$1" && test -s "$2/build/docs/html/docs/index.html"
