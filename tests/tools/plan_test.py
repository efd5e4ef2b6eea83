#!/usr/bin/env python3
"""Plans as files: `slicemorph plan`, and frames made by them.

usage: plan_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openvdb.
"""
import os
import shutil
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import named_cases, run_cases
from frames import folder, sums
from grids import puff
from meshes import box_obj

if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, ASSETS, ONLY = os.path.abspath(sys.argv[1]), os.path.join(os.path.abspath(sys.argv[2]), "assets"), sys.argv[3:]
DIE, OCTAHEDRON = (os.path.join(ASSETS, name) for name in ("die.ply", "octahedron.ply"))
SMALL = ["--resolution", "24", "--slices", "16", "--samples", "32"]


def run(o, *words, code=0):
    result = subprocess.run([PROGRAM, *map(str, words)], cwd=o, capture_output=True, text=True, timeout=600)
    assert result.returncode == code, "%s: exit %d\n%s" % (" ".join(map(str, words)), result.returncode, result.stderr)
    return result


def case_frames_are_the_same(o):
    """Frames by a plan, in ranges, from another folder, are those of a morph without; inputs may have moved."""
    whole, parts, moved = (folder(o, name) for name in ("whole", "parts", "moved"))
    shutil.copy(DIE, o + "/a.ply")
    shutil.copy(OCTAHEDRON, o + "/b.ply")
    run(whole, "morph", o + "/a.ply", o + "/b.ply", *SMALL, "--frames", 5, "-o", "m.####.vdb")
    run(o, "plan", "a.ply", "b.ply", *SMALL, "-o", "x.plan")
    for part in ("4-5", "1-3"):
        run(parts, "morph", "--plan", o + "/x.plan", "--frames", 5, "--range", part, "-o", "m.####.vdb")
    assert sums(whole, ".vdb") == sums(parts, ".vdb") and len(sums(whole, ".vdb")) == 5
    os.rename(o + "/a.ply", moved + "/a.ply")
    error = run(parts, "morph", "--plan", o + "/x.plan", "-o", "n.####.vdb", code=1).stderr
    assert "a.ply" in error, error
    run(parts, "morph", moved + "/a.ply", o + "/b.ply", "--plan", o + "/x.plan", "--frames", 5, "-o", "m.####.vdb")
    assert sums(whole, ".vdb") == sums(parts, ".vdb")
    # Other outputs of the same shapes take it, too.
    run(parts, "morph", moved + "/a.ply", o + "/b.ply", "--plan", o + "/x.plan", "--at", 0.5, "-o", "half.ply")
    assert os.path.getsize(parts + "/half.ply") > 1000


def case_keys_and_job_files(o):
    """Plans of several inputs, by a job file with a feature."""
    box = box_obj(o + "/box.obj", (-1, -0.8, -0.5), (1, 0.8, 0.5))
    with open(o + "/job.toml", "w") as job:
        job.write('inputs = ["%s", "%s", "%s"]\noutput = "m.####.vdb"\nframes = 3\nresolution = 24\nslices = 16\nsamples = 32\n'
                  '[[feature]]\nname = "top"\npoint = [[0, 0.5, 0], [0, 0.5, 0], [0, 0.8, 0]]\n' % (DIE, OCTAHEDRON, box))
    whole, planned = folder(o, "whole"), folder(o, "planned")
    run(whole, "morph", "--config", o + "/job.toml")
    run(o, "plan", "--config", "job.toml", "-o", "x.plan")
    run(planned, "morph", "--plan", o + "/x.plan")
    assert sums(whole, ".vdb") == sums(planned, ".vdb") and len(sums(whole, ".vdb")) == 3


