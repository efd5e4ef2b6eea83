#!/usr/bin/env python3
"""Job files of `slicemorph morph`: the examples in assets/jobs, --print-config, and messages for wrong ones.

usage: jobs_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

Volumes are read with Debian's python3-openvdb; that part is skipped, with a message, where it is not installed.
"""
import glob
import json
import os
import re
import shlex
import shutil
import subprocess
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import named_cases, run_cases
from frames import sums

if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, REPOSITORY, ONLY = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3:]
JOBS = sorted(glob.glob(os.path.join(REPOSITORY, "assets/jobs/*.toml")))

BASE = 'inputs = ["x/fish.ply", "b.ply"]\noutput = "m.####.vdb"\n'
FEATURE = '[[feature]]\nname = "nose"\n'
REGION = '[[region]]\nname = "head"\nweights = [0, 1]\n'

# (name, text after the two lines of BASE, line:column, texts of the message)
WRONG = [
    ("unknown key", "sices = 3\n", "3:1", ["'sices'", "slices", "feature", "keys"]),
    ("value out of range", "slices = 2\n", "3:10", ["--slices 2", "8 to 1024"]),
    ("choice", 'timing = "quadratic"\n', "3:10", ["quadratic", "smoothstep"]),
    ("interpolation", 'interpolation = "cubic"\n', "3:17", ["cubic", "intrinsic"]),
    ("easing", 'ease = "bounce"\n', "3:8", ["--ease bounce", "in-out", "X1,Y1"]),
    ("easing back in time", "ease = [0.5, 0, 1.5, 1]\n", "3:8", ["1.5", "0 to 1"]),
    ("iso", 'iso = "high"\n', "3:7", ["--iso high", "number"]),
    ("two ways of time", "frames = 3\nat = 0.5\n", "3:10", ["exclude"]),
    ("weights count", "weights = [1, 1, 1]\n", "3:11", ["3 numbers for 2 inputs"]),
    ("weights negative", "weights = [-1, 2]\n", "3:11", ["-1 is negative"]),
    ("weights zero", "weights = [0, 0]\n", "3:11", ["0,0", "all 0"]),
    ("weights and keys", 'weights = [1, 1]\nkeys = "a@0 b@1"\n', "4:8", ["--keys", "--frames or --at"]),
    ("keys text", 'keys = "a@0 c@1"\n', "3:8", ["'c' is no input", "1 'fish' (x/fish.ply)", "2 'b'"]),
    ("keys type", "keys = 3\n", "3:8", ["'keys'", "{at = 0"]),
    ("keys time", 'keys = [\n  {at = 0, input = "a"},\n  {at = 2, input = "b"},\n]\n', "5:9", ["key 2", "2", "0 to 1"]),
    ("keys fall", 'keys = [{at = 0.5, input = "a"}, {at = 0.5, input = "b"}]\n', "3:40", ["key 2", "not after 0.5", "rise"]),
    ("keys input", 'keys = [{at = 0, input = "fox"}]\n', "3:26", ["key 1", "'fox' is no input", "fish"]),
    ("keys weights", "keys = [{at = 0, weights = [1]}]\n", "3:28", ["key 1", "1 numbers for 2 inputs"]),
    ("keys both", 'keys = [{at = 0, input = "a", weights = [1, 0]}]\n', "3:9", ["key 1", "exactly one of weights, input"]),
    ("keys neither", "keys = [{at = 0}]\n", "3:9", ["none of weights, input"]),
    ("keys without time", 'keys = [{input = "a"}]\n', "3:9", ["key 1", "has no at"]),
    ("keys unknown", 'keys = [{at = 0, inptu = "a"}]\n', "3:18", ["'inptu'", "at, input, weights"]),
    ("feature no table", "feature = 3\n", "3:11", ["[[feature]]"]),
    ("feature unknown key", FEATURE + "pont = 3\n", "5:1", ["feature 'nose'", "'pont'", "point, line, disk"]),
    ("job's key in a feature", FEATURE + "frames = 3\n", "5:1", ["'frames'"]),
    ("feature empty", FEATURE, "3:1", ["feature 'nose'", "none of point, line, disk"]),
    ("feature two kinds", FEATURE + "point = []\nline = []\n", "3:1", ["has point, line", "exactly one"]),
    ("feature places", FEATURE + "point = [[0, 0, 0]]\n", "5:9", ["1 items for 2 inputs"]),
    ("feature place", FEATURE + "point = [[0, 0, 0], [0, 1]]\n", "5:21", ["point of input 2", "[x, y, z]"]),
    ("feature number", FEATURE + 'point = [[0, 0, 0], [0, "1", 2]]\n', "5:25", ["point of input 2", "finite number"]),
    ("feature infinite", FEATURE + "point = [[0, 0, 0], [0, inf, 2]]\n", "5:25", ["inf", "finite number"]),
    ("feature name", "[[feature]]\nname = 3\n", "4:8", ["feature 1", "text"]),
    ("feature without name", "[[feature]]\npoint = [[0, 0, 0], [0, 0, 0]]\n[[feature]]\n", "5:1", ["feature 2"]),
    ("line of one place", FEATURE + "line = [[[0, 0, 0]], [[0, 0, 0], [1, 0, 0]]]\n", "5:9", ["line of input 1", "two or more"]),
    ("line without length", FEATURE + "line = [[[0, 0, 0], [0, 0, 0]], []]\n", "5:9", ["no length"]),
    ("disk without normal", FEATURE + "disk = [{center = [0, 0, 0], radius = 1}, {}]\n", "5:9", ["has no normal"]),
    ("disk normal", FEATURE + "disk = [{center = [0, 0, 0], normal = [0, 0, 0], radius = 1}, {}]\n", "5:39",
     ["disk of input 1", "no length"]),
    ("disk radius", FEATURE + "disk = [{center = [0, 0, 0], normal = [0, 0, 1], radius = -1}, {}]\n", "5:59",
     ["radius -1", "above 0"]),
    ("disk unknown key", FEATURE + "disk = [{centre = [0, 0, 0]}, {}]\n", "5:10", ["'centre'", "center, normal, radius"]),
    ("region unknown key", REGION + "borders = 3\n", "6:1", ["region 'head'", "'borders'", "border"]),
    ("region empty", REGION, "3:1", ["none of sphere, box, spine"]),
    ("region sphere", REGION + "sphere = {center = [0, 0, 0], radius = 0}\n", "6:40", ["radius 0", "above 0"]),
    ("region box", REGION + "box = {min = [0, 0, 0], max = [1, 0, 1]}\n", "6:31", ["max", "above min"]),
    ("region spine", REGION + "spine = [0.5, 0.5]\n", "6:9", ["spine", "0 <= FROM < TO <= 1"]),
    ("region spine outside", REGION + "spine = [0.5, 1.5]\n", "6:9", ["FROM < TO"]),
    ("region border", REGION + "spine = [0, 1]\nborder = -0.1\n", "7:10", ["border -0.1", "0 or more"]),
    ("region on", REGION + 'spine = [0, 1]\non = "fox"\n', "7:6", ["'fox' is no input", "fish"]),
    ("region weights", "[[region]]\nspine = [0, 1]\nweights = [0, -1]\n", "5:11", ["region 1", "-1 is negative"]),
    ("region weights zero", "[[region]]\nspine = [0, 1]\nweights = [0, 0]\n", "5:11", ["all 0"]),
    ("region weights and input", REGION + 'spine = [0, 1]\ninput = "b"\n', "3:1", ["weights, input"]),
    ("region of another method", 'method = "sdf"\n[[region]]\nspine = [0, 1]\ninput = "b"\n', "4:1", ["--method slices", "sdf"]),
    ("landmarks", "landmarks = [[[0, 0, 0], [0, 0, 1], [0, 0, 2]]]\n", "3:13", ["--landmarks", "3 places for 2 inputs"]),
    ("landmarks of one place", "landmarks = [[[0, 0, 0]]]\n", "3:13", ["'landmarks'", "for every input"]),
    ("missing input", "frames = 2\n", "1:10", ["x/fish.ply", "no such file"]),
]

