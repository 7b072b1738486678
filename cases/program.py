"""Runs the program for scripts of cases.

SPDX-License-Identifier: BSD-3-Clause
"""
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROGRAM = ROOT / "build/release/spall"
AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def spall(*words, changes=(), ranks=None, program=PROGRAM, before=(), shows=False):
    """What `spall` prints on these words, or None where it `shows` that at once. `changes` are
    those of --set, key=value; `before` comes before the command, such as nice -n 5. Without
    `ranks`, or on one, mpirun is left out: it would bind all single ranks to the same core."""
    launched = ["mpirun", "--oversubscribe", "-n", ranks] if ranks and int(ranks) > 1 else []
    command = [*before, *launched, program, *words]
    for change in changes:
        command += ["--set", change]
    return subprocess.run([str(word) for word in command], check=True, text=True,
                          env=AS_ROOT | os.environ,
                          stdout=None if shows else subprocess.PIPE).stdout
