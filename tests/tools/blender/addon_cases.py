"""Runs inside Blender, started by blender_test.py: CASE ZIP FOLDER REPOSITORY."""
import glob
import math
import os
import subprocess
import sys
import time

import bpy
import numpy as np
from mathutils import Matrix

sys.path.append(os.path.dirname(os.path.abspath(__file__)))
from scene import (CASE, FOLDER, FRAMES, REPOSITORY, RESOLUTION, RESULTS, START, begin, bounds_of, bounds_over_time,
                   bundled, check_blur, listed, mark, morph, points_of, surface_of, upright)


def check_bounds(what, found, wanted, voxel):
    """Meshes of a level set are off by less than a voxel, from slopes and corners that are cut."""
    worst = np.abs(found - wanted).max() / voxel
    print("  %s: bounding boxes within %.2f voxels" % (what, worst))
    assert worst < 1, (what, found, wanted)


def between(a, b):
    """What goes straight from a to b."""
    t = np.linspace(0, 1, FRAMES).reshape(-1, 1, 1)
    return (1 - t) * a + t * b


def case_bundled_shapes():
    """Two bundled shapes, selected, active last: the ends are the inputs; volumes and meshes are the same shapes."""
    asked = begin()
    ends = [bundled("creature", upright()), bundled("amphora", upright(4, 1, 0.5))]
    wanted = [bounds_of(points_of(thing)) for thing in ends]
    voxels = [(high - low).max() / RESOLUTION for low, high in wanted]
    found = {}
    for result in RESULTS:
        bpy.ops.object.select_all(action="DESELECT")
        for thing in ends:
            thing.select_set(True)
        bpy.context.view_layer.objects.active = ends[1]  # by name it would be the first
        found[result] = bounds_over_time(morph(asked, result))
        for k in (0, -1):
            check_bounds("%s, frame %d" % (result, k), found[result][k], wanted[k], voxels[k])
    for result in RESULTS[1:]:
        check_bounds(result + " and volumes", found[result], found["VOLUME"], max(voxels))
    # Blender's name for a file is the frame's.
    assert sorted(map(os.path.basename, glob.glob(FOLDER + "/out/*"))) == ["volume.%04d.vdb" % (START + k) for k in range(FRAMES)]


def case_known_motion():
    """A shape, and the same moved and enlarged: every frame's box is known. Modifiers count."""
    asked = begin()
    bpy.ops.mesh.primitive_cube_add(size=1)
    small = bpy.context.object
    small.modifiers.new("two", "ARRAY").count = 2  # 1 x 1 x 1 becomes 2 x 1 x 1
    large = small.copy()
    bpy.context.scene.collection.objects.link(large)
    large.matrix_world = Matrix.Translation((4, 2, -1)) @ Matrix.Scale(1.5, 4)
    bpy.context.view_layer.update()
    listed(asked, small, large)
    a = np.array([[-0.5, -0.5, -0.5], [1.5, 0.5, 0.5]])
    for result in RESULTS:
        found = bounds_over_time(morph(asked, result))
        check_bounds(result, found, between(a, 1.5 * a + [4, 2, -1]), 3 / RESOLUTION)


def case_volumes_in():
    """A volume that stands upright by its object's rotation, and the same moved, turned about z and enlarged."""
    asked = begin()
    subprocess.run(["slicemorph", "convert", REPOSITORY + "/assets/amphora.ply", "-o", FOLDER + "/amphora.vdb", "--resolution",
                    str(RESOLUTION), "--quiet"], check=True)
    things = []
    for matrix in (upright(), Matrix.Translation((3, 1, 2)) @ Matrix.Rotation(math.pi, 4, "Z") @ upright(scale=1.5)):
        bpy.ops.object.volume_import(filepath=FOLDER + "/amphora.vdb")
        things.append(bpy.context.object)
        things[-1].matrix_world = matrix
    lookers = [surface_of(thing) for thing in things]
    bpy.context.view_layer.update()
    ends = [bounds_of(points_of(looker)) for looker in lookers]
    voxel = (ends[1][1] - ends[1][0]).max() / RESOLUTION
    listed(asked, *things)
    for result in RESULTS:
        made = morph(asked, result)
        # Turned half way round about z, the box in between is not known.
        found = bounds_over_time(made)
        for k in (0, -1):
            check_bounds("%s, frame %d" % (result, k), found[k], ends[k], voxel)
        check_bounds(result + ", heights", found[:, :, 2], between(*ends)[:, :, 2], voxel)


def case_motion_blur():
    for result in RESULTS:
        asked = begin()
        for x in (-3, 3):
            bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, location=(x, 0, 0))
            asked.inputs.add().thing = bpy.context.object
        check_blur(asked, result)


