"""VTK XML PolyData with appended raw data, read by VTK's description of its file formats."""
import struct
import xml.etree.ElementTree as ElementTree

import numpy as np


def read_vtp(path):
    """Points (N x 3), triangles (M x 3) and the text of the field SPACE, empty where there is none."""
    head, _, body = open(path, "rb").read().partition(b'<AppendedData encoding="raw">\n_')
    root = ElementTree.fromstring(head + b"</VTKFile>")
    assert root.get("type") == "PolyData" and root.get("header_type") == "UInt64"

    def block(array, kind):
        at = int(array.get("offset"))
        return np.frombuffer(body[at + 8:at + 8 + struct.unpack("<Q", body[at:at + 8])[0]], kind)

    piece = root.find("PolyData/Piece")
    polys = {array.get("Name"): block(array, "<i8") for array in piece.findall("Polys/DataArray")}
    points = block(piece.find("Points/DataArray"), "<f4").reshape(-1, 3).astype(float)
    triangles = polys["connectivity"].reshape(-1, 3)
    assert len(points) == int(piece.get("NumberOfPoints")) and len(triangles) == int(piece.get("NumberOfPolys"))
    assert np.array_equal(polys["offsets"], 3 * np.arange(1, len(triangles) + 1))
    field = root.find("PolyData/FieldData/Array")
    said = "".join(chr(int(c)) for c in field.text.split() if int(c)) if field is not None else ""
    return points, triangles, said


def volume_of(points, triangles):
    """By the divergence theorem; positive where triangles are counter-clockwise seen from outside."""
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return np.einsum("ij,ij", a, np.cross(b, c)) / 6


def is_closed(triangles):
    """Whether each edge is passed once in each direction."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    there = {tuple(edge) for edge in edges.tolist()}
    return len(there) == len(edges) and all((b, a) in there for a, b in there)