# Every kind of option, with names that need escapes in quotes; none of the files exists.
ALL_OPTIONS = r'''
morph "a \"b\" c.ply" 'back\slash.vdb:den sity' "grün.obj" -o "out put.####.vdb" --frames 7 --keys "1@0 2@0.125 grün@0.7 1@1"
--timing catmull-rom --ease 0.1,0.2,0.3,1.1 --voxel-size 0.0123456789012345678 --iso 300/250,-7.5e-3/0.1 --image grey --spacing 1,2.5,3
--landmarks a.txt,b.txt,c.txt --check-landmarks "1,2,3=4,5,6=7,8,9;0.1,0.2,0.3=1e-9,5,6=7,8,9" --slices 50 --samples 77 --axis 0,1,0.5
--spine curved --align none --interpolation hermite --grids surface,density --conserve --velocity v --velocity-unit frame
--add-velocity --fps 29.97 --glb-up z --glb-unit mm --threads 3 --report "r 1.json" --report r2.csv --dump-slices "dir x" --resume --quiet
'''


def run(*words, cwd):
    return subprocess.run([PROGRAM, *map(str, words)], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=600,
                          universal_newlines=True, encoding="utf-8")


def done(*words, cwd):
    result = run(*words, cwd=cwd)
    assert result.returncode == 0, "exit code %d: %s" % (result.returncode, result.stderr)
    return result


