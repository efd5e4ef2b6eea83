#!/usr/bin/env python3
"""`survey`: every method on the same objects. Figures of the table against closed forms and brute force, the score against the words
that tell it, the page in headless Chromium without a network, refusals.

usage: survey_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)
       survey_test.py --screenshot PAGE.html PICTURE.png [WIDTH [HEIGHT]]

Methods are asked for by name only where a closed form is theirs. The case of the page is skipped, with a message, where Chromium
is not installed.
"""
import csv
import json
import math
import os
import re
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from browser import Browser
from cases import run_within
from meshes import box_obj, sphere_obj
from program import Program

FIGURES = ("t", "volume", "area", "pieces", "genus", "change", "stretch_mean", "stretch_worst", "distance_mean", "distance_p95", "distance_max",
           "distance_percent_of_diagonal")


def table(path):
    """Per method its lines, in the order of the table."""
    methods = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            methods.setdefault(row["method"], []).append({k: float(v) if k in FIGURES + ("score",) and v else v for k, v in row.items()})
    return methods


def surveyed(*arguments):
    program.run("survey", *arguments, "-o", "page.html", "--csv", "table.csv", "--quiet")
    return table("table.csv")


def balls():
    """Of radius 1 and 2 about one middle. Their meshes, of 64 x 128 sides, lie within a tenth of a percent of them."""
    return sphere_obj("small.obj", 1, 64), sphere_obj("large.obj", 2, 64)


VOXELS = 32
#: Frames' voxels are those of the inputs or between, at most those of the larger ball; a surface in them is true to half a voxel.
HALF = 0.5 * 4 / VOXELS


def case_balls_against_closed_forms():
    rows = surveyed(*balls(), "--resolution", VOXELS, "--method", "sdf", "--method", "slices")
    assert set(rows) == {"sdf", "slices"}
    for name, frames in rows.items():
        assert [f["t"] for f in frames] == [i / 8 for i in range(9)], name
        before = None
        for f in frames:
            r = 1 + f["t"]
            assert abs((f["volume"] * 3 / 4 / math.pi) ** (1 / 3) - r) < HALF, (name, f)
            assert abs((f["area"] / 4 / math.pi) ** 0.5 - r) < HALF, (name, f)
            assert (f["pieces"], f["genus"]) == (1, 0), (name, f)
            shell = 4 / 3 * math.pi * (r ** 3 - (r - 1 / 8) ** 3)
            # Both surfaces of the shell may be off.
            assert before is None or abs(f["change"] - shell) < 2 * HALF * 4 * math.pi * r * r, (name, f, shell)
            before = f
        for end, file in ((frames[0], "small.obj"), (frames[-1], "large.obj")):
            assert end["compared_with"] == file and end["distance_max"] < HALF, (name, end)
        assert all(f["compared_with"] == "" for f in frames[1:-1])
    # Only methods that map surfaces tell how these are stretched.
    assert all(f["stretch_mean"] == "" for f in rows["sdf"]) and all(f["stretch_mean"] >= 1 for f in rows["slices"])


def case_true_frame():
    sphere_obj("true.obj", 1.6, 64)
    rows = surveyed(*balls(), "--method", "sdf", "--method", "slices", "--method", "levelset", "--frames", 5, "--resolution", VOXELS,
                    "--truth", "t=0.5:true.obj")
    for name in ("sdf", "slices"):
        f = rows[name][2]
        # Half way these are balls of 1.5: everywhere a tenth away.
        assert f["compared_with"] == "true.obj"
        for key in ("distance_mean", "distance_p95", "distance_max"):
            assert abs(f[key] - 0.1) < HALF, (name, f)
        assert f["distance_mean"] <= f["distance_p95"] <= f["distance_max"]
        diagonal = 3.2 * math.sqrt(3)
        assert abs(f["distance_percent_of_diagonal"] - 100 * f["distance_mean"] / diagonal) < 0.02 * f["distance_percent_of_diagonal"], f
    for frames in rows.values():
        assert all(f["score"] == frames[2]["distance_percent_of_diagonal"] for f in frames), frames
    scores = [frames[0]["score"] for frames in rows.values()]
    assert scores == sorted(scores) and [frames[0]["rank"] for frames in rows.values()] == ["1", "2", "3"]


def box_distance(p, half):
    q = np.abs(p) - half
    return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(-1), 0)


