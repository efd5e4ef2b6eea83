#!/usr/bin/env python3
"""Runs every slicemorph command of the README, in order, in a fresh folder. usage: readme_test.py PROGRAM REPOSITORY

Meshes are read at a low resolution to be quick; nothing else is changed.
"""
import os
import re
import shlex
import subprocess
import sys
import tempfile

program, repository = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
text = open(os.path.join(repository, "README.md")).read()
blocks = re.findall(r"```sh\n(.*?)```", text, re.S)
commands = [line for block in blocks for line in block.splitlines() if line.startswith("build/slicemorph ")]
if len(commands) < 5:
    sys.exit("found only %d commands in the README" % len(commands))
failed = 0
with tempfile.TemporaryDirectory() as folder:
    os.symlink(os.path.join(repository, "assets"), os.path.join(folder, "assets"))
    for command in commands:
        words = shlex.split(command)
        words[0] = program
        if any(w.startswith("assets/") for w in words) and "--resolution" not in words:
            words += ["--resolution", "48"]
        result = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300)
        print("%d  %s" % (result.returncode, command))
        if result.returncode:
            failed += 1
            print(result.stderr)
    for name in ("morph.0024.vdb", "morph.json", "sheet.png", "half.ply", "third.vdb", "slice.0016.exr", "morph.glb", "morph.html"):
        if not os.path.exists(os.path.join(folder, name)):
            failed += 1
            print("missing: " + name)
pictures = re.findall(r"!\[.*?\]\((.*?)\)", text)
for picture in pictures:
    if not os.path.exists(os.path.join(repository, picture)):
        failed += 1
        print("missing picture: " + picture)
sys.exit(1 if failed else 0)
