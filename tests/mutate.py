#!/usr/bin/env python3
# Changes the code at random, one place at a time, and says which tests notice.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: mutate.py [--count 100] [--seed 1] [--only REGEX] [--record FILE] [--again] [--statements]
                 [--tests REGEX] [--longest SECONDS] [--jobs 2]

Each change is one of four kinds: an operator (+ -, * /, += -=), a sign, a numeric constant (0 -> 1,
n -> n + 1, x -> 1.3 x) or a comparison (< <=, > >=, == !=, && ||). The kind is drawn first, then
the place, from src and include. With --statements whole lines are removed, too. Comments, texts,
preprocessor lines, template brackets and assertions at compile time are left alone.

The work is done in a copy of the tree below --work (build/mutants by default); the tree itself is
never changed. All changes are compiled into it at once, asleep: the environment variable
SPALL_MUTANT=k wakes the k-th where a program starts (tests/mutants.hpp). First each test on 1 or 2
ranks runs with all asleep, which says how long it takes and which changes it comes to. Then each
change is judged by the tests that come to it, until one fails, those of the changed room first;
--jobs changes at a time, each test in a folder of its own.

What does not compile in that form is built and judged by itself after the others, by all tests
whose program has become another one. That takes minutes each.

Outcomes: caught (with the test that failed, ran too long or did not build any more), survived (with
a word where no test comes to it), no_build (drawn again), same_code (the compiler makes the same
programs of it: drawn again) and argued (a survivor whose line in tests/mutants.md says why it
changes nothing that is promised). A record of JSON lines is kept, so that a run can be stopped and
gone on with: the same seed on the same code draws the same changes. --again runs the survivors of
the record once more, with the tests as they are now. A survivor costs all tests that come to it:
with --tests '_1$' --longest 15 a first turn is short, and --again without them judges its survivors
by all. --planted takes the changes from a file instead, as tests/planted.jsonl. --report prints the
table and runs nothing.

