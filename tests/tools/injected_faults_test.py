#!/usr/bin/env python3
"""What the program leaves behind where the machine fails it: writes that fail one by one, a disk that stays full, files that
vanish or shrink while they are read, clocks that jump, signals, and too little memory.

usage: injected_faults_test.py PATH/TO/slicemorph PATH/TO/libfault_calls.so REPOSITORY [NAME...]
       (NAME: only the cases whose name contains it)

Whatever happens, the exit code is 0, 1 or 2, a failure is told with the file's name and the system's reason, every file has its
old content or its new one, nothing half written lies beside it, and --resume goes on to the same bytes. The oracle are the bytes
of a run in which nothing fails. A part is run, chosen by a fixed seed; with SLICEMORPH_ALL_TESTS=1 all (tools/dev/inject_faults.sh).
"""
import io
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

import pydicom

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import run_within

if len(sys.argv) < 4:
    sys.exit(__doc__)
PROGRAM, LIBRARY = map(os.path.abspath, sys.argv[1:3])
ASSETS = os.path.abspath(sys.argv[3]) + "/assets"
ALL = os.environ.get("SLICEMORPH_ALL_TESTS") == "1"
chance = random.Random(23)

# A disk that is full, or whose quota is used up, stays so; a read or write error may be the only one.
ERRORS, STAYING = {"ENOSPC": 28, "EIO": 5, "EDQUOT": 122}, ("ENOSPC", "EDQUOT")
WRITES = ("open", "write", "writev", "pwrite", "fwrite", "fsync", "ftruncate", "close", "rename", "mkdir", "pread")
READS = ("open", "read", "pread", "fread", "mmap")
OLD = b"what was there before\n"
INPUTS = {}  # made once, see make_inputs

SDF = ["--method", "sdf"]
MORPH = ["morph", "{i}/a.vdb", "{i}/b.vdb", *SDF, "--frames", "2", "-o"]
MESH = ["convert", "{i}/a.ply", "--resolution", "16", "-o"]
# Each kind of output by its smallest job: the words, and the files that it writes. {i}: inputs, {o}: outputs.
JOBS = {
    "vdb": (MORPH + ["{o}/m.####.vdb"], ["m.0001.vdb", "m.0002.vdb"]),
    "nvdb": (MORPH + ["{o}/m.####.nvdb"], ["m.0001.nvdb", "m.0002.nvdb"]),
    "obj": (MESH + ["{o}/m.obj"], ["m.obj"]),
    "ply": (MORPH + ["{o}/m.####.ply"], ["m.0001.ply", "m.0002.ply"]),
    "stl": (MESH + ["{o}/m.stl"], ["m.stl"]),
    "glb": (MORPH + ["{o}/m.glb"], ["m.glb"]),
    "vtp": (MESH + ["{o}/m.vtp"], ["m.vtp"]),
    "usda": (MORPH + ["{o}/m.usda"], ["m.usda", "m.0001.vdb", "m.0002.vdb"]),
    "png": (MORPH + ["{o}/m.####.png", "--size", "32x32"], ["m.0001.png", "m.0002.png"]),
    "exr": (MORPH + ["{o}/m.####.exr", "--size", "32x32"], ["m.0001.exr", "m.0002.exr"]),
    "slices": (["slice", "{i}/a.vdb", "--slices", "3", "-o", "{o}/s.####.exr"], ["s.0001.exr", "s.0002.exr", "s.0003.exr"]),
    "nii.gz": (MESH + ["{o}/m.nii.gz"], ["m.nii.gz"]),
    "nrrd": (MESH + ["{o}/m.nrrd"], ["m.nrrd"]),
    "mha": (MESH + ["{o}/m.mha"], ["m.mha"]),
    "seg.nrrd": (MESH + ["{o}/m.seg.nrrd"], ["m.seg.nrrd"]),
    "seg.dcm": (MESH + ["{o}/m.seg.dcm"], ["m.seg.dcm"]),
    "rt.dcm": (MESH + ["{o}/m.rt.dcm"], ["m.rt.dcm"]),
    "report": (["morph", "{i}/a.vdb", "{i}/b.vdb", *SDF, "--at", "0.5", "-o", "{o}/m.vdb", "--report", "{o}/r.json", "--report",
                "{o}/r.csv"], ["m.vdb", "r.json", "r.csv"]),
    # Long enough to be interrupted.
    "frames": (["morph", "{i}/a.vdb", "{i}/b.vdb", *SDF, "--frames", "16", "-o", "{o}/m.####.vdb"], ["m.%04d.vdb" % n for n in range(1, 17)]),
    "plan": (["plan", "{i}/a.vdb", "{i}/b.vdb", "--slices", "12", "--samples", "24", "-o", "{o}/x.plan"], ["x.plan"]),
}
# They tell when they were made or how long that took, so that two runs differ.
DATED = ("seg.dcm", "rt.dcm", "r.json", "r.csv")
# Inputs of each kind, read while they vanish or change.
READERS = {name: ["info" if name.endswith(".plan") else "convert", "{i}/" + name, *([] if name.endswith(".plan") else ["-o", "{o}/m.vdb"])]
           for name in ("a.vdb", "a.ply", "a.obj", "a.stl", "a.glb", "a.nii.gz", "a.nrrd", "a.mha", "a.seg.dcm", "a.rt.dcm")}
