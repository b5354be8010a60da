# SPDX-License-Identifier: Apache-2.0
"""Runs a private Slurm on loopback for a test: munged, slurmctld and some slurmd as child processes of this machine,
each with its own name and port. It needs root, because slurmd starts tasks as their users, and Debian's packages
slurmctld, slurmd, slurm-client and munge. Uses only the standard library."""
import contextlib
import ctypes
import os
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol", "sinfo")
PATH = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
PR_SET_CHILD_SUBREAPER = 36

CONFIG = """
ClusterName=multum
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge/munge.socket,cred_expire=5
SlurmctldPort={port}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmctldLogFile={folder}/log/slurmctld.log
StateSaveLocation={folder}/state
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmdLogFile={folder}/log/slurmd.%n.log
SlurmdSpoolDir={folder}/spool/%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_min_interval=20000,bf_interval=1,default_queue_depth=1000
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
PriorityType=priority/basic
ReturnToService=2
MpiDefault=none
SlurmdParameters=config_overrides
SlurmctldTimeout=30
SlurmdTimeout=10
InactiveLimit=0
MinJobAge=300
KillWait=2
MessageTimeout=5
MaxJobCount=20000
RebootProgram=/bin/false
"""


def why_not():
    """Returns why no Slurm can be started here, or "" if it can."""
    if os.geteuid() != 0:
        return "only root can start Slurm"
    missing = [name for name in PROGRAMS if shutil.which(name, path=PATH) is None]
    return f"Slurm is not installed: no {', '.join(missing)}" if missing else ""


def free_ports(count):
    """Returns a loopback port that is free at this moment."""
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


def descendants(pid):
    """Returns the process numbers of all descendants of a process."""
    found = []
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        for task in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{task}/children", encoding="utf-8") as file:
                for child in map(int, file.read().split()):
                    found += [child, *descendants(child)]
    return found