The copy is built without vectors and with -O1, which compiles sooner. --cmake says otherwise, as
--cmake=-DSPALL_SCALAR=OFF: then code that multiplies and adds in one instruction rounds otherwise
where a change sleeps.
"""
import argparse
import hashlib
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from mutants import (KINDS, code_only, draw, edits, find_places, read_planted, with_sleeping,
                     without_constexpr)

ROOT = Path(__file__).resolve().parent.parent
JUDGED = ("caught", "survived")

# Which tests know most about a room; the others follow, the quick ones first.
NEAREST = {
    "base": ["domain", "gravity", "ghosts"],
    "keys": ["units", "case"],
    "state": ["prescribed", "ledger", "step", "penalty", "bonds", "potential"],
    "domain": ["domain", "ghosts"],
    "pairs": ["clouds", "bonds", "step", "penalty", "potential"],
    "gravity": ["ledger", "gravity", "gravity_tree", "orbits"],
    "solver": ["thresholds", "solver", "solver_methods", "fclib"],
    "engine": ["prescribed", "books", "potential", "penalty"],
    "rigid": ["ledger", "thresholds", "step", "clouds", "hard_cases", "books"],
    "potential": ["thresholds", "constitutive", "potential", "embedding", "pair_laws", "bonds"],
    "penalty": ["penalty", "penalty_scenes", "books"],
    "solid": ["solid", "solid_parts", "solid_bodies", "pressed_metal", "brittle", "rock", "porous",
              "two_solids"],
    "scene": ["scene", "packing", "surface_mesh", "case"],
    "analysis": ["thresholds", "analysis", "debris", "shields"],
    "output": ["output", "fclib", "debris"],
    "run": ["ledger", "reactions", "books", "pipeline", "scenes", "debris"],
    "spall": ["domain", "gravity", "step"],
}


# Building and running ----------------------------------------------------------------------------

class Workshop:
    """A copy of the tree with a build of its own, in which changes sleep."""

    def __init__(self, args):
        self.work, self.tree = args.work, args.work / "tree"
        self.build = self.tree / "build" / "release"
        self.jobs, self.longest = args.jobs, args.longest
        files = sorted(p for room in ("src", "include") for p in (ROOT / room).rglob("*.[ch]pp"))
        self.texts = {str(path.relative_to(ROOT)): path.read_text() for path in files}
        self.asleep = {}  # number -> (kind, file, at, before, after)
        self.loose = {}  # file -> edits of constants that depend on those of a change
        self.seconds, self.reached, self.hashes = {}, {}, {}
        for left in self.work.glob("run_*"):  # of a run that was stopped
            shutil.rmtree(left)
        self.copy()
        subprocess.run(["cmake", "-S", self.tree, "-B", self.build, "-G", "Ninja",
                        "-DCMAKE_BUILD_TYPE=Release", "-DSPALL_BENCH=OFF", "-DSPALL_SCALAR=ON",
                        "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG", "-DCMAKE_CXX_FLAGS=-w",
                        *args.cmake], check=True, stdout=subprocess.DEVNULL)
        self.tests = self.known_tests(args.tests)
        self.targets = sorted({target for test in self.tests.values() for target in test[0]})

    def wanted(self, file, instead=None):
        """The text of a file in the copy: with what sleeps there, and one change that does not."""
        places = {k: (kind, *place) for k, (kind, of, *place) in self.asleep.items() if of == file}
        loose = self.loose.get(file, [])
        if not places and not loose and not instead:
            return self.texts[file]
        header = self.tree / "tests" / "mutants.hpp"
        return with_sleeping(self.texts[file], places, header, loose, instead)

    def copy(self):
        """Brings the copy to the state of the tree; files that are the same keep their time."""
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard", "-z"],
                                check=True, capture_output=True, text=True).stdout.split("\0")
        names = {name for name in listed if name and (ROOT / name).is_file()}
        for name in names:
            target, in_texts = self.tree / name, name in self.texts
            new = self.wanted(name).encode() if in_texts else (ROOT / name).read_bytes()
            if target.is_file() and target.read_bytes() == new:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(new)
            shutil.copymode(ROOT / name, target)
        for path in list(self.tree.rglob("*.[ch]pp")):
            name = path.relative_to(self.tree)
            if name.parts[0] != "build" and str(name) not in names:
                path.unlink()

    def known_tests(self, wanted):
        """Name -> (targets, command, environment), of the tests on 1 and 2 ranks."""
        shown = json.loads(subprocess.run(["ctest", "--show-only=json-v1"], cwd=self.build,
                                          check=True, capture_output=True, text=True).stdout)
        tests = {}
        for test in shown["tests"]:
            command, found = test.get("command", []), {p["name"]: p for p in test["properties"]}
            built = [re.sub(r"^lib|\.so$", "", Path(word).name) for word in command
                     if word.startswith(f"{self.build}/")]
            name = test["name"]
            if built and re.fullmatch(r"\w+_[12]", name) and re.search(wanted, name):
                lines = found["ENVIRONMENT"]["value"] if "ENVIRONMENT" in found else []
                tests[name] = built, command, dict(line.split("=", 1) for line in lines)
        return tests

    def ninja(self, *words):
        return subprocess.run(["nice", "ninja", f"-j{self.jobs}", *words], cwd=self.build,
                              capture_output=True, text=True)

    def put_to_sleep(self, places):
        """Builds the tests with these changes asleep, less those that do not compile so."""
        cache = self.work / "not_asleep.json"
        known = {tuple(p) for p in json.loads(cache.read_text())} if cache.is_file() else set()
        for k, (kind, file, *place) in places.items():
            text = self.texts[file]
            if (file, *place) not in known and edits(text, code_only(text), k, kind, *place):
                self.asleep[k] = (kind, file, *place)
        while True:
            print(f"builds with {len(self.asleep)} of {len(places)} changes asleep", flush=True)
            self.copy()
            built = self.ninja("-k0", *self.targets)
            if built.returncode == 0:
                break
            if self.loosen(built.stdout):
                continue
            wrong = self.to_blame(built.stdout)
            if not wrong:
                sys.exit(f"the code does not build:\n{built.stdout[-5000:]}")
            known |= {self.asleep.pop(k)[1:] for k in wrong}
            cache.write_text(json.dumps(sorted(known)))

    def errors(self, said):
        """(file, line, whether it is that of an error, what is said) of a compiler's messages."""
        named = re.compile(re.escape(f"{self.tree}/") + r"([\w/]+\.[ch]pp):(\d+)(.*error: )?(.*)")
        return [(m[1], int(m[2]), bool(m[3]), m[4]) for m in named.finditer(said)]

    def loosen(self, said):
        """Constants that need another one when they are compiled; whether there are more now."""
        more = False
        for file, line, error, message in self.errors(said):
            if error and "not usable in a constant expression" in message and file in self.texts:
                code = code_only(self.texts[file])
                end = len("".join(code.splitlines(True)[:line]))
                for edit in without_constexpr(code, code.rfind(";", 0, end)):
                    more |= edit not in self.loose.setdefault(file, [])
                    self.loose[file] = sorted({*self.loose[file], edit})
        return more

    def to_blame(self, said):
        """Numbers of the changes in lines with errors; else in lines named; else in files named."""
        in_errors, in_lines, in_files = set(), set(), set()
        found = self.errors(said)
        for k, (kind, file, *place) in self.asleep.items():
            text = self.texts[file]
            made = edits(text, code_only(text), k, kind, *place)
            first, last = (text.count("\n", 0, f(f(e[:2]) for e in made)) + 1 for f in (min, max))
            for name, line, error, _ in found:
                if name == file:
                    in_files.add(k)
                    if first <= line <= last:
                        (in_errors if error else in_lines).add(k)
        return in_errors or in_lines or in_files

    def run(self, name, limit, **variables):
        """Whether the test passes within the limit; and how long it took."""
        _, command, environment = self.tests[name]
        folder = tempfile.mkdtemp(dir=self.work, prefix="run_")
        started = time.monotonic()
        # What changed may ask for all memory.
        with subprocess.Popen(["nice", "prlimit", f"--as={6 << 30}", *command], cwd=folder,
                              env=os.environ | environment | variables, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              start_new_session=True) as test:
            try:
                passed = test.wait(limit) == 0
            except subprocess.TimeoutExpired:
                passed = False
                os.killpg(test.pid, signal.SIGTERM)  # mpirun's: its ranks end with it
                try:
                    test.wait(20)
                except subprocess.TimeoutExpired:
                    os.killpg(test.pid, signal.SIGKILL)
        shutil.rmtree(folder, ignore_errors=True)
        return passed, time.monotonic() - started

    def measure(self):
        """Runs each test with all asleep: how long it takes, and which changes it comes to."""
        cache = self.work / "seconds.json"
        kept = json.loads(cache.read_text()) if cache.is_file() else {}

        def watch(name):
            with tempfile.NamedTemporaryFile(dir=self.work) as file:
                os.truncate(file.name, 4096)
                passed, kept[name] = self.run(name, 2 * self.longest,
                                              SPALL_MUTANTS_REACHED=file.name)
                reached = {k for k, said in enumerate(Path(file.name).read_bytes()) if said}
            print(f"asleep: {name} {'passes' if passed else 'FAILS or takes too long'}, "
                  f"{kept[name]:.1f} s, comes to {len(reached)} changes", flush=True)
            if passed and kept[name] < self.longest:
                self.seconds[name], self.reached[name] = kept[name], reached
                self.hashes[name] = self.hash(name)

        with ThreadPoolExecutor(self.jobs) as pool:
            # What took far too long before is not tried again.
            list(pool.map(watch, [n for n in self.tests if kept.get(n, 0) < 1.9 * self.longest]))
        cache.write_text(json.dumps(kept))

    def hash(self, name):
        """Of the programs that the test runs."""
        files = [self.build / folder / t for t in self.tests[name][0] for folder in ("", "tests")]
        return hashlib.sha256(b"".join(f.read_bytes() for f in files if f.is_file())).hexdigest()

    def order(self, file):
        """The tests' names, those nearest to the changed file first."""
        nearest = NEAREST.get(file.split("/")[1], [])

        def key(name):
            test = name.rsplit("_", 1)[0]
            place = nearest.index(test) if test in nearest else len(nearest)
            return (place, self.seconds[name], name)
        return sorted(self.seconds, key=key)

    def passes(self, name, **variables):
        # What hangs is noticed, too; a busy machine alone is not ten times as slow.
        return self.run(name, 20 + 10 * self.seconds[name], **variables)[0]

    def judge_asleep(self, k, file):
        names = [name for name in self.order(file) if k in self.reached[name]]
        for name in names:
            if not self.passes(name, SPALL_MUTANT=str(k)):
                return "caught", name
        return "survived", "" if names else "no test comes to it"

    def judge_built(self, file, at, before, after):
        """One change that is not asleep. The copy is as before afterwards."""
        path = self.tree / file
        path.write_text(self.wanted(file, (at, at + len(before), after)))
        try:
            if self.ninja("spall_core").returncode:
                return "no_build", ""
            changed = 0
            for name in self.order(file):
                if self.ninja(*self.tests[name][0]).returncode:
                    return ("caught", f"build of {name}") if changed else ("no_build", "")
                if self.hash(name) == self.hashes[name]:
                    continue
                changed += 1
                if not self.passes(name):
                    return "caught", name
            return ("survived" if changed else "same_code"), ""
        finally:
            path.write_text(self.wanted(file))

    def judge(self, places, until):
        """Yields number, outcome, test and seconds of each change, those asleep side by side."""
        def timed(k):
            began = time.monotonic()
            if began > until:
                return k, None, "", 0
            kind, file, *place = places[k]
            outcome, by = (self.judge_asleep(k, file) if k in self.asleep
                           else self.judge_built(file, *place))
            return k, outcome, by, time.monotonic() - began

        self.ninja(*self.targets)  # as they were before the last change that was built
        with ThreadPoolExecutor(self.jobs) as pool:
            turn = [pool.submit(timed, k) for k in places if k in self.asleep]
            yield from (future.result() for future in as_completed(turn))
        yield from (timed(k) for k in places if k not in self.asleep)