for name in READERS:
    if name.split(".")[1] in ("ply", "obj", "stl", "glb"):
        READERS[name] += ["--resolution", "16"]
READERS["a.rt.dcm"][0] = "reconstruct"


class Outcome:
    """What a run left: exit code, message, files, how often each call was made."""
    def __init__(self, code, message, folder, counts):
        self.code, self.message, self.counts = code, message, counts
        self.files = {name: open(os.path.join(folder, name), "rb").read() for name in sorted(os.listdir(folder))
                      if os.path.isfile(os.path.join(folder, name))}


class Place:
    """A folder with `o` for outputs (holding older files of their names) and `t` for scratch, where one job runs."""
    def __init__(self, words, files=(), inputs=None):
        self.top = tempfile.mkdtemp(prefix="slicemorph-fault-")
        self.o, self.t = self.top + "/o", self.top + "/t"
        os.mkdir(self.o), os.mkdir(self.t)
        self.i = inputs or INPUTS["folder"]
        self.words = [w.format(i=self.i, o=self.o) for w in words]
        for name in files:
            with open(os.path.join(self.o, name), "wb") as file:
                file.write(OLD)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.top)

    def start(self, more=(), fault=None, limit=None, folder=None):
        env = dict(os.environ, TMPDIR=self.t)
        if fault is not None:
            env.update(LD_PRELOAD=LIBRARY, FAULT_FOLDER=folder or self.top + "/", FAULT_COUNTS=os.path.join(self.i, "..", os.path.basename(self.top)),
                       **{"FAULT_" + k: str(v) for k, v in fault.items()})
        return subprocess.Popen([PROGRAM, *self.words, *(["--threads", "1"] if len(self.words) > 1 else []), *more], env=env, cwd=self.t, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, preexec_fn=limit)

    def run(self, more=(), fault=None, limit=None, folder=None):
        process = self.start(more, fault, limit, folder)
        message = process.communicate(timeout=300)[1].decode(errors="replace")
        counts, path = {}, os.path.join(self.i, "..", os.path.basename(self.top))
        if fault is not None and os.path.exists(path):
            counts = {k: int(v) for k, v in (line.split() for line in open(path))}
            os.remove(path)
        return Outcome(process.returncode, message, self.o, counts)


def make_inputs():
    """One small shape as a file of each format, and another to morph into."""
    if INPUTS:
        return
    top = tempfile.mkdtemp(prefix="slicemorph-fault-inputs-")
    INPUTS["top"], INPUTS["folder"] = top, top + "/i"
    os.mkdir(INPUTS["folder"])
    for source, name in (("octahedron", "a"), ("die", "b")):
        for ending in ("vdb", "ply", "obj", "stl", "glb", "nii.gz", "nrrd", "mha", "seg.dcm", "rt.dcm"):
            if name == "a" or ending == "vdb":
                subprocess.run([PROGRAM, "convert", "%s/%s.ply" % (ASSETS, source), "--resolution", "16", "--quiet", "-o",
                                "%s/i/%s.%s" % (top, name, ending)], check=True)


