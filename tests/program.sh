#!/bin/bash
# What the program says and how it ends: bad input, help, a run that is stopped and goes on.
# SPDX-License-Identifier: BSD-3-Clause
# usage: program.sh SPALL MPIEXEC RANKS CASES, in a folder to write in
set -u
spall=$1 mpiexec=$2 ranks=$3 cases=$4
here=$(cd "$(dirname "$0")" && pwd)
work=program_$ranks
rm -rf "$work"
mkdir "$work" && cd "$work" || exit 1
failures=0
export OMPI_MCA_mpi_yield_when_idle=1 # a rank that waits would keep a busy machine from the others

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

on_ranks() {  # ranks, arguments of the program
  local launcher=("$mpiexec" --oversubscribe -n "$1")
  [ "$1" -gt 1 ] || launcher=()  # which would wait for a second after each refusal
  shift
  timeout -k 2 60 "${launcher[@]}" "$spall" "$@" >stdout 2>stderr
}

# A case with some lines changed: s/what/by what/ for sed.
write_case() {
  cat >plain.toml <<'END'
title = "two spheres"
[materials.rock]
density = "1600 kg/m^3"
[contact]
friction = 0.5
[[groups]]
name = "left"
material = "rock"
volume = {shape = "sphere", radius = "1 m"}
[[groups]]
name = "right"
material = "rock"
volume = {shape = "sphere", radius = "1 m", center = ["3 m", "0 m", "0 m"]}
velocity = ["-1 m/s", "0 m/s", "0 m/s"]
[[phases]]
name = "meet"
step = "0.1 s"
duration = "2 s"
END
  sed "$1" plain.toml >"$2"
}

# Ends soon, not with 0, and says it once: a line with all of the given words.
refuses() {  # name, ranks, file, words…
  local name=$1 n=$2 file=$3 code word
  shift 3
  on_ranks "$n" run "$file" --out "${out:-out}" --overwrite
  code=$?
  [ $code -ne 0 ] || fail "$name: exit code is 0"
  [ $code -ne 124 ] && [ $code -ne 137 ] || fail "$name: hangs"
  [ "$(grep -c '^spall: ' stderr)" = 1 ] || fail "$name: not one message: $(cat stderr)"
  # On busy machines the launcher's event library tells of files that it has closed.
  [ "$(grep -c -v '^\[warn\] Epoll' stderr)" = 1 ] || fail "$name: more than one line: $(cat stderr)"
  [ ! -e "${out:-out}" ] || fail "$name: leaves files"
  for word in "$@"; do
    grep '^spall: ' stderr | grep -qF -- "$word" || fail "$name: no '$word' in: $(cat stderr)"
  done
}

write_case 's/^friction = .*/fricton = 0.5/' unknown.toml
refuses "an unknown key" "$ranks" unknown.toml unknown.toml:5 fricton friction
write_case 's/^friction = .*/friction = "much"/' type.toml
refuses "a wrong type" "$ranks" type.toml type.toml:5 contact.friction
write_case 's/^step = .*/step = "0.1 kg"/' unit.toml
refuses "a wrong unit" "$ranks" unit.toml unit.toml:17 step kg
write_case '0,/radius = "1 m"/s//radius = "-1 m"/' radius.toml
refuses "a negative radius" "$ranks" radius.toml radius.toml:9 radius
refuses "a missing file" "$ranks" nowhere.toml nowhere.toml
write_case 's/center = \["3 m"/center = ["1.5 m"/' overlap.toml
refuses "overlapping bodies" "$ranks" overlap.toml overlap.toml:10 groups.right allowed_overlap
write_case '/^\[\[groups/,/^velocity/d' none.toml
write_case 's/^name = "meet"/&\nmethod = "penalty"/; s/"-1 m/"-6700 m/; s/^friction.*/restitution = 0.5\n[penalty]/; s/^density.*/&\nyoungs_modulus = "50 GPa"/' fast.toml
refuses "a sphere at 6.7 km/s that penalty contact cannot stop" "$ranks" fast.toml phases.meet \
  "body 0" "body 1" "youngs_modulus must be at least"
