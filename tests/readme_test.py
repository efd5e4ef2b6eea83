#!/usr/bin/env python3
"""Runs every slicemorph command of README.md, then of tools/README.md, in order, in one fresh folder.

usage: readme_test.py PROGRAM REPOSITORY

Meshes are read at a low resolution to be quick; nothing else is changed.
"""
import os
import re
import shlex
import subprocess
import sys
import tempfile

program, repository = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])


def text_of(paper):
    with open(os.path.join(repository, paper), encoding="utf-8") as file:
        return file.read()


def commands_of(paper):
    blocks = re.findall(r"```sh\n(.*?)```", text_of(paper), re.S)
    return [line for block in blocks for line in block.splitlines() if line.startswith("build/slicemorph ")]


# The guide's commands read what the README's wrote.
commands = []
for paper, least in (("README.md", 5), ("tools/README.md", 20)):
    found = commands_of(paper)
    if len(found) < least:
        sys.exit("found only %d commands in %s" % (len(found), paper))
    commands += found
failed = 0
with tempfile.TemporaryDirectory() as folder:
    os.symlink(os.path.join(repository, "assets"), os.path.join(folder, "assets"))
    for command in commands:
        words = shlex.split(command)
        words[0] = program
        if any(w.startswith("assets/") for w in words) and "--resolution" not in words:
            words += ["--resolution", "32"]
        result = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=900)
        print("%d  %s" % (result.returncode, command))
        if result.returncode:
            failed += 1
            print(result.stderr)
    for name in ("morph.0024.vdb", "morph.json", "sheet.png", "half.ply", "third.vdb", "slice.0016.exr", "morph.glb", "morph.html",
                 "keyed.0005.vdb", "beauty.0003.exr", "stack.0002.exr", "again.vdb", "dense.nii.gz", "mask.csv"):
        if not os.path.exists(os.path.join(folder, name)):
            failed += 1
            print("missing: " + name)
sys.exit(1 if failed else 0)