def same(name, got, want):
    """Whether a file is whole: the same bytes; of a dated one the same elements, of a report as many lines and its end."""
    if name.startswith("r."):
        return got.count(b"\n") == want.count(b"\n") and got[-2:] == want[-2:]
    return elements(got) == elements(want) if name.endswith(DATED) else got == want


def elements(content):
    """Tags and lengths of a DICOM file's elements, and the values of those that no date, no time and no identifier is in."""
    try:
        data = pydicom.dcmread(io.BytesIO(content))
    except pydicom.errors.InvalidDicomError:
        return None
    return [(e.tag, None if e.VR in ("UI", "DA", "TM", "SQ") else e.value) for e in data.iterall()]


def clean(kind):
    """What a job makes where nothing fails."""
    if ("clean", kind) not in INPUTS:
        words, files = JOBS[kind]
        with Place(words) as place:
            result = place.run(fault={})
        assert result.code == 0, "%s: exit %d: %s" % (words, result.code, result.message)
        assert set(result.files) == set(files), (words, sorted(result.files))
        INPUTS["clean", kind] = result
    return INPUTS["clean", kind]


def check_files(result, files, want, what, hidden=()):
    """Old or new, and nothing beside them; `hidden`: names that may be there, too (the log that --resume reads)."""
    for name, content in result.files.items():
        if name in files:
            assert content == OLD or same(name, content, want.files[name]), "%s: %s is half written (%d of %d bytes)" % (
                what, name, len(content), len(want.files[name]))
        else:
            assert any(re.fullmatch(pattern, name) for pattern in hidden), "%s: left %s" % (what, name)
    for name in files:
        assert name in result.files, "%s: %s, which was there before, is gone" % (what, name)


def check_resumed(place, words, files, want, what):
    """A sequence goes on, with nothing failing any more."""
    if words[0] != "morph" or "####" not in " ".join(words):
        return
    again = place.run(["--resume"])
    assert again.code == 0, "%s: then exit %d: %s" % (what, again.code, again.message)
    assert set(again.files) == set(files), "%s: then there are %s" % (what, sorted(again.files))
    for name in files:
        assert same(name, again.files[name], want.files[name]), "%s: then %s has other bytes" % (what, name)


LOG = (r"\..*\.slicemorph",)


def failed_write(kind, words, files, want, call, nth, error):
    stays = error in STAYING
    what = "%s, %s %d: %s%s" % (kind, call, nth, error, " from then on" if stays else "")
    with Place(words, files) as place:
        action = error if error == "short" else ERRORS[error]
        result = place.run(fault={"CALL": call, "NTH": nth, "ACTION": action, "STAYS": int(stays)})
        assert result.code in (0, 1), "%s: exit %d: %s" % (what, result.code, result.message)
        if result.code == 0:
            for name in files:
                assert same(name, result.files[name], want.files[name]), "%s: exit 0, but %s is not as it should be" % (what, name)
        else:
            assert error != "short", "%s: exit 1: %s" % (what, result.message)
            assert os.strerror(action) in result.message, "%s: no reason: %s" % (what, result.message)
            assert place.top in result.message, "%s: no file: %s" % (what, result.message)
        check_files(result, files, want, what, LOG)
        assert not os.listdir(place.t), "%s: left %s in the scratch folder" % (what, os.listdir(place.t))
        check_resumed(place, words, files, want, what)
    return result.counts["fired"] > 0, result.code


def together(tasks):
    """Runs them, two at a time; returns what they return. All that fail are told."""
    results, problems = [], []
    def attempt(task):
        try:
            return task[0](*task[1:])
        except AssertionError as problem:
            problems.append(str(problem))
    with ThreadPoolExecutor(2) as pool:
        results = [r for r in pool.map(attempt, tasks) if r is not None]
    assert not problems, "%d of %d:\n%s" % (len(problems), len(tasks), "\n".join(problems[:40]))
    return results


