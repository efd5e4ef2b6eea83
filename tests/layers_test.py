#!/usr/bin/env python3
"""The tree shows the data flow: a folder includes only itself and folders before it. usage: layers_test.py REPOSITORY"""
import os
import re
import sys

repository = sys.argv[1]
# Folders of one line stand side by side; tools may include everything, io the engine, the engine only itself.
ORDER = [["volume"], ["frame", "spine"], ["slices"], ["contours"], ["match"], ["blend"], ["rebuild"], ["mean"], ["reconstruct"],
         ["measure", "peers", "render"], ["follow"]]
RANK = {folder: i for i, folders in enumerate(ORDER) for folder in folders}
errors = []
for top in ("engine", "io", "tools"):
    for folder, _, files in os.walk(os.path.join(repository, top)):
        for name in files:
            if not name.endswith((".h", ".cpp")):
                continue
            path = os.path.join(folder, name)
            mine = os.path.relpath(path, repository).split(os.sep)
            for included in re.findall(r'^#include "(.*?)"', open(path).read(), re.M):
                other = included.split("/")
                if top == "engine" and other[0] != "engine" or top == "io" and other[0] == "tools":
                    errors.append("%s includes %s" % ("/".join(mine), included))
                if top == "engine" and len(mine) == 3 and len(other) == 3:
                    if mine[1] not in RANK or other[1] not in RANK:
                        errors.append("%s or %s is in no known folder" % ("/".join(mine), included))
                    elif RANK[other[1]] > RANK[mine[1]]:
                        errors.append("%s includes %s, a later stage" % ("/".join(mine), included))
# The heavy headers cost 10 s and more each to compile.
HEAVY = ("MeshToVolume.h", "VolumeToMesh.h", "RayTracer.h", "FastSweeping.h", "LevelSetMorph.h", "LevelSetRebuild.h")
for heavy in HEAVY:
    users = [os.path.join(f, n) for top in ("engine", "io", "tools")
             for f, _, names in os.walk(os.path.join(repository, top)) for n in names
             if n.endswith((".h", ".cpp")) and "tools/" + heavy in open(os.path.join(f, n)).read()]
    if len(users) > 1:
        errors.append("%s is included by %s" % (heavy, ", ".join(users)))
print("\n".join(errors) or "the layers hold")
sys.exit(1 if errors else 0)
