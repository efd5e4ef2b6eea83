import textwrap

import bpy

from . import jobs

kColumns = 40  # letters on a line of a panel that has not been made wider


class SLICEMORPH_UL_inputs(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flags=0):
        layout.prop(item, "thing", text="", emboss=False, icon="OBJECT_DATA")


class SLICEMORPH_PT_panel(bpy.types.Panel):
    bl_label = "Slicemorph"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Slicemorph"

    def draw(self, context):
        layout, asked = self.layout, context.scene.slicemorph
        layout.use_property_split = True
        layout.use_property_decorate = False
        self.draw_inputs(layout, asked)
        self.draw_job(layout)
        for name in ("frames", "method", "resolution", "fit", "align", "marks", "result", "name"):
            layout.prop(asked, name)
        if asked.result == "VOLUME":
            layout.prop(asked, "folder")
        layout.prop(asked, "more")

    def draw_inputs(self, layout, asked):
        row = layout.row()
        row.template_list("SLICEMORPH_UL_inputs", "", asked, "inputs", asked, "active", rows=4)
        column = row.column(align=True)
        column.operator("slicemorph.add_inputs", text="", icon="ADD")
        for action, icon in (("REMOVE", "REMOVE"), ("UP", "TRIA_UP"), ("DOWN", "TRIA_DOWN"), ("CLEAR", "X")):
            column.operator("slicemorph.edit_inputs", text="", icon=icon).action = action
        if not asked.inputs:
            layout.label(text="The selected objects, the active last")

    def draw_job(self, layout):
        job = jobs.current
        if job:
            process = job.process
            left = f", {process.left} left" if process.left else ""
            layout.label(text="cancelling" if job.cancelled else f"{process.stage} {process.percent} %{left}")
            layout.operator("slicemorph.cancel", icon="CANCEL")
        else:
            layout.operator("slicemorph.morph", icon="MOD_REMESH")
            for line in jobs.last.splitlines():
                for part in textwrap.wrap(line, kColumns):
                    layout.label(text=part)


kClasses = (SLICEMORPH_UL_inputs, SLICEMORPH_PT_panel)
