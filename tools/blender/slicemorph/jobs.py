"""The morph that is being made: one at a time, in the background, looked at by a timer."""

import pathlib
import shutil
import tempfile

import bpy

from . import inputs, results
from .program import Process, Unusable, find_program
from .settings import preferences

kLook = 0.2  # seconds between two looks at the program
kOutputs = {"VOLUME": "{}.####.vdb", "MESH_CACHE": "{}.usda", "SHAPE_KEYS": "{}.glb"}

current = None  # the Job that runs
last = ""  # how the one before ended, for the panel


class Job:
    """Writes the inputs and starts the program. Blender's data may move while it runs, so that it keeps names, no
    data; raises Unusable."""

    def __init__(self, scene, context):
        asked = scene.slicemorph
        things = inputs.chosen_things(scene, context)
        self.scene, self.result, self.name = scene.name, asked.result, bpy.path.clean_name(asked.name) or "morph"
        if any(thing.get(results.kMade) == self.name for thing in things):
            raise Unusable(f"an input is the result named {self.name}, which would be replaced: choose another name")
        self.space = inputs.morph_space(things)
        self.start, self.frames = scene.frame_start, asked.frames
        self.fps = scene.render.fps / scene.render.fps_base
        self.steps, self.cancelled = None, False
        program = [find_program(bpy.path.abspath(preferences().program) if preferences() else ""), "morph"]
        more = inputs.extra_options(asked.more)
        marks, self.notes = inputs.find_marks(scene, things, self.space) if asked.marks else ({}, [])
        folder = self._result_folder(asked.folder)
        self.scratch = tempfile.mkdtemp(prefix="slicemorph-", dir=bpy.app.tempdir)
        try:
            self.output = pathlib.Path(folder or self.scratch, kOutputs[self.result].format(self.name))
            graph = context.evaluated_depsgraph_get()
            paths = [inputs.write_input(thing, number, self.space, graph, self.scratch)
                     for number, thing in enumerate(things, 1)]
            job = pathlib.Path(self.scratch, "job.toml")
            job.write_text(inputs.job_text(paths, marks, self._options(asked)), encoding="utf-8")
            self.process = Process([*program, "--config", str(job), *more])
        except BaseException:
            shutil.rmtree(self.scratch, ignore_errors=True)
            raise

    def _result_folder(self, folder):
        """Where volumes go, which stay in files; None for results that become part of the scene."""
        if self.result != "VOLUME":
            return None
        if folder.startswith("//") and not bpy.data.filepath:
            raise Unusable("the volumes' folder is beside this file: save the file first, or choose another folder")
        path = pathlib.Path(bpy.path.abspath(folder))
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            raise Unusable(f"{path}: cannot be made: {problem.strerror}") from None
        return path

    def _options(self, asked):
        up = inputs.upright_axis(self.space)
        options = {"output": str(self.output), "frames": self.frames, "start": self.start, "fps": self.fps,
                   "method": asked.method, "fit": asked.fit, "align": "auto" if asked.align else "none", "upright": up}
        if asked.resolution:
            options["resolution"] = asked.resolution
        if self.result == "MESH_CACHE":
            options["usd"] = "mesh"  # has its velocities per second
        else:
            options.update({"velocity": "vel", "velocity-unit": "second"})
        if self.result == "SHAPE_KEYS":
            options["glb-up"] = "z" if up == "z" else "y"
        return options

    def advance(self):
        """A short piece of the work; False when all is done. Raises Unusable where the program failed."""
        if self.steps is None:
            if not self.process.ended():
                return True
            if self.cancelled:
                raise Unusable("cancelled")
            if self.process.process.returncode:
                raise Unusable(self.process.complaint())
            if self.scene not in bpy.data.scenes:
                raise Unusable("the scene of the morph is no longer there")
            self.steps = results.add_result(self, bpy.data.scenes[self.scene])
        return next(self.steps, None) is not None

    def cancel(self):
        self.cancelled = True
        self.process.cancel()

    def close(self):
        self.process.kill()
        shutil.rmtree(self.scratch, ignore_errors=True)

    def all_notes(self):
        return self.notes + self.process.notes()


def begin(scene, context):
    """Starts the morph; look_again() goes on with it."""
    global current, last
    if current:
        raise Unusable("a morph is being made: wait for it, or cancel it")
    current, last = Job(scene, context), ""
    bpy.app.handlers.load_pre.append(leave_file)
    return current


def end(message):
    global current, last
    current.close()
    current, last = None, message
    bpy.app.handlers.load_pre.remove(leave_file)


def advance():
    """A piece of the current job, which is closed when it is done or fails; False when it is done."""
    try:
        if current.advance():
            return True
        end(f"{current.name} is made")
    except BaseException as problem:
        end(str(problem))
        raise
    return False


def look_again():
    """The timer: returns the seconds until it wants to be called again, None for never."""
    if not current:
        return None
    try:
        going = advance()
        if not going and bpy.ops.ed.undo_push.poll():
            bpy.ops.ed.undo_push(message="Morph")
    except Unusable:
        going = False  # the panel shows it
    redraw()
    return (0.01 if current.steps else kLook) if going else None


def leave_file(*_):
    """Another file is opened: nobody waits for the morph."""
    abandon()


def redraw():
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def abandon():
    """Ends what is going on and forgets it, as when the add-on is removed."""
    if bpy.app.timers.is_registered(look_again):
        bpy.app.timers.unregister(look_again)
    if current:
        end("")
