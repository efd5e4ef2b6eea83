#!/usr/bin/env python3
"""The add-on for Blender, installed from its zip and used in Blender without a window.

usage: blender_test.py SLICEMORPH ZIP REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

Each case is a function of tests/tools/blender/addon_cases.py, which runs in a Blender of its own. Skipped where
Blender is not installed.
"""
import ast
import os
import re
import shutil
import subprocess
import sys
import zipfile

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_cases
from program import Program

if len(sys.argv) < 4:
    sys.exit(__doc__)
PROGRAM, ZIP, REPOSITORY = (os.path.abspath(path) for path in sys.argv[1:4])
CASES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "blender", "addon_cases.py")


def inside(name):
    """A case that runs in Blender, with the program on the PATH and settings of its own."""
    def case(folder):
        if not shutil.which("blender"):
            raise Skip("Blender is not installed")
        # Blender takes the modules of the first Python on the PATH.
        environment = dict(os.environ, PATH=os.pathsep.join([os.path.dirname(PROGRAM), "/usr/bin", os.environ["PATH"]]),
                           BLENDER_USER_SCRIPTS=folder + "/scripts", BLENDER_USER_CONFIG=folder + "/config", TMPDIR=folder)
        result = subprocess.run(["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "--python", CASES,
                                 "--", name, ZIP, folder, REPOSITORY], capture_output=True, text=True, errors="replace",
                                timeout=900, env=environment)
        for line in result.stdout.splitlines():
            if line.startswith("  "):
                print(line)
        assert result.returncode == 0, (result.stdout + result.stderr)[-2500:]
    return case


def versions(folder):
    """The zip holds one folder, and its two descriptions have the program's version."""
    with zipfile.ZipFile(ZIP) as file:
        assert {name.split("/")[0] for name in file.namelist()} == {"slicemorph"}, file.namelist()
        manifest = file.read("slicemorph/blender_manifest.toml").decode()
        source = file.read("slicemorph/__init__.py").decode()
    info = next(ast.literal_eval(line.value) for line in ast.parse(source).body
                if isinstance(line, ast.Assign) and line.targets[0].id == "bl_info")
    version = Program(PROGRAM).run("--version").stdout.split()[1]
    assert re.search(r'^version = "(.*)"$', manifest, re.M)[1] == version == ".".join(map(str, info["version"]))
    assert info["blender"] == (3, 4, 0) and 'blender_version_min = "4.2.0"' in manifest


names = re.findall(r"^def case_(\w+)", open(CASES).read(), re.M)
sys.exit(run_cases([("versions", versions)] + [(name, inside(name)) for name in names], sys.argv[4:]))