def check_volumes(paths):
    """Level sets named `surface` with an inside."""
    script = """import pyopenvdb as v, sys
for path in sys.argv[1:]:
    g = v.read(path, 'surface')
    assert g.gridClass == 'level set', (path, g.gridClass)
    assert g.activeVoxelCount() > 1000 and g.evalMinMax()[0] < 0, (path, g.activeVoxelCount())
"""
    # Debian's module belongs to Debian's interpreter.
    if subprocess.run(["/usr/bin/python3", "-c", "import pyopenvdb"], stderr=subprocess.DEVNULL).returncode:
        print("      python3-openvdb is not there to look at the volumes")
        return
    result = subprocess.run(["/usr/bin/python3", "-c", script, *paths], stderr=subprocess.PIPE, universal_newlines=True)
    assert result.returncode == 0, result.stderr


def round_trip(o, *words):
    """--print-config of a file that --print-config wrote gives the same file, which is returned."""
    first = done("morph", *words, "--print-config", cwd=o).stdout
    path = os.path.join(o, "printed.toml")
    open(path, "w", encoding="utf-8").write(first)
    second = done("morph", "--config", path, "--print-config", cwd=o).stdout
    assert first == second, "differ:\n%s\n%s" % (first, second)
    return path


def settings_of(report):
    settings = json.load(open(report))["settings"]
    return {key: value for key, value in settings.items() if key not in ("output", "range")}


def run_example(job, o):
    """The job's frames exist and are not empty; a printed copy of it is the same job: it takes the same plan, which holds
    for one job's settings alone, and gives the same second frame."""
    os.symlink(os.path.join(REPOSITORY, "assets"), os.path.join(o, "assets"))
    text = open(job).read()
    output = re.search(r'^output = "(.*?)"', text, re.M).group(1)
    for folder in ("frames", "again"):
        os.mkdir(os.path.join(o, folder))
    # Plans know their job file by its name.
    here = os.path.join(o, "job.toml")
    shutil.copy(job, here)
    done("plan", "--config", here, "-o", "x.plan", cwd=o)
    by_plan = ["--config", here, "--plan", "x.plan"]
    made = done("morph", "-o", "frames/" + output, "--report", "r.json", *by_plan, cwd=o).stdout.split("\n")[:-1]
    files = [os.path.join(o, line) for line in made]
    assert files and all(os.path.getsize(f) > 0 for f in files), made
    report = json.load(open(os.path.join(o, "r.json")))
    assert len(files) == (1 if output.endswith(".glb") else len(report["frames"])), made
    if output.endswith(".vdb"):
        check_volumes(files)
    for frame in report["frames"]:
        assert abs(sum(frame["weights"]) - 1) < 1e-9, frame["weights"]
    if "keyed" in job:
        check_keyed(report)
    os.replace(round_trip(o, "--config", job), here)
    one = ["--range", 2] if "#" in output else []
    done("morph", "-o", "again/" + output, "--report", "b.json", *one, *by_plan, cwd=o)
    first, again = settings_of(os.path.join(o, "r.json")), settings_of(os.path.join(o, "b.json"))
    assert first and first == again, (first, again)
    ending = os.path.splitext(output)[1]
    made, again = (sums(os.path.join(o, folder), ending) for folder in ("frames", "again"))
    assert len(again) == 1 and again.items() <= made.items(), (made, again)


