#!/usr/bin/env python3
# Makes the pictures of docs/gallery.md: small runs of the cases, and the first picture of each
# report.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: gallery.py [--check | NAME ...]    from the root of the tree, with `spall` in PATH

Draws the pictures of these names, or all. --check draws none: it asks `spall check` of each
command.
"""
import base64
import io
import re
import subprocess
import sys
from pathlib import Path

from PIL import Image

PAGE = Path("docs/gallery.md")
# As the page tells them.
COMMAND = re.compile(r"^    spall (run .*?) --out out/gallery/(\w+)$", re.M)
WIDEST, COLOURS = 900, 160


def first_picture(report):
    found = re.search(r"data:image/\w+;base64,([^'\"]+)", report.read_text())
    return Image.open(io.BytesIO(base64.b64decode(found[1]))).convert("RGB")


def main(names, check):
    for words, name in COMMAND.findall(PAGE.read_text()):
        if names and name not in names:
            continue
        folder = Path("out/gallery") / name
        if check:
            subprocess.run(["sh", "-c", f"spall {words.replace('run', 'check', 1)}"], check=True)
            continue
        subprocess.run(["sh", "-c", f"spall {words} --out {folder} --overwrite"], check=True)
        subprocess.run(["spall", "report", folder], check=True)
        picture = first_picture(folder / "report.html")
        picture.thumbnail((WIDEST, WIDEST))
        picture.quantize(COLOURS).save(PAGE.parent / "gallery" / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main([a for a in sys.argv[1:] if a != "--check"], "--check" in sys.argv)
