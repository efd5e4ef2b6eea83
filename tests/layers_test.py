#!/usr/bin/env python3
"""A folder includes only itself and folders before it in the data flow. usage: layers_test.py REPOSITORY

The public headers (include/slicemorph) are the lowest layer: they include each other and libraries only. A
folder that includes a header of a later folder, or of one in the same line, makes a cycle or hides one.
"""
import os
import re
import sys

repository = sys.argv[1]
# The engine's folders in the order of the data flow; those in one line must not include each other.
# "." is the pipeline itself, engine/*.h and *.cpp.
ENGINE = [["include"], ["numerics"], ["volume"], ["spine"], ["frame"], ["slices"], ["contours"], ["match"], ["blend"],
          ["rebuild"], ["mean"], ["."], ["sections"], ["reconstruct"], ["measure"], ["peers", "render", "follow"]]
RANK = {folder: i for i, folders in enumerate(ENGINE) for folder in folders}
# tools may include everything, io itself and the engine, the engine only itself.
ABOVE = {"engine": ("io", "tools"), "io": ("tools",), "tools": ()}
errors = []


def sources(top):
    for folder, _, names in os.walk(os.path.join(repository, top)):
        for name in names:
            if name.endswith((".h", ".cpp")):
                yield os.path.relpath(os.path.join(folder, name), repository)


def folder_of(path):
    """The folder of a file of the engine, relative to the engine."""
    parts = path.split("/")
    return parts[1] if len(parts) > 2 else "."


def file_of(included):
    """Path in the tree of the file that an include names; None for a library's header."""
    if not included.startswith("slicemorph/"):
        return included if included.split("/")[0] in ABOVE else None
    homes = [top + "/include/" + included for top in ABOVE if os.path.exists(os.path.join(repository, top, "include", included))]
    if len(homes) != 1:
        errors.append("%s is in %s" % (included, " and ".join(homes) or "no include folder"))
    return homes[0] if homes else None


def check_include(mine, included):
    other = file_of(included)
    if other is None:
        return
    top, other_top = mine.split("/")[0], other.split("/")[0]
    if other_top in ABOVE[top]:
        errors.append("%s includes %s: %s comes after %s" % (mine, included, other_top, top))
    if top != "engine" or other_top != "engine":
        return
    folder, other_folder = folder_of(mine), folder_of(other)
    if folder not in RANK or other_folder not in RANK:
        errors.append("%s or %s is in no folder that layers_test.py knows" % (mine, other))
    elif folder != other_folder and RANK[other_folder] >= RANK[folder]:
        where = "beside it" if RANK[other_folder] == RANK[folder] else "a later stage"
        errors.append("%s includes %s, %s" % (mine, included, where))


found = set()
for top in ABOVE:
    for path in sources(top):
        if top == "engine":
            found.add(folder_of(path))
        text = open(os.path.join(repository, path)).read()
        for included in re.findall(r'^#include "(.*?)"', text, re.M):
            check_include(path, included)
errors += ["engine/%s is in no order" % folder for folder in found - set(RANK)]
errors += ["engine/%s is in the order, but not in the tree" % folder for folder in set(RANK) - found]
# Jobs and reports serve hosts without command line and terminal; reports must not depend on jobs.
FORBIDDEN = {"a command line": r'#include\s*[<"]CLI/', "commands": r'#include "tools/commands/',
             "printing": r"#include\s*<iostream>|\b(?:printf|puts|putchar)\s*\(|\b(?:cout|cerr|stdout|stderr)\b",
             "exit codes": r"\b(?:std::)?(?:exit|abort|_Exit|quick_exit)\s*\("}
for path in sources("tools"):
    folder = path.split("/")[1]
    if folder not in ("job", "report"):
        continue
    text = re.sub(r"//.*", "", open(os.path.join(repository, path)).read())
    patterns = dict(FORBIDDEN, jobs=r'#include "tools/job/') if folder == "report" else FORBIDDEN
    for what, pattern in patterns.items():
        hit = re.search(pattern, text)
        if hit:
            errors.append("%s knows of %s: %s" % (path, what, hit.group()))
# The heavy headers cost 10 s and more each to compile.
HEAVY = ("MeshToVolume.h", "VolumeToMesh.h", "RayTracer.h", "FastSweeping.h", "LevelSetMorph.h", "LevelSetRebuild.h")
for heavy in HEAVY:
    users = [path for top in ABOVE for path in sources(top)
             if "tools/" + heavy in open(os.path.join(repository, path)).read()]
    if len(users) > 1:
        errors.append("%s is included by %s" % (heavy, ", ".join(users)))
print("\n".join(errors) or "the layers hold")
sys.exit(1 if errors else 0)