def case_bar_turned():
    """A bar turned by 90 degrees about z."""
    long, short = 3, 0.5
    box_obj("across.obj", (-long, -short, -short), (long, short, short))
    box_obj("upright.obj", (-short, -long, -short), (short, long, short))
    rows = surveyed("across.obj", "upright.obj", "--method", "sdf", "--method", "slices", "--frames", 5, "--resolution", 48,
                    "--upright", "none")
    voxel = 2 * long / 48
    for name, frames in rows.items():
        for end in (frames[0], frames[-1]):
            # Edges of boxes are cut off in voxels: by less than one along 4 x (6 + 1 + 1).
            assert abs(end["volume"] - 6) < 26 * voxel / 2 and abs(end["area"] - 26) < 32 * voxel * 2, (name, end)
            assert end["distance_mean"] < voxel / 2, (name, end)
    # The blend of distances, half way, by brute force in voxels of half the size.
    axis = np.arange(-1.6, 1.6, voxel / 2)
    p = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1)
    inside = box_distance(p, (long, short, short)) + box_distance(p, (short, long, short)) < 0
    volume = inside.sum() * (voxel / 2) ** 3
    middle = rows["sdf"][2]
    assert 0 < volume < 6 and abs(middle["volume"] - volume) < middle["area"] * voxel / 2, (middle, volume)
    # What is in one frame alone is never less than the difference of volumes, nor more than their sum.
    for frames in rows.values():
        for a, b in zip(frames, frames[1:]):
            assert abs(a["volume"] - b["volume"]) - 1e-3 <= b["change"] <= a["volume"] + b["volume"] + 1e-3, (a, b)
    # Turned as a whole it stays what it is: the best of these figures.
    assert list(rows)[0] == "slices", rows
    for f in rows["slices"]:
        assert abs(f["volume"] - 6) < 26 * voxel / 2 and (f["pieces"], f["genus"]) == (1, 0), f


def told_score(frames, ends):
    """The score as the page tells it. `ends`: figures of the inputs."""
    def mean(values):
        values = list(values)
        return sum(values) / len(values)

    def line(f, size):
        return size(ends[0]) * (1 - f["t"]) + size(ends[1]) * f["t"]

    def outside(f, key):
        low, high = sorted(float(e[key]) for e in ends)
        return max(0, f[key] - high, low - f[key])

    points = 10 * mean(e["distance_percent_of_diagonal"] for e in (frames[0], frames[-1]))
    points += 10 * mean(outside(f, "pieces") + outside(f, "genus") for f in frames)
    points += mean(100 * abs(f["volume"] ** (1 / 3) / line(f, lambda e: e["volume"] ** (1 / 3)) - 1) for f in frames)
    points += mean(100 * abs(f["area"] ** 0.5 / line(f, lambda e: e["area"] ** 0.5) - 1) for f in frames)
    steps = [f["change"] for f in frames[1:]]
    return points + 0.1 * mean(100 * abs(s / mean(steps) - 1) for s in steps)


def case_score_is_as_told():
    """All methods that there are."""
    # A ball to two: pieces change.
    two = sphere_obj("left.obj", 0.7, 24, (-1, 0, 0)), sphere_obj("right.obj", 0.7, 24, (1, 0, 0))
    lines = [open(path).read().splitlines() for path in two]
    count = sum(line.startswith("v ") for line in lines[0])
    moved = [re.sub(r"\d+", lambda m: str(int(m.group()) + count), line) if line.startswith("f ") else line for line in lines[1]]
    with open("two.obj", "w") as file:
        file.write("\n".join(lines[0] + moved) + "\n")
    sphere_obj("one.obj", 1, 24)
    rows = surveyed("one.obj", "two.obj", "--frames", 5, "--resolution", 24)
    known = program.refused("survey", "one.obj", "two.obj", "-o", "none.html", "--method", "magic")
    assert set(rows) == set(re.search("there are (.*)", known).group(1).split(", ")), known
    # Slices begin and end with the inputs themselves.
    ends = rows["slices"][0], rows["slices"][-1]
    assert [e["pieces"] for e in ends] == [1, 2]
    last = 0
    for name, frames in rows.items():
        if not frames[0]["score"]:
            assert frames[0]["message"], (name, frames[0])
            continue
        # The table has nine digits.
        assert abs(told_score(frames, ends) - frames[0]["score"]) < 1e-4, (name, told_score(frames, ends), frames[0]["score"])
        assert frames[0]["score"] >= last and float(frames[0]["seconds"]) > 0 and float(frames[0]["cpu_seconds"]) > 0, frames[0]
        last = frames[0]["score"]


