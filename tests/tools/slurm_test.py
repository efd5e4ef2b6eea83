#!/usr/bin/env python3
"""A morph as an array of tasks of Slurm, on a cluster of this one machine, with tasks that are killed.

usage: slurm_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

Needs root and Debian's slurmctld, slurmd, slurm-client and munge; skipped, with a message, where these are not there.
"""
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, named_cases, run_cases
from frames import sums

if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, REPOSITORY, ONLY = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3:]
SCRIPT = os.path.join(REPOSITORY, "tools/farm/slurm_morph.sh")
DIE, OCTAHEDRON = (os.path.join(REPOSITORY, "assets", name) for name in ("die.ply", "octahedron.ply"))
WORDS = [DIE, OCTAHEDRON, "--resolution", "48", "--slices", "16", "--samples", "32", "--frames", "9", "--start", "1001"]
CONFIG = """ClusterName=one
SlurmctldHost={host}(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser=root
SlurmctldPort={port}
SlurmdPort={second}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
MailProg=/bin/true
MpiDefault=none
SchedulerParameters=sched_interval=1,bf_interval=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    holders = [socket.socket() for _ in range(count)]
    for holder in holders:
        holder.bind(("127.0.0.1", 0))
    ports = [holder.getsockname()[1] for holder in holders]
    for holder in holders:
        holder.close()
    return ports


class Cluster:
    """A cluster of this one machine, in a folder of its own."""

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="slicemorph-slurm-")
        host = socket.gethostname().split(".")[0]
        port, second = free_ports(2)
        for name in ("state", "spool"):
            os.mkdir(os.path.join(self.folder, name))
        config = os.path.join(self.folder, "slurm.conf")
        with open(config, "w") as file:
            file.write(CONFIG.format(host=host, folder=self.folder, port=port, second=second, cores=os.cpu_count()))
        self.environment = dict(os.environ, SLURM_CONF=config, SLICEMORPH=PROGRAM)
        path = lambda name: os.path.join(self.folder, name)
        self.call("mungekey", "-k", path("key"))
        self.call("munged", "--force", "--socket", path("munge.socket"), "--key-file", path("key"), "--pid-file", path("munged.pid"),
                  "--log-file", path("munged.log"), "--seed-file", path("seed"))
        self.call("slurmctld")
        self.call("slurmd", "-N", host)
        for _ in range(300):
            if "idle" in subprocess.run(["sinfo", "-h", "-o", "%T"], env=self.environment, capture_output=True, text=True).stdout:
                return self
            time.sleep(0.1)
        self.__exit__()
        raise Skip("Slurm does not start on this machine")

    def __exit__(self, *_):
        for name in ("slurmd", "slurmctld", "munged"):
            try:
                os.kill(int(open(os.path.join(self.folder, name + ".pid")).read()), signal.SIGKILL)
            except (OSError, ValueError):
                pass
        shutil.rmtree(self.folder, ignore_errors=True)

    def call(self, *words, cwd=None, code=0):
        result = subprocess.run(list(map(str, words)), env=self.environment, cwd=cwd, capture_output=True, text=True, timeout=300)
        assert result.returncode == code, "%s: exit %d\n%s%s" % (" ".join(map(str, words)), result.returncode, result.stdout, result.stderr)
        return result

    def busy(self):
        """Whether a job waits or runs. Jobs that are queued again wait for two minutes, which are not waited for here."""
        jobs = subprocess.run(["squeue", "-h", "-o", "%i %r"], env=self.environment, capture_output=True, text=True).stdout.split("\n")
        for job in jobs:
            if job.endswith(" BeginTime"):
                subprocess.run(["scontrol", "update", "JobId=" + job.split()[0], "StartTime=now"], env=self.environment)
        return any(jobs)


def makers(o):
    """Processes that make frames in a folder."""
    found = []
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            words = open("/proc/%s/cmdline" % process, "rb").read().split(b"\0")
            if words[0] == PROGRAM.encode() and b"--range" in words and os.readlink("/proc/%s/cwd" % process) == o:
                found.append(int(process))
        except (OSError, IndexError):
            pass
    return found


def case_an_array_of_tasks(o):
    """The same bytes as from one process, a report of all frames and a sheet; also when tasks are killed at any time."""
    whole = os.path.join(o, "whole")
    os.mkdir(whole)
    subprocess.run([PROGRAM, "morph", *WORDS, "-o", "m.####.vdb", "--report", "r.json", "--quiet"], cwd=whole, check=True, timeout=300)
    wanted = sums(whole, ".vdb")
    assert len(wanted) == 9
    times = random.Random(7)
    with Cluster() as cluster:
        for kills in ((0, 3) if os.environ.get("SLICEMORPH_ALL_TESTS") else (2,)):
            farm = os.path.join(o, "farm%d" % kills)
            os.mkdir(farm)
            cluster.call("bash", SCRIPT, "--tasks", 3, "--report", "r.json", "--sheet", "sheet.png", "--", *WORDS, "-o", "m.####.vdb", cwd=farm)
            killed, end = 0, time.time() + 250
            while cluster.busy():
                assert time.time() < end, subprocess.run(["squeue"], env=cluster.environment, capture_output=True, text=True).stdout
                running = makers(farm)
                if killed < kills and running:
                    time.sleep(times.uniform(0, 0.5))
                    for process in makers(farm)[:1]:
                        os.kill(process, signal.SIGKILL)
                        killed += 1
                time.sleep(0.05)
            assert sums(farm, ".vdb") == wanted, (sorted(os.listdir(farm)), kills)
            assert sorted(os.listdir(farm)) == sorted([*wanted, "r.json", "sheet.png"]), os.listdir(farm)
            figures = lambda folder: [[frame[key] for key in ("frame", "volume", "area")]
                                     for frame in json.load(open(os.path.join(folder, "r.json")))["frames"]]
            assert figures(farm) == figures(whole), figures(farm)
            assert kills == 0 or killed > 0


def case_wrong_words(o):
    for words, said in ((["--tasks", "0", "--", "a", "b"], "--tasks 0"), (["--", DIE, OCTAHEDRON, "-o", "m.vdb"], "####"),
                        (["a", "b"], "behind --"), (["--", "a.####.vdb", "b", "-o", "m.####.vdb"], "need --frames"),
                        (["--", "a", "b", "-o", "m.####.vdb", "--resume"], "--resume")):
        result = subprocess.run(["bash", SCRIPT, *words], cwd=o, env=dict(os.environ, SLICEMORPH=PROGRAM), capture_output=True, text=True)
        assert result.returncode == 2 and said in result.stderr, (words, result)
        assert not os.listdir(o)


if os.getuid() or not all(map(shutil.which, ("slurmctld", "slurmd", "sbatch", "munged", "mungekey"))):
    print("SKIPPED: needs root, slurmctld, slurmd, slurm-client and munge")
    sys.exit(0)
sys.exit(run_cases(named_cases(globals()), ONLY))
