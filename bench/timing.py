"""Processor time of one run of the program.

SPDX-License-Identifier: BSD-3-Clause
"""
import resource
import shutil
import subprocess


def processor_seconds(program, case, changes, folder):
    """Of `spall run` into an empty `folder`, on one rank, which waits for nobody."""
    shutil.rmtree(folder, ignore_errors=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, "run", case, "--out", folder,
                    *[word for one in changes for word in ("--set", one)]],
                   check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