def case_sequences(o):
    """A plan a frame: later frames then need no others."""
    for i in range(3):
        puff(o + "/a.%02d.vdb" % (i + 1), (0.1 * i - 0.2, 0, 0), 0.6 + 0.02 * i)
        puff(o + "/b.%02d.vdb" % (i + 1), (0, 0.12 * i - 0.2, 0.1), 0.7 - 0.03 * i)
    words = [o + "/a.##.vdb", o + "/b.##.vdb", "--slices", 16, "--samples", 32]
    whole, parts = folder(o, "whole"), folder(o, "parts")
    run(whole, "morph", *words, "-o", "m.####.vdb")
    error = run(o, "plan", *words, "-o", "x.plan", code=2).stderr
    assert "####" in error, error
    run(o, "plan", *words, "-o", "x.####.plan")
    error = run(parts, "morph", "--plan", o + "/x.0001.plan", "-o", "m.####.vdb", code=2).stderr
    assert "name.####.plan" in error, error
    os.remove(o + "/x.0002.plan")
    run(parts, "morph", "--plan", o + "/x.####.plan", "--range", 3, "-o", "m.####.vdb")
    assert sums(parts, ".vdb") == {"m.0003.vdb": sums(whole, ".vdb")["m.0003.vdb"]}
    # Plans belong to the inputs' frames, whatever the numbers of the frames that are made, or of the plans.
    later, numbered = folder(o, "later"), folder(o, "numbered")
    run(later, "morph", *words, "--start", 1001, "-o", "m.####.vdb")
    run(numbered, "morph", "--plan", o + "/x.####.plan", "--start", 1001, "--range", 1003, "-o", "m.####.vdb")
    assert sums(numbered, ".vdb") == {"m.1003.vdb": sums(later, ".vdb")["m.1003.vdb"]}
    run(later, "morph", *words, "--at", 1, "-o", "last.####.vdb")
    run(numbered, "morph", "--plan", o + "/x.####.plan", "--at", 1, "-o", "last.####.vdb")
    assert sums(numbered, ".vdb")["last.0001.vdb"] == sums(later, ".vdb")["last.0001.vdb"]
    run(o, "plan", *words, "--start", 501, "-o", "y.####.plan")
    run(numbered, "morph", "--plan", o + "/y.####.plan", "--range", 2, "-o", "m.####.vdb")
    assert sums(numbered, ".vdb")["m.0002.vdb"] == sums(whole, ".vdb")["m.0002.vdb"]
    error = run(parts, "morph", "--plan", o + "/x.####.plan", "-o", "m.####.vdb", code=1).stderr
    assert "x.0002.plan" in error, error
    # So are those of times, and times at the same files share one.
    for start in (1, 7):
        at = ["--at", "0,0.1,1", "-o", "at%d.####" % start]
        run(o, "plan", *words, "--start", start, *at[:3], at[3] + ".plan")
        plans = [name for name in sorted(os.listdir(o)) if name.startswith("at%d" % start)]
        assert plans == ["at%d.%04d.plan" % (start, start + i) for i in (0, 2)], plans
        run(later, "morph", *words, *at[:3], at[3] + ".vdb")
        run(numbered, "morph", "--plan", o + "/at%d.####.plan" % start, *at[:3], at[3] + ".vdb")
        for name in ("at%d.%04d.vdb" % (start, n) for n in (1, 2, 3)):
            assert sums(numbered, ".vdb")[name] == sums(later, ".vdb")[name], name


def case_what_does_not_fit_is_refused(o):
    run(o, "plan", DIE, OCTAHEDRON, *SMALL, "-o", "x.plan")
    morph = ["morph", "--plan", "x.plan", "-o", "m.####.vdb", "--frames", 2]
    error = run(o, *morph, "--slices", 17, code=2).stderr
    assert "--slices 17" in error and "made with 16" in error, error
    run(o, *morph, "--slices", 16)
    error = run(o, *morph, "--spine", "straight", code=2).stderr
    assert "--spine" in error and "made without it" in error, error
    error = run(o, *morph, "--dump-slices", "d", code=2).stderr
    assert "--dump-slices" in error, error
    error = run(o, *morph, DIE, box_obj(o + "/box.obj", (-1, -0.8, -0.5), (1, 0.8, 0.5)), code=1).stderr
    assert "x.plan" in error and "other objects" in error, error
    error = run(o, "morph", "--plan", DIE, "-o", "m.vdb", code=1).stderr
    assert "die.ply" in error and "is no plan" in error, error
    error = run(o, "plan", DIE, OCTAHEDRON, "-o", "x.vdb", code=2).stderr
    assert "name.plan" in error, error
    error = run(o, "plan", DIE, OCTAHEDRON, "--method", "sdf", "-o", "y.plan", code=2).stderr
    assert "--method sdf" in error and not os.path.exists(o + "/y.plan"), error
    whole = open(o + "/x.plan", "rb").read()
    for size in [*range(0, 400, 37), len(whole) // 2, len(whole) - 1]:
        with open(o + "/cut.plan", "wb") as file:
            file.write(whole[:size])
        error = run(o, "morph", "--plan", "cut.plan", "-o", "c.####.vdb", code=1).stderr
        assert "cut.plan" in error, (size, error)
    for at in (10, len(whole) // 2, len(whole) - 3):
        with open(o + "/bad.plan", "wb") as file:
            file.write(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1:])
        result = subprocess.run([PROGRAM, "morph", "--plan", "bad.plan", "-o", "c.####.vdb", "--frames", "2"], cwd=o,
                                capture_output=True, text=True)
        assert result.returncode in (1, 2) and "bad.plan" in result.stderr, (at, result.stderr)
    assert not [name for name in os.listdir(o) if name.startswith("c.")]


sys.exit(run_cases(named_cases(globals()), ONLY))