write_case 's/^name = "meet"/&\nmethod = "penalty"/' lawless.toml
refuses "penalty contact without a law" "$ranks" lawless.toml phases.meet "[penalty]"
refuses "no bodies" "$ranks" none.toml none.toml "no bodies"
write_case '' few.toml
refuses "more ranks than bodies" 3 few.toml few.toml "2 bodies" "3 ranks"
touch file
out=file/below refuses "an unwritable folder" "$ranks" few.toml file/below
SPALL_INSTRUCTIONS=v9 refuses "unknown instructions" "$ranks" few.toml SPALL_INSTRUCTIONS v9

# Where nothing moves nothing drifts.
write_case 's/"-1 m/"0 m/' still.toml
on_ranks "$ranks" run still.toml --out still || fail "bodies at rest: $(cat stderr)"
grep -q "^linear = 0.0 " still/results.toml || fail "drift of bodies at rest: $(grep linear still/results.toml)"

# The same for `spall solve`; problems themselves are tested elsewhere.
refuses_problem() {  # name, arguments, words…
  local name=$1 arguments=$2 code word
  shift 2
  # shellcheck disable=SC2086
  on_ranks "$ranks" solve $arguments
  code=$?
  [ $code -ne 0 ] || fail "$name: exit code is 0"
  [ $code -ne 124 ] && [ $code -ne 137 ] || fail "$name: hangs"
  for word in "$@"; do
    grep -qF -- "$word" stderr || fail "$name: no '$word' in: $(cat stderr)"
  done
}
refuses_problem "a missing problem" nowhere.hdf5 "spall: " nowhere.hdf5
refuses_problem "no HDF5 file" plain.toml "spall: " plain.toml
refuses_problem "an unknown method" "plain.toml --method newton" newton accelerated sor

for arguments in --help "solve --help" keys materials "materials copper" "check $cases/hello/case.toml" "check --time still.toml"; do
  # shellcheck disable=SC2086
  on_ranks "$ranks" $arguments || fail "spall $arguments: exit code is not 0"
  [ -s stdout ] || fail "spall $arguments: prints nothing"
done

# A lattice of some 40,000 spheres on a floor, for a few steps.
cat >lattice.toml <<'END'
[materials.rock]
density = 2500
youngs_modulus = "10 MPa"
[contact]
friction = 0.5
restitution = 0.3
[solver]
max_iterations = 10
[penalty]
model = "hertz"
[gravity]
uniform = [0, 0, -9.81]
[[planes]]
[[groups]]
name = "grains"
material = "rock"
volume = {shape = "box", size = [0.3, 0.3, 0.3], center = [0, 0, 0.15]}
packing = {kind = "hcp", radius = "5 mm"}
[[phases]]
name = "fall"
step = "20 us"
duration = "80 us"
END
sed 's/^name = "fall"/&\nmethod = "penalty"/' lattice.toml >springs.toml
sed 's/^name = "fall"/&\nmethod = "potential"/; /^\[\[planes/d
  s/^\[penalty\]/[pair_potential]/; s/^model = .*/law = "morse"\ndepth = 1\ndistance = 0.01\nsteepness = 6\ncutoff = 0.015/
  s/"20 us"/"1 us"/; s/"80 us"/"5 us"/' lattice.toml >bound.toml

# Memory that ends is told with what was wanted and what was foretold.
write_case '0,/^volume.*/s//volume = {shape = "box", size = [1, 1, 1], center = [0, 9, 0]}\npacking = {kind = "fcc", radius = 2e-3}/' many.toml
if ! grep -q __asan_init "$spall"; then  # it takes its own way
  for command in "check many.toml" "run many.toml --out many"; do
    # shellcheck disable=SC2086
    (ulimit -v 2000000; on_ranks 1 $command) && fail "more memory than there is: exit code is 0"
    grep -q "^spall: many.toml: out of memory: .* MB more were wanted at once; its bodies are foretold to take .* MB a rank" stderr ||
      fail "memory that ends: $(cat stderr)"
  done
