"""Meshes of closed forms, written as OBJ files."""
import math


def sphere_obj(path, radius, n=24, middle=(0, 0, 0)):
    """A closed mesh of a ball; poles along z."""
    m = 2 * n
    points = [(0, 0, radius)]
    for i in range(1, n):
        t = math.pi * i / n
        points += [(radius * math.sin(t) * math.cos(2 * math.pi * j / m), radius * math.sin(t) * math.sin(2 * math.pi * j / m),
                    radius * math.cos(t)) for j in range(m)]
    points.append((0, 0, -radius))
    at = lambda i, j: 1 if i == 0 else len(points) if i == n else 2 + (i - 1) * m + j % m
    with open(path, "w") as file:
        for p in points:
            file.write("v %.9g %.9g %.9g\n" % tuple(p[a] + middle[a] for a in range(3)))
        for i in range(n):
            for j in range(m):
                if i > 0:
                    file.write("f %d %d %d\n" % (at(i, j), at(i + 1, j + 1), at(i, j + 1)))
                if i < n - 1:
                    file.write("f %d %d %d\n" % (at(i, j), at(i + 1, j), at(i + 1, j + 1)))
    return path


def box_obj(path, low, high):
    """A closed mesh of a box between two corners."""
    corners = [[(low, high)[c >> a & 1][a] for a in range(3)] for c in range(8)]
    with open(path, "w") as file:
        for p in corners:
            file.write("v %.9g %.9g %.9g\n" % tuple(p))
        for f in ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)):
            file.write("f %d %d %d %d\n" % f)
    return path