def check_keyed(report):
    """At a key's time the weights are the key's; between keys a smooth course differs from the linear one."""
    at = {frame["t"]: frame["weights"] for frame in report["frames"]}
    assert at[0] == [1, 0, 0] and at[0.4] == [0, 1, 0] and at[0.6] == [0, 0.5, 0.5] and at[1] == [1, 0, 0], at
    assert [key["at"] for key in report["settings"]["keys"]] == [0, 0.4, 0.6, 0.8, 1]
    assert report["settings"]["timing"] == "catmull-rom"
    assert abs(at[0.2][0] - 0.5) > 0.01, at[0.2]


def case_all_options(o):
    path = round_trip(o, *shlex.split(ALL_OPTIONS)[1:])
    text = open(path, encoding="utf-8").read()
    for line in (r'inputs = ["a \"b\" c.ply", "back\\slash.vdb:den sity", "grün.obj"]', "frames = 7", "ease = [0.1, 0.2, 0.3, 1.1]",
                 "voxel-size = 0.0123456789012345", "# resolution =", 'iso = "300/250,-7.5e-3/0.1"', 'axis = "0,1,0.5"',
                 'landmarks = "a.txt,b.txt,c.txt"', "check-landmarks = [[[1, 2, 3], [4, 5, 6], [7, 8, 9]], ", "resume = true",
                 'report = ["r 1.json", "r2.csv"]', "# at =", "# fov = 25", '# size = "640x480"'):
        assert "\n" + line in text, line + "\nis not in\n" + text
    assert '{at = 0.7, input = "grün"}' in text, text


def case_bare(o):
    """Without inputs --print-config prints a file to be filled in, which sets nothing."""
    text = done("morph", "--print-config", cwd=o).stdout
    for line in ("# slices = 96", "# frames = 24", "# inputs =", "# quiet = false", '# timing = "linear"', "# keys =", "# [[feature]]",
                 "# [[region]]"):
        assert "\n" + line in text, line
    assert not [l for l in text.split("\n") if l and l[0] != "#"], text
    for option in re.findall(r"--([a-z][a-z-]+)", done("morph", "--help-all", cwd=o).stdout):
        if option not in ("help", "help-all", "config", "print-config", "plan"):  # what names files of options is not in one
            assert re.search(r"^# %s =" % option, text, re.M) or option in ("method",), option


def case_guidance_is_printed(o):
    """Features, regions and keys as tables are printed as they were read."""
    open(o + "/job.toml", "w").write(BASE + '''keys = [{at = 0.1, input = "fish"}, {at = 0.5, weights = [1, 2]}, {at = 1, input = "2"}]
[[feature]]
point = [[0.1, 2, 3], [4, 5, 6e-7]]
[[feature]]
name = "a \\"leg\\""
line = [[[0, 0, 0], [1, 1, 1]], [[0, 0, 0], [1, 1, 1], [2, 2, 2]]]
[[feature]]
disk = [{center = [0, 0, 0], normal = [0, 0, 2], radius = 1}, {center = [0, 0, 0.25], normal = [0, 1, 0], radius = 0.3}]
[[region]]
on = "2"
box = {min = [0, 0, 0], max = [1, 1, 1]}
weights = [3, 1]
[[region]]
spine = [0, 0.4]
border = 0.125
input = "b"
''')
    text = open(round_trip(o, "--config", "job.toml")).read()
    for line in ('  {at = 0.1, input = "fish"},', "  {at = 0.5, weights = [0.333333333333333", 'name = "feature 1"',
                 "point = [[0.1, 2, 3], [4, 5, 6e-07]]", r'name = "a \"leg\""', 'on = "b"', "weights = [0.75, 0.25]", "spine = [0, 0.4]",
                 "border = 0.125", "line = [[[0, 0, 0], [1, 1, 1]], [[0, 0, 0], [1, 1, 1], [2, 2, 2]]]"):
        assert "\n" + line in text, line + "\nis not in\n" + text
    notes = run("morph", "--config", "job.toml", "--print-config", cwd=o).stderr
    assert "note: job.toml:3:58: key 2: weights [ 1, 2 ] sum to 3: taken as 0.333333333,0.666666667" in notes, notes
    assert "region 1: weights [ 3, 1 ] sum to 4: taken as 0.75,0.25" in notes, notes
    quiet = run("morph", "--config", "job.toml", "--print-config", "--quiet", cwd=o)
    assert quiet.stderr == "" and "\nquiet = true" in quiet.stdout, quiet.stderr


