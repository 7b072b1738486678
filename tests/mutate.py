#!/usr/bin/env python3
# Changes the code at random, one place at a time, and says which tests notice.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: mutate.py [--count 100] [--seed 1] [--only REGEX] [--record FILE] [--again] [--statements]
                 [--tests REGEX] [--longest SECONDS] [--share K/N]

Each change is one of four kinds: an operator (+ -, * /, += -=), a sign, a numeric constant (0 -> 1,
n -> n + 1, x -> 1.3 x) or a comparison (< <=, > >=, == !=, && ||). The kind is drawn first, then
the place, from src and include. With --statements whole lines are removed, too. Comments, texts,
preprocessor lines, template brackets and assertions at compile time are left alone.

The work is done in a copy of the tree below --work (build/mutants by default); the tree itself is
never changed. For each change ninja builds what depends on it. Tests whose program has become
another one run on 1 and 2 ranks until one fails, those of the changed room first.

Outcomes: caught (with the test that failed, ran too long or did not build any more), survived,
no_build (drawn again), same_code (the compiler makes the same programs of it: drawn again) and
argued (a survivor whose line in tests/mutants.md says why it changes nothing that is promised).
A record of JSON lines is kept, so that a run can be stopped and gone on with: the same seed on the
same code draws the same changes. --again runs the survivors of the record once more, with the tests
as they are now. A survivor costs all tests: with --tests '_1$' --longest 15 a first turn is short,
and --again without them judges its survivors by all. --planted takes the changes from a file
instead, as tests/planted.jsonl. --report prints the table and runs nothing.
Several shops draw together by --share, each with a --work and a --record of its own: 1/2 and 2/2
take turns.
"""
import argparse
import hashlib
import itertools
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

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
    "solid": ["solid", "pressed_metal", "brittle", "rock", "porous", "two_solids"],
    "scene": ["scene", "packing", "surface_mesh", "case"],
    "analysis": ["thresholds", "analysis", "debris", "shields"],
    "output": ["output", "fclib", "debris"],
    "run": ["ledger", "reactions", "books", "pipeline", "scenes", "debris"],
    "spall": ["domain", "gravity", "step"],
}
OF_PROGRAM = {"program", "faults_errors", "faults_kills"}  # tests of `spall` itself


# Drawing -----------------------------------------------------------------------------------------

def code_only(text):
    """The text with everything that is not code replaced by blanks, newlines kept."""
    pattern = re.compile(
        r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\''
        r"|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*|\bstatic_assert\((?:[^;]*);|\btemplate <[^\n]*",
        re.S | re.M)
    return pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def other_number(text):
    """0 -> 1, n -> n + 1, x -> 1.3 x."""
    if re.fullmatch(r"\d+", text):
        return str(int(text) + 1)
    return repr(float(text) * 1.3) if float(text) else "1.0"


OPERATORS = {"+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
COMPARISONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||",
               "||": "&&"}
KINDS = {
    # Between blanks: template brackets, pointers and references stand at their type.
    "operator": (re.compile(r"(?<=\s)([-+*/]=?)(?=\s)"), OPERATORS.get),
    "sign": (re.compile(r"(?:(?<=[(\[{=,?:] )|(?<=[(\[{])|(?<=return ))(-)(?=[\w(])"),
             lambda _: ""),
    "constant": (re.compile(r"(?<![\w.<])((?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)(?![\w.'>])"),
                 other_number),
    "comparison": (re.compile(r"(?<=\s)(<=?|>=?|==|!=|&&|\|\|)(?=\s)"), COMPARISONS.get),
    # An assignment or a call that fills a line and follows a whole statement.
    "statement": (re.compile(r"(?<=[;{}]\n)[ \t]+([a-z_][\w.\[\]:]*"
                             r"(?: [-+*/]?= [^;\n]*|\([^;\n]*\));)(?=\s*\n)"), lambda _: ""),
}


def find_places(tree, only, kinds):
    """All places: kind -> list of (file, offset, before, after), in the order of the files."""
    places = {kind: [] for kind in kinds}
    files = sorted(p for folder in ("src", "include") for p in (tree / folder).rglob("*.[ch]pp"))
    for path in files:
        name = str(path.relative_to(tree))
        if only and not re.search(only, name):
            continue
        text = path.read_text()
        code = code_only(text)
        for kind in kinds:
            pattern, change = KINDS[kind]
            for found in pattern.finditer(code):
                before = text[found.start(1):found.end(1)]
                places[kind].append((name, found.start(1), before, change(before)))
    return places


def draw(places, seed):
    """Endless until nothing is left: kinds alike, places of a kind alike, none twice."""
    rng = random.Random(seed)
    left = {kind: list(found) for kind, found in places.items() if found}
    while left:
        kind = rng.choice(sorted(left))
        yield kind, *left[kind].pop(rng.randrange(len(left[kind])))
        if not left[kind]:
            del left[kind]


def read_planted(path, tree):
    """Changes chosen by hand: JSON lines of a file, a text that it holds once, and another."""
    for line in path.read_text().splitlines():
        row = json.loads(line)
        text = (tree / row["file"]).read_text()
        if text.count(row["from"]) != 1:
            sys.exit(f"{path}: {row['file']} does not hold once: {row['from']}")
        yield "planted", row["file"], text.index(row["from"]), row["from"], row["to"]


# Building and running ----------------------------------------------------------------------------

class Workshop:
    """A copy of the tree with a build of its own."""

    def __init__(self, work, jobs, cmake, longest):
        self.tree, self.jobs, self.longest = work / "tree", jobs, longest
        self.build = self.tree / "build" / "release"
        self.copy()
        self.configure(cmake)
        self.tests = self.known_tests()
        self.hashes, self.seconds = {}, {}

    def copy(self):
        """Brings the copy to the state of the tree; files that are the same keep their time."""
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard", "-z"],
                                check=True, capture_output=True, text=True).stdout.split("\0")
        wanted = {name for name in listed if name and (ROOT / name).is_file()}
        for name in wanted:
            target = self.tree / name
            if target.is_file() and target.read_bytes() == (ROOT / name).read_bytes():
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, target)
            shutil.copymode(ROOT / name, target)
        for path in list(self.tree.rglob("*.[ch]pp")):
            name = path.relative_to(self.tree)
            if name.parts[0] != "build" and str(name) not in wanted:
                path.unlink()

    def configure(self, cmake):
        subprocess.run(["cmake", "-S", self.tree, "-B", self.build, "-G", "Ninja",
                        "-DCMAKE_BUILD_TYPE=Release", "-DSPALL_BENCH=OFF", *cmake],
                       check=True, stdout=subprocess.DEVNULL)

    def known_tests(self):
        """Name -> program, of all tests on 1 and 2 ranks."""
        shown = json.loads(subprocess.run(["ctest", "--show-only=json-v1"], cwd=self.build,
                                          check=True, capture_output=True, text=True).stdout)
        tests = {}
        for test in shown["tests"]:
            if found := re.fullmatch(r"(\w+)_[12]", test["name"]):
                tests[test["name"]] = "spall" if found[1] in OF_PROGRAM else f"test_{found[1]}"
        return tests

    def ninja(self, *targets):
        return subprocess.run(["nice", "ninja", f"-j{self.jobs}", *targets], cwd=self.build,
                              capture_output=True, text=True).returncode == 0

    def program(self, target):
        return self.build / ("spall" if target == "spall" else f"tests/{target}")

    def hash(self, target):
        return hashlib.sha256(self.program(target).read_bytes()).hexdigest()

    def run(self, name, limit):
        """Whether the test passes within the limit; and how long it took."""
        started = time.monotonic()
        # By a time limit of its own: ctest's gives way to that of a test.
        with subprocess.Popen(["nice", "ctest", "-R", f"^{name}$"], cwd=self.build,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              start_new_session=True) as test:
            try:
                passed = test.wait(limit) == 0
            except subprocess.TimeoutExpired:
                os.killpg(test.pid, signal.SIGTERM)  # ctest's and mpirun's: its ranks end with it
                passed = False
        return passed, time.monotonic() - started

    def measure(self, cache):
        """Builds everything unchanged, runs every test, keeps times and programs."""
        if not self.ninja(*sorted(set(self.tests.values()))):
            sys.exit("the unchanged code does not build")
        self.hashes = {target: self.hash(target) for target in self.tests.values()}
        kept = {"hashes": {}, "seconds": {}, "longest": self.longest}
        if cache.is_file():
            kept = json.loads(cache.read_text())
        for name, target in sorted(self.tests.items()):
            if kept["hashes"].get(target) == self.hashes[target]:
                if name in kept["seconds"]:
                    self.seconds[name] = kept["seconds"][name]
                if name in kept["seconds"] or self.longest <= kept["longest"]:
                    continue
            # A busy machine is slower.
            passed, self.seconds[name] = self.run(name, 4 * self.longest)
            print(f"unchanged: {name} {'passes' if passed else 'FAILS or takes too long'}, "
                  f"{self.seconds[name]:.1f} s", flush=True)
            if not passed:  # it can say nothing about a change
                del self.seconds[name]
        cache.write_text(json.dumps({"hashes": kept["hashes"] | self.hashes,
                                     "seconds": kept["seconds"] | self.seconds,
                                     "longest": max(self.longest, kept["longest"])}))

    def order(self, file):
        """The tests' names, those nearest to the changed file first."""
        nearest = NEAREST.get(file.split("/")[1], [])

        def key(name):
            test = name.rsplit("_", 1)[0]
            place = nearest.index(test) if test in nearest else len(nearest)
            return (place, self.seconds[name], name)
        return sorted((n for n in self.seconds if self.seconds[n] < self.longest), key=key)

    def judge(self, place):
        """Outcome and the test that noticed, of one change. The copy is as before afterwards."""
        file, at, before, after = place
        path = self.tree / file
        whole = path.read_text()
        assert whole[at:at + len(before)] == before
        path.write_text(whole[:at] + after + whole[at + len(before):])
        try:
            if not self.ninja("spall_core"):
                return "no_build", ""
            changed = 0
            for name in self.order(file):
                target = self.tests[name]
                if not self.ninja(target):
                    return ("no_build", "") if changed == 0 else ("caught", f"build of {target}")
                if self.hash(target) == self.hashes[target]:
                    continue
                changed += 1
                # What hangs is noticed, too; a busy machine alone is not twenty times as slow.
                if not self.run(name, 60 + 20 * self.seconds[name])[0]:
                    return "caught", name
            return ("survived" if changed else "same_code"), ""
        finally:
            path.write_text(whole)


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


