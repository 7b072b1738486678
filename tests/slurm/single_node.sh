#!/usr/bin/env bash
# Runs jobs/cluster.slurm on a Slurm of this machine alone: takes root, slurm-wlm and munge, ten minutes.
# SPDX-License-Identifier: BSD-3-Clause
# usage: single_node.sh [SPALL]    default: build/release/spall
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$here/../../jobs/environment.sh"
source "$here/cluster.sh"

export OMPI_MCA_mpi_yield_when_idle=1 # ranks may have to share a processor
export SPALL=${1:-$PWD/build/release/spall}
job=$PWD/jobs/cluster.slurm
hello=$PWD/cases/hello/case.toml
work=$(mktemp -d)
failures=0
trap 'stop_cluster; rm -rf "$work"' EXIT
start_cluster "$work/slurm" || exit 1
cd "$work" || exit 1

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

passed() {
  echo "ok: $*"
}

# Waits for a condition, for a minute or so many seconds.
wait_for() {
  local tenths=600
  [[ $1 =~ ^[0-9]+$ ]] && tenths=$((10 * $1)) && shift
  for _ in $(seq $tenths); do
    "$@" && return 0
    sleep 0.1
  done
  return 1
}

submit() {  # words for sbatch
  sbatch --parsable --nodes=1 --ntasks-per-node=2 --output=%x_%A_%a.txt "$@"
}

state_of() {
  scontrol --oneliner show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p' | sort -u | tr '\n' ' '
}

is() {  # job, state
  [ "$(state_of "$1")" = "$2 " ]
}

# Slurm lets a job wait for two minutes in which its last turn might still be ending.
begin_again() {  # job
  wait_for is "$1" PENDING || return 1
  scontrol update JobId="$1" StartTime=now
}

runs() {  # folder
  [ -f "$1/series.csv" ] && [ "$(wc -l <"$1/series.csv")" -gt 100 ]
}

results_of() {
  sed '/^\[time\]/,$d' "$1/results.toml"
}

same() {  # name, folder, folder
  if diff <(results_of "$2") <(results_of "$3") >difference; then passed "$1: the results of the run left alone"; else
    fail "$1: other results: $(head -5 difference)"
  fi
}

small='s/count = 300/count = 40/; s/radius = "10 m"/radius = "6 m"/'
sed "$small; "'s/step = "10 s"/step = "2 s"/' "$hello" >case.toml
sed "$small; "'s/step = "10 s"/step = "0.5 s"/' "$hello" >longer.toml

name="a run that is left alone"
id=$(submit "$job" case.toml alone)
wait_for 200 is "$id" COMPLETED && passed "$name: $(state_of "$id")" || fail "$name: $(state_of "$id")"

name="a turn that is ended by SIGTERM"
id=$(submit "$job" case.toml signalled)
wait_for runs signalled
scancel --signal=TERM "$id"
begin_again "$id" && passed "$name: requeued" || fail "$name: $(state_of "$id")"
wait_for 200 is "$id" COMPLETED || fail "$name: $(state_of "$id")"
grep -q "^goes on: case.toml" spall_"${id}"_*.txt && passed "$name: goes on" || fail "$name: starts over"
same "$name" alone signalled

name="a job whose run is over"
before=$(stat -c %Y signalled/results.toml)
id=$(submit "$job" case.toml signalled)
wait_for is "$id" COMPLETED && [ "$(stat -c %Y signalled/results.toml)" = "$before" ] && passed "$name does nothing" ||
  fail "$name: $(state_of "$id")"

name="a newest file that is broken"
mkdir -p broken && cp signalled/restart.h5 broken/restart_before.h5 && head -c 5000 signalled/restart.h5 >broken/restart.h5
id=$(submit "$job" case.toml broken)
wait_for 200 is "$id" COMPLETED || fail "$name: $(state_of "$id")"
grep -q "'broken/restart.h5' is not a whole restart file" spall_"${id}"_*.txt || fail "$name: is not named"
same "$name" alone broken
mkdir -p lost && head -c 5000 signalled/restart.h5 >lost/restart.h5
id=$(submit "$job" case.toml lost)
wait_for is "$id" FAILED && [ -f lost/restart.h5 ] && passed "no whole file: it fails, nothing is overwritten" ||
  fail "no whole file: $(state_of "$id")"

