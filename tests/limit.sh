#!/bin/bash
# `spall limit`: the bracket closes on the limit by bisection and by several at a time; what is done stays.
# SPDX-License-Identifier: BSD-3-Clause
# usage: limit.sh SPALL, in a folder to write in
set -u
spall=$1
rm -rf limit
mkdir limit && cd limit || exit 1
failures=0
fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# A stand-in whose wall fails from 4.3 mm on, and from 5.2 km/s on, and that keeps count of its runs.
script=$(dirname "$spall")/share/spall/scripts/limit.py
cat >stand_in.py <<'END'
#!/usr/bin/python3
import re, sys, tomllib
from pathlib import Path
words = sys.argv[1:]
changes = dict(word.split("=", 1) for word in words if "=" in word)
if "never.key" in changes:
    sys.exit("never.key is not a key here")
layers = changes.get("ball.layers", "4")
if not layers.isdigit():
    sys.exit(f"shield.toml:3:1: ball.layers is not whole; a whole number is wanted")
if words[0] == "check":
    case = tomllib.loads(Path(words[1]).read_text())
    if "shields" in changes:
        case |= tomllib.loads(f"shields = {changes['shields']}")
    for shield in case.get("shields", []):
        print(f"  judged in the end: {shield['wall']}, 3.4 spacings thick, its rear towards z; openings")
    sys.exit()
out = Path(words[words.index("--out") + 1])
out.mkdir(parents=True, exist_ok=True)
with open("runs.log", "a") as log:
    log.write(f"{out.name}\n")
if "broken.key" in changes:
    sys.exit(1)
if "stopped.key" in changes and not Path("go_on").exists():
    sys.exit(3)
size = float(re.match(r"[\d.e-]+", changes.get("ball.diameter", layers))[0])
speed = float(re.search(r"-([\d.]+)", changes.get("ball.velocity", "-5"))[1])
islands = "islands.key" in changes and 2.9 < size < 3.1
held = size < 4.3 and speed < 5.2 and not islands
(out / "results.toml").write_text(f"""
[shield_rear]
wall = "rear"
verdict = "{'held' if held else 'perforated'}"
margin = {(4.3 - size) / 4.3}
thinnest = 0.001
hole = 0.0
spall_mass = 0.0
still_coming = {0.3 if size == 2 else 0.0}
still_failing = {'true' if size == 3 else 'false'}
opening_at_edge = {'true' if size == 9 else 'false'}
largest_met = 1.0
largest_passed = {2.0 if size == 3 else 0.5}
largest_met_diameter = 0.002
coarse = {'true' if size == 3 else 'false'}
[shield_front]
wall = "front"
verdict = "{'held' if size < 2.5 else 'perforated'}"
margin = 0.5
thinnest = 0.001
hole = 0.0
spall_mass = 0.0
still_coming = 0.0
opening_at_edge = false
[lattices]
{'warning = "groups.ball: its lattice has 0.9 of the mass"' if size == 9 else ''}
[conservation]
energy_unexplained = {0.07 if size == 9 else 0.01}
[provenance]
case = "x"
""")
END
chmod +x stand_in.py
cat >shield.toml <<'END'
[[shields]]
wall = "rear"
END
limit() { SPALL_PROGRAM=$PWD/stand_in.py python3 "$script" "$@" >out.txt 2>&1; }
runs() { wc -l <runs.log; }

limit shield.toml --vary ball.diameter=2..8mm --within 1% || fail "a search: $(cat out.txt)"
python3 - <<'END' || fail "the bracket: $(cat out/shield-limit/limit.json)"
import csv, json
limit = json.load(open("out/shield-limit/limit.json"))
low, high = (float(limit[end].removesuffix("mm")) for end in ("low", "high"))
assert low < 4.3 <= high and (high - low) / ((high + low) / 2) <= 0.01, limit
assert (limit["verdict_low"], limit["verdict_high"]) == ("held", "perforated"), limit
rows = list(csv.DictReader(open("out/shield-limit/table.csv")))
assert [row["verdict"] == "held" for row in rows] == sorted((row["verdict"] == "held" for row in rows), reverse=True)
assert all(row["state"] == "done" for row in rows)
END
[ "$(runs)" = 10 ] || fail "two ends and eight halvings, not $(runs)" # 6 mm/2^8 < 1 % of 4.3 mm
grep -q "limit: held at 4.29.*mm, perforated at 4.3.*mm" out.txt || fail "no bracket in: $(cat out.txt)"
grep -q "2mm: held.*not final: 30 %" out.txt || fail "a verdict that is not final: $(cat out.txt)"