def case_motion_blur_of_volumes():
    """The same for files that are half as large and have the way along z; level sets, and fog too dense to see through."""
    import pyopenvdb
    for kind in ("surface", "density"):
        asked = begin()
        for z in (-1.5, 1.5):
            ball = pyopenvdb.createLevelSetSphere(0.5, center=(0, 0, z), voxelSize=1 / RESOLUTION)
            if kind == "density":
                low, high = ball.evalActiveVoxelBoundingBox()
                distance = np.empty(np.subtract(high, low) + 1, np.float32)
                ball.copyToArray(distance, low)
                transform, ball = ball.transform, pyopenvdb.FloatGrid()
                ball.copyFromArray(np.where(distance < 0, 100, 0).astype(np.float32), low)
                ball.transform, ball.gridClass = transform, pyopenvdb.GridClass.FOG_VOLUME
            ball.name = kind
            path = "%s/%s%g.vdb" % (FOLDER, kind, z)
            pyopenvdb.write(path, grids=[ball])
            bpy.ops.object.volume_import(filepath=path)
            bpy.context.object.matrix_world = Matrix.Rotation(math.pi / 2, 4, "Y") @ Matrix.Scale(2, 4)
            asked.inputs.add().thing = bpy.context.object
        print("  " + kind)
        check_blur(asked, "VOLUME")


def case_marks():
    """Marks on a cube's sides say that it turns by a quarter: half way it stands on the diagonal."""
    asked = begin()
    cubes = []
    for x in (0, 4):
        bpy.ops.mesh.primitive_cube_add(size=2, location=(x, 0, 0))
        cubes.append(bpy.context.object)
    listed(asked, *cubes)
    sides = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    for k, side in enumerate(sides):
        mark(cubes[0], "side %d" % k, side)
        mark(cubes[1], "side %d" % k, sides[(k + 1) % 4])  # Blender calls it .001
    mark(cubes[0], "alone", (0, 0, 1))
    width = {}
    for marks in (False, True):
        asked.marks = marks
        found = bounds_over_time(morph(asked, "MESH_CACHE"))
        low, high = found[FRAMES // 2]
        width[marks] = (high - low)[:2]
    print("  width half way: %s, with marks %s" % (width[False], width[True]))
    assert (np.abs(width[False] - 2) < 0.1).all() and (width[True] > 2.4).all(), width
    note = "empty alone is left out"
    assert any(note in line for line in sys.modules["slicemorph.inputs"].find_marks(bpy.context.scene, cubes, Matrix())[1])


def case_colours():
    """Red, by points, becomes blue, by corners and in bytes."""
    asked = begin()
    for x, domain, kind, color in ((0, "POINT", "FLOAT_COLOR", (1, 0, 0, 1)), (4, "CORNER", "BYTE_COLOR", (0, 0, 1, 1))):
        bpy.ops.mesh.primitive_cube_add(location=(x, 0, 0))
        layer = bpy.context.object.data.color_attributes.new("paint", kind, domain)
        layer.data.foreach_set("color", color * len(layer.data))
        bpy.context.object.data.color_attributes.active_color = layer
        asked.inputs.add().thing = bpy.context.object
    shown, = morph(asked, "MESH_CACHE")
    for k in range(FRAMES):
        bpy.context.scene.frame_set(START + k)
        mesh = shown.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        colors = np.empty(4 * len(mesh.vertices), np.float32)
        mesh.attributes["Color"].data.foreach_get("color", colors)
        t = k / (FRAMES - 1)
        assert np.abs(colors.reshape(-1, 4) - [1 - t, 0, t, 1]).max() < 1 / 255, (k, colors[:4])
        assert [material.name for material in mesh.materials] == ["mesh_cache"]
    volume, = morph(asked, "VOLUME")
    shader = volume.data.materials[0].node_tree.nodes["Principled Volume"]
    assert shader.inputs["Color Attribute"].default_value == "Cd"


def case_settings_in_file():
    asked = begin()
    listed(asked, bundled("die", upright()), bundled("octahedron", upright(4)))
    asked.method, asked.fit, asked.more = "sdf", "box", "--shell 0.1"
    bpy.ops.wm.save_as_mainfile(filepath=FOLDER + "/kept.blend")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="slicemorph")
    bpy.ops.wm.open_mainfile(filepath=FOLDER + "/kept.blend")
    asked = bpy.context.scene.slicemorph
    assert [row.thing.name for row in asked.inputs] == ["die", "octahedron"]
    assert (asked.method, asked.fit, asked.more, asked.frames) == ("sdf", "box", "--shell 0.1", FRAMES)


def scratch_folders():
    return glob.glob(bpy.app.tempdir + "slicemorph-*")


