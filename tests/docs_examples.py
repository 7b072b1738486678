#!/usr/bin/env python3
# The code that pages show is the code that is compiled, and the files that they name are there.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: docs_examples.py ROOT    fails where a block of code differs from the file that it names.

Each block of code follows a line `<!-- from PATH -->`, stands in that file, lines together, and is
whole. Each file of docs/examples, which the tests compile or run, is shown by a page.
A path in backticks, such as `pairs/bonds.hpp`, must be one from the root, src, include or the page.
"""
import re
import sys
from pathlib import Path
from textwrap import dedent

MARK = re.compile(r"^<!-- from (\S+) -->\n+```(\w+)\n(.*?)^```$", re.M | re.S)
PATH = re.compile(r"`\"?((?:\w+/)+\w+\.(?:cpp|hpp|py|sh|toml|csv))\"?`")
BLOCK = re.compile(r"^```(cpp|cmake|python|sh|toml)$", re.M)


def stands_in(block, text):
    """Whether the lines of `block` follow each other in `text`, all indented alike."""
    wanted = dedent(block).splitlines()
    lines = text.splitlines()
    for k in range(len(lines) - len(wanted) + 1):
        if dedent("\n".join(lines[k : k + len(wanted)])).splitlines() == wanted:
            return True
    return False


def main(root):
    wrong, blocks, shown = [], 0, set()
    for page in sorted((root / "docs").rglob("*.md")):
        text = page.read_text()
        marked = MARK.findall(text)
        if len(marked) != len(BLOCK.findall(text)):
            wrong.append(f"{page.name}: a block of code does not say which file it is from")
        for path, _, block in marked:
            blocks += 1
            shown.add(root / path)
            if not stands_in(block, (root / path).read_text()):
                wrong.append(f"{page.name}: this is not in {path}:\n{block}")
            if block.count("{") != block.count("}"):
                wrong.append(f"{page.name}: this is not whole:\n{block}")
    for example in sorted((root / "docs/examples").iterdir()):
        if example.suffix in (".cpp", ".hpp", ".py", ".sh", ".toml") and example not in shown:
            wrong.append(f"no page shows {example.relative_to(root)}")
    paths = 0
    for page in [p for p in root.rglob("*.md") if p.name != "CHANGELOG.md"]:
        if page.relative_to(root).parts[0] in ("build", "out"):
            continue
        for path in PATH.findall(page.read_text()):
            paths += 1
            places = (root, root / "src", root / "include", page.parent)
            if not any((at / path).exists() for at in places):
                wrong.append(f"{page.relative_to(root)}: there is no file {path}")
    print("\n".join(wrong) or f"{paths} paths are there, {blocks} blocks stand in their files")
    return 1 if wrong or blocks == 0 else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
