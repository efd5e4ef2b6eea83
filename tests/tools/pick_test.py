#!/usr/bin/env python3
"""Pointing: the page of `pick`, and the same in a report, in headless Chromium with real mouse, keys and touch, without a network.

usage: pick_test.py PATH/TO/slicemorph SOURCE_FOLDER [NAME...]     (NAME: only the cases whose name contains it)
       pick_test.py --screenshot PAGE.html PICTURE.png [WIDTH [HEIGHT]]

What is clicked is checked against rays cast by brute force, from a camera that is computed here from the meshes alone: where the
page first looks from is said below. Cases are skipped, with a message, where Chromium is not installed.
"""
import base64
import json
import os
import re
import shlex
import sys
import time
import tomllib

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from browser import Browser
from cases import named_cases, run_cases
from meshes import sphere_obj
from program import Program

READY = "document.body.dataset.pick === 'ready'"
FOV, UP = 28, np.array([0, 1, 0])


def unit(v):
    return v / np.linalg.norm(v)


class Shape:
    """A mesh of the page with the camera of its view as it is when the page has just been opened."""

    def __init__(self, points, triangles, origin, box):
        self.points, self.triangles, self.box = points + origin, triangles, box
        target = (self.points.min(0) + self.points.max(0)) / 2
        sides = np.ptp(self.points, axis=0)
        # Across the longer one of the level sides, from a little above.
        self.towards = towards = unit(np.array([1, 0.3, 0.45] if sides[2] > 1.1 * sides[0] else [0.45, 0.3, 1]))
        self.right = unit(np.cross(UP, towards))
        self.axes = np.stack([self.right, np.cross(towards, self.right), towards])
        # The camera sees all points with a margin of 8 %.
        q = (self.points - target) @ self.axes.T
        tangent = np.tan(np.radians(FOV / 2))
        up = tangent / 1.08
        across = up * box[2] / box[3]
        distance = (q[:, 2] + np.maximum(np.abs(q[:, 0]) / across, np.abs(q[:, 1]) / up)).max()
        self.eye, self.scale = target + distance * towards, box[3] / 2 / tangent

    def pixel(self, place):
        """Where the window shows a place."""
        x, y, z = self.axes @ (np.asarray(place) - self.eye)
        return self.box[0] + self.box[2] / 2 - self.scale * x / z, self.box[1] + self.box[3] / 2 + self.scale * y / z

    def ray(self, pixel):
        x, y = pixel[0] - self.box[0] - self.box[2] / 2, pixel[1] - self.box[1] - self.box[3] / 2
        return unit(np.array([x, -y, -self.scale]) @ self.axes)

    def seen(self, pixel):
        """The nearest point of all triangles on the ray; None: there is none."""
        direction = self.ray(pixel)
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        n = np.cross(b - a, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ((a - self.eye) * n).sum(1) / (n @ direction)
            p = self.eye + t[:, None] * direction
            inside = np.isfinite(t) & (t > 0)
            for u, v in ((a, b), (b, c), (c, a)):
                inside &= (np.cross(v - u, p - u) * n).sum(1) >= 0
        return p[inside][t[inside].argmin()] if inside.any() else None

    def aim(self, score):
        """The pixel of the vertex of the highest score around which the surface is seen; whole, as a mouse's are."""
        normals = np.zeros_like(self.points)
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        for k in range(3):
            np.add.at(normals, self.triangles[:, k], np.cross(b - a, c - a))
        facing = (normals * (self.eye - self.points)).sum(1) > 0.35 * np.linalg.norm(normals, axis=1) * np.linalg.norm(self.eye - self.points, axis=1)
        reach = 0.03 * np.ptp(self.points, axis=0).max()
        for i in np.argsort(-score(self.points)):
            if not facing[i]:
                continue
            x, y = map(round, self.pixel(self.points[i]))
            around = [self.seen((x + dx, y + dy)) for dx, dy in ((0, 0), (2, 0), (-2, 0), (0, 2), (0, -2))]
            if all(p is not None and np.linalg.norm(p - self.points[i]) < reach for p in around):
                return x, y
        raise AssertionError("nothing is visible")


def data_of(page):
    text = open(page, encoding="utf-8").read()
    find = lambda name: re.search(r'<script id="%s"[^>]*>(.*?)</script>' % name, text, re.S).group(1)
    return json.loads(find("pick")), base64.b64decode(find("pickMeshes"))


def shapes_of(browser, page):
    """The meshes of the page's file and their views' boxes in the window."""
    data, raw = data_of(page)
    at, shapes = 0, []

    def take(kind, count):
        nonlocal at
        at += 4 * count
        return np.frombuffer(raw, kind, count, at - 4 * count)
    for k, shape in enumerate(data["shapes"]):
        n, m = shape["points"], shape["triangles"]
        points, triangles = take("<f4", 3 * n).reshape(n, 3).astype(float), take("<u4", 3 * m).reshape(m, 3)
        take("<f4", 0 if data["overlap"] is None else 3 * n * (len(data["shapes"]) - 1))
        take("<u4", n if shape["colors"] else 0)
        shapes.append(Shape(points, triangles, shape["origin"], browser.box(".shape:nth-child(%d) canvas" % (k + 1))))
    assert at == len(raw)
    return shapes


def numbers(text):
    return np.array(json.loads(text))


def job_of(browser):
    """The job file that the page shows, and its features that are points, shapes x 3 each."""
    text = browser.run("document.getElementById('jobText').textContent")
    return text, [numbers(line) for line in re.findall(r"^point = (.*)$", text, re.M)]


def say(browser):
    return browser.run("document.getElementById('pickSay').textContent")


def marks(browser, k):
    """Middles of a view's marks in the window."""
    return browser.run("[...document.querySelectorAll('.shape:nth-child(%d) .mark.place')].map(m => (r => [r.x + r.width / 2, r.y + r.height / 2])"
                       "(m.getBoundingClientRect()))" % (k + 1))


def pick(folder, *words):
    page = folder + "/pairs.html"
    program.run("pick", *words, "-o", page)
    assert os.path.getsize(page) < 20e6, os.path.getsize(page)
    return page


def download(browser, folder, name):
    """Saves the job file by the page's button; returns its text."""
    browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=folder)
    browser.run("document.getElementById('jobSave').click()")
    until = time.time() + 90
    while not os.path.exists(folder + "/" + name):
        assert time.time() < until, "%s was not downloaded; there are %s" % (name, sorted(os.listdir(folder)))
        time.sleep(0.05)
    return open(folder + "/" + name).read()


