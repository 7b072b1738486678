# Sourced: a Slurm of one node that lives in a folder and leaves the machine's own alone. Takes root.
# SPDX-License-Identifier: BSD-3-Clause
#   start_cluster FOLDER [CPUS]    exports SLURM_CONF; stop_cluster ends what it started

start_cluster() {
  local home=$1 cpus=${2:-4} node
  node=$(hostname -s)
  mkdir -p "$home/state" "$home/spool"
  chmod 755 "$home"
  head -c 1024 /dev/urandom >"$home/munge.key"
  chmod 600 "$home/munge.key"
  # Processors are told, not counted: jobs wait for each other even on a small machine.
  cat >"$home/slurm.conf" <<END
ClusterName=spall
SlurmctldHost=$node
SlurmUser=root
SlurmctldPort=16817
SlurmdPort=16818
AuthType=auth/munge
AuthInfo=socket=$home/munge.socket
StateSaveLocation=$home/state
SlurmdSpoolDir=$home/spool
SlurmctldPidFile=$home/slurmctld.pid
SlurmdPidFile=$home/slurmd.pid
SlurmctldLogFile=$home/slurmctld.log
SlurmdLogFile=$home/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=30
MinJobAge=300
NodeName=$node CPUs=$cpus State=UNKNOWN
PartitionName=one Nodes=$node Default=YES MaxTime=INFINITE State=UP
END
  export SLURM_CONF=$home/slurm.conf
  munged --foreground --force --key-file="$home/munge.key" --socket="$home/munge.socket" --log-file="$home/munged.log" \
    --pid-file="$home/munged.pid" --seed-file="$home/munged.seed" --num-threads=1 2>"$home/munged.err" &
  daemons=$!
  sleep 1
  slurmctld -D 2>"$home/slurmctld.err" &
  daemons+=" $!"
  slurmd -D 2>"$home/slurmd.err" &
  daemons+=" $!"
  for _ in $(seq 50); do
    [ -n "$(sinfo -h -t idle -o %n 2>/dev/null)" ] && return
    sleep 0.5
  done
  echo "Slurm does not start:" >&2
  tail -n 5 "$home"/*.log "$home"/*.err >&2
  return 1
}

stop_cluster() {
  scancel --full --signal=KILL --state=RUNNING 2>/dev/null
  sleep 1
  kill ${daemons:-} 2>/dev/null
  wait ${daemons:-} 2>/dev/null
}
