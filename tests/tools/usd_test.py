#!/usr/bin/env python3
"""USD stages of volumes and meshes. Oracles: the format and its schemas (tests/support/usda.py), pyopenvdb for every grid that a
stage names, closed forms, and the same surfaces as OBJ.

usage: usd_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openvdb and python3-nibabel. Real files are read where ../shared/data is beside the repository. Each
stage is also read by npm's tinyusdz: the folder of the package in TINYUSDZ, or installed globally.
"""
import os
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_within
from grids import ball, fog_of_smoke, real
from meshes import box_obj, sphere_obj
from program import Program
from usda import TINYUSDZ, read_stage

if len(sys.argv) < 2:
    sys.exit(__doc__)
program = Program(sys.argv[1])
ONLY = sys.argv[2:]

CLASSES = {vdb.GridClass.LEVEL_SET: "levelSet", vdb.GridClass.FOG_VOLUME: "fogVolume", vdb.GridClass.STAGGERED: "staggered",
           vdb.GridClass.UNKNOWN: "unknown"}
TYPES = {"float": "float", "double": "double", "int32": "int", "int64": "int64", "bool": "bool", "vec3s": "float3", "vec3d": "double3"}


def times_of(stage, fps, first, last):
    m = stage.metadata
    assert m["timeCodesPerSecond"] == m["framesPerSecond"] == fps, m
    assert (m["startTimeCode"], m["endTimeCode"]) == (first, last), m
    return list(range(first, last + 1))


def world_box(grids):
    """The box of all active voxels, out to their faces, and the largest voxel."""
    low, high, largest = np.full(3, np.inf), np.full(3, -np.inf), 0
    for grid in grids:
        if not grid.activeVoxelCount():
            continue
        box = np.array(grid.evalActiveVoxelBoundingBox(), float) + [[-.5], [.5]]
        corners = np.array([grid.transform.indexToWorld(tuple(box[c >> a & 1][a] for a in range(3))) for c in range(8)])
        low, high, largest = np.minimum(low, corners.min(0)), np.maximum(high, corners.max(0)), max(largest, *grid.transform.voxelSize())
    return low, high, largest


def checked_volume(path, fps, first, last, tinyusdz="scene"):
    """Every asset, index, class, type and extent is that of the VDB file. Returns the fields by (name, index)."""
    stage = read_stage(path, tinyusdz)
    times = times_of(stage, fps, first, last)
    assert stage.root.kind == "Xform" and list(stage.root.children) == ["volume"]
    volume = stage.root.children["volume"]
    fields = {}
    assert set(volume.fields) == set(volume.children), (volume.fields, list(volume.children))
    for name, target in volume.fields.items():
        assert target == "/%s/volume/%s" % (stage.root.name, name), target
        field = volume.children[name]
        assert field.kind == "OpenVDBAsset" and list(field.samples["filePath"]) == times
        key = field.values["fieldName"], field.values["fieldIndex"]
        assert key not in fields, key
        fields[key] = field
    for time in times:
        assets = {key: field.samples["filePath"][time] for key, field in fields.items()}
        files = {asset for asset in assets.values() if asset is not None}
        assert len(files) == 1 and all(asset.startswith("./") for asset in files), assets
        grids = vdb.readAll(os.path.join(os.path.dirname(path), files.pop()))[0]
        there = {}
        for grid in grids:
            index = sum(1 for name, _ in there if name == grid.name)
            there[grid.name, index] = grid
        # A grid that a file lacks has no value, and nothing else that a file holds is left out.
        assert {key for key, asset in assets.items() if asset is not None} == set(there), (time, assets, list(there))
        for key, grid in there.items():
            field = fields[key].values
            assert field["fieldClass"] == CLASSES[grid.gridClass], (key, field)
            assert field["fieldDataType"] == TYPES[grid.valueTypeName], (key, field)
        low, high, _ = world_box(there.values())
        extent = volume.samples["extent"][time]
        if np.isfinite(low).all():
            assert np.allclose(extent, [low, high], rtol=1e-6, atol=1e-6), (extent, low, high)
        else:
            assert extent is None, extent
    return stage, fields


