# The critical diameter or speed of a shield: runs between one that its wall holds and one that it
# does not.
# SPDX-License-Identifier: BSD-3-Clause
"""Finds where a wall begins to fail, by runs of a case with one key varied between two ends.

  spall limit shield.toml --vary groups.ball.volume.diameter=2..8mm --wall rear --jobs 4
  spall limit shield.toml --vary 'groups.ball.velocity=[0, 0, "-2 km/s"]..[0, 0, "-8 km/s"]'

The wall is one of [[shields]]. It has failed where its verdict is "detached spall" or "perforated".
After the two ends each round runs --jobs values that part the bracket evenly; one at a time, that
is bisection.
Each run has a folder of its own below --out. What is done stays, also of other ranges; what was
stopped goes on: say the same again. table.csv and table.json hold all values with their verdicts,
limit.json holds the bracket.
Exit codes: 0: found; 3: stopped by a signal, the same again goes on; 4: both ends have the same
verdict; others: an error.
"""
import argparse
import csv
import json
import math
import os
import re
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from sweep import (DONE, NUMBER, STOPPED, Run, by_names, claim, files_of, is_within, json_of,
                   names_of, unit_of)

NO_LIMIT = 4  # exit code
NOT_FINAL = 0.01  # of the energy that flies at the wall, beyond which a verdict may change
DOUBTED = 0.05  # of what was dissipated, beyond which a run tells not to believe it
COLUMNS = ("verdict", "margin", "thinnest", "hole", "spall_mass", "still_coming",
           "opening_at_edge", "energy_unexplained")


def leave(message, code=2):
    print(f"spall limit: {message}", file=sys.stderr)
    sys.exit(code)


class Range:
    """A key between two values that are alike but for numbers: a part 0 to 1 of the way gives a
    text, and back."""

    def __init__(self, text):
        self.key, equals, values = text.partition("=")
        low, dots, high = (part.strip() for part in values.partition(".."))
        if not equals or not dots or not low or not high:
            leave(f"--vary {text}: KEY=LOW..HIGH is wanted")
        if re.fullmatch(NUMBER, low):
            low += unit_of(high)
        self.ends = low, high
        words, others = (re.split(f"({NUMBER})", end) for end in self.ends)
        if [word.strip() for word in words[::2]] != [word.strip() for word in others[::2]]:
            leave(f"--vary {text}: both ends must be alike but for their numbers")
        self.words = words
        self.varied = [k for k in range(1, len(words), 2) if float(words[k]) != float(others[k])]
        for k in self.varied:
            if re.search(r"\w$", words[k - 1]) or words[k + 1].startswith("_"):
                leave(f"--vary {text}: write numbers in digits without _, decimal, apart from "
                      "letters before them")
        self.low = [float(words[k]) for k in self.varied]
        self.high = [float(others[k]) for k in self.varied]
        if not self.varied:
            leave(f"--vary {text}: both ends are the same")
        self.whole = False  # whether numbers between the ends are to be whole ones
        self.may_be_whole = all(end.is_integer() for end in (*self.low, *self.high))

    def value(self, part):
        if part in (0, 1):
            return self.ends[part]
        numbers = [low + part * (high - low) for low, high in zip(self.low, self.high)]
        return self.text(f"{number:.0f}" if self.whole else f"{number:.6g}" for number in numbers)

    def text(self, numbers):
        words = list(self.words)
        for k, number in zip(self.varied, numbers):
            words[k] = number
        return "".join(words)

    def between_whole(self):
        """A value within, of no whole number, where the ends are whole."""
        return self.text(str(low + math.copysign(0.5, high - low))
                         for low, high in zip(self.low, self.high))

    def numbers(self, text):
        words = re.split(f"({NUMBER})", text)
        return [float(words[k]) for k in self.varied] if len(words) == len(self.words) else None

    def part(self, text):
        """None of a value that is not of this range."""
        if text in self.ends:
            return self.ends.index(text)
        numbers = self.numbers(text)
        return (numbers[0] - self.low[0]) / (self.high[0] - self.low[0]) if numbers else None

    def width(self, a, b):
        """Of the bracket between two texts, of its middle."""
        pairs = list(zip(self.numbers(a), self.numbers(b)))
        return max(abs(x - y) / max(abs(x + y) / 2, 1e-300) for x, y in pairs)