def case_command_line_wins(o):
    open(o + "/job.toml", "w").write(BASE + 'keys = "a@0 b@1"\ntiming = "smoothstep"\nresolution = 20\nframes = 3\n')
    def printed(*words):
        return done("morph", "--config", "job.toml", "--print-config", *words, cwd=o).stdout
    text = printed("--weights", "1,3")
    for line in ("weights = [0.25, 0.75]", "# keys =", '# timing = "linear"', "# frames = 24", "resolution = 20"):
        assert "\n" + line in text, line + "\n" + text
    text = printed("--keys", "b@0 a@1", "--voxel-size", "0.5", "--at", "0.25")
    for line in ('  {at = 0, input = "b"},', "voxel-size = 0.5", "# resolution =", "at = 0.25", 'timing = "smoothstep"'):
        assert "\n" + line in text, line + "\n" + text


def case_notes(o):
    """Notes are on stderr, and absent with --quiet."""
    base = ["morph", "a.ply", "b.ply", "c.ply", "-o", "m.####.vdb", "--print-config"]
    assert done(*base, "--keys", "a@0 b@1", cwd=o).stderr == "note: --keys: no key shows c.ply\n"
    assert done(*base, "--weights", "1,3,0", cwd=o).stderr == "note: --weights 1,3,0 sum to 4: taken as 0.25,0.75,0\n"
    assert done(*base, "--weights", "1,3,0", "--quiet", cwd=o).stderr == ""
    assert done(*base, "--weights", "0.1,0.3,0.6", cwd=o).stderr == ""


def case_print_config_checks(o):
    """Errors are reported with --print-config, too."""
    result = run("morph", "a.ply", "b.ply", "-o", "m.####.vdb", "--slices", "3", "--print-config", cwd=o)
    assert result.returncode == 2 and "--slices 3" in result.stderr and result.stdout == "", result
    result = run("morph", b"a\xff.ply".decode("utf-8", "surrogateescape"), "b.ply", "-o", "m.####.vdb", "--print-config", cwd=o)
    assert result.returncode == 2 and "--print-config" in result.stderr, result


def wrong_job(case, o):
    name, text, location, says = case
    open(o + "/job.toml", "w").write(BASE + text)
    result = run("morph", "--config", "job.toml", cwd=o)
    assert result.returncode == (1 if name == "missing input" else 2), (result.returncode, result.stderr)
    assert result.stderr.startswith("slicemorph: job.toml:%s: " % location), result.stderr
    for said in says:
        assert said in result.stderr, "'%s' is not in: %s" % (said, result.stderr)
    assert os.listdir(o) == ["job.toml"], os.listdir(o)


if len(JOBS) < 6:
    sys.exit("found only %d jobs" % len(JOBS))
CASES = [("wrong: " + c[0], lambda o, c=c: wrong_job(c, o)) for c in WRONG]
CASES += [(name.replace("_", " "), case) for name, case in sorted(named_cases(globals()))]
CASES += [("example " + os.path.basename(job), lambda o, job=job: run_example(job, o)) for job in JOBS]
sys.exit(run_cases(CASES, ONLY))
