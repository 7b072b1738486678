# One run for each combination of values, side by side, and one table of their results.
# SPDX-License-Identifier: BSD-3-Clause
"""Runs a case once for each combination of values and gathers the results in one table.

  spall sweep cases/hello/case.toml --set contact.cohesion=1,10,100N --set seed=1..5 --jobs 2

Values stand one after another: 1,10,100N is 1 N, 10 N, 100 N; a list in brackets is one value.
A range is of whole numbers without a unit: 1..5 is 1, 2, 3, 4, 5. A sweep has up to 100,000 runs.
Each value is checked before any run begins. Each run has a folder of its own below --out. What is
done stays; what was stopped goes on: say the same again. table.csv and table.json hold what was
changed and all numbers and verdicts of results.toml; sweep.png shows those of --show.
Exit codes: 0: all done; 3: stopped by a signal, the same again goes on; others: an error.
"""
import argparse
import csv
import hashlib
import itertools
import json
import math
import os
import re
import shlex
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from system_python import need

DONE, STOPPED = 0, 3  # exit codes of spall
MOST_RUNS = 100_000  # each has a folder and a row; more are a slip, and would fill the memory
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
UNIT = r"(?:\s*[A-Za-zµ°%][^.]*)?"
WHOLE_RANGE = r"\s*([-+]?\d+)\s*\.\.\s*([-+]?\d+)\s*"
RANGE = rf"{NUMBER}{UNIT}\s*\.\.\s*{NUMBER}{UNIT}"  # of numbers of any kind; paths are none


def refuse_too_many(runs, told):
    if runs > MOST_RUNS:
        sys.exit(f"spall sweep: {told}: {runs:,} runs are more than {MOST_RUNS:,}")


def is_within(key, table):
    return f"{key}.".startswith(f"{table}.")


def by_names(key, case):
    """A key with names in place of numbers: in a case groups.0 may be groups.ball."""
    try:
        node = tomllib.loads(Path(case).read_text())
    except (OSError, ValueError):
        return key  # the check will say what is wrong with it
    parts = []
    for part in key.split("."):
        if isinstance(node, list):
            names = [entry.get("name") if isinstance(entry, dict) else None for entry in node]
            if part.isdigit() and int(part) < len(node):
                part, node = names[int(part)] or part, node[int(part)]
            else:
                node = node[names.index(part)] if part in names else None
        else:
            node = node.get(part) if isinstance(node, dict) else None
        parts.append(part)
    return ".".join(parts)


def split(text):
    """At the commas outside of brackets, braces and quotes."""
    parts, depth, quote = [""], 0, ""
    for char in text:
        if quote or char in "\"'":
            quote = "" if char == quote else quote or char
        elif char in "[]{}":
            depth += 1 if char in "[{" else -1
        if char == "," and depth == 0 and not quote:
            parts.append("")
        else:
            parts[-1] += char
    return [part.strip() for part in parts]


def unit_of(text):
    """What stands behind the number of '10 N'; "" of a number alone, 1e-3 too, and of no number."""
    if re.fullmatch(NUMBER, text):
        return ""
    found = re.fullmatch(rf"{NUMBER}\s*([^\d.\s].*)", text)
    return found[1] if found else ""


def values_of(text):
    """'1,10,100N' -> ['1N', '10N', '100N']; a unit or name behind the last number is that of
    all."""
    if found := re.fullmatch(WHOLE_RANGE, text):
        first, last = int(found[1]), int(found[2])
        if first > last:
            sys.exit(f"spall sweep: {text}: the first number is larger than the last")
        refuse_too_many(last - first + 1, text)
        return [str(k) for k in range(first, last + 1)]
    parts = split(text)
    if "" in parts:
        sys.exit(f"spall sweep: {text}: a value is missing")
    if any(re.fullmatch(RANGE, part) for part in parts):
        sys.exit(f"spall sweep: {text}: a range is of whole numbers without a unit, and alone: "
                 "1..3; other values are told one by one: 0.1,0.2,0.3N")
    unit = unit_of(parts[-1])
    parts = [part + unit if re.fullmatch(NUMBER, part) else part for part in parts]
    plain = [part for part in parts if re.fullmatch(NUMBER, part) and float(part) != 0]
    if plain and any(re.match(r"[A-Za-zµ°%]", unit_of(part)) for part in parts):
        sys.exit(f"spall sweep: {text}: {plain[0]} has no unit, and another value has one: a unit "
                 "behind the last value is that of all")
    return parts