def write_smoke(path, shift, heat=True):
    """Fog twice under one name, vectors on faces, and grids whose names are no names of prims."""
    fog, x, transform = fog_of_smoke(shift)
    grids = []
    for name, values, kind in (("density", fog, "FOG_VOLUME"), ("density", fog / 2, "FOG_VOLUME"), ("heat 1", 3 * fog, "UNKNOWN"),
                               ("heat.1", 2 * fog, "UNKNOWN"), ("wind", np.stack([fog, 2 * fog, x * fog], -1), "STAGGERED")):
        if name == "heat 1" and not heat:
            continue
        grid = vdb.Vec3SGrid() if values.ndim == 4 else vdb.FloatGrid()
        grid.copyFromArray(values.astype(np.float32))
        grid.name, grid.gridClass = name, getattr(vdb.GridClass, kind)
        grid.transform = transform
        grids.append(grid)
    vdb.write(path, grids=grids)


def case_volume_of_level_sets():
    ball("a.vdb", 3)
    ball("b.vdb", 4)
    printed = program.run("morph", "a.vdb", "b.vdb", "-o", "x.usda", "--frames", "3", "--start", "1001", "--fps", "29.97").stdout
    assert printed.split() == ["x.1001.vdb", "x.1002.vdb", "x.1003.vdb", "x.usda"], printed
    stage, fields = checked_volume("x.usda", 29.97, 1001, 1003)
    assert list(fields) == [("surface", 0), ("vel", 0)]
    assert fields["vel", 0].values["vectorDataRoleHint"] == "Vector"
    assert stage.metadata["upAxis"] == "Y" and stage.metadata["metersPerUnit"] == 1 and stage.root.name == "x"
    program.run("morph", "a.vdb", "b.vdb", "-o", "y.####.vdb", "--frames", "3", "--start", "1001", "--fps", "29.97")
    for n in (1001, 1002, 1003):
        assert open("x.%d.vdb" % n, "rb").read() == open("y.%d.vdb" % n, "rb").read(), n


def case_volume_of_smoke():
    write_smoke("a.vdb", 0)
    write_smoke("b.vdb", 3)
    os.mkdir("out")
    program.run("morph", "a.vdb", "b.vdb", "-o", "out/1 x-y.usda", "--frames", "3", "--glb-up", "z", "--glb-unit", "cm")
    stage, fields = checked_volume("out/1 x-y.usda", 24, 1, 3)
    assert {("density", 0), ("density", 1), ("heat 1", 0), ("heat.1", 0), ("wind", 0)} <= set(fields), list(fields)
    assert fields["wind", 0].values["fieldClass"] == "staggered"
    assert stage.metadata["upAxis"] == "Z" and stage.metadata["metersPerUnit"] == 0.01
    assert len({field.name for field in fields.values()}) == len(fields)


def case_grids_come_and_go():
    """A grid that only some of a sequence's files have, and files that hold nothing yet."""
    for n in range(1, 4):
        write_smoke("a.%04d.vdb" % n, n / 2, heat=n != 2)
        write_smoke("b.%04d.vdb" % n, 3, heat=n != 2)
    program.run("morph", "a.####.vdb", "b.####.vdb", "-o", "x.usda")
    fields = checked_volume("x.usda", 24, 1, 3)[1]
    assert [asset is None for asset in fields["heat 1", 0].samples["filePath"].values()] == [False, True, False]


def case_parts_of_a_sequence():
    """Processes that make some of the frames each leave the stage that one process writes."""
    ball("a.vdb", 3)
    ball("b.vdb", 4)
    command = ("morph", "a.vdb", "b.vdb", "--frames", "6", "-o")
    program.run(*command, "x.usda")
    whole = open("x.usda").read()
    os.makedirs("part")
    program.run(*command, "part/x.usda", "--range", "2-3")
    volume = read_stage("part/x.usda").root.children["volume"]
    assert list(volume.samples["extent"]) == [2, 3]
    assert all(list(field.samples["filePath"]) == [1, 2, 3, 4, 5, 6] for field in volume.children.values())
    running = [subprocess.Popen([program.path, *command, "part/x.usda", "--range", some, "--quiet"]) for some in ("1", "4-6x2", "5")]
    assert [process.wait(timeout=600) for process in running] == [0, 0, 0]
    assert open("part/x.usda").read() == whole
    os.remove("part/x.usda")
    os.remove("part/x.0004.vdb")
    program.run(*command, "part/x.usda", "--resume")
    assert open("part/x.usda").read() == whole


