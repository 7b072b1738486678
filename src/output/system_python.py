# The Python that has the packages of the distribution, where another one comes first in PATH.
# SPDX-License-Identifier: BSD-3-Clause
import importlib.util
import os
import sys

SYSTEM = "/usr/bin/python3"


def need(program, *modules):
    """Goes on in the system's Python where this one lacks a module; ends with a message where that
    does, too."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if not missing and sys.version_info >= (3, 11):
        return
    if os.path.exists(SYSTEM) and os.environ.get("SPALL_PYTHON") != SYSTEM:
        os.environ["SPALL_PYTHON"] = SYSTEM
        os.execv(SYSTEM, [SYSTEM, *sys.argv])
    packages = " ".join(f"python3-{name}" for name in modules)
    sys.exit(f"{program}: it needs Python 3.11 with {', '.join(modules)} (apt install {packages})")