def near(a, b, within):
    assert np.abs(np.asarray(a) - b).max() <= within, (a, b, within)


def opened(browser, page):
    browser.open(page, READY)
    # Once the views have their sizes.
    browser.run("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
    browser.run("document.getElementById('shapes').scrollIntoView()")
    return shapes_of(browser, page)


def two_balls(folder, second=(-1, 0, 0.25)):
    sphere_obj(folder + "/a.obj", 1, middle=(3, -2, 5))
    sphere_obj(folder + "/b.obj", 0.5, middle=second)
    return folder + "/a.obj", folder + "/b.obj"


def case_clicks_meet_the_surface(folder):
    """What is clicked lies on the balls and on the rays through the pixels, marks are where was clicked; undo, redo, remove."""
    # The second one lies where single precision has no digits left.
    far = 2e4, 0, 0.25
    a, b = two_balls(folder, far)
    page = pick(folder, a, b, "--no-plan", "--resolution", 64)
    balls = ((np.array([3, -2, 5]), 1), (np.array(far), 0.5))
    with Browser(960, 700) as browser:
        shapes = opened(browser, page)
        assert say(browser) == "Click a place on one shape.", say(browser)
        # In the middle the surface is seen straight on: at the centre plus a radius towards the camera.
        middles = [(s.box[0] + s.box[2] / 2, s.box[1] + s.box[3] / 2) for s in shapes]
        browser.click(*middles[0])
        assert "like of place 1 on b" in say(browser), say(browser)
        assert job_of(browser)[1] == []
        browser.click(*middles[1])
        clicked = [middles]
        for dx, dy in ((80, -30), (-60, 90)):
            clicked.append([(x + dx, y + dy) for x, y in middles])
            # The second shape may come first.
            for k in (1, 0):
                browser.click(*clicked[-1][k])
        text, places = job_of(browser)
        assert len(places) == 3, text
        for pixels, pair in zip(clicked, places):
            for (centre, radius), shape, pixel, place in zip(balls, shapes, pixels, pair):
                voxel = 2 * radius / 64
                # Marching cubes' chords are below the surface by voxel^2 / 8 / radius; the file's ball has chords of 7.5 degrees,
                # below it by 0.0021 of the radius; and the level set is trilinear: a quarter of a voxel covers all three.
                near(np.linalg.norm(place - centre), radius, voxel / 4)
                # Six digits of the size are written.
                near(np.linalg.norm(np.cross(place - shape.eye, shape.ray(pixel))), 0, 2e-5 * radius)
                near(place, shape.seen(pixel), 2e-5 * radius)
        near((places[0][0] - balls[0][0]), shapes[0].towards, 1 / 64)
        for k in (0, 1):
            near(marks(browser, k), [pixels[k] for pixels in clicked], 0.51)
        # Undo takes one click back, redo brings it again.
        browser.key("z", 90, modifiers=2)
        assert len(job_of(browser)[1]) == 2 and "not yet on a" in job_of(browser)[0]
        browser.key("y", 89, modifiers=2)
        assert job_of(browser)[0] == text
        # Beside the shape there is nothing to be clicked.
        browser.click(shapes[0].box[0] + 5, shapes[0].box[1] + 5)
        assert job_of(browser)[0] == text
        # Removed by a button, by the key on a mark; both undone.
        browser.run("document.querySelector('#placeTable tbody tr:nth-child(2) button').click()")
        near(np.array(job_of(browser)[1]), np.array([places[0], places[2]]), 0)
        browser.run("document.querySelector('.mark.place').focus()")
        browser.key("Delete", 46)
        near(np.array(job_of(browser)[1]), np.array([places[2]]), 0)
        for _ in range(2):
            browser.run("document.getElementById('pickUndo').click()")
        assert job_of(browser)[0] == text
        # The chosen place stays chosen where another one is removed.
        chosen = "[...document.querySelectorAll('#placeTable tbody tr')].map(r => r.className === 'chosen')"
        browser.run("document.querySelector('#placeTable tbody tr:nth-child(3) td').click()")
        assert browser.run(chosen) == [False, False, True]
        browser.run("document.querySelector('#placeTable tbody tr:nth-child(1) button').click()")
        assert browser.run(chosen) == [False, True]
        near(np.array(job_of(browser)[1]), np.array(places[1:]), 0)
        # Keys undo also from a box to tick, which has nothing typed to be undone.
        browser.run("document.getElementById('together').focus()")
        browser.key("z", 90, modifiers=2)
        assert job_of(browser)[0] == text
        assert browser.errors() == [], browser.errors()


def case_drag_turn_touch_keys(folder):
    """Marks are dragged along the surface; drags beside them turn the shape and pick nothing; a finger and keys pick, too."""
    page = pick(folder, ASSETS + "/creature.ply", ASSETS + "/ring.ply", "--no-plan", "--resolution", 48)
    with Browser(960, 700) as browser:
        creature, ring = opened(browser, page)
        start = creature.aim(lambda p: p[:, 0])
        browser.click(*start)
        browser.click(*ring.aim(lambda p: p[:, 1]))
        before = job_of(browser)[1]
        end = creature.aim(lambda p: p[:, 1])
        browser.drag(start, end)
        after = job_of(browser)[1]
        near(after[0][0], creature.seen(end), 1e-4)
        near(after[0][1], before[0][1], 0)
        assert np.linalg.norm(after[0][0] - before[0][0]) > 0.3
        near(marks(browser, 0), [end], 0.51)
        browser.key("z", 90, modifiers=2)
        near(job_of(browser)[1], before, 0)
        # Arrow keys move a mark along the surface, four pixels each.
        browser.run("document.querySelector('.mark.place').focus()")
        at = marks(browser, 0)[0]
        browser.key("ArrowLeft", 37)
        near(marks(browser, 0)[0], (at[0] - 4, at[1]), 0.6)
        # A drag beside the mark turns the shape: the mark moves on the screen, not on the shape.
        text, at = job_of(browser)[0], marks(browser, 0)[0]
        middle = creature.box[0] + creature.box[2] / 2, creature.box[1] + creature.box[3] / 2
        assert creature.seen(middle) is not None and creature.seen((middle[0] + 40, middle[1])) is not None
        browser.drag(middle, (middle[0] + 40, middle[1]))
        assert job_of(browser)[0] == text
        assert np.abs(np.subtract(marks(browser, 0)[0], at)).max() > 20
        # By keys: a Tab away from the page's start are tools and canvas; enter picks in the middle of the view.
        browser.run("document.querySelector('.shape:nth-child(1) .tools button:last-child').focus()")
        browser.key("Enter", 13, "\r")  # shows the shape whole, as at first
        browser.key("Tab", 9)
        assert browser.run("document.activeElement.tagName") == "CANVAS"
        browser.key("Enter", 13, "\r")
        browser.call("Emulation.setTouchEmulationEnabled", enabled=True)
        finger = ring.aim(lambda p: -p[:, 1])
        browser.tap(*finger)
        places = job_of(browser)[1]
        assert len(places) == 2, places
        near(places[1], [creature.seen(middle), ring.seen(finger)], 1e-4)
        # All that acts can be reached by Tab and has a name.
        nameless = browser.run("[...document.querySelectorAll('#pickPart button, #pickPart input, #pickPart select, #pickPart canvas')].filter(e => e.tabIndex < 0 ||"
                               " !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels && e.labels.length)).map(e => e.outerHTML)")
        assert nameless == [], nameless
        assert browser.errors() == [], browser.errors()


def elsewhere(places):
    """Where the creature's places are on the other one."""
    return places * np.array([1, 1.08, 1]) + (4, 0, -3)


def other_creature(folder):
    """The creature elsewhere, 8 % higher: a shape of its own, as equal ones are not matched at all."""
    path = folder + "/other.obj"
    program.run("convert", ASSETS + "/creature.ply", "-o", path, "--resolution", 64)
    lines = open(path).read().splitlines()
    with open(path, "w") as file:
        for line in lines:
            words = line.split()
            if words and words[0] == "v":
                words[1:4] = map(repr, elsewhere(np.array(words[1:4], float)).tolist())
            if words and words[0] in "vf":
                file.write(" ".join(words) + "\n")
    return path


def case_three_pairs_turn_the_match(folder):
    """Alone a creature is matched head to head; by three pairs head to tail it turns round. The downloaded job file as it is."""
    page = pick(folder, ASSETS + "/creature.ply", other_creature(folder), "--resolution", 40)
    data = data_of(page)[0]
    assert data["overlap"] > 0.8 and data["turns"][0]["degrees"] < 20, data["turns"]
    # Limbs that meet are those that are nearest where the other creature is.
    one, two = ([(limb["group"], np.array(limb["line"])) for limb in shape["limbs"]] for shape in data["shapes"])
    met = [(line, other) for group, line in one for found, other in two if group == found >= 0]
    assert len(met) > 3, (one, two)
    for line, partner in met:
        apart = [np.linalg.norm(elsewhere(line) - other, axis=1)[6:].mean() for _, other in two]
        near(np.linalg.norm(elsewhere(line) - partner, axis=1)[6:].mean(), min(apart), 1e-9)
    with Browser(960, 700) as browser:
        a, b = opened(browser, page)
        letters = [browser.run("[...document.querySelectorAll('.shape:nth-child(%d) .mark.limb')].map(m => m.textContent).sort().join('')" % k) for k in (1, 2)]
        assert letters == ["ABCDEFGH"[:len(met)]] * 2, letters
        head, tail, back = (lambda p: p[:, 0]), (lambda p: -p[:, 0]), (lambda p: p[:, 1] - np.abs(p[:, 0] - p[:, 0].mean()))
        ghost = "[...document.querySelectorAll('.shape:nth-child(2) .ghost')].map(m => (r => [r.x + r.width / 2, r.y + r.height / 2])(m.getBoundingClientRect()))"
        for on_a, on_b in ((head, tail), (tail, head), (back, back)):
            pixel = a.aim(on_a)
            browser.click(*pixel)
            # The match has it at the same place of the other creature: to a twentieth of the view.
            near(browser.run(ghost), [b.pixel(elsewhere(a.seen(pixel)))], b.box[2] / 20)
            browser.click(*b.aim(on_b))
        misses = browser.run("[...document.querySelectorAll('#placeTable tbody tr')].map(r => parseFloat(r.cells[4].textContent))")
        sides = np.ptp(b.points, axis=0).max()
        for miss, place in zip(misses, job_of(browser)[1]):
            near(miss, 100 * np.linalg.norm(place[1] - elsewhere(place[0])) / sides, 5)
        assert misses[0] > 60 and misses[1] > 60, misses
        assert download(browser, folder, "pairs.toml") == job_of(browser)[0]
        assert browser.errors() == [], browser.errors()
    report = folder + "/r.json"
    program.run("morph", "--config", folder + "/pairs.toml", "-o", folder + "/half.ply", "--at", "0.5", "--report", report)
    turn = json.load(open(report))["plan"]["turns"][0]["degrees"]
    assert 150 < turn < 210, turn


def case_what_the_job_file_has_is_kept(folder):
    """Features of --config are there as marks, what else it says goes on; scaled and moved inputs are where features want them."""
    a, b = two_balls(folder)
    with open(folder + "/old.toml", "w") as file:
        file.write('inputs = ["%s", {file = "%s", scale = 3}]\noutput = "own.##.vdb"\nframes = 7\nfit = "box"\nkeys = [{at = 0, input = "a"}, {at = 1, input = "b"}]\n'
                   '[[feature]]\nname = "the \\"top\\""\npoint = [[3, -1, 5], [3, -1, 5]]\n'
                   '[[feature]]\nname = "axis"\nline = [[[3, -2, 4], [3, -2, 6]], [[3, -2, 4], [3, -2, 6]]]\n'
                   '[[region]]\non = "a"\nsphere = {center = [3, -1, 5], radius = 0.2}\ninput = "b"\n' % (a, b))
    page = pick(folder, "--config", folder + "/old.toml", "--resolution", 48, "--no-plan")
    with Browser(960, 700) as browser:
        shapes = opened(browser, page)
        assert len(marks(browser, 0)) == len(marks(browser, 1)) == 1
        near(marks(browser, 0), [shapes[0].pixel((3, -1, 5))], 0.51)
        # The second ball was brought into the first one's box.
        for k in (0, 1):
            browser.click(shapes[k].box[0] + shapes[k].box[2] / 2 + 50, shapes[k].box[1] + shapes[k].box[3] / 2)
        text, places = job_of(browser)
        near([np.linalg.norm(p - (3, -2, 5)) for p in places[1]], (1, 1), 1 / 48)
        with open(folder + "/new.toml", "w") as file:
            file.write(text)
        assert browser.errors() == [], browser.errors()
    # The output is that of the job which was given, and is not written over.
    assert not re.search(r"^output", text, re.M), text
    old, new = (program.run("morph", "--config", folder + "/" + name, "-o", folder + "/new.##.vdb", "--print-config").stdout
                for name in ("old.toml", "new.toml"))
    for word in ("frames = 7", 'fit = "box"', "keys = [", 'name = "the \\"top\\""', 'name = "axis"', "[[region]]", "{scale=3}"):
        assert word in old and word in new, word
    assert "resolution = 48" in new and new.count("\n[[feature]]") == 3, new


def case_in_a_report(folder):
    """The report of a morph has the same part: places that are picked there become its job with features."""
    page = folder + "/r.html"
    program.run("morph", ASSETS + "/blade.ply", ASSETS + "/ring.ply", "-o", folder + "/m.vdb", "--at", 0.5, "--resolution", 32, "--report", page)
    with Browser(960, 700) as browser:
        browser.open(page)
        browser.run("document.getElementById('shapes').scrollIntoView()")
        browser.wait(READY + " && document.querySelectorAll('.shape canvas').length == 2")
        browser.run("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
        browser.run("document.getElementById('shapes').scrollIntoView()")
        shapes = shapes_of(browser, page)
        for shape in shapes:
            browser.click(*shape.aim(lambda p: p[:, 1]))
        text, places = job_of(browser)
        assert len(places) == 1 and 'resolution = 32' in text and '/blade.ply"' in text, text
        assert not re.search("^(output|report)", text, re.M), text
        with open(folder + "/job.toml", "w") as file:
            file.write(text)
        assert browser.errors() == [], browser.errors()
    assert "[[feature]]" in program.run("morph", "--config", folder + "/job.toml", "-o", folder + "/n.vdb", "--print-config").stdout


def case_job_file_from_any_folder(folder):
    """Taken in another folder it reads the same files; it writes nothing over, as the options of the one run are not in it."""
    two_balls(folder)
    elsewhere = folder + "/elsewhere"
    os.mkdir(elsewhere)
    os.chdir(folder)
    for name, text in (("a.txt", "4 -2 5\n3 -1 5\n"), ("b.txt", "-0.5 0 0.25\n-1 0.5 0.25\n"), ("planes.txt", "3 -2 5 1 0 0\n")):
        with open(name, "w") as file:
            file.write(text)
    both = 'inputs = ["a.obj", "b.obj"]\nresolution = 24\ncheck-landmarks = "a.txt,b.txt"\n'
    with open("frames.toml", "w") as file:
        file.write(both + 'frames = 3\noutput = "own.##.vdb"\nreport = ["own.json"]\ndump-slices = "own"\nrange = "1"\nresume = true\n'
                   'quiet = true\nthreads = 1\nmemory = "4G"\n')
    with open("slices.toml", "w") as file:
        file.write(both + 'at = 0.5\noutput = "own.exr"\nexr = "slices"\nexr-planes = "planes.txt"\nverbose = true\n')
    jobs = {}
    for name, page in (("frames", "it's.html"), ("slices", "slices.html")):
        program.run("pick", "--config", name + ".toml", "-o", page, "--no-plan")
        text = data_of(page)[0]["job"]
        jobs[name] = tomllib.loads(text)
        with open("elsewhere/%s.toml" % name, "w") as file:
            file.write(text)
    here = os.getcwd()
    both = {"inputs": [here + "/a.obj", here + "/b.obj"], "resolution": 24,
            "check-landmarks": [[[4, -2, 5], [-0.5, 0, 0.25]], [[3, -1, 5], [-1, 0.5, 0.25]]]}
    assert jobs["frames"] == {**both, "frames": 3}, jobs
    assert jobs["slices"] == {**both, "at": 0.5, "exr": "slices", "exr-planes": here + "/planes.txt"}, jobs
    before = set(os.listdir("."))
    os.chdir(elsewhere)
    for made in ("a_to_b", "a_to_b_2"):
        written = program.run("morph", "--config", "frames.toml").stdout.split()
        assert written == ["%s/%s/a_to_b.%04d.vdb" % (here, made, n) for n in (1, 2, 3)], written
    program.run("morph", "--config", "slices.toml", "-o", "s.exr")
    assert sorted(os.listdir(".")) == ["frames.toml", "s.exr", "slices.toml"], os.listdir(".")
    assert set(os.listdir(here)) - before == {"a_to_b", "a_to_b_2"}, os.listdir(here)
    os.chdir("/")
    # The command that the page shows is one for a shell, whatever the page is called.
    with Browser(960, 700) as browser:
        browser.open(here + "/it's.html", READY)
        shown = browser.run("document.getElementById('jobLine').textContent")
        assert shlex.split(shown) == ["slicemorph", "morph", "--config", "it's.toml"], shown


def case_three_shapes(folder):
    """More than two inputs have a view each; a place is whole when it is on all of them."""
    a, b = two_balls(folder)
    page = pick(folder, a, b, ASSETS + "/ring.ply", "--no-plan", "--resolution", 32)
    with Browser(1400, 1400) as browser:
        shapes = opened(browser, page)
        for k in (2, 0, 1):
            assert job_of(browser)[1] == []
            browser.click(*shapes[k].aim(lambda p: p[:, 1]))
        places = job_of(browser)[1]
        assert len(places) == 1 and places[0].shape == (3, 3), places
        assert browser.errors() == [], browser.errors()


def case_refusals(folder):
    os.chdir(folder)
    a, b = two_balls(folder)
    program.refused("pick", a, "-o", "p.html", says=["pick needs two inputs", "not 1"])
    program.refused("pick", a, b, "-o", "p.toml", says=["-o p.toml", "name.html"])
    program.refused("pick", a, folder + "/none.obj", "-o", "p.html", says=["none.obj"])
    program.refused("pick", a, b, "-o", "no/p.html", says=["no/p.html", "does not exist"])
    with open("job.toml", "w") as file:
        file.write('method = "sdf"\n')
    program.refused("pick", a, b, "--config", "job.toml", "-o", "p.html", says=["job.toml:1", "--method sdf", "features"])
    with open("job.toml", "w") as file:
        file.write("[[feature]]\npoint = [[1, 2, 3]]\n")
    program.refused("pick", a, b, "--config", "job.toml", "-o", "p.html", says=["job.toml:2", "point"])


if len(sys.argv) > 3 and sys.argv[1] == "--screenshot":
    with Browser(*map(int, sys.argv[4:6] or (1240, 1300))) as browser:
        browser.open(sys.argv[2], READY)
        open(sys.argv[3], "wb").write(browser.png())
        print("\n".join(browser.errors()))
    sys.exit(0)
if len(sys.argv) < 3:
    sys.exit(__doc__)
program, ASSETS, ONLY = Program(sys.argv[1]), os.path.join(os.path.abspath(sys.argv[2]), "assets"), sys.argv[3:]
sys.exit(run_cases(sorted(named_cases(globals())), ONLY))