fi

# How a metal fails in bodies of this size: by hand 2 G_c / (Y V^(1/3)), and the same of the tension.
on_ranks 1 check "$cases/plate_solid/case.toml" || fail "check of a solid: $(cat stderr)"
for told in "tension of 1.2e+09 Pa and fails where they are 0.0171 of" "parts over 0.0634 of plastic strain at 3.24e+08 Pa"; do
  grep -q "$told" stdout || fail "check of a solid does not tell \"$told\""
done

# The largest rank takes what was foretold, within a third.
foretells_memory() {  # case
  local told peak
  on_ranks "$ranks" check "$1" || fail "check of $1: $(cat stderr)"
  told=$(sed -n 's/.*at most about \([0-9.e+]*\) MB a rank.*/\1/p' stdout)
  peak=$(/usr/bin/python3 -c 'import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024e-6)' \
    "$mpiexec" --oversubscribe -n "$ranks" "$spall" run "$1" --out lattice --overwrite)
  /usr/bin/python3 -c "import sys; sys.exit(not 0.75 < $told / $peak < 4 / 3)" ||
    fail "$1 takes $peak MB a rank, not $told"
}
grep -q __asan_init "$spall" ||  # whose shadow would be counted
  for one in lattice springs bound; do foretells_memory $one.toml; done

# Waits for a condition, at most 20 s.
wait_for() {
  for _ in $(seq 200); do
    "$@" && return 0
    sleep 0.1
  done
  return 1
}

# Physics of a results file: everything but the seconds and where it comes from.
results_of() {
  sed '/^\[time\]/,$d' "$1/results.toml"
}

# Rows of a series but for the seconds that its stages took.
series_of() {
  /usr/bin/python3 -c 'import csv, sys
for row in csv.DictReader(open(sys.argv[1])):
    print({key: value for key, value in row.items() if not key.startswith("seconds_")})' "$1/series.csv"
}

# A run that goes on from its restart file ends with the same digits as one that was left alone.
sed 's/count = 300/count = 40/; s/radius = "10 m"/radius = "6 m"/; s/duration = "4 h"/duration = "40 min"/' \
  "$cases/hello/case.toml" >small.toml
on_ranks "$ranks" run small.toml --out whole || fail "a small run: $(cat stderr)"
on_ranks "$ranks" resume whole/after_aggregation.h5 --out resumed || fail "resume: $(cat stderr)"
diff <(results_of whole) <(results_of resumed) || fail "a resumed run ends otherwise"

# The case that lies beside results is the one that was run, changes and all, wherever it stands.
on_ranks "$ranks" run small.toml --out seeded --set seed=2 --set "output.restart_every=1 h" || fail "a changed run: $(cat stderr)"
diff -q <(results_of whole) <(results_of seeded) >/dev/null && fail "a changed seed changes nothing"
mkdir -p elsewhere && cp seeded/resolved_case.toml elsewhere/own.toml
on_ranks "$ranks" run elsewhere/own.toml --out again || fail "a resolved case: $(cat stderr)"
diff <(results_of seeded) <(results_of again) || fail "a resolved case gives another run"
/usr/bin/python3 - seeded <<'END' || fail "where results come from"
import sys, tomllib
told = tomllib.load(open(sys.argv[1] + "/results.toml", "rb"))["provenance"]
assert told["case"] == open("small.toml").read(), told["case"]
assert told["overrides"] == "seed=2\noutput.restart_every=1 h\n", told["overrides"]
assert told["command"].endswith("run small.toml --out seeded --set seed=2 --set 'output.restart_every=1 h'"), told["command"]
assert told["seed"] == 2 and told["case_file"] == "small.toml", told
END

