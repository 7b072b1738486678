#!/usr/bin/env python3
# Texts are read by people: how long their sentences are, and how many are chained by semicolons.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: prose.py ROOT [-v]    prints a row a page and fails where the bounds are passed.

Counted are sentences of running text and of lists, in every page but the change log and what
scripts write. Code, formulas, tables, headings and pictures are passed over. -v shows long
sentences.
"""
import re
import sys
from pathlib import Path

LONG, VERY_LONG = 30, 36  # words
MOST_LONG = 0.10  # share of the sentences of a page; over all pages half of it
MOST_SEMICOLONS = 15  # of 100 sentences, over all pages
FEWEST = 20  # sentences from which on a page is judged by itself


def sentences(text):
    text = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
    text = re.sub(r"<!-- ([^>]*) -->.*?<!-- end of \1 -->", "", text, flags=re.S)  # by scripts
    text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"`[^`]*`", "CODE", text)
    text = re.sub(r"^\$\$.*?^\$\$$", "", text, flags=re.M | re.S)
    text = re.sub(r"\$[^$\n]+\$", "FORMULA", text)
    blocks, block = [], []
    for line in [*text.splitlines(), ""]:
        starts = re.match(r"\s*([-*]|\d+\.)\s", line)
        skipped = re.match(r"(#|\||    |\s*$|!\[)", line) and not starts
        if (starts or skipped) and block:
            blocks.append(" ".join(block))
            block = []
        if not skipped:
            block.append(re.sub(r"^\s*([-*]|\d+\.)\s", "", line).strip())
    for paragraph in blocks:
        plain = paragraph.replace("**", "").replace("*", "")
        plain = re.sub(r"\b(et al|e\.g|i\.e|cf|eqs?|Fig|vs|No|ch)\. ", r"\1 ", plain)
        for sentence in re.split(r"(?<=[.!?])[\")]?\s+(?=[A-Z0-9\"(])", plain):
            if re.search(r"[A-Za-z]{2}", sentence):
                yield sentence.strip()


def words(sentence):
    return len(re.findall(r"[A-Za-z0-9][^\s]*", sentence))


def main(root, verbose):
    pages = [p.relative_to(root) for p in root.rglob("*.md")]
    pages = [root / p for p in pages if p.parts[0] not in ("build", "out", ".git")]
    pages = [p for p in pages if p.parent.name != "results"]
    pages = [p for p in pages if p.name not in ("CHANGELOG.md", "results.md", "convergence.md")]
    wrong, everything = [], []
    print(f"{'sentences':>9} {'words':>5} {'> 30':>5} {'> 36':>5} {'; of 100':>8}")
    for page in [*sorted(pages), None]:
        found = everything if page is None else list(sentences(page.read_text()))
        if not found:
            continue
        if page is not None:
            everything += found
        lengths = [words(s) for s in found]
        many = sum(n > LONG for n in lengths)
        very = sum(n > VERY_LONG for n in lengths)
        chained = 100 * sum(s.count(";") for s in found) / len(found)
        name = page.relative_to(root) if page else "all"
        mean = sum(lengths) / len(found)
        print(f"{len(found):9} {mean:5.1f} {many:5} {very:5} {chained:8.1f}  {name}")
        if page and len(found) >= FEWEST and many > MOST_LONG * len(found):
            wrong.append(f"{name}: {many} of {len(found)} sentences have more than {LONG} words")
        if page is None and many > MOST_LONG / 2 * len(found):
            wrong.append(f"{many} of all {len(found)} sentences have more than {LONG} words")
        if page is None and chained > MOST_SEMICOLONS:
            wrong.append(f"{chained:.0f} semicolons in 100 sentences, more than {MOST_SEMICOLONS}")
        if verbose and page:
            print("".join(f"    {words(s)}: {s}\n" for s in found if words(s) > LONG), end="")
    print("\n".join(wrong))
    return 1 if wrong or not everything else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), "-v" in sys.argv))
