#!/usr/bin/env python3
# Lints the tree's Python: pyflakes, and of pycodestyle what the code is written by.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: python_style.py ROOT    fails with a line for each place; needs python3-pyflakes and
python3-pycodestyle, and is skipped (77) without them.

No line has more than 100 columns, as in C++; nothing is imported or named in vain; no blanks end a
line; one statement stands in a line. Code of others (three, uplot, Spack's recipe) is left alone.
"""
import sys
from pathlib import Path

try:
    import pycodestyle
    from pyflakes import api, reporter
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

NOT_OURS = ("build", "out", "src/output/three", "src/output/uplot", "packaging/spack")
COLUMNS = 100
CHECKS = ["E501", "E70", "E71", "E72", "E9", "W1", "W2", "W3", "W6"]


def main(root):
    files = [str(path) for path in sorted(root.rglob("*.py"))
             if not str(path.relative_to(root)).startswith(NOT_OURS)]
    found = sum(api.checkPath(file, reporter.Reporter(sys.stdout, sys.stderr)) for file in files)
    style = pycodestyle.StyleGuide(select=CHECKS, max_line_length=COLUMNS)
    found += style.check_files(files).total_errors
    print(f"{len(files)} files, {found} places")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