class Slurm:
    """`nodes` is the number of nodes on this machine, named bake1 and so on, with `cpus` processors each. `more` holds
    lines of slurm.conf."""

    def __init__(self, folder, nodes=2, cpus=1, more=""):
        self.folder = folder
        self.nodes = [f"bake{i + 1}" for i in range(nodes)]
        self.processes = {}
        # Processes that outlive Slurm's daemons become children of this process, which ends them by their process ids.
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
        for name in ("state", "log", "spool"):
            os.makedirs(os.path.join(folder, name))
        os.makedirs(os.path.join(folder, "munge"), mode=0o700)
        self.key = os.path.join(folder, "munge", "munge.key")
        with open(os.open(self.key, os.O_WRONLY | os.O_CREAT, 0o600), "wb") as file:
            file.write(os.urandom(1024))
        ports = free_ports(nodes + 1)
        config = CONFIG.format(folder=folder, port=ports[0]) + more
        for name, port in zip(self.nodes, ports[1:]):
            config += (f"NodeName={name} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} CPUs={cpus} Boards=1 "
                       f"SocketsPerBoard=1 CoresPerSocket={cpus} ThreadsPerCore=1 RealMemory=8000 State=UNKNOWN\n")
        config += "PartitionName=bake Nodes=ALL Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO\n"
        self.config = os.path.join(folder, "slurm.conf")
        with open(self.config, "w", encoding="utf-8") as file:
            file.write(config)
        if not os.path.ismount("/sys/fs/cgroup"):  # slurmd reads the cgroup version there, and would end without it
            with open(os.path.join(folder, "cgroup.conf"), "w", encoding="utf-8") as file:
                file.write("CgroupPlugin=cgroup/v1\n")
        self.environment = {"SLURM_CONF": self.config, "PATH": PATH}

    def start(self):
        munge = os.path.join(self.folder, "munge")
        os.chmod(self.folder, 0o755)
        self.begin("munged", "munged", "--foreground", "--force", f"--key-file={self.key}",
                   f"--socket={munge}/munge.socket", f"--pid-file={munge}/munged.pid",
                   f"--log-file={munge}/munged.log", f"--seed-file={munge}/seed", "--num-threads=4")
        self.wait_until("munged listens", lambda: os.path.exists(f"{munge}/munge.socket"))
        self.start_controller()
        for node in self.nodes:
            self.start_node(node)
        self.wait_for_nodes()
        return self

    def begin(self, name, *words):
        with open(os.path.join(self.folder, "log", name + ".said"), "ab") as said:
            self.processes[name] = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                                                    env=dict(os.environ, **self.environment))

    def start_controller(self):
        self.begin("slurmctld", "slurmctld", "-D", "-f", self.config)

    def start_node(self, node):
        self.begin(node, "slurmd", "-D", "-f", self.config, "-N", node)

    def wait_until(self, what, is_so, timeout=30):
        deadline = time.monotonic() + timeout
        while not is_so():
            assert time.monotonic() < deadline, f"not within {timeout} s: {what}\n{self.said()}"
            time.sleep(0.05)

    def said(self):
        """Returns the ends of all logs."""
        text = ""
        for name in sorted(os.listdir(os.path.join(self.folder, "log"))):
            with open(os.path.join(self.folder, "log", name), encoding="utf-8", errors="replace") as file:
                text += f"--- {name}\n{file.read()[-600:]}\n"
        return text

    def run(self, *words):
        """Returns the output of a Slurm command, or "" if it fails."""
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=60,
                              env=dict(os.environ, **self.environment))
        return done.stdout if done.returncode == 0 else ""

    def node_states(self):
        return sorted(self.run("sinfo", "-h", "-N", "-o", "%N %T").split("\n")[:-1])

    def wait_for_nodes(self):
        wanted = [f"{node} idle" for node in self.nodes]
        self.wait_until("all nodes idle", lambda: self.node_states() == wanted)

    def jobs(self, states=""):
        """Returns the rows of squeue's list: number, name, state, node."""
        words = ["squeue", "-h", "--array", "-o", "%i %j %T %N"] + ([f"--states={states}"] if states else [])
        return self.run(*words).splitlines()

    def kill(self, name):
        """Sends SIGKILL to one of the daemons. The tasks of a node continue to run."""
        process = self.processes[name]
        process.send_signal(signal.SIGKILL)
        process.wait()

    def crash_node(self, node):
        """Ends the daemon of a node and all of its tasks, as a power cut would."""
        doomed = []
        for pid in descendants(os.getpid()):
            with contextlib.suppress(FileNotFoundError, ProcessLookupError):
                with open(f"/proc/{pid}/environ", encoding="utf-8", errors="replace") as file:
                    is_task = f"SLURMD_NODENAME={node}" in file.read().split("\0")
                with open(f"/proc/{pid}/cmdline", encoding="utf-8", errors="replace") as file:
                    is_starter = file.read().startswith("slurmstepd:") and self.starter_node(pid) == node
                if is_task or is_starter:
                    doomed.append(pid)
        self.kill(node)
        for pid in doomed:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def return_node(self, node):
        """Starts a crashed node again. Slurm must first know that the node is down, otherwise its tasks stay
        "completing" for minutes."""
        self.run("scontrol", "update", f"NodeName={node}", "State=DOWN", "Reason=crashed")
        self.start_node(node)
        self.run("scontrol", "update", f"NodeName={node}", "State=RESUME")

    def starter_node(self, pid):
        """Returns the number of a slurmstepd, found by a task that it has started."""
        for child in descendants(pid):
            with contextlib.suppress(FileNotFoundError, ProcessLookupError):
                with open(f"/proc/{child}/environ", encoding="utf-8", errors="replace") as file:
                    for word in file.read().split("\0"):
                        if word.startswith("SLURMD_NODENAME="):
                            return word.split("=")[1]
        return ""

    def stop(self):
        """Ends every process of this Slurm by its number."""
        if self.processes.get("slurmctld") and self.processes["slurmctld"].poll() is None:
            self.run("scancel", "--user=root")
            with contextlib.suppress(AssertionError):
                self.wait_until("no jobs", lambda: not self.jobs(), timeout=5)
        for name in reversed(list(self.processes)):
            process = self.processes[name]
            if process.poll() is None:
                process.terminate()
        for process in self.processes.values():
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.reap()

    def reap(self):
        """Ends processes that Slurm's daemons left behind. They have become children of this process."""
        for _ in range(100):
            left = [pid for pid in descendants(os.getpid()) if self.is_of_slurm(pid)]
            if not left:
                return
            for pid in left:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
                with contextlib.suppress(ChildProcessError):
                    os.waitpid(pid, os.WNOHANG)
            time.sleep(0.02)

    def is_of_slurm(self, pid):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
                if file.read().rsplit(")", 1)[1].split()[0] == "Z":
                    return True
            with open(f"/proc/{pid}/environ", encoding="utf-8", errors="replace") as file:
                words = file.read().split("\0")
            with open(f"/proc/{pid}/cmdline", encoding="utf-8", errors="replace") as file:
                command = file.read()
            return f"SLURM_CONF={self.config}" in words or command.startswith("slurmstepd:")
        return False
