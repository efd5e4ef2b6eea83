#!/usr/bin/env python3
"""Frame numbers and ranges of `slicemorph morph`, and processes that make frames of one sequence at the same time.

usage: range_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openvdb.
"""
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import time

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, named_cases, run_cases
import frames
from frames import folder
from grids import puff
from meshes import box_obj

if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, ASSETS, ONLY = os.path.abspath(sys.argv[1]), os.path.join(os.path.abspath(sys.argv[2]), "assets"), sys.argv[3:]
DIE, OCTAHEDRON = (os.path.join(ASSETS, name) for name in ("die.ply", "octahedron.ply"))
SMALL = ["--resolution", "24", "--slices", "16", "--samples", "32"]
# What is quick to plan, where only the making of frames matters.
QUICK = ["--resolution", "24", "--method", "sdf"]


def start(o, *words, command="morph"):
    return subprocess.Popen([PROGRAM, command, *map(str, words)], cwd=o, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def run(o, *words, code=0, command="morph"):
    process = start(o, *words, command=command)
    out, err = process.communicate(timeout=600)
    assert process.returncode == code, "%s: exit %d\n%s" % (" ".join(map(str, words)), process.returncode, err)
    return subprocess.CompletedProcess(words, code, out, err)


def sums(o, ending=".vdb"):
    """Those of the frames of a folder, whose hidden files must all be gone."""
    hidden = [name for name in os.listdir(o) if name.startswith(".")]
    assert not hidden, hidden
    return frames.sums(o, ending)


def same_in_parts(o, words, ranges, names, ending=".vdb", pattern="m.####"):
    """The frames from one process are those from several, of a range each; `names`: of all."""
    whole, parts = folder(o, "whole"), folder(o, "parts")
    run(whole, *words, "-o", pattern + ending)
    for part in ranges:
        run(parts, *words, "-o", pattern + ending, "--range", part)
    assert list(sums(whole, ending)) == names, list(sums(whole, ending))
    assert sums(whole, ending) == sums(parts, ending)


def case_a_pair(o):
    """Two shapes, with velocities, in ranges that are made in no order, some with a step."""
    names = ["m.%d.vdb" % n for n in range(1001, 1009)]
    same_in_parts(o, [DIE, OCTAHEDRON, *SMALL, "--frames", 8, "--start", 1001],
                  ["1005-1006,1001-1008x4", "1008,1002-1004:2,1003,1007"], names)
    grids = {grid.name: grid for grid in vdb.readAllGridMetadata(os.path.join(o, "parts", "m.1003.vdb"))}
    assert grids["surface"]["frame"] == 1003 and "vel" in grids, grids


def case_times_and_keys(o):
    """Frames of --at, which need not be in order and far from even, have the velocities that they have in the whole."""
    box = box_obj(o + "/box.obj", (-1, -0.8, -0.5), (1, 0.8, 0.5))
    run(o, DIE, OCTAHEDRON, box, *SMALL, "-o", "x.plan", command="plan")
    same_in_parts(o, ["--plan", o + "/x.plan", "--at", "0.1,0.9,0.2,0.25", "--keys", "die@0 box@0.4 octahedron@1", "--timing",
                      "catmull-rom", "--start", -1], ["0", "-1,1-2"], ["m.%s.vdb" % n for n in ("-0001", "0000", "0001", "0002")])


def case_sequences(o):
    """Plans of sequences follow the frame before, also where that is not made."""
    for i in range(5):
        puff(o + "/a.%02d.vdb" % (i + 1), (0.1 * i - 0.2, 0, 0), 0.6 + 0.02 * i)
        puff(o + "/b.%02d.vdb" % (i + 1), (0, 0.12 * i - 0.2, 0.1), 0.7 - 0.03 * i)
    same_in_parts(o, [o + "/a.##.vdb", o + "/b.##.vdb", "--slices", 16, "--samples", 32, "--start", 11], ["15", "11-14"],
                  ["m.%04d.vdb" % n for n in range(11, 16)])


def case_levelset_steps(o):
    same_in_parts(o, [DIE, OCTAHEDRON, "--resolution", 24, "--method", "levelset", "--frames", 4, "--start", 7, "--velocity", "none"],
                  ["9-10", "7-8"], ["m.%04d.vdb" % n for n in range(7, 11)])


def case_pictures(o):
    """All frames share one camera, whichever are drawn."""
    same_in_parts(o, [DIE, OCTAHEDRON, *QUICK, "--frames", 4, "--size", "64x48"], ["3", "1-4x3,2"],
                  ["m.%04d.png" % n for n in range(1, 5)], ending=".png")


def glb_json(path):
    data = open(path, "rb").read()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[28 + length:]


def case_one_glb(o):
    """A .glb of a range has its frames, at their times, and says which."""
    words = [DIE, OCTAHEDRON, *SMALL, "--frames", 6, "--start", 101, "--fps", 10]
    said = run(o, *words, "-o", "m.glb", "--range", "102-106x2").stderr
    assert "frames 102, 104, 106" in said, said
    gltf, binary = glb_json(o + "/m.glb")
    names = [name for mesh in gltf["meshes"] for name in mesh.get("extras", {}).get("targetNames", [])]
    assert names == ["frame.0104", "frame.0106"], names
    times = gltf["accessors"][gltf["animations"][0]["samplers"][0]["input"]]
    view = gltf["bufferViews"][times["bufferView"]]
    got = struct.unpack_from("<3f", binary, view.get("byteOffset", 0) + times.get("byteOffset", 0))
    assert np.allclose(got, [0, 0.2, 0.4]), got


def case_report(o):
    """A range's report has its frames, with the same figures as the whole one's, and says which they are."""
    words = [DIE, OCTAHEDRON, *QUICK, "--frames", 5, "-o", "m.####.vdb"]
    run(o, *words, "--report", "whole.json")
    run(o, *words, "--report", "part.json", "--report", "part.html", "--range", "2,4-5")
    whole, part = (json.load(open(o + "/" + name)) for name in ("whole.json", "part.json"))
    assert part["settings"]["range"] == "2,4-5" and part["settings"]["start"] == 1, part["settings"]
    for frame in whole["frames"] + part["frames"]:
        del frame["seconds"]
    assert part["frames"] == [whole["frames"][i] for i in (1, 3, 4)]
    assert part["frames"][1]["symmetricDifference"] > 0
    assert '"frames":[0,1,2]' in open(o + "/part.html").read(), "the page's player does not have the report's frames"


def case_resume_across_ranges(o):
    """What a range made is kept by a run of all, and by one of another range."""
    words = [DIE, OCTAHEDRON, *QUICK, "--frames", 6, "-o", "m.####.vdb"]
    run(o, *words, "--range", "2-3")
    assert os.path.exists(o + "/.m.####.vdb.slicemorph"), os.listdir(o)
    out = run(o, *words, "--range", "3-4", "--resume").stdout
    assert out == "m.0003.vdb (kept)\nm.0004.vdb\n", out
    os.remove(o + "/m.0002.vdb")
    out = run(o, *words, "--resume").stdout
    assert out == "m.0001.vdb\nm.0002.vdb\nm.0003.vdb (kept)\nm.0004.vdb (kept)\nm.0005.vdb\nm.0006.vdb\n", out
    assert len(sums(o)) == 6
    # Frames that another job has written since are not this one's, though one range of it is left.
    run(o, *words, "--range", "1-2")
    run(o, *words, "--range", "2", "--fps", 30)
    result = run(o, *words, "--range", "1-3", "--resume")
    assert "m.0001.vdb (kept)\nm.0002.vdb\n" in result.stdout, result.stdout
    assert "of the frames that are there 2 are of other settings" in result.stderr, result.stderr


def case_wrong_ranges(o):
    words = [DIE, OCTAHEDRON, *QUICK, "--frames", 6, "-o", "m.####.vdb"]
    for text in ("", "a", "3-", "5-2", "1-6x0", "1-6y2", "1,,2", "1,", "1-6x", "2x2", "1--", "1 2"):
        said = run(o, *words, "--range=" + text, code=2).stderr
        assert "--range" in said and (text == "" or ("--range " + text in said and "1005-1012" in said)), (text, said)
    said = run(o, *words, "--range", "5-8", code=2).stderr
    assert "--range 5-8: frames 7-8 are none of this sequence, which has 1 to 6" in said, said
    said = run(o, *words, "--start", 1001, "--range", "1", code=2).stderr
    assert "frame 1 is none" in said and "1001 to 1006" in said, said
    said = run(o, DIE, OCTAHEDRON, "-o", "m.vdb", "--frames", 6, "--range", 2, code=2).stderr
    assert "####" in said, said
    open(o + "/job.toml", "w").write('inputs = ["%s", "%s"]\noutput = "m.####.vdb"\nframes = 4\nrange = "9"\n' % (DIE, OCTAHEDRON))
    said = run(o, "--config", "job.toml", code=2).stderr
    assert "job.toml:4:9: --range 9" in said, said
    printed = run(o, "--config", "job.toml", "--print-config", "--start", 5, "--range", "5-8x2").stdout
    assert 'range = "5-8x2"' in printed and "\nstart = 5" in printed, printed
    assert os.listdir(o) == ["job.toml"], os.listdir(o)


def case_range_of_one_frame_is_numbered(o):
    assert run(o, DIE, OCTAHEDRON, *QUICK, "--frames", 6, "-o", "m.##.vdb", "--range", 5).stdout == "m.05.vdb\n"


def claim_text(**changed):
    """A claim of this process; it lives as long as the test."""
    stat = open("/proc/self/stat").read().rsplit(")", 1)[1].split()
    owner = {"host": socket.gethostname(), "processes": os.readlink("/proc/self/ns/pid"), "pid": os.getpid(), "started": stat[19],
             "purpose": "something"}
    owner.update(changed)
    return "".join("%s %s\n" % item for item in owner.items()) + "end\n"


def wait_for(path, process, seconds=200):
    end = time.time() + seconds
    while not os.path.exists(path) and process.poll() is None and time.time() < end:
        time.sleep(0.002)
    if not os.path.exists(path):
        raise Skip("it was over before it could be looked at: %s" % (process.communicate(),))


def case_two_at_the_same_time(o):
    """Overlapping ranges: each frame is whole, none is lost, the one that comes second says so once."""
    words = [DIE, OCTAHEDRON, "--method", "sdf", "--resolution", "40", "--frames", 24, "-o", "m.####.vdb"]
    alone = folder(o, "alone")
    run(alone, *words)
    both = folder(o, "both")
    processes = [start(both, *words, "--range", part) for part in ("1-18", "7-24")]
    said = [(process.communicate(timeout=600), process.returncode) for process in processes]
    assert [code for _, code in said] == [0, 0], said
    assert sums(both) == sums(alone)
    for (out, err), _ in said:
        assert err.count("left to") <= 1, err
    # The first rests until the second makes frames that both are to make.
    again = folder(o, "again")
    first = start(again, *words, "--range", "1-24")
    wait_for(again + "/m.0003.vdb", first)
    first.send_signal(signal.SIGSTOP)
    try:
        second = start(again, *words, "--range", "15-24")
        wait_for(again + "/m.0016.vdb", second)
    finally:
        first.send_signal(signal.SIGCONT)
    said = [(process.communicate(timeout=600), process.returncode) for process in (first, second)]
    assert [code for _, code in said] == [0, 0], said
    assert sums(again) == sums(alone)
    made = said[0][0][0].count("\n") + said[1][0][0].count("\n")
    notes = (said[0][0][1] + said[1][0][1]).count(" left to ")
    assert made == 24, "frames were made twice, or none made them: %s" % (said,)
    assert notes >= 1 and all(err.count(" left to ") <= 1 for (_, err), _ in said), said


def case_killed_anywhere(o):
    """A process that is killed at any moment leaves nothing that the next one does not put right."""
    words = [DIE, OCTAHEDRON, *QUICK, "--frames", 12, "-o", "m.####.vdb"]
    alone = folder(o, "alone")
    run(alone, *words)
    killed = folder(o, "killed")
    for frame, wait in ((1, 0), (3, 0.004), (5, 0.011), (7, 0.019), (9, 0.028)):
        process = start(killed, *words, "--resume")
        wait_for(killed + "/m.%04d.vdb" % frame, process)
        time.sleep(wait)
        process.send_signal(signal.SIGKILL)
        process.communicate()
    run(killed, *words, "--resume")
    assert sums(killed) == sums(alone)


def case_interrupted_frees_its_claim(o):
    words = [DIE, OCTAHEDRON, "--method", "sdf", "--resolution", "40", "--frames", 60, "-o", "m.####.vdb"]
    process = start(o, *words)
    wait_for(o + "/m.0002.vdb", process)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=100)
    hidden = [name for name in os.listdir(o) if name.startswith(".")]
    assert hidden in ([".m.####.vdb.slicemorph"], []), hidden


