#!/usr/bin/env python3
"""Every C++ source is formatted as clang-format does it. usage: format_test.py REPOSITORY

Skipped, with a message, where clang-format 14 is not installed: other versions break lines differently.
"""
import os
import shutil
import subprocess
import sys

repository = sys.argv[1]
program = shutil.which("clang-format-14") or shutil.which("clang-format")
version = subprocess.run([program, "--version"], capture_output=True, text=True).stdout if program else ""
if " 14." not in version:
    print("skipped: clang-format 14 is not there (found: %s)" % (version.strip() or "none"))
    sys.exit(0)
sources = [os.path.join(folder, name)
           for top in ("engine", "io", "tools", "tests")
           for folder, _, names in os.walk(os.path.join(repository, top))
           for name in names if name.endswith((".h", ".cpp"))]
if len(sources) < 100:
    sys.exit("found only %d sources in %s" % (len(sources), repository))
result = subprocess.run([program, "--dry-run", "--Werror", *sources], capture_output=True, text=True)
bad = sorted({line.split(":")[0] for line in result.stderr.splitlines() if "error:" in line})
print("\n".join(os.path.relpath(path, repository) for path in bad) or "%d sources are formatted" % len(sources))
sys.exit(1 if bad or result.returncode else 0)