def case_figures_are_those_of_morph():
    """The report of the same morph, run alone; also its memory."""
    small, large = balls()
    rows = surveyed(small, large, "--frames", 3, "--resolution", 24, "--method", "slices", "--slices", 48)
    program.run("morph", small, large, "-o", "alone.####.vdb", "--frames", 3, "--resolution", 24, "--slices", 48, "--report", "alone.json", "--quiet")
    report = json.load(open("alone.json"))
    for f, g in zip(rows["slices"], report["frames"]):
        for key, value in (("volume", g["volume"]), ("area", g["area"]), ("pieces", g["pieces"]), ("stretch_mean", g["stretch"]["mean"])):
            assert abs(f[key] - value) <= 1e-8 * abs(value), (key, f, g)
    # An allocator's memory differs from run to run, but not by much.
    assert 0.5 < float(rows["slices"][0]["peak_memory_bytes"]) / report["peakMemoryBytes"] < 2, (rows["slices"][0], report["peakMemoryBytes"])


def case_same_for_any_threads():
    tables = []
    for threads in (1, 2):
        rows = surveyed(*balls(), "--threads", threads, "--frames", 3, "--resolution", 16)
        tables.append({name: [{k: v for k, v in f.items() if k not in ("seconds", "cpu_seconds", "peak_memory_bytes")} for f in frames]
                       for name, frames in rows.items()})
    assert tables[0] == tables[1]


def case_what_cannot_be_is_said():
    """Methods that refuse say it in their own words; the others go on."""
    small, large = balls()
    rows = surveyed(small, large, small, "--frames", 3, "--resolution", 24, "--method", "levelset", "--method", "sdf", "--method", "dissolve")
    assert list(rows) == ["sdf", "dissolve", "levelset"]
    words = program.refused("morph", small, large, small, "-o", "x.####.vdb", "--method", "levelset")
    assert rows["levelset"][0]["message"] and rows["levelset"][0]["message"] in words, (rows["levelset"], words)
    assert rows["levelset"][0]["message"] in open("page.html").read()
    assert rows["dissolve"][0]["volume"] == "" and "no surface" in rows["dissolve"][0]["message"]
    # Of three inputs the middle one is there half way.
    assert abs(rows["sdf"][1]["volume"] / (4 / 3 * math.pi * 8) - 1) < 0.1, rows["sdf"][1]


def case_features_of_a_job():
    small, large = balls()
    with open("job.toml", "w") as file:
        file.write('inputs = ["%s", "%s"]\nframes = 3\nresolution = 24\nease = "in"\n[[feature]]\nname = "top"\npoint = [[0, 1, 0], [0, 2, 0]]\n'
                   % (small, large))
    said = program.run("survey", "--config", "job.toml", "-o", "page.html", "--csv", "table.csv", "--method", "slices", "--method", "sdf").stderr
    assert "job.toml" in said and "ease" in said, said
    rows = table("table.csv")
    assert [len(frames) for frames in rows.values()] == [3, 3]
    page = open("page.html").read()
    assert "without features and regions" in page[page.index('id="k%d"' % list(rows).index("sdf")):], page[-2000:]