name="a turn that is killed"
id=$(submit "$job" case.toml killed --set "output.restart_every=1 s")
wait_for test -f killed/restart.h5
scancel --signal=KILL "$id"
id=$(submit --dependency="afterany:$id" "$job" case.toml killed)
wait_for 200 is "$id" COMPLETED || fail "$name, the next job: $(state_of "$id")"
same "$name" alone killed

name="a job that is cancelled"
id=$(submit "$job" case.toml cancelled)
wait_for runs cancelled
scancel "$id"
sleep 5
is "$id" CANCELLED && passed "$name stays so" || fail "$name: $(state_of "$id")"

name="an array"
id=$(submit --array=1-2 --ntasks-per-node=1 "$job" longer.toml seeds)
wait_for runs seeds_1 && wait_for runs seeds_2
scancel --signal=TERM "$id"
begin_again "${id}_1" && begin_again "${id}_2" || fail "$name: $(state_of "$id")"
wait_for 200 is "$id" COMPLETED && passed "$name: all over" || fail "$name: $(state_of "$id")"
cmp -s <(results_of seeds_1) <(results_of seeds_2) && fail "$name: two seeds have the same results"

name="a sweep"
id=$(submit --array=1-2 --ntasks-per-node=1 "$job" sweep case.toml --set phases.impact.cohesion=100,500N --out swept)
wait_for 200 is "$id" COMPLETED || fail "$name: $(state_of "$id")"
"$SPALL" sweep case.toml --set phases.impact.cohesion=100,500N --out swept --table >said 2>&1 && [ "$(wc -l <swept/table.csv)" = 3 ] &&
  passed "$name: $(head -1 said)" || fail "$name: $(cat said)"

name="a chain"
for turn in 1 2 3; do ids[turn]=$(submit --no-requeue --job-name=chain --dependency=singleton "$job" case.toml chain); done
wait_for runs chain
scancel --signal=TERM "${ids[1]}"
wait_for 200 is "${ids[3]}" COMPLETED || fail "$name: $(state_of "${ids[3]}")"
passed "$name: $(for turn in 1 2 3; do state_of "${ids[turn]}"; done)"
same "$name" alone chain

# Time that is over: a minute is the shortest that Slurm knows.
name="a time limit"
id=$(submit --time=1 --signal=TERM@20 "$job" longer.toml limit)
wait_for runs limit
wait_for 150 is "$id" PENDING && passed "$name: requeued" ||
  fail "$name: $(state_of "$id")"
scontrol update JobId="$id" TimeLimit=10 StartTime=now
wait_for 300 is "$id" COMPLETED && passed "$name: $(state_of "$id")" || fail "$name: $(state_of "$id")"
grep -q "^goes on: longer.toml" spall_"${id}"_*.txt || fail "$name: starts over"

# Signals: what each leaves behind.
for to in step srun; do
  for number in TERM INT HUP USR1 USR2 XCPU; do
    # srun takes these for itself and kills its tasks at once, or dies.
    [ $to = srun ] && [[ TERM,INT,HUP,XCPU =~ $number ]] && continue
    rm -rf signals
    srun --mpi=pmix --ntasks=2 "$SPALL" run longer.toml --out signals >said 2>&1 &
    launcher=$!
    wait_for runs signals
    if [ $to = srun ]; then kill -$number $launcher; else scancel --signal=$number "$(squeue -h -o %i -t running)"; fi
    wait $launcher
    code=$?
    [ $code = 3 ] && srun --mpi=pmix --ntasks=2 "$SPALL" check signals/restart.h5 >said 2>&1 &&
      passed "SIG$number to $to: code 3, $(cat said)" || fail "SIG$number to $to: code $code: $(cat said)"
  done
done

[ $failures -eq 0 ] && echo "all as it should be"
exit $((failures > 0))
