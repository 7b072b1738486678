"""Puts text into a README, between <!-- name --> and <!-- end of name -->.

SPDX-License-Identifier: BSD-3-Clause
"""
import datetime
import os
import pathlib
import subprocess


def origin(ranks):
    """What was measured, when and where."""
    commit = subprocess.run([pathlib.Path(__file__).with_name("commit.sh")], text=True,
                            capture_output=True).stdout.strip()
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo")
                if line.startswith("model name")), "")
    shared = f"{ranks} rank{'s' if ranks > 1 else ''} on {os.cpu_count()} shared cores ({cpu})"
    return f"commit {commit}, {datetime.date.today()}, {shared}"


def replace_section(path, name, text):
    whole = path.read_text()
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, rest = whole.split(begin)
    path.write_text(before + begin + "\n" + text + "\n" + end + rest.split(end)[1])
