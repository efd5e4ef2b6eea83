#!/usr/bin/env python3
"""What people at a terminal rely on: progress that never goes back and tells the time left, outputs without -o, `demo`, numbers
in units that are read. How true the time left is depends on the machine: it is printed here, and tested with a clock of its own in
tests/tools/job/time_left_test.cpp.

usage: habits_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)
"""
import json
import os
import pty
import re
import shutil
import stat
import subprocess
import sys
import time

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_within
from program import Program

if len(sys.argv) < 3:
    sys.exit(__doc__)
program = Program(sys.argv[1])
ASSETS = os.path.abspath(sys.argv[2]) + "/assets"
QUICK = ["--resolution", "40"]
LINE = re.compile(r"(\S.*?) (\d+)%(?:, (.+) left)?\s*$")
UNITS = {"s": 1, "min": 60, "h": 3600, "day": 86400, "days": 86400}


def seconds(text):
    """The time that a text like "3 min 20 s" tells."""
    words = text.split()
    assert len(words) % 2 == 0, text
    return sum(float(words[i]) * UNITS[words[i + 1]] for i in range(0, len(words), 2))


def watched(*arguments, code=0):
    """Runs the program at a terminal. Returns its lines of progress, (moment, stage, percent, seconds left or None), and how
    long it ran."""
    ours, its = pty.openpty()
    start = time.time()
    process = subprocess.Popen([program.path, *map(str, arguments)], stderr=its, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
    os.close(its)
    lines, rest = [], ""
    while True:
        try:
            data = os.read(ours, 65536)
        except OSError:
            data = b""
        if not data:
            break
        *whole, rest = re.split(r"[\r\n]", rest + data.decode(errors="replace"))
        # A line ends with the beginning of the next, so it is looked at before.
        for line in whole + [rest]:
            found = LINE.match(line)
            if found:
                lines.append((time.time() - start, found[1], int(found[2]), seconds(found[3]) if found[3] else None))
    os.close(ours)
    assert process.wait() == code, process.returncode
    return lines, time.time() - start


def check_progress(what, lines, stages=(), least=3):
    """`least`: so many different percentages were drawn."""
    percents = [line[2] for line in lines]
    assert percents and percents == sorted(percents), (what, percents)
    assert all(0 <= percent <= 100 for percent in percents), (what, percents)
    assert len(set(percents)) >= least, (what, percents)
    for stage in stages:
        assert any(line[1] == stage for line in lines), (what, stage, {line[1] for line in lines})


def meshes():
    for name in ("blade", "ring", "creature"):
        shutil.copy("%s/%s.ply" % (ASSETS, name), "%s.ply" % name)


def moving(name, shape, count):
    """A sequence of a shape that moves by half of its length."""
    for k in range(count):
        points = []
        with open(shape) as file:
            text = file.read()
        header, _, body = text.partition("end_header\n")
        vertices = int(re.search(r"element vertex (\d+)", header)[1])
        for i, line in enumerate(body.splitlines()):
            words = line.split()
            if i < vertices:
                words[0] = repr(float(words[0]) + 0.2 * k)
            points.append(" ".join(words))
        with open("moved.ply", "w") as file:
            file.write(header + "end_header\n" + "\n".join(points) + "\n")
        program.run("convert", "moved.ply", "-o", "%s.%04d.vdb" % (name, k + 1), *QUICK)


def case_progress_of_a_morph():
    """Plan, frames and the page of a report; resumed, too."""
    meshes()
    job = ["morph", "blade.ply", "ring.ply", "-o", "m.####.vdb", "--frames", "12", "--report", "r.html", "--resolution", "96"]
    lines, _ = watched(*job)
    check_progress("morph", lines, ["reading", "making frames", "following surfaces"])
    for number in (3, 7, 8):
        os.remove("m.%04d.vdb" % number)
    lines, _ = watched(*job, "--resume")
    check_progress("resumed", lines, least=1)
    lines, _ = watched("morph", "blade.ply", "ring.ply", "-o", "m.glb", "--frames", "6", *QUICK)
    check_progress("glb", lines, ["following surfaces"])
    lines, _ = watched("morph", "blade.ply", "ring.ply", "creature.ply", "-o", "n.####.vdb", "--frames", "5", *QUICK)
    check_progress("three", lines)


def case_progress_of_sequences():
    meshes()
    moving("a", ASSETS + "/die.ply", 5)
    program.run("convert", "ring.ply", "-o", "ring.vdb", *QUICK)
    lines, _ = watched("morph", "a.####.vdb", "ring.vdb", "-o", "m.####.vdb")
    check_progress("sequence", lines, ["reading", "making frames"])
    lines, _ = watched("retime", "a.####.vdb", "-o", "slow.####.vdb", "--factor", "2")
    check_progress("retime", lines, ["making frames"])
    # Several plans in one job.
    lines, _ = watched("plan", "a.####.vdb", "ring.vdb", "-o", "p.####.plan")
    check_progress("plan", lines, ["reading"])
    lines, _ = watched("morph", "--plan", "p.####.plan", "-o", "q.####.vdb")
    check_progress("morph by plans", lines, ["making frames"])
    lines, _ = watched("slice", "a.0001.vdb", "-o", "s.####.exr", "--slices", "400", "--pixel-size", "0.01")
    check_progress("slice", lines, least=1)
    lines, _ = watched("render", "m.####.vdb", "-o", "r.####.png", "--size", "320x240")
    check_progress("render", lines, ["rendering"])


def case_time_left_is_told():
    """A time that is told has numbers and units and is more than nothing. By how much it is wrong is printed, not tested: from a
    quarter of the run on, while more than a second and a tenth of the run are left."""
    meshes()
    lines, took = watched("morph", "blade.ply", "creature.ply", "-o", "m.####.vdb", "--frames", "24", "--resolution", "128")
    told = [left for _, _, _, left in lines if left is not None]
    factors = []
    for moment, _, _, left in lines:
        truly = took - moment
        if moment > 0.25 * took and truly > max(1, 0.1 * took) and left:
            factors.append(max(left / truly, truly / left))
    factors.sort()
    print("  %.1f s; %d times told, wrong by a factor of %.2f at the median, %.2f at most" % (
        took, len(told), factors[len(factors) // 2] if factors else 0, factors[-1] if factors else 0))
    assert told and min(told) > 0, lines


def case_no_progress_but_on_terminals():
    meshes()
    result = program.run("morph", "blade.ply", "ring.ply", "-o", "m.####.vdb", "--frames", "3", *QUICK)
    assert "\r" not in result.stderr and not any(map(LINE.match, result.stderr.splitlines())), result.stderr
    lines, _ = watched("morph", "blade.ply", "ring.ply", "-o", "n.####.vdb", "--frames", "3", "--quiet", *QUICK)
    assert not lines, lines


def chosen(*arguments):
    """Runs without -o. Returns the output that stderr tells, and the files that stdout names."""
    result = program.run(*arguments)
    told = re.findall(r"^note: without -o the result is (.+)$", result.stderr, re.M)
    assert len(told) == 1, result.stderr
    return told[0], result.stdout.split()


def case_outputs_without_o():
    """Beside the first input, by a name that nothing has yet."""
    os.makedirs("in")
    os.chdir("in")
    meshes()
    os.chdir("..")
    frames = ["in/blade_to_ring/blade_to_ring.%04d.vdb" % n for n in (1, 2)]
    job = ["morph", "in/blade.ply", "in/ring.ply", "--frames", "2", *QUICK]
    assert chosen(*job) == ("in/blade_to_ring/blade_to_ring.####.vdb", frames)
    before = [open(frame, "rb").read() for frame in frames]
    told, files = chosen(*job)
    assert told == "in/blade_to_ring_2/blade_to_ring.####.vdb" and all(map(os.path.exists, files))
    assert [open(frame, "rb").read() for frame in frames] == before
    assert chosen("morph", "in/blade.ply", "in/ring.ply", "--at", "0.5", *QUICK)[1] == ["in/blade_to_ring.vdb"]
    assert chosen("morph", "in/blade.ply", "in/ring.ply", "--weights", "1,1", *QUICK)[1] == ["in/blade_and_ring.vdb"]
    assert chosen("morph", "in/blade.ply", "in/ring.ply", "--weights", "1,1", *QUICK)[1] == ["in/blade_and_ring_2.vdb"]
    assert chosen("slice", "in/blade_to_ring.vdb", "--slices", "3")[1] == [
        "in/blade_to_ring_slices/blade_to_ring.%04d.exr" % n for n in (1, 2, 3)]
    told, _ = chosen("reconstruct", "in/blade_to_ring_slices/blade_to_ring.####.exr")
    assert told == "in/blade_to_ring_slices/blade_to_ring_rebuilt.vdb" and os.path.exists(told)
    assert chosen("render", "in/blade.ply", "--size", "32x32")[1] == ["in/blade.png"]
    assert chosen("render", "in/blade_to_ring/blade_to_ring.####.vdb", "--size", "32x32")[1] == [
        "in/blade_to_ring/blade_to_ring_pictures/blade_to_ring.%04d.png" % n for n in (1, 2)]
    assert chosen("apply", "in/blade.ply", "in/ring.ply", "in/blade.ply", *QUICK)[0] == "in/blade_carried.ply"
    assert chosen("retime", "in/blade_to_ring/blade_to_ring.####.vdb", "--factor", "1")[0] == (
        "in/blade_to_ring/blade_to_ring_retimed/blade_to_ring.####.vdb")
    os.chdir("in")
    assert chosen("morph", "blade.ply", "ring.ply", "--at", "0", *QUICK)[1] == ["blade_to_ring_2.vdb"]


def case_two_at_once_without_o():
    """Of two programs that begin at once each has a name of its own; a link that leads nowhere is a name that is taken."""
    meshes()
    os.symlink("nowhere/at.vdb", "blade_and_ring.vdb")
    job = [program.path, "morph", "blade.ply", "ring.ply", *QUICK, "--weights"]
    both = [subprocess.Popen(job + [weights], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for weights in ("1,1", "3,1")]
    for process in both:
        told = process.communicate()
        assert process.returncode == 0, told
    assert sorted(os.listdir(".")) == ["blade.ply", "blade_and_ring.vdb", "blade_and_ring_2.vdb", "blade_and_ring_3.vdb", "creature.ply",
                                       "ring.ply"], os.listdir(".")
    assert os.path.islink("blade_and_ring.vdb")
    program.refused("slice", "missing/a.vdb", says=["missing/a.vdb: no such file"])


def case_images_without_o():
    """Of images images, in the first one's form; label maps with gaps are filled."""
    meshes()
    for name in ("blade", "ring"):
        program.run("convert", name + ".ply", "-o", name + ".nrrd", "--resolution", "32")
    assert chosen("morph", "blade.nrrd", "ring.nrrd", "--frames", "2")[1] == ["blade_to_ring/blade_to_ring.%04d.nrrd" % n for n in (1, 2)]
    assert chosen("reconstruct", "blade.nrrd", "--between", "1")[0] == "blade_dense.nrrd"


def case_where_inputs_cannot_be_written_to():
    """Then the current folder; where neither can be, a refusal."""
    os.makedirs("in")
    os.chdir("in")
    meshes()
    os.chdir("..")
    job = ["morph", "in/blade.ply", "in/ring.ply", "--at", "0", *QUICK]
    os.chmod("in", 0o555)
    user = [] if os.geteuid() else ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    if user and not shutil.which("setpriv"):
        raise Skip("setpriv is not there, and root may write everywhere")

    def run():
        return subprocess.run([*user, program.path, *job], capture_output=True, text=True)
    try:
        os.chmod(".", 0o777)
        result = run()
        assert result.returncode == 0 and result.stdout == "blade_to_ring.vdb\n", (result.stdout, result.stderr)
        os.remove("blade_to_ring.vdb")
        os.chmod(".", 0o555)
        result = run()
        assert result.returncode == 2 and "name an output by -o" in result.stderr, (result.returncode, result.stderr)
        assert sorted(os.listdir(".")) == ["in"] and len(os.listdir("in")) == 3
    finally:
        os.chmod(".", stat.S_IRWXU), os.chmod("in", stat.S_IRWXU)


def case_refused_without_o():
    """Nothing is left, no empty folder either."""
    meshes()
    program.refused("morph", "blade.ply", "ring.ply", "--resume", says=["--resume", "-o"])
    program.refused("morph", "blade.ply", "missing.ply", says=["missing.ply"])
    program.refused("morph", "blade.ply", "ring.ply", "--resolution", "9999", says=["9999"])
    program.refused("morph", "blade.ply", says=["two inputs"])
    program.refused("convert", "blade.ply", says=["--output"])
    program.refused("plan", "blade.ply", "ring.ply", says=["-o"])
    program.refused("slice", "missing.vdb", says=["missing.vdb"])


def case_numbers_are_readable():
    meshes()
    program.run("convert", "ring.ply", "-o", "ring.vdb", "--resolution", "256")
    text, raw = program.run("info", "ring.vdb").stdout, json.loads(program.run("info", "ring.vdb", "--json").stdout)
    size, voxels = os.path.getsize("ring.vdb"), raw["grids"][0]["activeVoxels"]
    assert raw["bytes"] == size and voxels > 1e5
    told = re.search(r", (\S+) (KB|MB), file version", text)
    assert abs(float(told[1]) * {"KB": 1024, "MB": 1024 ** 2}[told[2]] / size - 1) < 0.005, text
    told = re.search(r"active voxels +(\S+)( million)?\n", text)
    assert abs(float(told[1].replace(",", "")) * (1e6 if told[2] else 1) / voxels - 1) < 0.05, (text, voxels)
    said = program.refused("convert", "ring.ply", "-o", "n.vdb", "--resolution", "4096", "--memory", "300M", says=["GB", "300 MB"])
    assert re.search(r"\d million of these|billion of these", said), said


def case_demo():
    """Everything it lists is there, names are those of tools/demo.sh; what is there is not touched."""
    result = program.run("demo")
    lines = result.stdout.splitlines()
    names = ["slicemorph-demo/" + pair + end for pair in ("creature_to_ring", "blade_to_creature") for end in
             ("/{0}.png", "/vdb/{0}.####.vdb", "/mesh/{0}.####.ply", "/slices/{0}.####.exr", "/pictures/{0}.####.png", "/report.json")]
    names = [name.format(name.split("/")[1]) for name in names]
    assert [line.split("  ")[0] for line in lines[:-1]] == names, lines
    found = [os.path.join(top, file) for top, _, files in os.walk("slicemorph-demo") for file in files]
    assert len(found) == 2 * (9 + 9 + 64 + 9 + 2), len(found)
    for name in names:
        pattern = re.compile(re.escape(name).replace(re.escape("####"), r"\d{4}"))
        count = sum(1 for file in found if pattern.fullmatch(file))
        assert count == (1 if "#" not in name else 64 if "/slices/" in name else 9), (name, count)
    told = re.match(r"(\d+) files, (\S+) MB, made in (.+)$", lines[-1])
    size = sum(map(os.path.getsize, found))
    assert int(told[1]) == len(found) and abs(float(told[2]) * 1024 ** 2 / size - 1) < 0.005 and seconds(told[3]) > 0, lines[-1]
    report = json.load(open("slicemorph-demo/creature_to_ring/report.json"))
    assert len(report["frames"]) == 9
    program.refused("demo", "-o", "slicemorph-demo", says=["slicemorph-demo/creature_to_ring is there already"])
    program.refused("demo", ASSETS + "/blade.ply", says=["two shapes"])
    # What was there before stays, though nothing is in it; what was made for a demo that is refused goes.
    os.makedirs("mine/empty")
    os.symlink("mine", "link")
    with open("notes.txt", "w") as file:
        file.write("no shape")
    for folder in ("mine", "link", "new"):
        program.refused("demo", ASSETS + "/blade.ply", "notes.txt", "-o", folder, says=["notes.txt"])
    assert os.listdir("mine") == ["empty"] and os.path.islink("link") and not os.path.exists("new")


def case_demo_of_own_shapes():
    if not os.environ.get("SLICEMORPH_ALL_TESTS"):
        raise Skip("only with SLICEMORPH_ALL_TESTS")
    meshes()
    lines, _ = watched("demo", "blade.ply", "ring.ply", "-o", "mine")
    percents = [line[2] for line in lines]
    assert percents == sorted(percents) and any(line[1] == "meshing" for line in lines), lines
    assert os.listdir("mine") == ["blade_to_ring"] and os.path.exists("mine/blade_to_ring/blade_to_ring.png")


sys.exit(run_within(globals(), sys.argv[3:]))