def case_real_files():
    """Gas of a simulation, and a file of three grids of one name."""
    data = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "shared", "data", "vdb")
    # Without `flags`: pyopenvdb knows no grids of integers.
    program.run("morph", real(data, "c42_gas_0006.vdb"), real(data, "c42_gas_0010.vdb"), "--at", "0,0.5", "-o", "gas.usda",
                "--grids", "density,temperature,flame,velocity")
    fields = checked_volume("gas.usda", 24, 1, 2)[1]
    assert {(name, 0) for name in ("density", "temperature", "flame", "velocity")} <= set(fields), list(fields)
    assert fields["velocity", 0].values["vectorDataRoleHint"] == "Vector"
    program.run("morph", *[real(data, "three_grids_same_name.vdb")] * 2, "--frames", "2", "-o", "three.usda")
    assert {("density", n) for n in range(3)} <= set(checked_volume("three.usda", 24, 1, 2)[1])


def case_retime():
    for n, radius in ((1, 3), (3, 3.5)):
        ball("a.%04d.vdb" % n, radius)
    program.run("retime", "a.####.vdb", "-o", "slow.usda", "--fps", "25", "--range", "2-3")
    program.run("retime", "a.####.vdb", "-o", "slow.usda", "--fps", "25", "--resume")
    checked_volume("slow.usda", 25, 1, 3)


def case_image_is_in_millimetres():
    import nibabel as nib
    data = np.zeros((16, 14, 12), np.int16)
    for name, size in (("a.nii", 4), ("b.nii", 5)):
        data[8 - size:8 + size, 7 - size:7 + size, 6 - size:6 + size] = 1000
        nib.save(nib.Nifti1Image(data, np.diag([2, 2, 2, 1.])), name)
    program.run("morph", "a.nii", "b.nii", "-o", "x.usda", "--frames", "2", "--image", "grey", "--iso", "500")
    stage, fields = checked_volume("x.usda", 24, 1, 2)
    assert {("surface", 0), ("image", 0)} <= set(fields), list(fields)
    assert stage.metadata["upAxis"] == "Z" and stage.metadata["metersPerUnit"] == 0.001, stage.metadata
    program.run("morph", "a.nii", "b.nii", "-o", "m.usda", "--usd", "mesh", "--frames", "2", "--image", "grey", "--iso", "500",
                "--glb-up", "y", "--glb-unit", "m")
    stage = read_stage("m.usda")
    assert stage.metadata["upAxis"] == "Y" and stage.metadata["metersPerUnit"] == 1, stage.metadata
    program.run("convert", "a.nii", "--image", "grey", "--iso", "500", "-o", "c.usda")
    stage = read_stage("c.usda")
    assert stage.metadata == {"defaultPrim": "c", "metersPerUnit": 0.001, "upAxis": "Z"}, stage.metadata


def obj(path):
    points, colors, faces = [], [], []
    for line in open(path):
        parts = line.split()
        if parts[0] == "v":
            points.append(parts[1:4]), colors.append(parts[4:])
        elif parts[0] == "f":
            faces.append([int(p) - 1 for p in parts[1:]])
    return np.array(points, float).reshape(-1, 3), np.array(colors, float), np.array(faces).reshape(-1, 3)


def mesh_at(prim, time=None):
    """Attributes at a time (None: of a still) as arrays, after checks that hold for every mesh."""
    values = prim.values if time is None else {name: samples[time] for name, samples in prim.samples.items()}
    assert prim.values["subdivisionScheme"] == "none"
    counts, indices = np.array(values["faceVertexCounts"], int), np.array(values["faceVertexIndices"], int)
    points, normals = np.array(values["points"], float).reshape(-1, 3), np.array(values["normals"], float).reshape(-1, 3)
    assert (counts == 3).all() and len(indices) == counts.sum() and len(normals) == len(points)
    faces = indices.reshape(-1, 3)
    if len(points):
        assert 0 <= indices.min() and indices.max() < len(points)
        assert np.array_equal(values["extent"], [points.min(0), points.max(0)]), values["extent"]
        assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
    else:
        assert values["extent"] is None
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there = set(map(tuple, edges))
    assert len(there) == len(edges) and all((b, a) in there for a, b in there), "not closed"
    for name in ("normals", "primvars:displayColor"):
        assert (name in values) == (name in prim.interpolation), (name, prim.interpolation)
    return points, faces, normals, values