# Record and report -------------------------------------------------------------------------------

def load(record):
    """Line by line; what was said of a change last holds."""
    rows = {}
    if record.is_file():
        for line in record.read_text().splitlines():
            row = json.loads(line)
            rows[(row["file"], row["at"], row["before"], row["after"])] = row
    return rows


def argued():
    """The code lines that tests/mutants.md argues about: `file` and the changed line."""
    path = ROOT / "tests" / "mutants.md"
    text = path.read_text() if path.is_file() else ""
    return set(re.findall(r"^- `(src/[^`]+|include/[^`]+)`: `([^`]+)`", text, re.M))


def is_argued(row, known):
    return (row["file"], row["to"].strip()) in known


def report(rows):
    known = argued()
    for row in rows:
        if row["outcome"] == "survived" and is_argued(row, known):
            row["outcome"] = "argued"
    outcomes = ["caught", "survived", "argued", "no_build", "same_code"]
    print(f"\n| kind | {' | '.join(outcomes)} |\n|---|{'---|' * len(outcomes)}")
    for kind in [*KINDS, "planted", "all"]:
        of_kind = [r for r in rows if kind in (r["kind"], "all")]
        if of_kind:
            counts = [sum(r["outcome"] == o for r in of_kind) for o in outcomes]
            print(f"| {kind} | {' | '.join(map(str, counts))} |")
    caught = sum(r["outcome"] == "caught" for r in rows)
    judged = caught + sum(r["outcome"] in ("survived", "argued") for r in rows)
    if judged:
        print(f"\n{caught} of {judged} changes caught: {100 * caught / judged:.0f} %")
    for row in rows:
        if row["outcome"] in ("survived", "argued"):
            print(f"\n{row['outcome']}: {row['file']}:{row['line']} ({row['kind']})\n"
                  f"- {row['from'].strip()}\n+ {row['to'].strip()}")


