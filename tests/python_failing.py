# A force that ends one rank alone, or never ends; SPDX-License-Identifier: BSD-3-Clause
"""usage: python_failing.py MPIEXEC

All ranks must be gone within 10 s, with one message that says why.
"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

MOST_SECONDS = 10  # from what the force does until all ranks are gone
ENDS = {  # what one line says
    "error": "ValueError: of one rank alone",
    "memory": "MemoryError",
    "kill": "exited on signal 9",
    "crash": "exited on signal 11",
    "endless": None,  # ended by SIGTERM to the launcher
}


def run(how, mark):
    import spall

    sim = spall.Simulation(materials={"rock": {"density": 1000}},
                           phases=[{"name": "only", "step": 0.01, "duration": 1}])
    for k in range(4):
        sim.add("rock", radius=0.1, position=(k, 0, 0))

    def force(bodies, forces):
        if spall.rank() == 0:
            return
        pathlib.Path(mark).touch()
        if how == "error":
            raise ValueError("of one rank alone")
        if how == "memory":
            bytearray(1 << 60)
        if how in ("kill", "crash"):
            os.kill(os.getpid(), signal.SIGKILL if how == "kill" else signal.SIGSEGV)
        while True:
            pass

    sim.add_force(force)
    sim.run_until(0.2)


def try_end(mpiexec, how, words):
    with tempfile.TemporaryDirectory() as folder:
        mark = pathlib.Path(folder) / "mark"
        process = subprocess.Popen([mpiexec, "--oversubscribe", "-n", "2", sys.executable, __file__,
                                    "--as", how, mark],
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
        while process.poll() is None and not mark.exists():
            time.sleep(0.01)
        since = time.time()
        if how == "endless":
            process.send_signal(signal.SIGTERM)
        said = process.communicate(timeout=60)[1]
        lives = ["pgrep", "-s", str(process.pid), "-r", "D,R,S,T"]
        while (subprocess.run(lives, stdout=subprocess.DEVNULL, check=False).returncode == 0
               and time.time() < since + 60):
            time.sleep(0.05)
        seconds = time.time() - since
    print(f"{how}: {process.returncode} after {seconds:.1f} s: {said}")
    assert process.returncode != 0, how
    assert seconds < MOST_SECONDS, how
    assert words is None or sum(words in line for line in said.splitlines()) == 1, how
    assert how not in ("error", "memory") or said.startswith("spall: rank 1: Traceback"), how
    assert said.count("spall: ") == (how in ("error", "memory")), how


if sys.argv[1] == "--as":
    run(*sys.argv[2:])
else:
    for how, words in ENDS.items():
        try_end(sys.argv[1], how, words)