# What a run took before its restart file counts, also where nothing is left to do.
on_ranks "$ranks" resume whole/after_evolution.h5 --out ended || fail "resume at the end: $(cat stderr)"
grep -q "all phases of this run are over" stdout || fail "does not say that nothing is left to do"
grep -q "^solver_s = 0.0 " ended/results.toml && fail "a resumed run forgets the seconds of its stages"

# Restart files change nothing, whenever they are written.
on_ranks "$ranks" run small.toml --out often --set "output.restart_every=5 ms" || fail "a run that saves: $(cat stderr)"
diff <(results_of whole) <(results_of often) || fail "writing restart files changes a run"
diff <(series_of whole) <(series_of often) || fail "writing restart files changes a series"
[ -f often/restart_before.h5 ] || fail "no former restart file is kept"

# Nor does a signal: what was done since the last kept state is done again.
sed 's/step = "10 s"/step = "2 s"/' "$cases/hello/case.toml" >longer.toml
on_ranks "$ranks" run longer.toml --out alone || fail "a longer run: $(cat stderr)"
"$mpiexec" --oversubscribe -n "$ranks" "$spall" run longer.toml --out stopped >stdout 2>stderr &
launcher=$!
wait_for grep -q "^phase aggregation" stdout
kill -USR1 $launcher
wait $launcher
code=$?
if [ $code = 3 ]; then
  on_ranks "$ranks" resume stopped/restart.h5 || fail "a stopped run does not go on: $(cat stderr)"
  grep -q "^goes on: longer.toml, step" stdout || fail "does not say what goes on: $(head -3 stdout)"
else
  [ $code = 0 ] || fail "a stopped run ends with $code: $(cat stderr)"
fi
diff <(results_of alone) <(results_of stopped) || fail "a stopped run ends otherwise"
diff <(series_of alone) <(series_of stopped) || fail "a stopped run has another series"

# A body whose motion is no number ends the run, and the last good state goes on with shorter steps. The second
# falls by g h^2 n (n + 1) / 2 until the middle of step n: after 1,200 steps it is 1e-45 m from the first, and no
# double holds the force.
cat >lost.toml <<'END'
[materials.rock]
density = 1000
[pair_potential]
law = "lennard_jones"
depth = 1e-3
distance = 0.0625
cutoff = 0.125
[gravity]
uniform = [0, 0, -128]
[[groups]]
name = "held"
material = "rock"
fixed = true
volume = {shape = "sphere", radius = 0.03}
[[groups]]
name = "falling"
material = "rock"
volume = {shape = "sphere", radius = 0.03, center = [0, 1e-45, 87.9638671875]}
[[phases]]
name = "fall"
method = "potential"
step = 0.0009765625
duration = 2
END
on_ranks "$ranks" run lost.toml --out lost && fail "a body without a finite motion is not noticed"
[ "$(wc -l <stderr)" = 1 ] || fail "a lost body: more than a line: $(cat stderr)"
grep -q "^spall: lost.toml:19:1: phases.fall: body 0 has no finite place, velocity or spin any more after step 1200 of phase fall: the step may be too long; 'lost/restart.h5' is the state of step 1000, before" stderr ||
  fail "a lost body: $(cat stderr)"
on_ranks "$ranks" resume lost/restart.h5 --set phases.fall.step=4e-5 || fail "does not go on from before a body was lost: $(cat stderr)"