def case_page():
    """Opened in Chromium: a picture for each method with frames, a curve for each with a surface, no error, no network."""
    sphere_obj("true.obj", 1.6, 64)
    rows = surveyed(*balls(), "--frames", 5, "--resolution", 24, "--truth", "t=0.5:true.obj")
    with Browser(1280, 1400) as browser:
        browser.open("page.html", "document.images.length > 0 && [...document.images].every(i => i.complete)")
        made = [name for name, frames in rows.items() if len(frames) == 5]
        surfaces = [name for name in made if rows[name][0]["volume"] != ""]
        assert browser.run("document.images.length") == len(made) + 1
        # Five pictures side by side.
        assert browser.run("[...document.images].every(i => i.naturalWidth > 5 * 200)")
        assert browser.run("[...document.querySelectorAll('#ranking a')].map(a => a.textContent)") == made
        shown = browser.run("[...document.querySelectorAll('#ranking tr.k0 td')].map(d => d.textContent)")
        assert abs(float(shown[2]) / rows[made[0]][0]["score"] - 1) < 1e-2, shown
        # Five panels and the names beside their lines.
        for i, name in enumerate(made):
            assert browser.run("document.querySelectorAll('#curves .line.k%d').length" % i) == (6 if name in surfaces else 0), name
        # Volumes from 4.2 to 33.5 go up: in pixels down.
        points = browser.run("document.querySelector('#curves .line.k%d').getAttribute('points')" % made.index("sdf"))
        heights = [float(p.split(",")[1]) for p in points.split()]
        assert len(heights) == 5 and all(a > b for a, b in zip(heights, heights[1:])), heights
        # What is wider than the window is scrolled in itself.
        assert browser.run("document.documentElement.scrollWidth <= innerWidth")
        # Pointing at a method leaves its lines and dims the others.
        browser.run("document.querySelector('#ranking tr.k0').scrollIntoView()")
        x, y, width, height = browser.box("#ranking tr.k0")
        browser.mouse("Moved", x + width / 2, y + height / 2, False)
        opacity = "getComputedStyle(document.querySelector('#curves .line.k%d')).opacity"
        assert browser.run(opacity % 0) == "1" and float(browser.run(opacity % 1)) < 0.5
        assert browser.errors() == [], browser.errors()


def case_names_that_could_be_markup():
    sphere_obj('<b>"&.obj', 1, 12)
    sphere_obj("large.obj", 2, 12)
    rows = surveyed('<b>"&.obj', "large.obj", "--frames", 2, "--resolution", 16, "--method", "sdf")
    assert rows["sdf"][0]["compared_with"] == '<b>"&.obj'
    page = open("page.html").read()
    assert "&lt;b&gt;&quot;&amp;" in page and "<b>\"&" not in page


def case_wrong_inputs():
    small, large = balls()
    no = lambda *arguments, says: program.refused("survey", *arguments, says=says)
    page = ("-o", "page.html")
    no(small, *page, says=["two inputs or more, not 1", "survey a.obj b.obj"])
    no(small, large, says=["--output is required"])
    no(small, large, "-o", "page.pdf", says=["-o page.pdf", "name.html"])
    no(small, large, "-o", "none/page.html", says=["none", "does not exist"])
    no(small, large, *page, "--csv", "table.txt", says=["--csv table.txt", "name.csv"])
    no(small, large, *page, "--csv", "none/table.csv", says=["none", "does not exist"])
    no(small, "nothing.obj", *page, says=["nothing.obj"])
    no(small, "a.####.obj", *page, says=["a.####.obj"])
    no(small, large, *page, "--method", "magic", says=["--method magic", "slices"])
    no(small, large, *page, "--frames", 1, says=["--frames 1", "2 to 65"])
    no(small, large, *page, "--resolution", 3, says=["--resolution 3", "8 to 4096"])
    no(small, large, *page, "--resolution", 32, "--voxel-size", 0.1, says=["--voxel-size", "--resolution"])
    for truth, says in (("true.obj", "t=T:FILE"), ("t=0.5:", "t=T:FILE"), ("t=x:small.obj", "'x' is not a number"), ("t=1:small.obj", "between 0 and 1"),
                        ("t=0.3:small.obj", "1/8 apart"), ("t=0.5:nothing.obj", "nothing.obj"), ("t=0.5:small.####.obj", "small.####.obj")):
        no(small, large, *page, "--truth", truth, says=[says])
    no(small, large, *page, "--truth", "t=0.5:small.obj", "--truth", "t=0.5:large.obj", says=["t=0.5 already"])
    with open("job.toml", "w") as file:
        file.write("frames = 1000\n")
    no(small, large, *page, "--config", "job.toml", says=["job.toml:1", "2 to 65"])
    with open("broken.obj", "w") as file:
        file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    no(small, "broken.obj", *page, says=["broken.obj"])


if len(sys.argv) > 3 and sys.argv[1] == "--screenshot":
    with Browser(*map(int, sys.argv[4:])) as browser:
        browser.open(sys.argv[2], "[...document.images].every(i => i.complete)")
        with open(sys.argv[3], "wb") as file:
            file.write(browser.png(captureBeyondViewport=True, clip=dict(zip(
                ("x", "y", "width", "height"), (0, 0, browser.run("innerWidth"), browser.run("document.documentElement.scrollHeight"))), scale=1)))
    sys.exit(0)
if len(sys.argv) < 2:
    sys.exit(__doc__)
program = Program(sys.argv[1])
sys.exit(run_within(globals(), sys.argv[2:]))
