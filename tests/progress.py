"""What a run shows while it goes on: one line that is written over on a terminal, lines elsewhere.

SPDX-License-Identifier: BSD-3-Clause
usage: progress.py SPALL MPIEXEC, in a folder to write in
"""
import fcntl
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

spall, mpiexec = sys.argv[1:]
COLUMNS = 60
CASE = """
[materials.rock]
density = 2000
[[groups]]
name = "ball"
material = "rock"
volume = {shape = "sphere", radius = 1}
velocity = ["1 m/s", 0, 0]
[[phases]]
name = "flight"
step = "1 ms"
duration = "1e9 s"
[output]
series_every = "1000 s"
"""


def shown(words, terminal, folder):
    """All that a run writes in its first seconds, until it is told to stop."""
    ours, theirs = pty.openpty() if terminal else os.pipe()
    if terminal:
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, COLUMNS, 0, 0))
    run = subprocess.Popen([*words, spall, "run", "flight.toml", "--out", folder, "--overwrite"],
                           stdout=theirs,
                           env={**os.environ, "TERM": "xterm"})
    os.close(theirs)
    parts = []

    def collect():
        try:
            while part := os.read(ours, 65536):
                parts.append(part)
        except OSError:  # how a terminal ends
            pass

    reader = threading.Thread(target=collect)
    reader.start()
    begin = time.time()
    while time.time() - begin < 30 and b"flight           step" not in b"".join(parts):
        time.sleep(0.1)
    run.send_signal(signal.SIGUSR1)
    assert run.wait(30) == 3, run.returncode
    reader.join()
    return b"".join(parts).decode().replace("\r\n", "\n")


work = Path("progress")
work.mkdir(exist_ok=True)
os.chdir(work)
Path("flight.toml").write_text(CASE)
# At once: what takes long is to wait for lines.
ways = [(words, terminal) for words in ([], [mpiexec, "-n", "1"]) for terminal in (True, False)]
with ThreadPoolExecutor(len(ways)) as pool:
    texts = list(pool.map(lambda k: shown(*ways[k], f"out_{k}"), range(len(ways))))
for (_, terminal), text in zip(ways, texts):
    if terminal:
        lines = re.findall(r"\r([^\r\n]+)\x1b\[K", text)
        assert lines and all(line.startswith("flight ") and len(line) < COLUMNS
                             for line in lines), text
        assert "\r\x1b[Kstopped by a signal" in text, text
    else:
        assert "\x1b" not in text and "\r" not in text, text
        assert re.search(r"^flight  .* steps/s .*$", text, re.M), text
print("all passed")
