"""Moves the grids of a VDB file in space, by their transforms alone. Knows nothing of Blender.

The layout is that of openvdb/io/Archive.cc, io/File.cc, io/GridDescriptor.cc and math/Maps.h.
"""

import struct

import numpy

from .program import Unusable

# Bytes of a map, and where its translation (None: none) and its scales (None: a matrix, as numbers) lie.
kScales = {"ScaleMap": (120, None, 0), "UniformScaleMap": (120, None, 0),
           "ScaleTranslateMap": (144, 0, 24), "UniformScaleTranslateMap": (144, 0, 24), "TranslationMap": (24, 0, None)}
kMatrices = {"AffineMap": 128, "UnitaryMap": 128}
kOldest = 222  # version of files whose grids say how they are packed: OpenVDB 1.2, of 2013


def read_string(data, at):
    length = struct.unpack_from("<I", data, at)[0]
    return data[at + 4:at + 4 + length], at + 4 + length


def skip_metadata(data, at):
    count = struct.unpack_from("<I", data, at)[0]
    at += 4
    for _ in range(3 * count):  # name, type, value
        at = read_string(data, at)[1]
    return at


def read_map(data, at, path):
    """The 4 x 4 matrix, for row vectors, of a grid's transform that begins at `at`; and where it ends."""
    name, at = read_string(data, at)
    name = name.decode("ascii", "replace")
    matrix = numpy.eye(4)
    if name in kMatrices:
        return numpy.frombuffer(data, "<f8", 16, at).reshape(4, 4), at + kMatrices[name]
    if name not in kScales:
        raise Unusable(f"{path}: a grid's transform is a {name}, which cannot be moved; apply the object's transform "
                       "where the file is made")
    size, translation, scales = kScales[name]
    if scales is not None:
        matrix[range(3), range(3)] = numpy.frombuffer(data, "<f8", 3, at + scales)
    if translation is not None:
        matrix[3, :3] = numpy.frombuffer(data, "<f8", 3, at + translation)
    return matrix, at + size


def affine_map(matrix):
    name = b"AffineMap"
    return struct.pack("<I", len(name)) + name + numpy.ascontiguousarray(matrix, "<f8").tobytes()


def move_vdb(source, target, matrix):
    """Writes the file `source` as `target`, every grid moved by `matrix` (4 x 4, for column vectors). The values of
    vector grids stay as they are."""
    with open(source, "rb") as file:
        data = file.read()
    try:
        if data[:8] != b" BDV\0\0\0\0" or struct.unpack_from("<I", data, 8)[0] < kOldest or not data[20]:
            raise Unusable(f"{source}: not a VDB file that can be moved: of OpenVDB 1.2 or later, not written as a stream")
        at = skip_metadata(data, 21 + 36)
        count = struct.unpack_from("<i", data, at)[0]
        done, pieces, shift = 0, [], 0
        at += 4
        for _ in range(count):
            for _ in range(3):  # name, type, the grid whose tree this one shares
                at = read_string(data, at)[1]
            grid, block, end = struct.unpack_from("<3q", data, at)
            start = skip_metadata(data, grid + 4)
            old, stop = read_map(data, start, source)
            new = affine_map(old @ numpy.asarray(matrix, float).T)
            grown = len(new) - (stop - start)
            # What follows the transform lies so much later, the grid itself only by what came before it.
            places = struct.pack("<3q", grid + shift, block + shift + grown, end + shift + grown)
            pieces += [data[done:at], places, data[at + 24:start], new]
            done, at, shift = stop, end, shift + grown
        pieces.append(data[done:])
    except (struct.error, IndexError, ValueError):
        raise Unusable(f"{source}: not a whole VDB file") from None
    with open(target, "wb") as file:
        file.write(b"".join(pieces))