def case_in_the_background():
    """As with a window: the timer's function, called again and again, never takes long. Progress, end, cancelling,
    another file."""
    asked = begin()
    asked.resolution = 128
    from slicemorph import jobs
    listed(asked, bundled("creature", upright()), bundled("amphora", upright(4)))
    asked.result = "VOLUME"
    job, seen, longest, before = jobs.begin(bpy.context.scene, bpy.context), set(), 0, len(bpy.data.objects)
    assert not bpy.ops.slicemorph.morph.poll()
    while True:
        start = time.thread_time()
        again = jobs.look_again()
        longest = max(longest, time.thread_time() - start)
        seen.add(job.process.percent)
        if again is None:
            break
        time.sleep(again)
    print("  %d values of progress, the longest look took %.3f s" % (len(seen), longest))
    assert len(seen) > 5 and max(seen) > 50 and len(bpy.data.objects) == before + 1, seen
    assert jobs.current is None and not scratch_folders()
    job = jobs.begin(bpy.context.scene, bpy.context)
    while job.process.percent < 3:
        jobs.look_again()
        time.sleep(0.05)
    bpy.ops.slicemorph.cancel()
    while jobs.look_again() is not None:
        time.sleep(0.05)
    assert jobs.last == "cancelled" and job.process.process.returncode == 1 and not scratch_folders()
    job = jobs.begin(bpy.context.scene, bpy.context)
    bpy.ops.wm.read_homefile()
    assert jobs.current is None and jobs.look_again() is None and not scratch_folders()
    assert job.process.process.poll() is not None and jobs.leave_file not in bpy.app.handlers.load_pre


def refused(says):
    try:
        bpy.ops.slicemorph.morph(wait=True)
    except RuntimeError as problem:
        assert says in str(problem), problem
        assert sys.modules["slicemorph.jobs"].current is None and not scratch_folders()
        return
    raise AssertionError("not refused: " + says)


def case_refused():
    asked = begin()
    refused("two or more")
    die, octahedron = bundled("die", upright()), bundled("octahedron", upright(4))
    listed(asked, die, octahedron)
    asked.folder = "//out"
    refused("save the file first")
    asked.result, asked.more = "MESH_CACHE", "--frames=3"
    refused("--frames=3 is set by the add-on")
    asked.more = "--nonsense 1"
    refused("--nonsense")  # says the program
    asked.more, asked.resolution = "", 5
    refused("8 to 4096")
    asked.resolution, die.hide_viewport = RESOLUTION, True
    refused("die is hidden")
    die.hide_viewport = False
    die["slicemorph"] = asked.name
    refused("choose another name")
    del die["slicemorph"]
    mark(die, "here", (0, 0, 0))
    mark(die, "here", (1, 0, 0))
    refused("two empties named here")
    asked.marks = False
    bpy.ops.object.volume_add()
    listed(asked, die, bpy.context.object)
    refused("must come from a file")
    listed(asked, die, octahedron)
    preferences = bpy.context.preferences.addons["slicemorph"].preferences
    preferences.program = FOLDER + "/nothing"
    refused("no program is there")
    preferences.program, os.environ["PATH"] = "", "/nowhere"
    refused("is not found")


def case_nothing_left():
    """Disabled in the middle of a morph, the add-on leaves no process, property, class, handler or timer."""
    def state():
        # As sets: Blender's own add-ons add theirs again with every new file.
        handlers = {(name, one.__module__, one.__name__) for name in dir(bpy.app.handlers)
                    if isinstance(getattr(bpy.app.handlers, name), list) for one in getattr(bpy.app.handlers, name)}
        return handlers, {name for name in dir(bpy.types) if "slicemorph" in name.lower()}, hasattr(bpy.types.Scene, "slicemorph")

    bpy.ops.wm.read_factory_settings(use_empty=True)
    before = state()
    asked = begin()
    assert state() != before
    from slicemorph import jobs
    listed(asked, bundled("creature", upright()), bundled("amphora", upright(4)))
    process = jobs.begin(bpy.context.scene, bpy.context).process.process
    bpy.app.timers.register(jobs.look_again)
    assert process.poll() is None
    bpy.ops.preferences.addon_disable(module="slicemorph")
    assert state() == before, state()
    assert process.poll() is not None and not scratch_folders()
    assert not bpy.app.timers.is_registered(jobs.look_again)
    bpy.ops.preferences.addon_enable(module="slicemorph")
    try:
        bpy.ops.preferences.addon_remove(module="slicemorph")
    except RuntimeError as problem:
        assert "tag_redraw" in str(problem), problem  # Blender's last step, for which there is no window
    assert state() == before and not glob.glob(FOLDER + "/scripts/addons/*")


globals()["case_" + CASE]()
