#!/usr/bin/env python3
"""The guides are true: files and links exist, and the rows of the code's tables are in the guides.

usage: papers_test.py PROGRAM REPOSITORY
"""
import glob
import os
import re
import subprocess
import sys

PROGRAM, REPOSITORY = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
PAPERS = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "engine/README.md", "engine/bibliography.md",
          "io/README.md", "tools/README.md", "tests/README.md", "assets/README.md"]
FOLDERS = ("engine", "io", "tools", "tests", "assets")
# A path in backquotes may contain a name to be filled in, or stand for several files.
PATH = re.compile(r"`((?:%s)/[\w./*#-]*)`" % "|".join(FOLDERS))
KEY = re.compile(r"\[([A-Z][A-Za-z]+[0-9]{2})\]")
errors = []


def read(path):
    with open(os.path.join(REPOSITORY, path), encoding="utf-8") as file:
        return file.read()


def check_paths(paper):
    """A pattern with a name to be filled in (NAME, FOLDER) must fit a file that exists."""
    for path in PATH.findall(read(paper)):
        if path.startswith("assets/jobs/NAME"):
            continue
        pattern = re.sub(r"NAME|FOLDER", "*", path)
        if not glob.glob(os.path.join(REPOSITORY, pattern)):
            errors.append("%s names %s, which is not there" % (paper, path))


def anchors_of(text):
    """Anchor of a heading, as usual hosts make it: lower case, blanks to dashes, no other punctuation."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def check_links(paper):
    for target in re.findall(r"\]\(([^)\s]+)\)", read(paper)):
        if "://" in target:
            continue
        path, _, anchor = target.partition("#")
        whole = os.path.normpath(os.path.join(os.path.dirname(paper), path)) if path else paper
        if not os.path.exists(os.path.join(REPOSITORY, whole)):
            errors.append("%s links to %s, which is not there" % (paper, target))
        elif anchor and anchor not in anchors_of(read(whole)):
            errors.append("%s links to %s: there is no such heading" % (paper, target))


def sources():
    for top in FOLDERS[:4]:
        for folder, _, names in os.walk(os.path.join(REPOSITORY, top)):
            yield from (os.path.relpath(os.path.join(folder, name), REPOSITORY) for name in names
                        if name.endswith((".h", ".cpp")))


def check_bibliography():
    """Every key that is cited is in the bibliography, and every key there is cited."""
    known = set(re.findall(r"^- \[(\w+)\]", read("engine/bibliography.md"), re.M))
    cited = set()
    for path in list(sources()) + [paper for paper in PAPERS if paper != "engine/bibliography.md"]:
        text = read(path)
        if not path.endswith(".md"):
            text = "\n".join(re.findall(r"//.*", text))
        for key in KEY.findall(text):
            cited.add(key)
            if key not in known:
                errors.append("%s cites [%s], which is not in engine/bibliography.md" % (path, key))
    # Pictures have a text that names what they show.
    errors.extend("nothing cites [%s] of engine/bibliography.md" % key for key in sorted(known - cited - {"SP04"}))


def check_engine_map():
    """Every folder of the engine has a row in the map, and the files that a row names are in the folder."""
    text = read("engine/README.md")
    rows = {}
    for line in text[text.index("## Map of the code"):text.index("## The library")].splitlines():
        row = re.match(r"\| `([\w.]+)/?` \| (.*) \|$", line)
        if row:
            rows[row.group(1)] = row.group(2)
    engine = os.path.join(REPOSITORY, "engine")
    folders = {name for name in os.listdir(engine) if os.path.isdir(os.path.join(engine, name))} | {"."}
    errors.extend("the map of engine/README.md lacks %s" % folder for folder in sorted(folders - set(rows)))
    errors.extend("the map of engine/README.md has %s, which is not there" % folder for folder in sorted(set(rows) - folders))
    for folder in sorted(folders & set(rows)):
        for name in re.findall(r"`([\w./]+)`", rows[folder]):
            pattern = os.path.join(engine, folder, name if name.endswith(".h") else name + ".*")
            if not glob.glob(pattern):
                errors.append("the map of engine/README.md has %s in %s/" % (name, folder))


def check_formats():
    """Every extension of the code's table is in the table of io/README.md, and the other way round."""
    code = read("io/formats.cpp")
    code = code[code.index("Format dicom()"):code.index("const std::vector<Format>& formats()")]
    extensions = set(re.findall(r'"(\.[a-z.]+)"', code))
    text = read("io/README.md")
    table = text[text.index("## Formats"):text.index("Pictures and films")]
    documented = set(re.findall(r"`(?:[\w#.]+\.####)?(\.[a-z.]+)`", table))
    if len(extensions) < 15:
        errors.append("only %d extensions found in io/formats.cpp" % len(extensions))
    errors.extend("io/README.md lacks the extension %s" % e for e in sorted(extensions - documented))
    errors.extend("io/README.md has the extension %s, io/formats.cpp has not" % e for e in sorted(documented - extensions))