limit shield.toml --vary ball.diameter=2..8mm --within 1% || fail "the same again"
[ "$(runs)" = 10 ] || fail "what was done ran again"
limit shield.toml --vary ball.diameter=2..4.5mm --within 1% || fail "another range: $(cat out.txt)"
[ "$(runs)" = 11 ] || fail "of another range one end is new, not $(($(runs) - 10))"
limit shield.toml --vary ball.diameter=2..8mm --within 0.2% || fail "narrower"
[ "$(runs)" -gt 11 ] && [ "$(runs)" -le 15 ] || fail "a narrower bracket goes on from what is known: $(runs)"

# Three at a time quarter the bracket in each round: 6 mm/4^4 is less than 1 % of 4.3 mm.
rm runs.log
limit shield.toml --vary ball.diameter=2..8mm --within 1% --jobs 3 --out out/three || fail "three at a time: $(cat out.txt)"
[ "$(runs)" -ge 13 ] && [ "$(runs)" -le 15 ] || fail "three at a time made $(runs) runs"
limit shield.toml --vary ball.diameter=2..7mm --within 5% --jobs 4 --out out/again || fail "four at a time: $(cat out.txt)"
before=$(runs)
limit shield.toml --vary ball.diameter=2..7mm --within 5% --jobs 4 --out out/again || fail "four at a time, again"
[ "$(runs)" = "$before" ] && [ -z "$(cut -d, -f1 out/again/table.csv | sort | uniq -d)" ] ||
  fail "a third of the range is another one when it is read again: $(cat out/again/table.csv)"
limit shield.toml --vary 'ball.velocity=[0, 0, "-2 km/s"]..[0, 0, "-8 km/s"]' --within 2% --out out/speed ||
  fail "a speed: $(cat out.txt)"
grep -q 'limit: held at \[0, 0, "-5.1.* km/s"\], perforated at \[0, 0, "-5.2.* km/s"\]' out.txt ||
  fail "of a speed: $(cat out.txt)"

limit shield.toml --vary ball.diameter=2..8mm --within 5 --out out/none && fail "500 %"
limit shield.toml --vary ball.diameter=2..4mm --out out/none
[ $? = 4 ] && grep -q "held at 2mm (not final: 30 % .*) and held at 4mm" out.txt || fail "no limit between: $(cat out.txt)"
limit shield.toml --vary ball.diameter=2000e-3..8e0 --within 1% --out out/exponents || fail "exponents: $(cat out.txt)"
grep -q "limit: held at 4.29[0-9]*, perforated at 4.3" out.txt || fail "of exponents: $(cat out.txt)"
limit shield.toml --vary ball.diameter=2..8mm --set islands.key=1 --jobs 7 --out out/islands || fail "islands"
grep -q "changes more than once" out.txt || fail "islands: $(cat out.txt)"
limit shield.toml --vary ball.diameter=3..9mm --within 60% --out out/doubts || fail "doubts: $(cat out.txt)"
grep -q "^9mm: perforated, margin .*; opened as far as its edge: .*; not to be believed: 0.07 of what .*; groups.ball: its lattice has 0.9" out.txt &&
  grep -q "^3mm: held, margin .*; still failing: .*; too narrow: a piece of 2 J flew past.*; coarse: .* of 0.002 m" out.txt ||
  fail "what runs say against their verdicts: $(cat out.txt)"
python3 - <<'END' || fail "doubts: $(cat out/doubts/limit.json)"
import csv, json
assert json.load(open("out/doubts/limit.json"))["doubts_high"] == [], "6mm has none"
rows = {row["value"]: row for row in csv.DictReader(open("out/doubts/table.csv"))}
assert (rows["9mm"]["opening_at_edge"], rows["9mm"]["energy_unexplained"]) == ("True", "0.07"), rows
END
limit shield.toml --vary ball.layers=2..9 --within 1% --jobs 3 --out out/layers || fail "whole numbers: $(cat out.txt)"
grep -q "limit: held at 4, perforated at 5" out.txt || fail "of whole numbers: $(cat out.txt)"
limit shield.toml --vary ball.layers=4..5 --jobs 4 --out out/two_layers || fail "two whole numbers: $(cat out.txt)"
grep -q "limit: held at 4, perforated at 5" out.txt || fail "of two whole numbers: $(cat out.txt)"
limit shield.toml --vary ball.layers=0..500 --within 1% --out out/many_layers || fail "many layers: $(cat out.txt)"
grep -q "limit: held at 4, perforated at 5" out.txt || fail "of many layers: $(cat out.txt)"

