"""Materials of what comes out."""

import bpy

kOpaque = 10.0  # optical depth of a level set's inner band: nothing shines through
kBand = 3.0  # its width, in voxels


def new_material(name, shader_type, socket="Volume"):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new(shader_type)
    output.location = (300, 0)
    links.new(shader.outputs[0], output.inputs[socket])
    return material, nodes, links, shader


def smoke(name, grids):
    """Principled Volume of the grids `density`, `color` and `temperature`, as Blender's own smoke has them."""
    material, _, _, shader = new_material(name, "ShaderNodeVolumePrincipled")
    shader.inputs["Density Attribute"].default_value = "density"
    use_color(shader, grids)
    return material


def use_color(shader, grids):
    color = next((name for name in ("color", "Cd") if name in grids), "")
    shader.inputs["Color Attribute"].default_value = color
    if color:
        shader.inputs["Color"].default_value = (1, 1, 1, 1)


def painted(name, attribute):
    """A surface in the colours of its mesh."""
    material, nodes, links, shader = new_material(name, "ShaderNodeBsdfPrincipled", "Surface")
    color = nodes.new("ShaderNodeAttribute")
    color.attribute_name = attribute
    color.location = (-300, 0)
    links.new(color.outputs["Color"], shader.inputs["Base Color"])
    return material


def solid(name, grids, voxel):
    """Opaque where the level set `surface` is negative; `voxel`: its size, in the object's space."""
    material, nodes, links, shader = new_material(name, "ShaderNodeVolumePrincipled")
    shader.inputs["Density Attribute"].default_value = ""
    use_color(shader, grids)
    distance, inside, dense = (nodes.new(kind) for kind in ("ShaderNodeAttribute", "ShaderNodeMath", "ShaderNodeMath"))
    distance.attribute_name = "surface"
    inside.operation, dense.operation = "LESS_THAN", "MULTIPLY"
    inside.inputs[1].default_value = 0
    dense.inputs[1].default_value = kOpaque / (kBand * voxel)
    links.new(distance.outputs["Fac"], inside.inputs[0])
    links.new(inside.outputs[0], dense.inputs[0])
    links.new(dense.outputs[0], shader.inputs["Density"])
    for column, node in enumerate((distance, inside, dense)):
        node.location = (200 * column - 600, 0)
    return material