class Search:
    """What is known so far: part of the way -> what the run there says of the wall."""

    def __init__(self, out, options, span, fixed, wall):
        self.out, self.options, self.span, self.fixed, self.wall = out, options, span, fixed, wall
        self.known, self.states = {}, {}

    def run_of(self, part):
        return self.run_at(self.span.value(part))

    def run_at(self, value):
        return Run(self.out, {**self.fixed, self.span.key: value}, names_of([self.span.key]))

    def verdict(self, run):
        """The section of the wall, of a run that is done; else None."""
        path = run.folder / "results.toml"
        if not path.is_file():
            return None
        results = tomllib.loads(path.read_text())
        found = [rows for rows in results.values()
                 if rows.get("wall") == self.wall and "verdict" in rows]
        if not found:
            leave(f"{path} has no verdict on the wall \"{self.wall}\"")
        lost = results["conservation"]["energy_unexplained"]
        return {**found[0], "energy_unexplained": lost,
                "lattices": results.get("lattices", {}).get("warning", "")}

    def recall(self):
        """What earlier calls found, whatever their range was."""
        path = self.out / "table.json"
        for row in json.loads(path.read_text()) if path.is_file() else []:
            part = self.span.part(row["value"])
            if part is not None and 0 <= part <= 1 and self.span.value(part) == row["value"]:
                if found := self.verdict(self.run_of(part)):
                    self.known[part], self.states[part] = found, "done"

    def carry_out(self, part):
        run, options = self.run_of(part), self.options
        command = run.command(options.spall, options.case, options.ranks)
        code = DONE
        if command:
            with open(self.out / f"{run.name}.log", "w") as log:
                code = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT).returncode
        self.states[part] = "done" if code == DONE else "stopped" if code == STOPPED else "failed"
        found = self.verdict(run) if code == DONE else None
        if found is None:
            print(f"{self.span.value(part)}: {self.states[part]}, see {self.out / run.name}.log",
                  flush=True)
            return
        self.known[part] = found
        print("; ".join([f"{self.span.value(part)}: {found['verdict']}, margin "
                         f"{found['margin']:.3g}", *self.doubts(part)]), flush=True)

    def learn(self, parts):
        known = {self.span.value(part) for part in self.known}
        wanted = {}
        for part in parts:
            if (value := self.span.value(part)) not in known:
                wanted.setdefault(value, part)
        wanted = list(wanted.values())
        with ThreadPoolExecutor(self.options.jobs) as pool:
            list(pool.map(self.carry_out, wanted))
        self.write_table()
        states = [self.states[part] for part in wanted]
        if "failed" in states:
            leave("a run has failed; nothing can be said beyond it", 1)
        if "stopped" in states:
            leave("stopped; say the same again to go on", STOPPED)

    def write_table(self):
        rows = []
        for part in sorted(self.states):
            found = self.known.get(part, {})
            rows.append({"value": self.span.value(part), "state": self.states[part],
                         "wall": self.wall, **{key: found.get(key, "") for key in COLUMNS}})
        others = {row["value"] for row in rows}
        path = self.out / "table.json"
        rows += [row for row in (json.loads(path.read_text()) if path.is_file() else [])
                 if row["value"] not in others and row.get("wall") == self.wall]
        with open(self.out / "table.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, ["value", "state", "wall", *COLUMNS])
            writer.writeheader()
            writer.writerows(rows)
        path.write_text(json_of(rows))

    def holds(self, part):
        return self.known[part]["verdict"] == "held"

    def final(self, part):
        """What has failed stays so; what has held may yet fail by what is still coming."""
        return not self.holds(part) or self.known[part]["still_coming"] <= NOT_FINAL

    def doubts(self, part):
        """What the run itself says against its verdict."""
        found, doubts = self.known[part], []
        if not self.final(part):
            doubts.append(f"not final: {100 * found['still_coming']:.2g} % of the energy that flies"
                          " at it has not met it")
        if found.get("still_failing", False):
            doubts.append("still failing: its margin fell until the end")
        if found["opening_at_edge"]:
            doubts.append("opened as far as its edge: the wall may be too small")
        met, passed = (found.get(f"largest_{way}", 0) for way in ("met", "passed"))  # 0: older runs
        if self.holds(part) and passed > met:
            doubts.append(f"too narrow: a piece of {passed:.3g} J flew past what is judged, which "
                          f"no piece of more than {met:.3g} J has met")
        if found.get("coarse", False):
            doubts.append("coarse: fewer than seven of its bodies lie across the largest piece "
                          f"that met it, of {found['largest_met_diameter']:.2g} m")
        if not abs(found["energy_unexplained"]) <= DOUBTED:
            doubts.append(f"not to be believed: {found['energy_unexplained']:.2g} of what was "
                          "dissipated is explained by no entry")
        if found["lattices"]:
            doubts.append(found["lattices"])
        return doubts

    def changes(self):
        """Neighbours of which one has held and one has not, from the low end on."""
        parts = sorted(self.known)
        return [(a, b) for a, b in zip(parts, parts[1:]) if self.holds(a) != self.holds(b)]

    def told(self, part):
        doubts = "".join(f" ({doubt})" for doubt in self.doubts(part))
        return f"{self.known[part]['verdict']} at {self.span.value(part)}{doubts}"


def between(a, b, count):
    return [a + (b - a) * (k + 1) / (count + 1) for k in range(count)]


def share(text):
    """"5%" or "0.05"; 5 alone is hardly 500 %."""
    value = float(text[:-1]) / 100 if text.endswith("%") else float(text)
    if not 0 < value < (math.inf if text.endswith("%") else 1):
        raise ValueError
    return value


def main():
    parser = argparse.ArgumentParser(prog="spall limit", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", help="case file (TOML)")
    parser.add_argument("--vary", required=True, metavar="KEY=LOW..HIGH",
                        help="the key that is varied, and its ends")
    parser.add_argument("--wall",
                        help="whose verdict decides; may be left out where [[shields]] has one")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="change a key; may be given several times")
    parser.add_argument("--within", type=share, default=0.05, metavar="SHARE",
                        help="end where the bracket is so narrow, of its middle; default: 5%%")
    parser.add_argument("--out", type=Path, help="folder of all runs; default: out/<case>-limit")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time; default: 1")
    parser.add_argument("--ranks", type=int, default=1, help="of each run; default: 1")
    parser.add_argument("--overwrite", action="store_true",
                        help="forget what --out holds of another search")
    options = parser.parse_args()
    if options.jobs < 1 or options.ranks < 1:
        leave("--jobs and --ranks are 1 at least")
    options.spall = os.environ.get("SPALL_PROGRAM", "spall")
    case = Path(options.case)
    out = options.out or Path(
        "out") / f"{case.parent.name if case.stem == 'case' else case.stem}-limit"
    span, fixed = Range(options.vary), {}
    varied = by_names(span.key, case)
    spelled = {varied}
    for text in options.set:
        key, equals, value = text.partition("=")
        named = by_names(key, case)
        if not equals or named in spelled:
            leave(f"--set {text}: {'KEY=VALUE is wanted' if not equals else 'told twice'}")
        if is_within(varied, named):
            leave(f"--set {text}: it would change {span.key}, which is varied")
        fixed[key] = value
        spelled.add(named)

    # What one end refuses would end the search after hours: nothing is begun then.
    search = Search(out, options, span, fixed, options.wall)
    def check(value):
        words = [options.spall, "check", options.case, *search.run_at(value).options()]
        return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    span.whole = span.may_be_whole and "is not whole" in check(span.between_whole()).stderr
    for value in (span.value(0), span.value(1), span.value(0.5)):
        checked = check(value)
        print(checked.stderr, end="", file=sys.stderr)
        if checked.returncode != 0:
            leave(f"{span.key}={value} is refused", checked.returncode)
    walls = re.findall(r"judged in the end: (.+), \S+ spacings thick", checked.stdout)
    named = ", ".join(f"\"{wall}\"" for wall in walls)
    if options.wall is None and len(walls) != 1:
        leave(
            f"--wall is wanted: {case} judges "
            f"{named or 'no wall; [[shields]] names those that it should'}")
    search.wall = options.wall or walls[0]
    if search.wall not in walls:
        leave(
            f"--wall {search.wall}: {case} judges "
            f"{named or 'no wall; [[shields]] names those that it should'}")

    claim(out, case, {"vary": span.key, **fixed}, options.overwrite, "spall limit",
          files=files_of(case, fixed.items()))
    (out / "limit.json").unlink(missing_ok=True)
    search.recall()
    search.learn([0, 1, *between(0, 1, options.jobs - 2)])
    if search.holds(0) == search.holds(1):
        leave(
            f"{search.told(0)} and {search.told(1)}: the limit is not between them, or there are "
            f"several", NO_LIMIT)
    while True:
        low, high = search.changes()[0]
        texts = span.value(low), span.value(high)
        parts = [part for part in between(low, high, options.jobs) if span.value(part) not in texts]
        if span.width(*texts) <= options.within or not parts:
            break
        search.learn(parts)
    if len(search.changes()) > 1:
        found = "; ".join(f"{search.told(a)}, {search.told(b)}" for a, b in search.changes())
        print(f"the verdict changes more than once: {found}; the first change is told")
    print(f"limit: {search.told(low)}, {search.told(high)}")
    whole = {"key": span.key, "wall": search.wall, "low": texts[0], "high": texts[1],
             "verdict_low": search.known[low]["verdict"],
             "verdict_high": search.known[high]["verdict"],
             "final": search.final(low) and search.final(high),
             "doubts_low": search.doubts(low), "doubts_high": search.doubts(high)}
    (out / "limit.json").write_text(json.dumps(whole, indent=1) + "\n")
    print(f"table: {out / 'table.csv'}, {out / 'table.json'}")


if __name__ == "__main__":
    main()
