#!/bin/bash
# `spall sweep`: one run for each combination, one table; what is done stays, what cannot be is refused.
# SPDX-License-Identifier: BSD-3-Clause
# usage: sweep.sh SPALL, in a folder to write in
set -u
spall=$1
job=$(cd "$(dirname "$0")" && pwd)/../jobs/cluster.slurm
rm -rf sweep
mkdir sweep && cd sweep || exit 1
failures=0
fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}
cat >fall.toml <<'END'
title = "a sphere falls"
[materials.rock]
density = "1600 kg/m^3"
[contact]
[[groups]]
name = "ball"
material = "rock"
volume = {shape = "sphere", radius = "1 m"}
[gravity]
uniform = [0, 0, "-1 m/s^2"]
[[phases]]
name = "fall"
step = "1 s"
duration = "10 s"
END

"$spall" sweep fall.toml --set groups.ball.volume.radius=1,2m --set seed=1..2 --jobs 2 \
  --show pile.mass >out.txt 2>&1 || fail "a sweep"
[ "$(wc -l <out/fall-sweep/table.csv)" = 5 ] || fail "one row for each of four combinations"
[ -s out/fall-sweep/sweep.png ] || fail "no picture"
python3 - <<'END' || fail "the table's numbers"
import json
rows = json.load(open("out/fall-sweep/table.json"))
masses = {row["groups.ball.volume.radius"]: row["pile.mass"] for row in rows}
assert sorted(masses) == ["1m", "2m"], masses
assert abs(masses["2m"] / masses["1m"] - 8) < 1e-12, masses
assert all(row["state"] == "done" for row in rows)
END

before=$(stat -c %y out/fall-sweep/radius=1m_seed=1/results.toml)
"$spall" sweep fall.toml --set groups.ball.volume.radius=1,2,3m --set seed=1..2 >out.txt 2>&1 || fail "more values"
[ "$(wc -l <out/fall-sweep/table.csv)" = 7 ] || fail "rows of more values"
[ "$before" = "$(stat -c %y out/fall-sweep/radius=1m_seed=1/results.toml)" ] || fail "what was done ran again"
[ -z "$("$spall" sweep fall.toml --set groups.ball.volume.radius=1,2,3m --set seed=1..2 --commands)" ] ||
  fail "commands of runs that are done"
[ "$("$spall" sweep fall.toml --set groups.ball.volume.radius=1,2,3,4m --commands --ranks 2 | grep -c 'mpirun -n 2')" = 4 ] ||
  fail "commands of what is not done"
"$spall" sweep fall.toml --set groups.ball.volume.radius=1,2,4m --set seed=1..2 --commands 2>&1 >out.txt |
  grep -q "^4 of 6 are done$" || fail "how many are done"
"$spall" sweep fall.toml --set seed=1..2 --commands --out not_yet >out.txt 2>&1 || fail "commands of a new sweep"
[ ! -e not_yet ] && [ "$(grep -c -- "--out not_yet" out.txt)" = 2 ] || fail "commands write nothing: $(cat out.txt)"

# A job array, as Slurm would start it: a job a combination, side by side, then one table of the same numbers.
mkdir -p slurm
printf '#!/bin/sh\nexec "$@"\n' >slurm/srun
chmod +x slurm/srun
for k in 1 2 3 4; do
  PATH=$PWD/slurm:$PATH SPALL=$spall SLURM_JOB_ID=$k SLURM_ARRAY_TASK_ID=$k bash "$job" sweep fall.toml \
    --set groups.ball.volume.radius=1,2m --set seed=1..2 --out out/array >"job_$k" 2>&1 &
  jobs[k]=$!
done
for k in 1 2 3 4; do wait "${jobs[k]}" || fail "job $k of an array: $(cat "job_$k")"; done
"$spall" sweep fall.toml --set groups.ball.volume.radius=1,2m --set seed=1..2 --out out/array --table >out.txt ||
  fail "a table of an array: $(cat out.txt)"
python3 - <<'END' || fail "the table of an array"
import json
def rows_of(sweep):
    return [{key: value for key, value in row.items() if not key.startswith("time.")}
            for row in json.load(open(f"out/{sweep}/table.json")) if row["groups.ball.volume.radius"] != "3m"]
assert rows_of("array") == rows_of("fall-sweep"), rows_of("array")
END
# A job of one case names its folder as `spall run` does, and takes no other case's results for its own.
commands=$PWD/slurm
one_job() { # case [folder]
  PATH=$commands:$PATH SPALL=$spall SLURM_JOB_ID=1 bash "$job" "$@" >job.txt 2>&1
}
mkdir tower
cp fall.toml tower/case.toml
one_job fall.toml && [ -f out/fall/results.toml ] || fail "a job of fall.toml: $(cat job.txt)"
(cd tower && one_job case.toml && [ -f out/tower/results.toml ]) || fail "a job of a case.toml: $(cat tower/job.txt)"
one_job fall.toml && grep -q "'out/fall' holds the results already" job.txt || fail "a job that is over: $(cat job.txt)"
one_job tower/case.toml out/fall && fail "a job takes the results of another case"
grep -q "'out/fall' holds the results of another case" job.txt || fail "another case's results: $(cat job.txt)"
"$spall" sweep fall.toml --set seed=1..3 --out out/empty --table >out.txt
[ $? = 3 ] && grep -q "3 of 3 are not done" out.txt || fail "a table of nothing: $(cat out.txt)"

