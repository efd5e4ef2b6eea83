import time

import bpy
from bpy.props import BoolProperty, EnumProperty

from . import inputs, jobs
from .program import Unusable


class SLICEMORPH_OT_morph(bpy.types.Operator):
    """Make the morph, in the background"""
    bl_idname = "slicemorph.morph"
    bl_label = "Morph"
    wait: BoolProperty(name="Wait", description="Return when the result is in the scene, as scripts want it",
                       options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return jobs.current is None

    def execute(self, context):
        try:
            job = jobs.begin(context.scene, context)
            if not self.wait and not bpy.app.background:
                bpy.app.timers.register(jobs.look_again, first_interval=jobs.kLook, persistent=True)
                return {"FINISHED"}
            while jobs.advance():
                time.sleep(0.01)
        except Unusable as problem:
            jobs.last = str(problem)
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        except BaseException:
            jobs.abandon()
            raise
        for note in job.all_notes():
            self.report({"INFO"}, note)
        return {"FINISHED"}


class SLICEMORPH_OT_cancel(bpy.types.Operator):
    """Stop making the morph"""
    bl_idname = "slicemorph.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return jobs.current is not None

    def execute(self, context):
        jobs.current.cancel()
        return {"FINISHED"}


class SLICEMORPH_OT_add_inputs(bpy.types.Operator):
    """Put the selected objects on the list, the active one last"""
    bl_idname = "slicemorph.add_inputs"
    bl_label = "Add Selected"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        rows = context.scene.slicemorph.inputs
        there = [row.thing for row in rows]
        for thing in inputs.selected_things(context):
            if thing not in there:
                rows.add().thing = thing
        context.scene.slicemorph.active = len(rows) - 1
        return {"FINISHED"}


class SLICEMORPH_OT_edit_inputs(bpy.types.Operator):
    """Change the list of inputs"""
    bl_idname = "slicemorph.edit_inputs"
    bl_label = "Edit List"
    bl_options = {"REGISTER", "UNDO"}
    action: EnumProperty(items=[("REMOVE", "Remove", "Take it off the list"), ("UP", "Up", "Earlier"),
                                ("DOWN", "Down", "Later"), ("CLEAR", "Clear", "Take all off the list")])

    def execute(self, context):
        asked = context.scene.slicemorph
        rows, row = asked.inputs, asked.active
        if self.action == "CLEAR":
            rows.clear()
        elif self.action == "REMOVE" and 0 <= row < len(rows):
            rows.remove(row)
        elif self.action in ("UP", "DOWN"):
            to = row + (1 if self.action == "DOWN" else -1)
            if 0 <= row < len(rows) and 0 <= to < len(rows):
                rows.move(row, to)
                asked.active = to
        asked.active = max(0, min(asked.active, len(rows) - 1))
        return {"FINISHED"}


kClasses = (SLICEMORPH_OT_morph, SLICEMORPH_OT_cancel, SLICEMORPH_OT_add_inputs, SLICEMORPH_OT_edit_inputs)