def case_another_job_is_not_written_over(o):
    """A frame that a living process makes of other settings ends the second one, before it writes anything there."""
    words = [DIE, OCTAHEDRON, *QUICK, "--frames", 3, "-o", "m.####.vdb"]
    open(o + "/.m.0002.vdb.claim", "w").write(claim_text())
    said = run(o, *words, code=1).stderr
    assert "m.0002.vdb" in said and "process %d on " % os.getpid() in said and "other settings" in said, said
    assert sorted(os.listdir(o))[-1] == "m.0001.vdb" and os.path.exists(o + "/.m.0002.vdb.claim"), os.listdir(o)


def case_claims_of_other_machines(o):
    """A claim from another machine is respected; the message names the file that may be deleted."""
    words = [DIE, OCTAHEDRON, *QUICK, "--frames", 4, "-o", "m.####.vdb"]
    run(o, *words, "--range", 1)
    log = [json.loads(line) for line in open(o + "/.m.####.vdb.slicemorph") if line.strip()]
    purpose = log[0]["job"] + "-" + log[0]["program"]
    open(o + "/.m.0002.vdb.claim", "w").write(claim_text(host="farm3", purpose=purpose))
    result = run(o, *words, code=1)
    assert result.stdout == "m.0001.vdb\nm.0003.vdb\nm.0004.vdb\n", result.stdout
    for text in ("frame 2 ", "on farm3", "delete .m.0002.vdb.claim"):
        assert text in result.stderr, (text, result.stderr)
    os.remove(o + "/.m.0002.vdb.claim")
    assert "m.0002.vdb\n" in run(o, *words, "--resume").stdout
    assert len(sums(o)) == 4
    # One that lives here and makes the same frame is left to it.
    open(o + "/.m.0002.vdb.claim", "w").write(claim_text(purpose=purpose))
    result = run(o, *words)
    assert result.stdout == "m.0001.vdb\nm.0003.vdb\nm.0004.vdb\n", result.stdout
    said = "m.####.vdb: frame 2 was left to process %d on %s, which makes it, too; it is still making frame 2" % (os.getpid(),
                                                                                                                socket.gethostname())
    assert said in result.stderr and result.stderr.count(" left to ") == 1, result.stderr


def case_reports_are_not_written_over(o):
    open(o + "/.r.json.claim", "w").write(claim_text(purpose="report"))
    said = run(o, DIE, OCTAHEDRON, *QUICK, "--frames", 2, "-o", "m.####.vdb", "--report", "r.json", code=1).stderr
    assert "r.json" in said and "--report" in said, said
    assert not os.path.exists(o + "/m.0001.vdb")


sys.exit(run_cases([(name.replace("_", " "), case) for name, case in named_cases(globals())], ONLY))
