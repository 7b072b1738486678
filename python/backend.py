"""Makes the wheel that `pip install .` asks for: CMake builds the program and the module.

SPDX-License-Identifier: BSD-3-Clause
The interface is PEP 517's, the wheel's layout that of the binary distribution format
(packaging.python.org).
"""
import base64
import hashlib
import os
import re
import stat
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / f"python-{sysconfig.get_config_var('py_version_nodot')}"


def get_requires_for_build_wheel(config_settings=None):
    return []


def version():
    return re.search(r"project\(spall VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


def tag():
    python = f"cp{sysconfig.get_config_var('py_version_nodot')}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def metadata():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {version()}",
             f"Summary: {project['description']}", f"License: {project['license']['text']}",
             f"Requires-Python: {project['requires-python']}", "Requires-Dist: numpy",
             "Provides-Extra: results", *(f"Requires-Dist: {name}; extra == 'results'"
                                          for name in ("h5py", "matplotlib", "pandas"))]
    return "\n".join(lines) + "\n"


def compile_all():
    subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DSPALL_PYTHON=ON",
                    "-DSPALL_TESTS=OFF", "-DSPALL_BENCH=OFF",
                    f"-DPYTHON_EXECUTABLE={sys.executable}"],
                   check=True, stdout=sys.stderr)
    subprocess.run(["cmake", "--build", BUILD, "-j", str(os.cpu_count()), "--target", "spall",
                    "spall_python"],
                   check=True, stdout=sys.stderr)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    compile_all()
    name = f"spall-{version()}"
    data, info = f"{name}.data", f"{name}.dist-info"
    files = {f"spall/{path.name}": path
             for path in sorted((ROOT / "python" / "spall").glob("*.py"))}
    files |= {f"spall/{path.name}": path
              for path in (BUILD / "python" / "spall").glob("_spall.*.so")}
    files[f"{data}/scripts/spall"] = BUILD / "spall"
    scripts = BUILD / "share" / "spall" / "scripts"  # and the parts of their pages
    files |= {f"{data}/data/share/spall/scripts/{path.relative_to(scripts)}": path
              for path in sorted(scripts.rglob("*")) if path.is_file() and path.suffix != ".pyc"}
    contents = {place: path.read_bytes() for place, path in files.items()}
    contents[f"{info}/METADATA"] = metadata().encode()
    contents[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: spall\nRoot-Is-Purelib: false\nTag: {tag()}\n").encode()
    record = ""
    for place, content in contents.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{place},sha256={digest},{len(content)}\n"
    contents[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    wheel = f"{name}-{tag()}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, content in contents.items():
            entry = zipfile.ZipInfo(place)
            entry.compress_type = zipfile.ZIP_DEFLATED
            is_program = place == f"{data}/scripts/spall"
            entry.external_attr = (stat.S_IFREG | (0o755 if is_program else 0o644)) << 16
            archive.writestr(entry, content)
    return wheel