def case_mesh_of_balls():
    """A ball that grows and moves: place, size, normals and speed at every frame by their closed forms."""
    sphere_obj("a.obj", 1, 48, (0, 0, 0))
    sphere_obj("b.obj", 1.5, 48, (0.5, 0, 1))
    frames, fps, voxel = 5, 10, 0.0625
    assert program.run("morph", "a.obj", "b.obj", "-o", "x.usda", "--frames", frames, "--fps", fps, "--voxel-size", voxel,
                       "--align", "none").stdout.split() == ["x.usda"]
    stage = read_stage("x.usda")
    times = times_of(stage, fps, 1, frames)
    prim = stage.root.children["surface"]
    assert prim.kind == "Mesh" and "primvars:displayColor" not in prim.samples
    seconds = (frames - 1) / fps
    for time in times:
        points, faces, normals, values = mesh_at(prim, time)
        t = (time - 1) / (frames - 1)
        radius, center, growth, motion = 1 + t / 2, np.array([t / 2, 0, t]), 0.5 / seconds, np.array([0.5, 0, 1]) / seconds
        out = points - center
        distance = np.linalg.norm(out, axis=1)
        # Half a voxel, and the facets of the inputs: their middles are nearer by r (1 - cos(pi / 96)) along each of two directions.
        wrong = np.abs(distance - radius)
        assert wrong.max() < voxel / 2 + 2 * radius * (1 - np.cos(np.pi / 96)), (time, wrong.max())
        out /= distance[:, None]
        assert (np.einsum("ij,ij->i", normals, out) > 0.9).all()
        # Outward speed: along the surface any motion shows the same ball. The grid's velocities are wrong by a tenth of a
        # voxel per frame at most (kVelocityError), and the map by half a voxel over all frames.
        speed = np.einsum("ij,ij->i", np.array(values["velocities"]), out)
        wrong = np.abs(speed - growth - out @ motion) / fps / voxel
        assert wrong.max() < 0.1 + 0.5 / (frames - 1), (time, wrong.max(), wrong.mean())


def case_mesh_is_that_of_obj():
    """Points, faces and colours of a coloured morph are those of its OBJ files, also frame by frame and in parts."""
    for name, low, high, color in (("a", -1, 1, (1, .5, 0)), ("b", -1.2, 0.9, (0, .25, 1))):
        box_obj(name + ".obj", [low] * 3, [high] * 3)
        lines = [line.rstrip() + (" %g %g %g" % color if line[0] == "v" else "") for line in open(name + ".obj")]
        open(name + ".obj", "w").write("\n".join(lines) + "\n")
    command = ("morph", "a.obj", "b.obj", "--frames", "3", "--resolution", "24", "-o")
    program.run(*command, "x.####.obj")
    program.run(*command, "x.usda")
    program.run(*command, "part.usda", "--range", "2-3")
    program.run(*command, "x.####.usda")
    prim, part = (read_stage(name).root.children["surface"] for name in ("x.usda", "part.usda"))
    assert list(part.samples["points"]) == [2, 3]
    for time in (1, 2, 3):
        points, colors, faces = obj("x.%04d.obj" % time)
        still = read_stage("x.%04d.usda" % time).root.children["surface"]
        for found in [(prim, time), (still, None)] + [(part, time)] * (time > 1):
            own_points, own_faces, _, values = mesh_at(*found)
            assert np.array_equal(own_points, points.astype(np.float32)) and np.array_equal(own_faces, faces), time
            assert np.array_equal(values["primvars:displayColor"], colors.astype(np.float32)), time
    assert prim.samples["primvars:displayColor"][1][0] == [1, .5, 0]


