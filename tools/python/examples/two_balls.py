"""Two balls of numpy to a sequence, without a file until the end: a .vdb a frame, and how far each is from the truth."""
import numpy as np

import slicemorph

h = 0.05  # edge of a voxel, world units
lattice = np.stack(np.meshgrid(*[np.arange(-32, 33) * h] * 3, indexing="ij"), -1)  # i, j, k, xyz


def ball(radius, middle):
    distance = np.linalg.norm(lattice - middle, axis=-1) - radius
    return slicemorph.Grid.from_numpy(distance.astype(np.float32), h, lattice[0, 0, 0], name="surface", grid_class="level set",
                                      background=3 * h)


plan = slicemorph.plan(ball(0.9, [-0.4, 0, 0]), ball(0.5, [0.7, 0.3, -0.2]), slices=48)
for frame in plan.frames(5):
    radius, middle = 0.9 - 0.4 * frame.t, np.array([-0.4, 0, 0]) + frame.t * np.array([1.1, 0.3, -0.2])
    off = np.abs(np.linalg.norm(frame.to_mesh().vertices - middle, axis=1) - radius) / h
    print("t = %.2f: %.3f voxels off in the mean, %.3f at most" % (frame.t, off.mean(), off.max()))
    frame.save("balls.%04d.vdb" % frame.number)

# Points are carried by the map alone; further grids move with the shapes.
print("the first ball's middle at t = 0.5:", plan.apply([[-0.4, 0, 0]], 0, 0.5)[0].round(2))