# Commas within quotes, brackets and braces part no values.
"$spall" sweep fall.toml --set 'title="a, b"' --set 'groups.ball.motion={velocity=[0,0,1]},{velocity=[0,1,0]}' \
  --commands --out never >out.txt 2>&1 || fail "tables as values: $(cat out.txt)"
[ "$(grep -c 'title="a, b"' out.txt)" = 2 ] || fail "two runs of one title: $(cat out.txt)"
python3 - "$(dirname "$spall")/share/spall/scripts" <<'END' || fail "places of a picture"
import sys
sys.path.insert(0, sys.argv[1])
import sweep
assert sweep.numbers_of(["50cm", "1m"]) is None and sweep.numbers_of(["a", "2"]) is None
assert sweep.numbers_of(["1 N", "10N"]) == [1, 10]
assert sweep.values_of("1e-3,0.01,0") == ["1e-3", "0.01", "0"] and sweep.values_of("1e-3") == ["1e-3"]
assert sweep.values_of("1e-3,2e-3 m") == ["1e-3m", "2e-3 m"], sweep.values_of("1e-3,2e-3 m")
assert sweep.json_of([{"a": float("nan"), "b": 1.0}]) == '[\n {\n  "a": null,\n  "b": 1.0\n }\n]\n'
assert sweep.split("[[0, 1], [2, 3]], {a = [4, 5]}, 6") == ["[[0, 1], [2, 3]]", "{a = [4, 5]}", "6"]
END

refused() { # text that must be said, arguments
  local text=$1
  shift
  "$spall" sweep "$@" >out.txt 2>&1 && fail "accepted: $*"
  grep -q -- "$text" out.txt || fail "$*: no '$text' in: $(cat out.txt)"
}
refused "friktion" fall.toml --set contact.friktion=0.1,0.2 --out never
[ ! -e never ] || fail "a refused sweep left a folder"
refused "another case" fall.toml --set seed=1..2 --set contact.friction=0.3 --out out/fall-sweep
"$spall" sweep fall.toml --set solver.tolerance=0.1,0.2 --out out/named >out.txt || fail "a sweep of the solver: $(cat out.txt)"
refused "with other keys" fall.toml --set phases.fall.solver.tolerance=0.1,0.2 --out out/named
echo 'density = "1600 kg/m^3"' >rock.toml
sed 's/^density.*/file = "rock.toml"/' fall.toml >of_file.toml
"$spall" sweep of_file.toml --set seed=1,2 --out out/files >out.txt || fail "a sweep of a file: $(cat out.txt)"
"$spall" sweep of_file.toml --set seed=1..3 --out out/files >out.txt || fail "more of a file: $(cat out.txt)"
echo 'density = "3200 kg/m^3"' >rock.toml
refused "of files that have changed" of_file.toml --set seed=1..4 --out out/files
for forget in "" --overwrite; do
  # shellcheck disable=SC2086
  refused "another case" fall.toml --set seed=1..2 --set contact.friction=0.3 --out out/fall-sweep --commands $forget
done
[ "$before" = "$(stat -c %y out/fall-sweep/radius=1m_seed=1/results.toml)" ] || fail "commands have forgotten a run"
refused "friktion" fall.toml --set contact.friktion=0.1,0.2 --out never --commands
refused "2 has no unit" fall.toml --set contact.cohesion=1kN,2,3 --out never
"$spall" sweep fall.toml --set seed=1..2 --out out/changed >out.txt || fail "two seeds: $(cat out.txt)"
sed -i 's/^overrides = .*/overrides = "seed=7\\n"/' out/changed/seed=1/results.toml
refused "holds a run with other keys: seed=1, seed=7" fall.toml --set seed=1..2 --out out/changed
refused "a value is missing" fall.toml --set seed=1,,2
refused "told twice" fall.toml --set seed=1 --set seed=2
refused "one would change what the other" fall.toml --set 'groups.0.velocity=[0,0,0]' --set groups.ball.velocity.0=1,2
refused "told twice" fall.toml --set 'groups.0.velocity=[0,0,0],[0,0,1]' --set 'groups.ball.velocity=[0,0,2]'
refused "larger than the last" fall.toml --set seed=5..1
refused "no run has a result" fall.toml --set seed=1..2 --out shown --show pile.mas
refused "there are combinations 1 to 2" fall.toml --set seed=1..2 --out other --only 3
refused "another case" fall.toml --set contact.friction=0.3 --set seed=1..2 --out out/array --only 1
for range in 0.1..0.3 1..3N "1 m/s .. 3 m/s" 1..2.5 1..3,7 1e0..3; do
  refused "a range is of whole numbers" fall.toml --set "seed=$range" --out never
done
refused "100,000,000,000 runs are more than 100,000" fall.toml --set seed=1..100000000000 --out never
refused "100,001 runs are more than 100,000" fall.toml --set seed=0..100000 --out never
refused "together: 120,000 runs" fall.toml --set seed=1..400 --set contact.friction=1..300 --out never
refused "argument --jobs: 0 is less than 1" fall.toml --set seed=1..2 --out never --jobs 0
refused "argument --ranks: -1 is less than 1" fall.toml --set seed=1..2 --out never --ranks -1
refused "argument --jobs: invalid count value: 'two'" fall.toml --set seed=1..2 --out never --jobs two
refused "radius=-3m_seed=1 is refused, so nothing is begun" fall.toml --set groups.ball.volume.radius=1,2,-3m --set seed=1..5 --out never
refused "seed=-2 is refused" fall.toml --set seed=-2..5 --out never
refused "no_such.toml" no_such.toml --set seed=1..2

[ $failures = 0 ] && echo "all passed"
exit $failures