def names_of(keys):
    """What folders call each key: its last word, where no other key has the same."""
    last = [key.split(".")[-1] for key in keys]
    return {word if last.count(word) == 1 else key: key for word, key in zip(last, keys)}


class Run:
    """One combination: what is changed, and the folder of its results."""

    def __init__(self, out, changes, names):
        self.changes = changes  # key -> value, all
        told = [f"{name}={changes[key]}" for name, key in names.items()]
        self.name = "_".join(re.sub(r"[^\w.=+-]+", "-", name) for name in told) or "run"
        self.folder = out / self.name

    def options(self):
        return [word for key, value in self.changes.items() for word in ("--set", f"{key}={value}")]

    def state(self):
        """What its folder tells; a run that is under way waits, too."""
        path = self.folder / "results.toml"
        if not path.is_file():
            return "waits"
        told = tomllib.loads(path.read_text()).get("provenance", {}).get("overrides")
        own = {f"{key}={value}" for key, value in self.changes.items()}
        if told is not None and set(told.splitlines()) != own:
            sys.exit(f"spall sweep: {self.folder} holds a run with other keys: "
                     f"{', '.join(sorted(set(told.splitlines()) ^ own))}; remove it, or --out "
                     "names another folder")
        return "done"

    def command(self, spall, case, ranks):
        """What begins this run, or goes on with it; None where it is done."""
        if self.state() == "done":
            return None
        if (self.folder / "restart.h5").is_file():
            words = [spall, "resume", str(self.folder / "restart.h5")]
        else:
            words = [spall, "run", case, "--out", str(self.folder), "--overwrite", *self.options()]
        return ["mpirun", "-n", str(ranks), *words] if ranks > 1 else words

    def results(self):
        """section.key -> number or text, of results.toml."""
        path = self.folder / "results.toml"
        if not path.is_file():
            return {}
        flat = {}
        for section, rows in tomllib.loads(path.read_text()).items():
            for key, value in rows.items():
                if section != "provenance" and isinstance(value, (int, float, str)):
                    flat[f"{section}.{key}"] = value
        return flat


def to_try(runs, ends):
    """A run for each value of each key, but for those of a range between its `ends`."""
    seen = set()
    for run in runs:
        new = {(key, value) for key, value in run.changes.items()
               if (key, value) not in seen and value in ends.get(key, [value])}
        seen |= new
        if new:
            yield run


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def files_of(case, settings):
    """Name -> digest of what the case and settings (key, value) name as a `file`: materials,
    meshes, bodies of earlier runs."""
    named = {value.strip("\"'") for key, value in settings if key.split(".")[-1] == "file"}

    def look(node):
        for key, value in node.items() if isinstance(node, dict) else enumerate(node):
            if key == "file":
                named.add(str(value))
            elif isinstance(value, (dict, list)):
                look(value)

    look(tomllib.loads(case.read_text()))
    return {name: digest(case.parent / name) for name in sorted(named)
            if (case.parent / name).is_file()}


def claim(out, case, fixed, overwrite, program="spall sweep", write=True, names=None, files=None):
    """Runs of another case, with other fixed keys, of keys that only have the same `names` or of
    `files` that have changed must not stand in the same table. Without `write` it is only
    compared."""
    own = {"case": str(case), "sha256": digest(case), "fixed": fixed}
    path = out / "sweep.json"
    told = {"names": names or {}, "files": files or {}}
    former = json.loads(path.read_text()) if path.is_file() else dict(own)
    before = {kind: former.pop(kind, {}) for kind in told}
    if former != own or any(before[kind].get(name, value) != value
                            for kind in told for name, value in told[kind].items()):
        if not (overwrite and write):
            forget = "--overwrite" if write else "--overwrite, without --commands,"
            sys.exit(f"{program}: {out} holds runs of another case, with other keys or of files "
                     f"that have changed ({path}); "
                     f"{forget} forgets them, --out names another folder")
        for old in [*out.glob("*/results.toml"), *out.glob("*/restart*.h5"), *out.glob("table.*")]:
            old.unlink()
        before = {kind: {} for kind in told}
    if not write:
        return
    out.mkdir(parents=True, exist_ok=True)
    whole = path.with_suffix(f".{os.getpid()}")  # jobs of an array write it side by side
    whole.write_text(json.dumps(own | {kind: before[kind] | told[kind] for kind in told},
                                indent=1) + "\n")
    whole.replace(path)