def describe(texts, kind, place, outcome, by, seed, seconds):
    file, at, before, after = place
    text = texts[file]
    start, end = text.rfind("\n", 0, at) + 1, text.find("\n", at)
    changed = text[start:at] + after + text[at + len(before):end]
    return {"seed": seed, "kind": kind, "file": file, "line": text.count("\n", 0, at) + 1, "at": at,
            "before": before, "after": after, "from": text[start:end], "to": changed,
            "outcome": outcome, "by": by, "seconds": round(seconds, 1)}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100, help="changes to be judged")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="regular expression that the file's name must hold")
    parser.add_argument("--statements", action="store_true", help="remove lines, too")
    parser.add_argument("--again", action="store_true", help="judge the survivors once more")
    parser.add_argument("--planted", type=Path, help="changes of a file, as tests/planted.jsonl")
    parser.add_argument("--tests", default="", help="regular expression of the tests to run")
    parser.add_argument("--longest", type=float, default=60,
                        help="leave out tests that take more seconds with all asleep")
    parser.add_argument("--report", action="store_true", help="print the table of the record")
    parser.add_argument("--minutes", type=float, default=1e9, help="begin no change after so many")
    parser.add_argument("--jobs", type=int, default=2, help="compilers or tests at the same time")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "mutants")
    parser.add_argument("--record", type=Path, help="JSON lines; below --work by default")
    parser.add_argument("--cmake", action="append", default=[], help="argument for cmake")
    args = parser.parse_args()
    args.work = args.work.resolve()
    record = args.record or args.work / "record.jsonl"
    rows = load(record)
    if args.report:
        report(list(rows.values()))
        return
    print(f"seed {args.seed}, {args.count} changes, record {record}", flush=True)
    until = time.monotonic() + 60 * args.minutes
    args.work.mkdir(parents=True, exist_ok=True)
    shop = Workshop(args)
    if args.planted:
        todo = list(read_planted(args.planted, shop.texts))
        args.count = len(todo)
    elif args.again:
        todo = [(r["kind"], *key) for key, r in rows.items() if r["outcome"] == "survived"]
        args.count = len(todo)
    else:
        kinds = [k for k in KINDS if k != "statement" or args.statements]
        todo = draw(find_places(shop.texts, args.only, kinds), args.seed)
    # Some more, instead of those that change nothing or do not compile.
    numbered = enumerate(todo, 1)
    first = dict(itertools.islice(numbered, args.count + args.count // 4))
    shop.put_to_sleep(first)
    shop.measure()
    numbered = itertools.chain(first.items(), numbered)
    judged, mine = 0, []
    while judged < args.count and time.monotonic() < until:
        turn = dict(itertools.islice(numbered, args.count - judged))
        if not turn:
            break
        if not args.again:
            known = {k: rows[tuple(place)] for k, (_, *place) in turn.items()
                     if tuple(place) in rows}
            mine += known.values()
            judged += sum(row["outcome"] in JUDGED for row in known.values())
            turn = {k: turn[k] for k in turn if k not in known}
        for k, outcome, by, seconds in shop.judge(turn, until):
            if not outcome:
                continue
            kind, *place = turn[k]
            row = describe(shop.texts, kind, place, outcome, by, args.seed, seconds)
            with open(record, "a") as out:
                out.write(json.dumps(row) + "\n")
            print(f"{row['outcome']:9} {row['by']:18} {row['file']}:{row['line']}  "
                  f"{row['before']!r} -> {row['after']!r}  {row['seconds']} s", flush=True)
            judged += row["outcome"] in JUDGED
            mine.append(row)
    report(mine)


if __name__ == "__main__":
    main()
