#!/usr/bin/env python3
"""Man pages and the completion for bash: `man` formats them without a warning, they name every option of the help, and
completion proposes what can be typed. Oracles: man-db, groff and bash.

usage: manual_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's man-db and groff-base.
"""
import os
import re
import subprocess
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import run_within
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
program = Program(sys.argv[1])
ONLY = sys.argv[2:]
WIDE = dict(os.environ, MANWIDTH="200", MANROFFOPT="", LC_ALL="C.UTF-8")


def written():
    program.run("--manual", "manual")
    return sorted(name for name in os.listdir("manual") if name.endswith(".1"))


def commands():
    return re.findall(r"^  ([a-z]+) ", program.run("--help").stdout, re.M)


def case_a_page_for_each_command():
    names = commands()
    assert len(names) > 8, names
    assert written() == sorted(["slicemorph.1"] + ["slicemorph-%s.1" % name for name in names])


def case_man_takes_them():
    for page in written():
        shown = subprocess.run(["man", "--warnings", "-l", "manual/" + page], capture_output=True, text=True, env=WIDE)
        assert shown.returncode == 0 and not shown.stderr, (page, shown.stderr)
        # The line that `apropos` finds.
        named = subprocess.run(["lexgrog", "manual/" + page], capture_output=True, text=True)
        assert named.returncode == 0 and page[:-2] + " - " in named.stdout, (page, named.stdout, named.stderr)


def case_every_option_of_the_help():
    written()
    for name in commands():
        page = subprocess.run(["man", "-l", "manual/slicemorph-%s.1" % name], capture_output=True, text=True, env=WIDE).stdout
        text = " ".join(page.replace("\u2010\n", "").split())
        for line in program.run(name, "--help-all").stdout.splitlines():
            for option in re.findall(r"^ {2,}(?:-\w,\s*)?(--[a-z0-9-]+)", line):
                assert option + " " in text, (name, option)


def proposed(*words):
    """What bash proposes for the last of these words."""
    script = ". manual/slicemorph.bash; COMP_WORDS=(%s); COMP_CWORD=%d; _slicemorph; printf '%%s\\n' \"${COMPREPLY[@]}\"" % (
        " ".join("'%s'" % word for word in words), len(words) - 1)
    result = subprocess.run(["bash", "-euc", script], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return result.stdout.split()


def case_completion():
    written()
    assert set(commands()) <= set(proposed("slicemorph", ""))
    assert proposed("slicemorph", "rec") == ["reconstruct"]
    assert "--frames" in proposed("slicemorph", "morph", "a.vdb", "--fr")
    assert "--frames" not in proposed("slicemorph", "info", "--")
    section = re.search(r"^Methods:\n((?:  .*\n)+)", program.run("morph", "--help-all").stdout, re.M).group(1)
    methods = re.findall(r"^  (\S+)", section, re.M)
    assert methods[0] == "slices" and len(methods) >= 4
    assert sorted(proposed("slicemorph", "morph", "--method", "")) == sorted(methods)
    # Nothing: bash then proposes files.
    assert proposed("slicemorph", "morph", "-o", "") == [] == proposed("slicemorph", "morph", "a")


def case_a_folder_that_cannot_be_made():
    open("file", "w").close()
    program.refused("--manual", "file/below", says=["file/below"])


sys.exit(run_within(globals(), ONLY))