def json_of(rows):
    """As text; what is no number has no word in JSON but null."""
    told = [{key: None if isinstance(value, float) and not math.isfinite(value) else value
             for key, value in row.items()} for row in rows]
    return json.dumps(told, indent=1, allow_nan=False) + "\n"


def write_tables(out, runs, states):
    rows = [{"run": run.name, "state": states[run.name], **run.changes, **run.results()}
            for run in runs]
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with open(out / "table.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)
    (out / "table.json").write_text(json_of(rows))
    return rows


def readable(value):
    return value if isinstance(value, str) else f"{value:.6g}"


def numbers_of(values):
    """Where all begin with a number and end alike; else None: 50cm and 1m have no common axis."""
    found = [re.match(rf"({NUMBER})(.*)", str(value)) for value in values]
    if not all(found) or len({one[2].strip() for one in found}) > 1:
        return None
    return [float(one[1]) for one in found]


def draw(out, rows, swept, show):
    """Each result of `show` over the first key that is swept; the scatter is that of all others."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(len(show), 1, figsize=(7, 3.2 * len(show)), squeeze=False,
                                   layout="constrained")
    for axis, name in zip(axes[:, 0], show):
        points = {}
        for row in rows:
            if name in row:
                points.setdefault(row[swept[0]], []).append(row[name])
        numbers = numbers_of(points)
        places = numbers or list(range(len(points)))
        for place, found in zip(places, points.values()):
            axis.plot([place] * len(found), found, "o", color="#9bb4d4", ms=4)
        axis.plot(places, [sum(found) / len(found) for found in points.values()], "-s",
                  color="#1f4e8c", ms=5,
                  label="mean")
        if numbers and min(places) > 0 and max(places) >= 30 * min(places):
            axis.set_xscale("log")
        axis.set_xticks(places, list(points))
        axis.minorticks_off()
        axis.set_xlabel(swept[0])
        axis.set_ylabel(name)
        axis.legend(frameon=False)
    figure.savefig(out / "sweep.png", dpi=120)
    print(f"picture: {out / 'sweep.png'}")


def count(text):
    """Of what there is one at least."""
    if int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is less than 1")
    return int(text)


def main():
    parser = argparse.ArgumentParser(prog="spall sweep", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", help="case file (TOML)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUES",
                        help="change a key; may be given several times")
    parser.add_argument("--out", type=Path, help="folder of all runs; default: out/<case>-sweep")
    parser.add_argument("--jobs", type=count, default=1, help="runs at a time; default: 1")
    parser.add_argument("--ranks", type=count, default=1, help="of each run; default: 1")
    parser.add_argument("--show", action="append", default=[], metavar="SECTION.KEY",
                        help="a result of results.toml to print, and a number to draw, as "
                             "deflection.beta; may be given several times")
    parser.add_argument("--overwrite", action="store_true",
                        help="forget what --out holds of another sweep")
    parser.add_argument("--commands", action="store_true",
                        help="run nothing, forget nothing: print a line for each run that is not "
                             "done")
    parser.add_argument("--only", type=int, metavar="K",
                        help="run nothing: print case, folder and --set of combination K, counted "
                             "from 1, a word a line; "
                             "jobs/cluster.slurm does so")
    parser.add_argument("--table", action="store_true",
                        help="run nothing: gather the results that are there")
    options = parser.parse_args()
    if options.show:
        need("spall sweep --show", "matplotlib")
    spall = os.environ.get("SPALL_PROGRAM", "spall")
    case = Path(options.case)
    out = options.out or Path(
        "out") / f"{case.parent.name if case.stem == 'case' else case.stem}-sweep"

    keys, ends, spelled = {}, {}, {}
    for text in options.set:
        key, equals, value = text.partition("=")
        named = by_names(key, case)
        if not equals or named in spelled:
            sys.exit(
                f"spall sweep: --set {text}: {'told twice' if equals else 'KEY=VALUES is wanted'}")
        for before, other in spelled.items():
            if is_within(named, before) or is_within(before, named):
                sys.exit(f"spall sweep: --set {other} and --set {key}: one would change what the "
                         "other sets")
        keys[key], spelled[named] = values_of(value), key
        if re.fullmatch(WHOLE_RANGE, value):
            ends[key] = {keys[key][0], keys[key][-1]}
    swept = [key for key, values in keys.items() if len(values) > 1]
    refuse_too_many(math.prod(map(len, keys.values())), "all --set together")
    names = names_of(swept)
    runs = [Run(out, dict(zip(keys, values)), names)
            for values in itertools.product(*keys.values())]
    if len({run.name for run in runs}) < len(runs):
        sys.exit("spall sweep: two combinations are the same")
    if options.only is not None and not 1 <= options.only <= len(runs):
        sys.exit(f"spall sweep: --only {options.only}: there are combinations 1 to {len(runs)}")

    # A typo in the last value would else be found when its run begins, hours later.
    begins = options.only is None and not options.table
    for run in to_try(runs, ends) if begins else runs[:1]:
        checked = subprocess.run([spall, "check", options.case, *run.options()],
                                 stdout=subprocess.DEVNULL)
        if checked.returncode != 0:
            print(f"spall sweep: {run.name} is refused, so nothing is begun", file=sys.stderr)
            sys.exit(checked.returncode)
    claim(out, case, {key: values[0] for key, values in keys.items() if len(values) == 1},
          options.overwrite, write=not options.commands, names=names,
          files=files_of(case, [(key, value) for key in keys for value in keys[key]]))
    if options.commands:
        commands = [run.command(spall, options.case, options.ranks) for run in runs]
        for command in filter(None, commands):
            print(shlex.join(command))
        print(f"{commands.count(None)} of {len(runs)} are done", file=sys.stderr)
        return
    if options.only is not None:
        run = runs[options.only - 1]
        print(options.case, run.folder, *run.options(), sep="\n")
        return
    states = {run.name: run.state() if options.table else "waits" for run in runs}

    def carry_out(run):
        command = run.command(spall, options.case, options.ranks)
        code = DONE
        if command:
            with open(out / f"{run.name}.log", "w") as log:
                code = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT).returncode
        states[run.name] = "done" if code == DONE else "stopped" if code == STOPPED else "failed"
        ended = sum(state != "waits" for state in states.values())
        found = run.results()
        shown = "".join(f"  {name} = {readable(found[name])}" for name in options.show
                        if name in found)
        print(f"{ended} of {len(runs)}  {run.name}: {states[run.name]}{shown}", flush=True)

    if not options.table:
        with ThreadPoolExecutor(options.jobs) as pool:
            list(pool.map(carry_out, runs))
    rows = write_tables(out, runs, states)
    print(f"table: {out / 'table.csv'}, {out / 'table.json'}")
    for name in options.show:
        if not any(name in row for row in rows):
            sys.exit(f"spall sweep: no run has a result {name}; table.csv names all there are")
    numbers = [name for name in options.show
               if not any(isinstance(row.get(name), str) for row in rows)]
    if numbers and swept:
        draw(out, rows, swept, numbers)
    if "failed" in states.values():
        for run in runs:
            if states[run.name] == "failed":
                print(f"failed: {run.name}, see {out / run.name}.log", file=sys.stderr)
        sys.exit(1)
    if waiting := list(states.values()).count("waits"):
        print(f"{waiting} of {len(runs)} are not done")
    if waiting or "stopped" in states.values():
        sys.exit(STOPPED)


if __name__ == "__main__":
    main()
