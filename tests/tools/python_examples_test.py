#!/usr/bin/env python3
"""The examples of the Python package, and the lines of its README, run as they stand.

usage: python_examples_test.py PATH/TO/slicemorph FOLDER REPOSITORY [NAME...]
FOLDER: that holds the package; NAME: only the cases whose name contains it

Needs Debian's python3-openvdb, python3-nibabel, python3-matplotlib and mypy, and their Python.
"""
import os
import re
import subprocess
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import named_cases, run_cases, within

if len(sys.argv) < 4:
    sys.exit(__doc__)
PROGRAM, PACKAGE, REPOSITORY = map(os.path.abspath, sys.argv[1:4])
ONLY = sys.argv[4:]
EXAMPLES = os.path.join(REPOSITORY, "tools/python/examples")
SHAPES = [os.path.join(REPOSITORY, "assets", name) for name in ("die.ply", "octahedron.ply")]


def run(*words):
    path = os.pathsep.join([PACKAGE, "/usr/lib/python3/dist-packages"])
    result = subprocess.run([sys.executable, *words], capture_output=True, text=True, timeout=900,
                            env=dict(os.environ, PYTHONPATH=path, PYTHONWARNINGS="error::ResourceWarning"))
    assert result.returncode == 0, result.stderr[-2000:]
    return result.stdout


def example(name, *words):
    return run(os.path.join(EXAMPLES, name + ".py"), *words)


def case_two_balls():
    told = [float(n) for n in re.findall(r"([0-9.]+) at most", example("two_balls"))]
    assert len(told) == 5 and max(told) < 1, told
    assert all(os.path.getsize("balls.%04d.vdb" % n) > 1000 for n in range(1, 6))


def case_meshes():
    told = example("meshes", SHAPES[1])
    assert "vertices" in told and "%" in told and os.path.getsize("half.ply") > 1000, told


def case_scan():
    dice = float(re.search(r"structure: ([0-9.]+)", example("scan")).group(1))
    assert dice > 0.97 and os.path.exists("filled.nii.gz"), dice


def case_draw():
    example("draw", *SHAPES, "sheet.png")
    from matplotlib.image import imread
    picture = imread("sheet.png")
    assert picture.shape == (495, 1100, 4), picture.shape
    # Five shapes stand in the upper part: each fifth of it has grey pixels that are no letters.
    shapes = picture[60:280, :, :3]
    assert all((part.std(axis=-1) < 0.2).mean() > 0.3 and part.min(axis=-1).mean() < 0.95
               for part in (shapes[:, 220 * n:220 * n + 220] for n in range(5)))


def case_types():
    """The package has types, those of all options too: mypy finds no fault in it, and faults in what uses it wrongly."""
    mypy = ["/usr/bin/mypy", "--enable-incomplete-feature=Unpack", "--ignore-missing-imports", "--cache-dir", "cache"]
    with open("use.py", "w") as file:
        file.write("import slicemorph\nplan = slicemorph.plan('a', 'b', voxel_size=0.1, align='none', at=[0.5])\n"
                   "plan.frame(0.5).to_mesh().vertices.shape\nslicemorph.load('x', spacing=(1, 1, 2)).affine\n"
                   "slicemorph.plan('a', 'b', align='sideways')\nslicemorph.plan('a', 'b', frames='many')\nplan.frame('x')\n")
    environment = dict(os.environ, MYPYPATH=PACKAGE)
    package = subprocess.run([*mypy, "-p", "slicemorph"], capture_output=True, text=True, env=environment)
    assert package.returncode == 0, package.stdout + package.stderr
    told = subprocess.run([*mypy, "use.py"], capture_output=True, text=True, env=environment).stdout
    assert [int(n) for n in re.findall(r"^use.py:(\d+): error", told, re.M)] == [5, 6, 7], told


def case_all_examples_run():
    examples = {name[:-3] for name in os.listdir(EXAMPLES) if name.endswith(".py")}
    assert examples and examples <= {name for name, _ in CASES}, examples


def case_readme():
    """Every block of Python in the READMEs, in order, in one folder with the bundled shapes."""
    os.symlink(os.path.join(REPOSITORY, "assets"), "assets")
    for paper in ("README.md", "tools/python/README.md"):
        with open(os.path.join(REPOSITORY, paper), encoding="utf-8") as file:
            blocks = re.findall(r"```python\n(.*?)```", file.read(), re.S)
        assert blocks, "no lines of Python in " + paper
        # One program: blocks go on where the ones before ended.
        run("-c", "\n".join(blocks))


CASES = named_cases(globals())
sys.exit(run_cases([(name, within(case)) for name, case in CASES], ONLY))
