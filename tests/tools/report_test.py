#!/usr/bin/env python3
"""The page of `morph --report x.html`, opened from the disk in headless Chromium without a network.

usage: report_test.py PATH/TO/slicemorph SOURCE_FOLDER [NAME...]     (NAME: only the cases whose name contains it)
       report_test.py --screenshot PAGE.html PICTURE.png [T]           (a picture of a page at a time from 0 to 1)

Needs Debian's python3-openimageio; cases are skipped, with a message, where Chromium is not installed.
"""
import csv
import json
import os
import shutil
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from browser import Browser
from cases import named_cases, run_cases


def morph(folder, *words):
    page = folder + "/report.html"
    result = subprocess.run([PROGRAM, "morph", *map(str, words), "--report", page], capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    assert os.path.getsize(page) < 20e6, os.path.getsize(page)
    return page


def scrub(browser, t):
    """Moves the slider as a user does: sets its value and sends its event."""
    browser.run("(s => { s.value = %r; s.dispatchEvent(new Event('input')); })(document.getElementById('time'))" % t)


def case_player(folder):
    """Opens without errors; scrubbing shows the shape of that time; the network is not used."""
    page = morph(folder, ASSETS + "/blade.ply", ASSETS + "/creature.ply", "-o", folder + "/m.####.ply", "--frames", 5,
                 "--resolution", 32)
    with Browser() as browser:
        browser.open(page)
        assert not browser.run("!!document.querySelector('#player .none')"), browser.run("document.querySelector('#player').textContent")
        pictures = {}
        for t in (0, 0.3, 0.5, 1):
            scrub(browser, t)
            pictures[t] = browser.picture("#player canvas")
            assert pictures[t].std() > 5, "nothing is to be seen at %g" % t
            shown = browser.run("document.getElementById('now').textContent")
            assert "t = %.3f" % t in shown and "frame %d" % round(1 + 4 * t + 1e-9) in shown, shown
        for a, b in ((0, 0.3), (0.3, 0.5), (0.5, 1)):
            changed = (np.abs(pictures[a] - pictures[b]).max(axis=2) > 24).mean()
            assert changed > 0.005, "from %g to %g only %.2f %% of the pixels change" % (a, b, 100 * changed)
        scrub(browser, 0)
        assert (np.abs(browser.picture("#player canvas") - pictures[0]).max(axis=2) > 24).mean() < 0.001
        assert browser.errors() == [], browser.errors()


def case_parts(folder):
    """Curves, sheet, slices, notes and settings are there, and are those of the job."""
    page = morph(folder, ASSETS + "/blade.ply", ASSETS + "/ring.ply", "-o", folder + "/m.####.ply", "--frames", 3,
                 "--resolution", 32, "--report", folder + "/m.json")
    report = json.load(open(folder + "/m.json"))
    with Browser() as browser:
        browser.open(page)
        titles = browser.run("[...document.querySelectorAll('#curves svg text:first-of-type')].map(e => e.textContent)")
        for word in ("Volume", "Area", "Pieces", "Genus", "Fold", "Seconds"):
            assert any(word in title for title in titles), (word, titles)
        # The curve of the volume: the heights of its points agree with the figures.
        y = np.array(browser.run("[...document.querySelectorAll('#curves svg')[0].querySelectorAll('circle')].map(c => +c.getAttribute('cy'))"))
        v = np.array([f["volume"] for f in report["frames"]])
        assert len(y) == len(v) and np.corrcoef(-y, v)[0, 1] > 0.9999
        size = browser.run("(i => [i.naturalWidth, i.naturalHeight])(document.getElementById('sheet'))")
        assert min(size) > 100, size
        slices = browser.run("JSON.parse(document.getElementById('slices').textContent).length")
        assert slices > 8 and browser.run("!!document.querySelector('#slice svg')")
        text = browser.run("document.body.innerText")
        for word in ("blade.ply", "ring.ply", *report["notes"]):
            assert word in text, word
        assert browser.errors() == [], browser.errors()


def case_labels_over_time(folder):
    """Of label maps the volume of every label of every frame, as CSV and as a curve in the page, whatever the output is."""
    import nibabel as nib
    at = np.stack(np.meshgrid(*map(np.arange, (40, 30, 24)), indexing="ij"), -1)
    radii = {4: (6, 8), 9: (7, 5)}
    for name, n in (("a", 0), ("b", 1)):
        labels = np.zeros(at.shape[:3], np.uint8)
        for (label, r), x in zip(radii.items(), (11, 29)):
            labels[np.linalg.norm(at - (x, 15, 12), axis=-1) < r[n]] = label
        nib.save(nib.Nifti1Image(labels, np.diag([-1, -1, 1, 1])), folder + "/%s.nii" % name)
    for output in ("m.#.nii", "m.#.vdb", "m.#.ply", "m.nii"):
        table = folder + "/r.csv"
        page = morph(folder, folder + "/a.nii", folder + "/b.nii", "-o", folder + "/" + output, "--frames", 3, "--align", "none", "--report", table)
        rows = list(csv.DictReader(open(table)))
        assert [(row["frame"], row["label"]) for row in rows] == [(str(f), l) for f in (1, 2, 3) for l in ("4", "9")], rows
        for frame, name in (("1", "a"), ("3", "b")):
            labels = np.asanyarray(nib.load(folder + "/%s.nii" % name).dataobj)
            for row in rows:
                assert row["frame"] != frame or abs(float(row["volume_ml"]) - (labels == int(row["label"])).sum() / 1000) < 1e-9, row
    with Browser() as browser:
        browser.open(page)
        find = "[...document.querySelectorAll('#curves svg')].find(e => e.querySelector('text').textContent == 'Labels, ml')"
        assert browser.run("[...%s.querySelectorAll('polyline')].length" % find) == 2
        # Higher on the page is more: the pixel of each point is a linear function of its volume.
        y = np.array(browser.run("[...%s.querySelectorAll('circle')].map(c => +c.getAttribute('cy'))" % find)).reshape(2, 3)[::-1].T.ravel()
        volumes = np.array([float(row["volume_ml"]) for row in rows])
        fit = np.polyfit(volumes, y, 1)
        assert fit[0] < 0 and np.abs(np.polyval(fit, volumes) - y).max() < 0.06, (volumes, y)
        names = browser.run("[...%s.querySelectorAll('text')].map(e => e.textContent)" % find)
        assert "4" in names and "9" in names, names
        assert not browser.errors(), browser.errors()


def case_without_shapes(folder):
    """A method without a surface, and blends without times, give a page without errors, too."""
    with Browser() as browser:
        for words in (["-o", folder + "/m.####.vdb", "--frames", 3, "--method", "dissolve"],
                      ["-o", folder + "/m.vdb", "--weights", "0.4,0.6"],
                      ["-o", folder + "/m.####.png", "--frames", 2, "--size", "60x40", "--method", "sdf"]):
            browser.open(morph(folder, ASSETS + "/blade.ply", ASSETS + "/ring.ply", "--resolution", 24, *words))
            assert browser.errors() == [], browser.errors()
            assert browser.run("!!document.querySelector('#player .none')") == ("dissolve" in words)


def case_names_cannot_break_the_page(folder):
    """A file's name is shown as text, whatever it contains."""
    name = folder + "/a<b>&'\"<!--.ply"
    shutil.copy(ASSETS + "/blade.ply", name)
    page = morph(folder, name, ASSETS + "/ring.ply", "-o", folder + "/m.vdb", "--at", 0.5, "--resolution", 24, "--method", "sdf")
    with Browser() as browser:
        browser.open(page)
        assert os.path.basename(name) in browser.run("document.title")
        assert browser.errors() == [], browser.errors()


if len(sys.argv) > 3 and sys.argv[1] == "--screenshot":
    with Browser(1240, 2400) as browser:
        browser.open(sys.argv[2])
        scrub(browser, float(sys.argv[4]) if len(sys.argv) > 4 else 0.5)
        open(sys.argv[3], "wb").write(browser.png())
        for error in browser.errors():
            print(error)
    sys.exit(0)
if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, ASSETS, ONLY = os.path.abspath(sys.argv[1]), os.path.join(sys.argv[2], "assets"), sys.argv[3:]
sys.exit(run_cases(sorted(named_cases(globals())), ONLY))