def told(row, runs, more=""):
    """The line for the table of SECURITY.md."""
    print("| %s | %d | %s |" % (row, runs, more), flush=True)


def part(tasks, count):
    return tasks if ALL else chance.sample(tasks, min(count, len(tasks)))


def each_write_fails(kind):
    """Each call that writes fails by each error, and each write stops half way."""
    make_inputs()
    words, files = JOBS[kind]
    want = clean(kind)
    places = [(call, nth) for call in WRITES for nth in range(1, want.counts[call] + 1)]
    assert places, kind
    tasks = [(failed_write, kind, words, files, want, call, nth, error) for call, nth in places for error in ERRORS]
    tasks += [(failed_write, kind, words, files, want, call, nth, "short") for call, nth in places if call == "write"]
    results = together(part(tasks, 2))
    assert all(fired for fired, _ in results), "a fault was never met"
    told("%s: a call that writes fails, or the disk stays full" % kind, len(results), "%d calls; %d ended with exit 1, the rest wrote all" %
         (len(places), sum(code for _, code in results)))


for each in JOBS:
    if each == "frames":
        continue
    globals()["case_writes_" + each] = lambda kind=each: each_write_fails(kind)


def changed_input(name, words, call, nth, action):
    what = "%s, %s %d: %s" % (name, call, nth, action)
    inputs = tempfile.mkdtemp(prefix="slicemorph-fault-changed-")
    try:
        os.mkdir(inputs + "/i")
        shutil.copy2(INPUTS["folder"] + "/" + name, inputs + "/i/" + name)
        with Place(words, inputs=inputs + "/i") as place:
            result = place.run(fault={"CALL": call, "NTH": nth, "ACTION": action}, folder=inputs + "/i")
            assert result.code in (0, 1, 2), "%s: exit %d: %s" % (what, result.code, result.message)
            assert result.code == 0 or name.split(".")[0] + "." in result.message, "%s: no file: %s" % (what, result.message)
            assert set(result.files) == ({"m.vdb"} if result.code == 0 else set()), "%s: left %s" % (what, sorted(result.files))
            # A file that could be opened is read to its end even where its name is gone; one that could not be read is no result.
            if result.code == 0 and action == "remove":
                assert same("m.vdb", result.files["m.vdb"], INPUTS["want", name].files["m.vdb"]), "%s: another result" % what
            assert not os.listdir(place.t), "%s: left %s in the scratch folder" % (what, os.listdir(place.t))
    finally:
        shutil.rmtree(inputs)
    return result.counts["fired"] > 0, result.code


def case_inputs_vanish_or_change():
    make_inputs()
    tasks = []
    for name, words in READERS.items():
        with Place(words) as place:
            want = INPUTS["want", name] = place.run(fault={}, folder=INPUTS["folder"])
        assert want.code == 0, "%s: %s" % (name, want.message)
        places = [(call, nth) for call in READS for nth in range(1, want.counts[call] + 1)]
        assert places, name
        tasks += part([(changed_input, name, words, call, nth, action) for call, nth in places for action in (ERRORS["EIO"], "remove", "cut")], 3)
    results = together(tasks)
    told("an input vanishes, is cut, or cannot be read, at each look at it", len(results),
         "%d formats; %d runs ended with exit 1 or 2" % (len(READERS), sum(code > 0 for _, code in results)))


def wrong_clock(kind, words, files, want, clock):
    with Place(words, files) as place:
        result = place.run(fault={"CLOCK": clock})
        assert result.code == 0, "%s, clock %s: exit %d: %s" % (kind, clock, result.code, result.message)
        for name in files:
            assert same(name, result.files[name], want.files[name]) or name.endswith(DATED), "%s, clock %s: %s has other bytes" % (kind, clock, name)
    return 0


