# Sourced after support.sh: munged, slurmctld and one slurmd with two cores, as the user who runs the test, with keys, ports,
# logs and folders of their own below the work folder. Nothing of a Slurm that the machine may have is read or changed.

# free_ports COUNT: numbers of TCP ports that nobody listens on.
free_ports() {
    python3 - "$1" << 'END'
import socket, sys
sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(int(sys.argv[1]))]
print(*(s.getsockname()[1] for s in sockets))
END
}

# No accounting, no cgroups, and no user but this one: what a login node needs an administrator for.
write_slurm_conf() {
    local node ports
    node="$(hostname -s)"
    read -r -a ports < <(free_ports 2)
    cat > slurm.conf << END
ClusterName=lamella
SlurmctldHost=$node(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmdPort=${ports[1]}
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$engine/munge.socket
SlurmctldPidFile=$engine/slurmctld.pid
SlurmdPidFile=$engine/slurmd.pid
StateSaveLocation=$engine/state
SlurmdSpoolDir=$engine/spool
SlurmctldLogFile=$engine/slurmctld.log
SlurmdLogFile=$engine/slurmd.log
ReturnToService=2
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SwitchType=switch/none
JobRequeue=1
KillWait=10
SchedulerParameters=batch_sched_delay=0,sched_interval=1
NodeName=$node NodeAddr=127.0.0.1 CPUs=2 RealMemory=2000 State=UNKNOWN
PartitionName=test Nodes=$node Default=YES MaxTime=INFINITE State=UP
END
}

start_slurm() {
    engine="$work/engine"
    mkdir -m 755 "$engine"
    mkdir -m 700 "$engine/state" "$engine/spool" "$engine/key"
    head -c 1024 /dev/urandom > "$engine/key/munge.key"
    chmod 600 "$engine/key/munge.key"
    write_slurm_conf
    export SLURM_CONF="$work/slurm.conf"
    # --force: whoever runs it, and whoever may write to the folders above.
    start munged /usr/sbin/munged --foreground --force --key-file="$engine/key/munge.key" --socket="$engine/munge.socket" \
        --pid-file="$engine/munged.pid" --seed-file="$engine/key/seed"
    wait_for 20 "munged" test -S "$engine/munge.socket"
    start slurmctld /usr/sbin/slurmctld -D
    wait_for 30 "slurmctld" scontrol ping
    start slurmd /usr/sbin/slurmd -D
    wait_for 30 "an idle node" eval '[[ "$(sinfo --noheader --format=%t)" == idle ]]'
}

# state_of JOB: PENDING, RUNNING, COMPLETED, ...
state_of() { scontrol --oneliner show job "$1" | sed -n 's/.* JobState=\([A-Z_]*\).*/\1/p' | head -n 1; }

# start_again JOB [SECONDS]: waits so long for it to be requeued. Slurm lets a requeued job wait for two minutes, so that no part of it is left that would refuse its return. Here
# some seconds do.
start_again() {
    wait_for "${2:-60}" "$1 to be pending" eval "[[ \$(state_of $1) == PENDING ]]"
    sleep 3
    scontrol update "JobId=$1" StartTime=now
}

# Tasks of jobs that are still there end with the engine.
stop_slurm() {
    scancel --user="$(id -un)" > /dev/null 2>&1 || true
    wait_for 60 "the jobs' end" eval '[[ -z "$(squeue --noheader)" ]]'
}