def help_of(command):
    result = subprocess.run([PROGRAM, command, "--help-all"], capture_output=True, text=True, timeout=60)
    if result.returncode:
        sys.exit("%s --help-all: %s" % (command, result.stderr))
    return result.stdout


def options_of(command):
    found = re.findall(r"^  (?:-\w,)?--([a-z][a-z-]*)", help_of(command), re.M)
    return set(found) - {"help", "help-all", "version"}


def check_options():
    """Every option of every command has a row in tools/README.md for that
    command, and every row is of an option."""
    letters = {"morph": "m", "apply": "a", "retime": "t", "slice": "s", "reconstruct": "r", "convert": "c", "render": "d", "compare": "p", "info": "i",
               "demo": "e", "pick": "k", "survey": "v"}
    text = read("tools/README.md")
    there = {name[:-len("_command.cpp")] for name in os.listdir(os.path.join(REPOSITORY, "tools/commands"))
             if name.endswith("_command.cpp")}
    # `plan` has the options of `morph`, which go into its file.
    if there != set(letters) | {"plan"}:
        errors.append("tools/README.md and this test tell of %s, there are %s" % (sorted(letters), sorted(there)))
    if options_of("plan") != options_of("morph"):
        errors.append("`plan` and `morph` have different options: %s" % sorted(options_of("plan") ^ options_of("morph")))
    documented = set()
    for names, commands in re.findall(r"^\| ([^|]*`--[^|]*) \| ([a-z ]+) \|", text, re.M):
        options = re.findall(r"--([a-z-]+)", names)
        for letter in commands.split():
            # In rows with both names `morph` has the one with the prefix, other commands the one without.
            mixed = any(option.startswith("exr-") for option in options)
            documented |= {(letter, o) for o in options if not mixed or (letter == "m") == o.startswith("exr-")}
    real = set()
    for command, letter in letters.items():
        if "`%s`" % command not in text:
            errors.append("tools/README.md lacks the command %s" % command)
        real |= {(letter, option) for option in options_of(command)}
    if len(real) < 100:
        errors.append("only %d options found in the help" % len(real))
    errors.extend("tools/README.md lacks --%s of %s" % (o, c) for c, l in letters.items()
                  for o in sorted(o for k, o in real - documented if k == l))
    errors.extend("tools/README.md has --%s of %s, the program has not" % (o, c) for c, l in letters.items()
                  for o in sorted(o for k, o in documented - real if k == l))


def check_methods():
    tables = [os.path.relpath(path, REPOSITORY) for path in glob.glob(os.path.join(REPOSITORY, "tools/job/*methods.cpp"))]
    names = [name for table in tables for name in re.findall(r'push_back\(\{"([\w-]+)"', read(table))]
    if len(names) < 4:
        errors.append("only %d methods found in tools/job/*methods.cpp" % len(names))
    errors.extend("tools/README.md lacks the method %s" % name for name in names if "`%s`" % name not in read("tools/README.md"))


def check_build():
    """The options of a build are in CONTRIBUTING.md."""
    text = read("CONTRIBUTING.md")
    for path in ["CMakeLists.txt"] + ["%s/CMakeLists.txt" % folder for folder in FOLDERS[:4]]:
        code = read(path)
        for name in re.findall(r"^\s*option\((\w+) ", code, re.M) + re.findall(r"^\s*set\((SLICEMORPH_\w+) \S* ?CACHE", code, re.M):
            if "`%s`" % name not in text:
                errors.append("CONTRIBUTING.md lacks %s of %s" % (name, path))


def check_environment():
    for path in sources():
        for name in re.findall(r'getenv\("(\w+)"\)', read(path)):
            if not any("`%s" % name in read(paper) for paper in PAPERS):
                errors.append("%s looks at %s, which no paper tells of" % (path, name))


for each in PAPERS:
    if not os.path.exists(os.path.join(REPOSITORY, each)):
        sys.exit("missing: " + each)
    check_paths(each)
    check_links(each)
check_bibliography()
check_engine_map()
check_formats()
check_options()
check_methods()
check_build()
check_environment()
print("\n".join(errors) or "the papers say what is so")
sys.exit(1 if errors else 0)