# A table is of one wall.
printf '[[shields]]\nwall = "front"\n[[shields]]\nwall = "rear"\n' >two.toml
limit two.toml --vary ball.diameter=2..8mm --wall front || fail "the front wall: $(cat out.txt)"
limit two.toml --vary ball.diameter=3..6mm --wall rear || fail "the rear wall: $(cat out.txt)"
python3 - <<'END' || fail "a table of two walls: $(cat out/two-limit/table.csv)"
import csv
rows = list(csv.DictReader(open("out/two-limit/table.csv")))
assert {row["wall"] for row in rows} == {"rear"}, rows
for row in rows:
    assert (row["verdict"] == "held") == (float(row["value"].removesuffix("mm")) < 4.3), row
END
limit shield.toml --vary ball.diameter=2..8mm --set broken.key=1 --out out/broken
[ $? = 1 ] && grep -q "a run has failed" out.txt || fail "a run that fails: $(cat out.txt)"
limit shield.toml --vary ball.diameter=2..8mm --set stopped.key=1 --out out/stopped
[ $? = 3 ] && grep -q "say the same again" out.txt || fail "a run that was stopped: $(cat out.txt)"
touch go_on
limit shield.toml --vary ball.diameter=2..8mm --set stopped.key=1 --out out/stopped || fail "it goes on: $(cat out.txt)"

refused() { # text that must be said, arguments
  local text=$1
  shift
  limit "$@" && fail "accepted: $*"
  grep -q -- "$text" out.txt || fail "$*: no '$text' in: $(cat out.txt)"
}
refused "KEY=LOW..HIGH" shield.toml --vary ball.diameter=2
refused "alike but for their numbers" shield.toml --vary ball.diameter=2mm..8cm
refused "both ends are the same" shield.toml --vary ball.diameter=2mm..2mm
refused "digits without _" shield.toml --vary 'ball.velocity=[0, 0, -1_000]..[0, 0, -2_200]'
refused "digits without _" shield.toml --vary ball.diameter=0x10..0x20
refused "told twice" shield.toml --vary ball.diameter=2..8mm --set ball.diameter=3mm
refused "never.key=1 is refused" shield.toml --vary never.key=1..2 --out never
[ ! -e never ] || fail "a refused search left a folder"
refused "jobs and --ranks are 1 at least" shield.toml --vary ball.diameter=2..8mm --jobs 0 --out never
refused "jobs and --ranks are 1 at least" shield.toml --vary ball.diameter=2..8mm --ranks -1 --out never
refused "judges \"rear\"" shield.toml --vary ball.diameter=2..8mm --wall front
refused "another case" shield.toml --vary ball.diameter=2..8mm --set seed=2
echo 'title = "none"' >none.toml
refused "judges no wall" none.toml --vary ball.diameter=2..8mm
limit none.toml --vary ball.diameter=2..8mm --set 'shields=[{wall = "rear"}]' || fail "a wall that --set names: $(cat out.txt)"

# The program itself: a thin plate, a ball of a few bodies.
cat >thin.toml <<'END'
[materials.al]
library = "aluminium_6061_t6"
[[groups]]
name = "plate"
material = "al"
volume = {shape = "box", size = ["16 mm", "16 mm", "2 mm"]}
packing = {kind = "fcc", diameter = "1 mm", orientation = "random"}
[[groups]]
name = "ball"
material = "al"
volume = {shape = "sphere", diameter = "4 mm", center = [0, 0, "3.3 mm"]}
packing = {kind = "fcc", diameter = "1 mm"}
velocity = [0, 0, "-1 km/s"]
[[phases]]
name = "hit"
method = "solid"
step = "8 ns"
duration = "6 us"
[[shields]]
wall = "plate"
END
"$spall" limit thin.toml --vary 'groups.ball.velocity=[0, 0, "-300 m/s"]..[0, 0, "-3000 m/s"]' --within 150% --jobs 2 >out.txt 2>&1 ||
  fail "the program: $(cat out.txt)"
grep -q "limit: held.* at .*m/s.*, perforated at .*m/s" out.txt || fail "the program's bracket: $(cat out.txt)"

[ $failures = 0 ] && echo "all passed"
exit $failures