# A folder belongs to one run.
refuses() {  # what the one line on standard error says; arguments of the program
  local what=$1
  shift
  on_ranks "$ranks" "$@" && fail "not refused: $*"
  [ "$(wc -l <stderr)" = 1 ] || fail "more than a line: $(cat stderr)"
  grep -q "$what" stderr || fail "says '$(cat stderr)', not '$what'"
}
echo "a user's own" >whole/notes.txt
refuses "'whole' holds a run already (.*): choose another folder with --out, or --overwrite it" run small.toml --out whole
refuses "holds a run already" resume often/after_aggregation.h5 --out whole
[ -f whole/results.toml ] || fail "a refused run has lost what was there"
sed 's/restitution = 0.3/restitution = 3/' small.toml >bad.toml
refuses "restitution" run bad.toml --out whole --overwrite
[ -f whole/results.toml ] || fail "a case that is refused has lost what was there"
on_ranks "$ranks" run small.toml --out whole --overwrite || fail "does not overwrite: $(cat stderr)"
[ -f whole/notes.txt ] || fail "removes what it has not written"
[ -f whole/lock ] && fail "a run that is over holds its folder"
sleep 60 &
echo "$(hostname) $!" >whole/lock
refuses "'whole': a run is under way there, by process $! on $(hostname)" run small.toml --out whole --overwrite
kill $!
wait $! 2>/dev/null
echo "elsewhere $!" >whole/lock
refuses "'whole': a run is under way there, by process $! on elsewhere" run small.toml --out whole --overwrite
echo "$(hostname) $!" >whole/lock
on_ranks "$ranks" run small.toml --out whole --overwrite || fail "is kept out by a stale lock: $(cat stderr)"
grep -q "has left 'whole/lock': it is taken over" stderr || fail "does not name a stale lock: $(cat stderr)"

# A run goes on with its own case.
sed 's/friction = /friction = 0/' small.toml >changed && cp small.toml kept.toml && mv changed small.toml
refuses "'small.toml' has changed since" resume whole/after_aggregation.h5
on_ranks "$ranks" resume whole/after_aggregation.h5 --stored-case || fail "resume: $(cat stderr)"
mv kept.toml small.toml

# What --set changed stands in the first file that such a run writes, too, before it has kept a state of its own.
cat >glide.toml <<'END'
[materials.rock]
density = 1000
[contact]
restitution = 0.5
[penalty]
model = "hooke"
stiffness = 1
[gravity]
uniform = [0, 0, -1]
[[groups]]
name = "left"
material = "rock"
volume = {shape = "sphere", radius = 0.1}
[[groups]]
name = "right"
material = "rock"
volume = {shape = "sphere", radius = 0.1, center = [3, 0, 0]}
[[phases]]
name = "fall"
method = "penalty"
step = 0.125
duration = 5
[[phases]]
name = "glide"
step = 0.125
duration = 1
[output]
snapshot_every = 0.3125
END
on_ranks "$ranks" run glide.toml --out glide || fail "a fall: $(cat stderr)"
# Times midway between two steps count at the first of them, and none is lost where steps are made at once.
[ "$(find glide/snapshots -name '*.h5' | wc -l)" = 21 ] || fail "snapshots midway between steps: $(ls glide/snapshots)"
on_ranks "$ranks" resume glide/after_fall.h5 --out pulled --set "gravity.uniform=[0,0,-2]" --set "output.restart_every=1 ns" ||
  fail "a fall by other gravity: $(cat stderr)"
on_ranks "$ranks" resume pulled/after_glide.h5 --set "output.restart_every=1 h" --out over || fail "a run that is over goes on otherwise: $(cat stderr)"
on_ranks "$ranks" resume pulled/restart.h5 --out pulled_on || fail "a fall goes on again: $(cat stderr)"
diff <(series_of pulled) <(series_of pulled_on) || fail "what --set changed is lost on the way"
# What cannot go on leaves what is there.
cp glide/series.csv rows.csv
rm glide/snapshots/000003.h5
refuses "000003.h5' is lost, one of" resume glide/after_fall.h5
cmp glide/series.csv rows.csv || fail "a refused run has cut the series"
refuses "after_meet_before.h5 is the file before that of phases.meet" check glide.toml --set 'phases.fall.name="meet"' 'phases.glide.name="meet_before"'

