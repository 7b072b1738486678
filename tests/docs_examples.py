#!/usr/bin/env python3
# The code that pages show is the code that is compiled and run, and the files that they name are
# there.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: docs_examples.py ROOT    fails where a listing differs from the file that it names, or
names none.

Looked at are README.md, CONTRIBUTING.md and the pages below docs. Each listing, whether it is
indented or between lines of ```, follows one of two lines:
- `<!-- from PATH -->`: it stands in that file, lines together, and is whole. The tests compile or
  run that file.
- `<!-- not run: REASON -->`: commands that take an hour, a cluster, a key to end them; or a
  formula.
Lines of docs/gallery.md are those that docs/site/gallery.py reads: the test docs_gallery has them
checked.
What a block of `program-output` shows is made anew with the site, by the test docs_site.

Each file of docs/examples, which the tests compile or run, is shown by a page.
A path in backticks, such as `pairs/bonds.hpp`, must be one from the root, src, include or the page;
so must one that a listing names, where no run writes it.
"""
import re
import sys
from pathlib import Path
from textwrap import dedent

MARK = re.compile(r"<!-- (from|not run:) (.*) -->")
PATH = re.compile(r"`\"?((?:\w+/)+\w+\.(?:cpp|hpp|py|sh|toml|csv))\"?`")
NAMED = re.compile(r"(?<![\w/.])((?:bench|cases|docs|jobs|packaging|src|tests)/[\w./]+"
                   r"\.(?:obj|py|sh|slurm|toml))\b")
CODE = ("", "cpp", "cmake", "python", "sh", "toml")  # not pictures made of text
GALLERY = re.compile(r"    spall run .*? --out out/gallery/\w+\n")
# What is compiled or run, besides docs/examples: by tests of that name, the library's own build, or
# jobs/long_tests.sh.
RUN = ("docs/figures/", "include/", "jobs/try_pip.sh", "src/", "tests/outside/")


def stands_in(block, text):
    """Whether the lines of `block` follow each other in `text`, all indented alike."""
    wanted = dedent(block).splitlines()
    lines = text.splitlines()
    for k in range(len(lines) - len(wanted) + 1):
        if dedent("\n".join(lines[k : k + len(wanted)])).splitlines() == wanted:
            return True
    return False


def listings(text):
    """Kind of mark, what it says, and text, of each listing of a page."""
    lines, at, mark, in_list = text.splitlines(), 0, None, False
    while at < len(lines):
        line, begin = lines[at], at
        at += 1
        if line.startswith("```"):
            at = lines.index("```", at) + 1
            if line[3:] in CODE:
                yield *(mark or (None, None)), "\n".join(lines[begin + 1 : at - 1]) + "\n"
            mark = None
        elif line.startswith("    ") and not in_list:
            while at < len(lines) and (lines[at].startswith("    ") or not lines[at]):
                at += 1
            yield *(mark or (None, None)), "\n".join(lines[begin:at]).rstrip("\n") + "\n"
            mark = None
        elif line:
            found = MARK.fullmatch(line)
            mark = found and found.groups()
            # What is indented below an item of a list is more of it.
            in_list = (bool(re.match(r"\s*([-*]|\d+\.) ", line))
                       or (in_list and line.startswith(" ")))


def main(root):
    wrong, tied, untied, shown = [], 0, 0, set()
    pages = [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md"))]
    for page in pages:
        name = page.relative_to(root)
        for kind, says, block in listings(page.read_text()):
            if str(name) == "docs/gallery.md" and GALLERY.fullmatch(block):
                continue
            if kind is None:
                wrong.append(f"{name}: this does not say which file it is from, nor why it is not "
                             f"run:\n{block}")
            elif kind == "not run:":
                untied += 1
            else:
                tied += 1
                shown.add(root / says)
                if not says.startswith(("docs/examples/", *RUN)):
                    wrong.append(f"{name}: no test runs {says}")
                elif not stands_in(block, (root / says).read_text()):
                    wrong.append(f"{name}: this is not in {says}:\n{block}")
                if block.count("{") != block.count("}"):
                    wrong.append(f"{name}: this is not whole:\n{block}")
            for path in NAMED.findall(block):
                if not (root / path).exists():
                    wrong.append(f"{name}: there is no file {path}")
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
    print("\n".join(wrong) or
          f"{paths} paths are there, {tied} listings stand in their files, "
          f"{untied} tell why they are not run")
    return 1 if wrong or tied == 0 else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
