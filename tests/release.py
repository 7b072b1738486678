"""What a release must agree on: one version, a licence for each file, recipes that can be read.

SPDX-License-Identifier: BSD-3-Clause
usage: release.py ROOT SPALL
"""
import ast
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
          "spall --version": subprocess.run([spall, "--version"], check=True, capture_output=True,
                                            text=True).stdout
          .split()[1].rstrip(",")}
wrong = {name: told for name, told in others.items() if told != version}
assert not wrong, f"CMakeLists.txt tells {version}, but {wrong}"
assert tomllib.loads((root / "pyproject.toml").read_text())["project"]["dynamic"] == ["version"]

soname = ".".join(version.split(".")[:2])
control = (root / "debian/control").read_text()
assert f"\nPackage: libspall{soname}\n" in control, \
    f"debian/control has no package libspall{soname}"
assert (root / f"debian/libspall{soname}.install").is_file()

# Keys that the format wants, and those that it knows (https://citation-file-format.github.io,
# 1.2.0).
citation = re.findall(r"^([a-z-]+):", (root / "CITATION.cff").read_text(), re.M)
assert {"cff-version", "message", "title", "authors"} <= set(citation), citation
told = re.search(rf"^## {re.escape(version)} \((\S+)\)$", (root / "CHANGELOG.md").read_text(), re.M)
assert told, f"CHANGELOG.md has no heading for {version}"
assert said("CITATION.cff", r"^date-released: (\S+)$") == told[1], \
    "CITATION.cff and CHANGELOG.md tell other days"
known = {"cff-version", "message", "type", "title", "abstract", "authors", "version", "license",
         "keywords", "doi", "date-released", "repository-code", "url", "commit", "identifiers",
         "references", "preferred-citation"}
assert set(citation) <= known and len(set(citation)) == len(citation), citation

if (root / ".git").exists():
    tags = subprocess.run(["git", "-C", root, "tag", "--points-at", "HEAD", "v*"],
                          capture_output=True, text=True)
    for tag in tags.stdout.split():
        assert tag == f"v{version}", f"the tag {tag} is on version {version}"
    if shutil.which("reuse"):
        lint = subprocess.run(["reuse", "--root", root, "lint"], capture_output=True, text=True)
        assert lint.returncode == 0, lint.stdout
# Recipes for programs that need not be here: Spack's directives and Apptainer's sections.
package = ast.parse((root / "packaging/spack/packages/spall/package.py").read_text())
recipe = next(node for node in package.body if isinstance(node, ast.ClassDef))
assert recipe.name == "Spall" and recipe.bases[0].id == "CMakePackage"
called = {node.value.func.id for node in recipe.body if isinstance(node, ast.Expr)
          and isinstance(node.value, ast.Call)}
assert called <= {"license", "version", "generator", "depends_on", "conflicts"}, called
options = set(re.findall(r"^option\((\w+)", (root / "CMakeLists.txt").read_text(), re.M))
given = {node.value for node in ast.walk(recipe) if isinstance(node, ast.Constant)
         and str(node.value).startswith("SPALL_")}
assert given and given <= options, given - options

stages = (root / "packaging/spall.def").read_text().split("Bootstrap: ")[1:]
for stage in stages:
    sections = re.split(r"^%(\w+).*\n", stage, flags=re.M)[1:]
    assert set(sections[::2]) <= {"files", "post", "test", "runscript", "help"}, sections[::2]
    for name, text in zip(sections[::2], sections[1::2]):
        if name in ("post", "test", "runscript"):
            subprocess.run(["sh", "-n"], input=text, text=True, check=True)
assert [re.search(r"^Stage: (\w+)$", stage, re.M)[1] for stage in stages] == ["build", "run"]
print(f"version {version} everywhere")