# The same in penalty contact, whose springs go on too.
sed 's/"30 mm"/"8 mm"/g; s/"16.5 mm"/"6 mm"/; s/duration = ".*"/duration = "2 ms"/' \
  "$cases/column/case.toml" >grains.toml
cat >>grains.toml <<'END'
[[phases]]
name = "later"
method = "penalty"
step = "20 us"
duration = "2 ms"
END
on_ranks "$ranks" run grains.toml --out grains || fail "a run of grains: $(cat stderr)"
grep -q "^residual" grains/results.toml && fail "a run without a solver speaks of residuals"
for run in grains whole; do  # bodies of two ranks touch in both
  [ "$ranks" -eq 2 ] && grep -q "^ghosts_a_body = 0.0 " $run/results.toml && fail "no ghosts in $run"
done
grep -q "^residual" whole/results.toml || fail "a run with a solver does not speak of residuals"
on_ranks "$ranks" resume grains/after_collapse.h5 --out grains_resumed || fail "resume: $(cat stderr)"
diff <(results_of grains) <(results_of grains_resumed) || fail "resumed grains end otherwise"

# What runs write is H5MD, also where bodies are added and space repeats itself.
printf '[periodic]\nlow = ["-20 mm", "-20 mm", 0]\nsize = ["40 mm", "40 mm", 0]\n' >>grains.toml
on_ranks "$ranks" run grains.toml --out periodic || fail "a periodic run: $(cat stderr)"
/usr/bin/python3 "$here/h5md.py" {whole,grains,periodic}/{trajectory.h5,trajectory.xdmf,series.h5,snapshots/*.h5} >stdout ||
  fail "not H5MD: $(cat stdout)"
grep -q "whole/trajectory.h5: .* 4 frames, 41 particles" stdout || fail "no frame at the start: $(cat stdout)"

# Whatever asks a run to stop leaves a restart file. mpirun hands on some signals; at others it warns its
# ranks, asks them a second later to stop, and kills them a second after that; where it begins, after five each.
write_case 's/duration = "2 s"/duration = "1e9 s"/' endless.toml
stop_by() {  # signal, "launcher" or "rank", exit code, seconds that mpirun leaves
  local target launcher code
  OMPI_MCA_odls_base_sigkill_timeout=${4:-1} "$mpiexec" --oversubscribe -n "$ranks" "$spall" run endless.toml --out endless --overwrite >stdout 2>stderr &
  launcher=$!
  wait_for grep -q "^phase meet" stdout || fail "does not say that its phase begins: $(cat stdout stderr)"
  sleep 1  # past the first fiftieth step, which a restart file holds
  target=$launcher
  [ "$2" = launcher ] || target=$(pgrep -P $launcher -x "$(basename "$spall")" | tail -1)
  kill "-$1" "$target"
  if [ "$1" = CONT ]; then
    wait_for test -f endless/restart.h5 || fail "SIGCONT writes no restart file"
    kill -0 "$target" || fail "SIGCONT ends a run"
    kill -USR1 $launcher
  fi
  wait $launcher
  code=$?
  [ $code = "$3" ] || fail "SIG$1 to the $2 ends a run with $code"
  on_ranks "$ranks" check endless/restart.h5 || fail "SIG$1 to the $2 leaves no whole restart file: $(cat stderr)"
}
stop_by TERM launcher 1 5
stop_by XCPU launcher 3
stop_by INT rank 3
stop_by CONT rank 3
stop_by USR2 rank 3
on_ranks "$ranks" check endless/restart.h5 --set seed=2 && fail "a check of a restart file leaves out --set without a word"
on_ranks "$ranks" resume endless/restart.h5 --set "phases.meet.duration=1 s" ||
  fail "a stopped run does not go on: $(cat stderr)"
grep -q "phase meet is over: it has run for" stdout || fail "does not say that its phase is over"
grep -q "^linear" endless/results.toml || fail "a stopped run has no results in the end"

[ $failures -eq 0 ] && echo "all as it should be"
exit $((failures > 0))
