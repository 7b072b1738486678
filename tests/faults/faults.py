#!/usr/bin/python3
# Kills runs, fills their disks, lets their writes, syncs, renames and opens fail, and their ranks
# crash or hang; looks at what is left behind.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: faults.py errors|kills|writers|ends|disks SPALL MPIEXEC CASES WORK
                 [--disk SO] [--count 6] [--ranks 2] [--seed 1]

errors   One call of one rank fails (failing_disk.c), alone or with all that follow. All ranks must
         be gone within 10 s, with one message that tells the reason where rank 0 knows it. Errors
         that no call met do not count.
kills    SIGKILL to all ranks at a random time after the first restart file, in three methods in
         turn.
writers  SIGKILL to the rank that writes, at a random byte of a restart file.
ends     In turn one rank is killed, crashes, gets no more memory, or hangs in a call or is stopped
         until the launcher gets SIGTERM. All ranks must be gone 10 s later, where memory ends after
         it was said; one message says why, the launcher's where the rank cannot.
disks    A tmpfs for each run, of sizes from nearly nothing to all that a run needs: the message
         says that no space is left. Mounting takes root.

After each a run goes on from the newest restart file, where there is one, to the numbers of the run
that was left alone: results, series, snapshots and states, bit by bit, but for the seconds that it
took.
"""
import argparse
import collections
import csv
import errno
import itertools
import os
import random
import select
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py

SCENES = {
    "nonsmooth": ["hello/case.toml", "groups.cloud.packing.count=40",
                  "groups.cloud.volume.radius=6 m", "phases.aggregation.duration=40 min"],
    "penalty": ["column/case.toml", "groups.column.volume.radius=8 mm",
                "groups.column.volume.height=8 mm", 'groups.column.volume.center=[0, 0, "6 mm"]',
                "phases.collapse.duration=0.1 s"],
    "potential": ["bumper/case.toml", 'groups.plate.volume.size=["3 mm", "3 mm", "0.5 mm"]'],
}
FAULTS = {"fsync": 5, "rename": 6, "open": 8}  # calls of a short run, of which one fails
REASONS = [errno.ENOSPC, errno.EDQUOT, errno.EIO]
# restart_every; the last leaves the files at the ends of phases
SAVES = ["1 ms", "10 ms", "50 ms", "1 h"]
ENDS = {  # what one line says, one of these
    "kill": ["exited on signal 9"],
    "crash": ["exited on signal 11"],
    # Its stack cannot grow either, and libraries do not look.
    "memory": ["memory", "exited on signal"],
    "hang": [],
    "stop": [],
}
MOST_SECONDS = 10  # from an error, or SIGTERM, until all ranks are gone


def numbers(folder):
    """What a run has computed, by names: not the seconds that it took, nor where it comes from."""
    parts = (folder / "results.toml").read_text().split("\n\n")
    found = {"results.toml " + part.split("\n")[0]: part for part in parts
             if not part.startswith(("[time]", "[communication]", "[provenance]"))}
    with open(folder / "series.csv", newline="") as file:
        for name, *column in zip(*csv.reader(file)):
            found["series.csv " + name] = column

    def note(name, thing):
        if isinstance(thing, h5py.Dataset) and not name.startswith(
                ("parameters", "scalars", "case", "version")):
            found[f"{path.relative_to(folder)} {name}"] = thing.shape, thing[()].tobytes()

    for path in sorted([*folder.glob("snapshots/*.h5"), *folder.glob("after_*.h5"),
                        folder / "series.h5", folder / "trajectory.h5"]):
        with h5py.File(path) as file:
            file.visititems(note)
    return {name: values for name, values in found.items() if "seconds_" not in name}


def differences(found, wanted):
    """Names of what differs, a few of them; empty: nothing does."""
    names = sorted(name for name in found.keys() | wanted.keys()
                   if found.get(name) != wanted.get(name))
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def changed_at(file):
    return file.stat().st_mtime


def newest_restart(folder):
    return max([*folder.glob("restart*.h5"), *folder.glob("after_*.h5")],
               key=changed_at, default=None)


def files_of(folder):
    return [file for file in folder.rglob("*") if file.is_file()]


class Runs:
    def __init__(self, given):
        self.given = given
        self.work = Path(given.work).resolve()
        self.out = self.work / "out"
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir(parents=True)
        self.seen, self.wrong = collections.Counter(), []
        self.whole, self.gone_after = {}, []
        self.ends = itertools.cycle(ENDS)

    def start(self, *words, **faults):
        """A program of all ranks, in a session of its own."""
        environment = {**os.environ, "OMPI_MCA_mpi_yield_when_idle": "1",
                       **{key: str(value) for key, value in faults.items()}}
        command = [self.given.mpiexec, "--oversubscribe", "-n", str(self.given.ranks),
                   self.given.spall]
        return subprocess.Popen([*command, *map(str, words)], cwd=self.work, env=environment,
                                text=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                start_new_session=True)

    def end(self, process, limit):
        """Exit code (None: it hung) and lines on standard error."""
        try:
            said = process.communicate(timeout=limit)[1]
            code = process.returncode
        except subprocess.TimeoutExpired:
            subprocess.run(["pkill", "-KILL", "-s", str(process.pid)], check=False)
            code, said = None, process.communicate()[1]
        return code, [line for line in said.splitlines() if line.strip()]

    def words(self, method, out):
        case, *changes = SCENES[method]
        sets = [word for change in changes for word in ("--set", change)]
        return ["run", Path(self.given.cases).resolve() / case, "--out", out, *sets]

    def run_whole(self, method):
        """Numbers and seconds of a run that is left alone."""
        if method not in self.whole:
            begin = time.time()
            code, said = self.end(self.start(*self.words(method, "whole-" + method)), 300)
            assert code == 0, said
            self.whole[method] = numbers(self.work / ("whole-" + method)), time.time() - begin
        return self.whole[method]

    def goes_on(self, method, label):
        wanted, seconds = self.run_whole(method)
        restart = newest_restart(self.out)
        if restart is None:
            self.seen["without a file yet"] += 1
            return
        code, said = self.end(self.start("resume", restart), 20 * seconds + 100)
        if code != 0:
            self.wrong.append(f"{label}: {restart.name} does not go on: {code} {said[:2]}")
        elif other := differences(numbers(self.out), wanted):
            self.wrong.append(f"{label}: {restart.name} goes on to another {other}")
        else:
            self.seen["gone on"] += 1

    def kill(self, draw, method):
        _, seconds = self.run_whole(method)
        shutil.rmtree(self.out, ignore_errors=True)
        process = self.start(*self.words(method, "out"), "--set",
                             f"output.restart_every={draw.choice(SAVES)}")
        while newest_restart(self.out) is None and process.poll() is None:
            time.sleep(0.002)
        wait = draw.uniform(0, seconds)
        time.sleep(wait)
        over = process.poll() is not None
        if not over:  # the ranks first: the launcher would end them gently
            subprocess.run(["pkill", "-KILL", "-s", str(process.pid), "-x", "spall"], check=False)
        self.end(process, 30)
        self.seen["over before" if over else "killed"] += 1
        if not over:
            self.goes_on(method, f"{method} killed {wait:.2f} s after its first file")

    def error(self, draw, method):
        self.run_whole(method)
        written = sum(file.stat().st_size
                      for file in (self.work / ("whole-" + method)).rglob("*.h5"))
        fault = draw.choice(["write", *FAULTS])  # rank 0 alone syncs and renames, and writes most
        rank = draw.randrange(self.given.ranks) if fault in ("write", "open") else 0
        at = draw.randint(1, FAULTS.get(fault, written if rank == 0 else written // 6))
        reason = errno.EMFILE if fault == "open" else draw.choice(REASONS)
        once = {"FAULT_ONCE": 1} if draw.random() < 0.5 else {}
        mark = self.work / "failed"
        mark.unlink(missing_ok=True)
        shutil.rmtree(self.out, ignore_errors=True)
        self.fail(method, f"{method}: {fault} {at} of rank {rank}{', once' if once else ''}, "
                  f"{os.strerror(reason)}",
                  os.strerror(reason) if rank == 0 else "", lambda: mark, draw.choice(SAVES),
                  FAULT=fault, FAULT_AT=at, FAULT_RANK=rank, FAULT_ERRNO=reason,
                  FAULT_FOLDER=self.out, **once, **self.faults(mark))

    def faults(self, mark):
        return {"LD_PRELOAD": self.given.disk, "FAULT_MARK": mark}

    def end_rank(self, method, does, rank, at, folder, save):
        """One rank is ended by failing_disk.c, or with SIGTERM to the launcher where it hangs."""
        mark = self.work / "failed"
        mark.unlink(missing_ok=True)
        shutil.rmtree(self.out, ignore_errors=True)
        label = (f"{method}: {does} of rank {rank} at byte {at} of {Path(folder).name}, "
                 f"saved each {save}")
        process = self.start(*self.words(method, "out"), "--set", f"output.restart_every={save}",
                             FAULT="write", FAULT_AT=at, FAULT_RANK=rank, FAULT_FOLDER=folder,
                             FAULT_DOES=does, **self.faults(mark))
        while process.poll() is None and not mark.exists():
            time.sleep(0.01)
        if does == "memory":  # what a rank has by then may serve it for long
            select.select([process.stderr], [], [],
                          10 * MOST_SECONDS + 20 * self.run_whole(method)[1])
        since = time.time()
        if does in ("hang", "stop") and process.poll() is None:
            time.sleep(0.5)  # it would not end by itself
            if process.poll() is not None:
                self.wrong.append(f"{label}: it did not hang: {process.communicate()[1]}")
            since = time.time()
            process.send_signal(signal.SIGTERM)
        code, said = self.end(process, 10 * MOST_SECONDS)
        if not mark.exists():
            self.seen["not met"] += 1
            return
        self.wait_until_gone(process)
        self.gone_after.append(time.time() - since)
        self.seen["hangs" if code is None else "ended"] += 1
        if code in (None, 0):
            self.wrong.append(f"{label}: hangs or is not noticed: {code} {said[:2]}")
        if self.gone_after[-1] > MOST_SECONDS:
            self.wrong.append(f"{label}: gone only after {self.gone_after[-1]:.1f} s")
        telling = [line for line in said if any(words in line for words in ENDS[does])]
        if ENDS[does] and len(telling) != 1:
            self.wrong.append(f"{label}: not one message with '{ENDS[does]}': {said}")
        self.goes_on(method, label)

    def writer(self, draw, method):
        """Of the first four restart files one is being written."""
        self.run_whole(method)
        size = next((self.work / ("whole-" + method)).glob("after_*.h5")).stat().st_size
        rank = draw.randrange(self.given.ranks)
        self.end_rank(method, "kill", rank, draw.randint(1, 4 * size if rank == 0 else size),
                      self.out / "restart.h5", "1 ms")

    def rank_end(self, draw, method):
        self.run_whole(method)
        written = sum(file.stat().st_size
                      for file in (self.work / ("whole-" + method)).rglob("*.h5"))
        rank = draw.randrange(self.given.ranks)
        self.end_rank(method, next(self.ends), rank,
                      draw.randint(1, written if rank == 0 else written // 6),
                      self.out, draw.choice(SAVES))

    @staticmethod
    def wait_until_gone(process):
        lives = ["pgrep", "-s", str(process.pid), "-r", "D,R,S,T"]
        deadline = time.time() + MOST_SECONDS
        while (time.time() < deadline
               and subprocess.run(lives, stdout=subprocess.DEVNULL, check=False).returncode == 0):
            time.sleep(0.05)

    def disk(self, draw, method):
        """The run goes on after the disk has grown."""
        self.run_whole(method)
        needs = sum(file.stat().st_size for file in files_of(self.work / ("whole-" + method)))
        page = 4096
        size = draw.randint(1, needs // page) * page
        self.out.mkdir(exist_ok=True)
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "spall-faults", self.out],
                       check=True)
        try:
            self.fail(method, f"{method}: a disk of {size} bytes", os.strerror(errno.ENOSPC),
                      lambda: max(files_of(self.out), key=changed_at), draw.choice(SAVES),
                      grown=True)
        finally:
            subprocess.run(["umount", self.out], check=True)

    def fail(self, method, label, reason, failed, save, grown=False, **faults):
        """A run that must end by itself and say the reason; the file `failed()` tells since
        when."""
        wanted, seconds = self.run_whole(method)
        process = self.start(*self.words(method, "out"), "--set", f"output.restart_every={save}",
                             **faults)
        code, said = self.end(process, 20 * seconds + 100)  # machines may have more to do
        self.wait_until_gone(process)
        now = time.time()
        if code == 0:
            self.seen["not met"] += 1
            if not grown and failed().exists():
                self.wrong.append(f"{label}: nobody noticed")
            if other := differences(numbers(self.out), wanted):
                self.wrong.append(f"{label}: nobody noticed, and there is another {other}")
            return
        if not failed().exists():
            self.wrong.append(f"{label}: ended before any call failed: {code} {said[:2]}")
            return
        self.seen["hangs" if code is None else "ended"] += 1
        if code is None:
            self.wrong.append(f"{label}: hangs: {said[:2]}")
        elif len(said) != 1 or not said[0].startswith("spall: "):
            self.wrong.append(f"{label}: not one message: {said[:3]}")
        elif reason not in said[0]:
            self.wrong.append(f"{label}: no reason: {said[0]}")
        self.gone_after.append(now - changed_at(failed()))
        if self.gone_after[-1] > MOST_SECONDS:
            self.wrong.append(f"{label}: gone only after {self.gone_after[-1]:.1f} s")
        if grown:
            subprocess.run(["mount", "-o", "remount,size=1g", self.out], check=True)
        self.goes_on(method, label)


def main():
    parser = argparse.ArgumentParser()
    for name in ("what", "spall", "mpiexec", "cases", "work"):
        parser.add_argument(name)
    parser.add_argument("--disk", help="failing_disk as a library")
    parser.add_argument("--count", type=int, default=6)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    runs, draw = Runs(given), random.Random(given.seed)
    one = {"kills": runs.kill, "errors": runs.error, "disks": runs.disk, "writers": runs.writer,
           "ends": runs.rank_end}[given.what]
    met = ["killed"] if given.what == "kills" else ["ended", "hangs"]
    for drawn, method in enumerate(itertools.cycle(SCENES)):
        if sum(runs.seen[what] for what in met) >= given.count or drawn > 10 * given.count:
            break
        one(draw, method)
    print(f"{given.what}, {given.ranks} ranks, seed {given.seed}: "
          + ", ".join(f"{count} {what}" for what, count in sorted(runs.seen.items()))
          + (f"; all ranks gone after {max(runs.gone_after):.1f} s at most" if runs.gone_after
             else ""))
    for line in runs.wrong:
        print("FAILED:", line)
    sys.exit(bool(runs.wrong))


if __name__ == "__main__":
    main()