def case_clocks_jump():
    make_inputs()
    tasks = [(wrong_clock, kind, *JOBS[kind], clean(kind), clock) for kind in part(list(JOBS), 2) for clock in ("back", "jump")]
    told("a clock that goes back, or jumps by days", len(together(tasks)), "the same bytes")


def ended(kind, words, files, want, number, moment):
    """A signal at a moment; then the job goes on."""
    what = "%s, %s after %.0f ms" % (kind, number.name, 1000 * moment)
    with Place(words, files) as place:
        process = place.start()
        time.sleep(moment)
        process.send_signal(number)
        message = process.communicate(timeout=300)[1].decode(errors="replace")
        result = Outcome(process.returncode, message, place.o, {})
        # Before main() a signal ends any process.
        assert result.code in (0, 1, -number), "%s: exit %d: %s" % (what, result.code, message)
        # What a process that is ended at once leaves, the next one removes.
        left = LOG + (r"\..*\.claim", r"\..*\.tmp-\d+") if result.code == -number else LOG
        check_files(result, files, want, what, left)
        if result.code == 1:
            assert "cancelled" in message, "%s: %s" % (what, message)
        check_resumed(place, words, files, want, what)
    return result.code


def moments(words, count):
    """Evenly spread random moments of the job's time."""
    start = time.time()
    with Place(words) as place:
        place.run()
    length = time.time() - start
    return [chance.uniform(0, length) for _ in range(count)]


def case_signals():
    make_inputs()
    tasks = []
    for kind in list(JOBS) if ALL else ["frames", "report"]:
        words, files = JOBS[kind]
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            tasks += [(ended, kind, words, files, clean(kind), number, moment) for moment in moments(words, 3 if ALL else 1)]
    codes = together(tasks)
    told("INT, TERM, HUP at random moments", len(codes), "%d ended with exit 1, %d were done before, %d ended at once" %
         (codes.count(1), codes.count(0), sum(code < 0 for code in codes)))


def case_kills():
    make_inputs()
    words, files = JOBS["frames"]
    codes = together([(ended, "frames", words, files, clean("frames"), signal.SIGKILL, moment) for moment in moments(words, 200 if ALL else 4)])
    told("killed (-9) at random moments, then --resume", len(codes), "the same bytes; %d were done before" % codes.count(0))


def short_of_memory(kind, words, files, want, limit):
    what = "%s within %d MB" % (kind, limit >> 20)
    with Place(words, files) as place:
        result = place.run(limit=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        assert result.code in (0, 1, 2), "%s: exit %d: %s" % (what, result.code, result.message)
        assert result.code == 0 or result.message.strip(), "%s: exit %d without a message" % (what, result.code)
        check_files(result, files, want, what, LOG)
        if result.code == 0:
            for name in files:
                assert same(name, result.files[name], want.files[name]), "%s: %s has other bytes" % (what, name)
        check_resumed(place, words, files, want, what)
    return result.code


def least_memory(words):
    """The address space, in bytes, that the job can do with: by bisection, to a 128th."""
    low, high = 64 << 20, 1 << 30
    while high - low > high / 128:
        middle = (low + high) // 2
        with Place(words) as place:
            done = place.run(limit=lambda: resource.setrlimit(resource.RLIMIT_AS, (middle, middle))).code == 0
        low, high = (low, middle) if done else (middle, high)
    return high


def case_memory_ends():
    make_inputs()
    tasks = []
    # Before main() the loader and the libraries themselves end a process that they find no memory for.
    started = least_memory(["--version"])
    for kind in list(JOBS) if ALL else ["vdb"]:
        words, files = JOBS[kind]
        want, least = clean(kind), least_memory(words)
        limits = [int(started + (least - started) * (k + 1) / 20) for k in range(20)]
        tasks += [(short_of_memory, kind, words, files, want, limit) for limit in part(limits, 4)]
    codes = together(tasks)
    told("memory ends, at 20 limits", len(codes), "%d ended with exit 1, %d were done" % (codes.count(1), codes.count(0)))


try:
    code = run_within(globals(), sys.argv[4:])
finally:
    if INPUTS:
        shutil.rmtree(INPUTS["top"])
sys.exit(code)
