"""What a release must agree on: one version, a licence for each file.

SPDX-License-Identifier: BSD-3-Clause
usage: release.py ROOT SPALL
"""
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

root, spall = Path(sys.argv[1]), sys.argv[2]


def said(path, pattern):
    found = re.search(pattern, (root / path).read_text(), re.M)
    assert found, f"{path} tells no version"
    return found[1]


version = said("CMakeLists.txt", r"^project\(spall VERSION (\d+\.\d+\.\d+) ")
others = {"CITATION.cff": said("CITATION.cff", r"^version: (\S+)$"),
          "debian/changelog": said("debian/changelog", r"\Aspall \(([^)]+)-\d+\)"),
          "spall --version": subprocess.run([spall, "--version"], check=True, capture_output=True, text=True).stdout
          .split()[1].rstrip(",")}
wrong = {name: told for name, told in others.items() if told != version}
assert not wrong, f"CMakeLists.txt tells {version}, but {wrong}"
assert tomllib.loads((root / "pyproject.toml").read_text())["project"]["dynamic"] == ["version"]

soname = ".".join(version.split(".")[:2])
control = (root / "debian/control").read_text()
assert f"\nPackage: libspall{soname}\n" in control, f"debian/control has no package libspall{soname}"
assert (root / f"debian/libspall{soname}.install").is_file()

# Keys that the format wants, and those that it knows (https://citation-file-format.github.io, 1.2.0).
citation = re.findall(r"^([a-z-]+):", (root / "CITATION.cff").read_text(), re.M)
assert {"cff-version", "message", "title", "authors"} <= set(citation), citation
known = {"cff-version", "message", "type", "title", "abstract", "authors", "version", "license", "keywords", "doi",
         "date-released", "repository-code", "url", "commit", "identifiers", "references", "preferred-citation"}
assert set(citation) <= known and len(set(citation)) == len(citation), citation

if (root / ".git").exists():
    tags = subprocess.run(["git", "-C", root, "tag", "--points-at", "HEAD", "v*"], capture_output=True, text=True)
    for tag in tags.stdout.split():
        assert tag == f"v{version}", f"the tag {tag} is on version {version}"
    if shutil.which("reuse"):
        lint = subprocess.run(["reuse", "--root", root, "lint"], capture_output=True, text=True)
        assert lint.returncode == 0, lint.stdout
print(f"version {version} everywhere")
