"""A sheet drawn with matplotlib: frames of a morph as pictures, and their volumes over time.

usage: draw.py A B PICTURE.png
"""
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

import slicemorph

a, b, output = sys.argv[1:]
plan = slicemorph.plan(a, b, resolution=64, slices=48)
frames = list(plan.frames(5))
figure = plt.figure(figsize=(10, 4.5), layout="constrained")
above, below = figure.subfigures(2, height_ratios=(3, 2))
pictures = slicemorph.render(*frames, size="240x240", transparent=True)  # by one camera
for axes, frame, picture in zip(above.subplots(1, len(frames)), frames, pictures):
    axes.imshow(slicemorph.srgb(picture))
    axes.set_title("t = %.2f" % frame.t)
    axes.axis("off")
axes = below.subplots()
volumes = [slicemorph.compare(frame, frame)["a"]["volume"] for frame in frames]
axes.plot([frame.t for frame in frames], volumes, "o-", color="tab:blue")
axes.set(xlabel="t", ylabel="volume", ylim=(0, None))
figure.savefig(output, dpi=110)
