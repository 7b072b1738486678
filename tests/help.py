"""The man page and the completions of shells have all subcommands and options that the program
tells.

SPDX-License-Identifier: BSD-3-Clause
usage: help.py SPALL FOLDER    of the files that packaging/write_help.py wrote
"""
import re
import shutil
import subprocess
import sys
from pathlib import Path

spall, folder = sys.argv[1], Path(sys.argv[2])


def output(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def told_options(text):
    """All that begin a line of a help."""
    return set(re.findall(r"^  (?:-\w, ?)?(--[\w-]+)", text, re.M))


def completed(*words):
    """What bash proposes for the last of the words."""
    listed = " ".join(f"'{word}'" for word in ("spall", *words))
    return output("bash", "-c",
                  f"source {folder}/spall.bash; COMP_WORDS=({listed}); COMP_CWORD={len(words)}; "
                  f"_spall; "
                  "echo ${COMPREPLY[@]}").split()


page = (folder / "spall.1").read_text().replace("\\-", "-")
whole = output(spall, "--help")
commands = re.findall(r"^  (\w+)  ", whole.partition("Subcommands:\n")[2], re.M)
assert len(commands) >= 8 and {"run", "sweep", "keys"} <= set(commands), commands
assert set(completed("")) == {*commands, *told_options(whole)}, completed("")
for command in commands:
    options = told_options(output(spall, command, "--help"))
    assert set(completed(command, "-")) == options, (command, options, completed(command, "-"))
    part = re.search(rf'^\.SS "spall {command}\b.*\n((?:(?!\.S[SH]).*\n)*)', page, re.M)[1]
    missing = {option for option in options - {"--help"} if f".B {option}" not in part}
    assert not missing, (command, missing)
assert completed("run", "--ov") == ["--overwrite"], completed("run", "--ov")
assert completed("solve", "--method", "a") == ["accelerated",
                                               "apgd"], completed("solve", "--method", "a")
assert completed("run", "") == [], "files are completed by bash itself"
if shutil.which("man"):
    warnings = subprocess.run(["man", "--warnings", "-l", folder / "spall.1"], capture_output=True,
                              text=True).stderr
    assert not warnings, warnings
if shutil.which("zsh"):
    output("zsh", "-n", folder / "_spall")
print(f"{len(commands)} subcommands are in the page and in the completions")