def case_mesh_far_away():
    """What lies far from 0 keeps its digits by a translation."""
    for name, size in (("a.obj", 1), ("b.obj", 1.5)):
        box_obj(name, [4e5 - size, 5e6 - size, 0], [4e5 + size, 5e6 + size, 2 * size])
    command = ("morph", "a.obj", "b.obj", "--frames", "2", "--resolution", "16", "-o")
    program.run(*command, "x.####.obj")
    program.run(*command, "x.usda")
    prim = read_stage("x.usda").root.children["surface"]
    assert prim.values["xformOpOrder"] == ["xformOp:translate"]
    for time in (1, 2):
        expected = obj("x.%04d.obj" % time)[0]
        points = mesh_at(prim, time)[0] + prim.values["xformOp:translate"]
        assert np.abs(points - expected).max() < 1e-6, np.abs(points - expected).max()


def case_mesh_of_nothing():
    """Before something is there, a mesh without points."""
    empty = vdb.FloatGrid(0.75)
    empty.name, empty.gridClass = "surface", vdb.GridClass.LEVEL_SET
    empty.transform = vdb.createLinearTransform(0.25)
    for name in "ab":
        vdb.write(name + ".0001.vdb", grids=[empty])
        for n in (2, 3):
            ball("%s.%04d.vdb" % (name, n), 2 + n / 4)
    program.run("morph", "a.####.vdb", "b.####.vdb", "-o", "x.usda", "--usd", "mesh")
    # tinyusdz makes no scene of a mesh without points.
    prim = read_stage("x.usda", "layer").root.children["surface"]
    assert [len(mesh_at(prim, time)[0]) > 0 for time in (1, 2, 3)] == [False, True, True]


def case_the_same_for_any_threads():
    ball("a.vdb", 3)
    ball("b.vdb", 4, (2, 2, 3))
    for kind in ("volume", "mesh"):
        content = []
        for threads in ("1", "2"):
            program.run("morph", "a.vdb", "b.vdb", "--usd", kind, "--frames", "3", "--threads", threads, "-o", "x.usda")
            content.append(open("x.usda", "rb").read())
        assert content[0] == content[1], kind


def case_names_with_signs():
    ball("a.vdb", 3)
    ball("b.vdb", 4)
    program.run("morph", "a.vdb", "b.vdb", "-o", "a@b \xe9.usda", "--at", "0.5")
    # tinyusdz 0.9.0 cuts two letters off names in @@@.
    fields = checked_volume("a@b \xe9.usda", 24, 1, 1, tinyusdz=None)[1]
    assert fields["surface", 0].samples["filePath"][1] == "./a@b \xe9.0001.vdb", fields["surface", 0].samples


def case_tinyusdz():
    if not TINYUSDZ:
        raise Skip("npm's tinyusdz is not installed (npm install -g tinyusdz, or its folder in TINYUSDZ)")
    ball("a.vdb", 3)
    program.run("convert", "a.vdb", "-o", "x.usda")
    mesh_at(read_stage("x.usda").root.children["surface"])


def case_refused():
    ball("a.vdb", 3)
    ball("b.vdb", 4)
    program.refused("morph", "a.vdb", "b.vdb", "-o", "x.####.usda", "--usd", "volume", says=["--usd", "####"])
    program.refused("morph", "a.vdb", "b.vdb", "-o", "x.####.vdb", "--usd", "volume", says=["--usd volume", "x.####.vdb"])
    program.refused("morph", "a.vdb", "b.vdb", "-o", "x.usda", "--usd", "mesh", "--velocity-unit", "frame", says=["--velocity-unit"])
    program.refused("morph", "a.vdb", "b.vdb", "-o", "x.usda", "--usd", "points", says=["--usd points", "volume"])
    program.refused("morph", "a.vdb", "b.vdb", "-o", "missing/x.usda", says=["missing"])
    os.mkdir("folder.usda")
    program.refused("morph", "a.vdb", "b.vdb", "-o", "folder.usda", says=["folder.usda"])
    open("x.usda", "w").write("#usda 1.0\n")
    program.refused("convert", "x.usda", "-o", "y.obj", says=["x.usda"])


sys.exit(run_within(globals(), ONLY))