def describe(tree, kind, place, outcome, by, seed, seconds):
    file, at, before, after = place
    text = (tree / file).read_text()
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
                        help="leave out tests that take more seconds on the unchanged code")
    parser.add_argument("--share", default="1/1", help="which of the draws, as 1/2")
    parser.add_argument("--report", action="store_true", help="print the table of the record")
    parser.add_argument("--minutes", type=float, default=1e9, help="begin no change after so many")
    parser.add_argument("--jobs", type=int, default=2, help="of ninja")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "mutants")
    parser.add_argument("--record", type=Path, help="JSON lines; below --work by default")
    parser.add_argument("--cmake", action="append", default=[], help="argument for cmake")
    args = parser.parse_args()
    record = args.record or args.work / "record.jsonl"
    rows = load(record)
    if args.report:
        report(list(rows.values()))
        return
    print(f"seed {args.seed}, {args.count} changes, record {record}", flush=True)
    args.work.mkdir(parents=True, exist_ok=True)
    workshop = Workshop(args.work, args.jobs, args.cmake, args.longest)
    workshop.tests = {n: t for n, t in workshop.tests.items() if re.search(args.tests, n)}
    workshop.measure(args.work / "unchanged.json")
    kinds = [k for k in KINDS if k != "statement" or args.statements]
    if args.planted:
        todo = list(read_planted(args.planted, workshop.tree))
        args.count = len(todo)
    elif args.again:
        todo = [(r["kind"], *key) for key, r in rows.items() if r["outcome"] == "survived"]
        args.count = len(todo)
    else:
        first, shops = map(int, args.share.split("/"))
        todo = itertools.islice(draw(find_places(workshop.tree, args.only, kinds), args.seed),
                                first - 1, None, shops)
    judged, mine, started = 0, [], time.monotonic()
    for kind, *place in todo:
        if judged >= args.count or time.monotonic() - started > 60 * args.minutes:
            break
        row = rows.get(tuple(place))
        if row is None or args.again:
            began = time.monotonic()
            outcome, by = workshop.judge(place)
            row = describe(workshop.tree, kind, place, outcome, by, args.seed,
                           time.monotonic() - began)
            with open(record, "a") as out:
                out.write(json.dumps(row) + "\n")
            print(f"{row['outcome']:9} {row['by']:18} {row['file']}:{row['line']}  "
                  f"{row['before']!r} -> {row['after']!r}  {row['seconds']} s", flush=True)
        judged += row["outcome"] in ("caught", "survived")
        mine.append(row)
    report(mine)


if __name__ == "__main__":
    main()
