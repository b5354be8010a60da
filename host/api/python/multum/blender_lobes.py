# SPDX-License-Identifier: Apache-2.0
"""Draws baked lobes, NAME.ndf.exr, or the textures of `multum export --for blender` with Cycles, Blender's path tracer,
and exports materials to engines.

This file is an add-on for Blender 3.4: install it in Edit > Preferences > Add-ons. It is also a module:

>>> import bpy, multum.blender_lobes
>>> multum.blender_lobes.add_lobes(bpy.context.object, "rock.ndf.exr")
>>> multum.blender_lobes.add_textures(bpy.context.object, "rock/")

Each lobe becomes a copy of the material's Principled BSDF, whose roughness is widened by the lobe. The copies are mixed
by the amplitudes of the lobes. Textures need only one copy. Each point of the surface mixes two mip levels, which
depend on the distance from the camera: their texels are about as large as the part of the pixel that one of the scene's
samples covers.
"""
import math
import pathlib
import subprocess

import bpy
import numpy as np
from bpy_extras.io_utils import ExportHelper, ImportHelper
from multum import reader

bl_info = {"name": "multum lobes", "author": "multum", "version": (0, 1, 0), "blender": (3, 4, 0),
           "location": "File > Import, File > Export", "category": "Material",
           "description": "Draws baked lobes with Cycles, and exports materials with multum"}

# A lobe widens GGX to alpha^2 = alpha_0^2 + SPREAD_FACTOR lambda, as in the closed form of kernels/one_lobe.cl. lambda
# is the variance of a lobe's normals per tangent axis, |r| / kappa for a vMF lobe. With Banerjee's kappa = (3 |r| -
# |r|^3) / (1 - |r|^2), lambda = (1 - |r|^2) / (3 - |r|^2). A mixture of GGX and Beckmann fits the density of facets
# better, but was tried and made pictures too bright, because each BSDF computes masking and cosines at the mean normal.
SPREAD_FACTOR = 1.75
COSINE_MIN = 0.05  # limits the stretch of pixels near the horizon
MARK = "multum"  # custom property of every node that the add-on made


class Nodes:
    """Adds nodes to a material. Each input is a constant or a socket of another node; None keeps the default."""

    def __init__(self, tree):
        self.tree = tree

    def add(self, kind, *inputs, **properties):
        node = self.tree.nodes.new(kind)
        node[MARK] = True
        for name, value in properties.items():
            setattr(node, name, value)
        for socket, value in zip(node.inputs, inputs):
            self.put(value, socket)
        return node

    def put(self, value, socket):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif value is not None:
            socket.default_value = value

    def math(self, operation, *inputs, clamp=False):
        return self.add("ShaderNodeMath", *inputs, operation=operation, use_clamp=clamp).outputs[0]

    def vector(self, operation, *inputs):
        node = self.add("ShaderNodeVectorMath", *inputs, operation=operation)
        return node.outputs["Value" if operation in ("DOT_PRODUCT", "LENGTH") else "Vector"]


def texels_per_unit(thing, size):
    """Returns the number of texels per unit of length in the scene, averaged over the faces of the object."""
    mesh, uvs = thing.data, thing.data.uv_layers.active.data
    mesh.calc_loop_triangles()
    area_on_map = area = 0.0
    for triangle in mesh.loop_triangles:
        a, b, c = (uvs[i].uv for i in triangle.loops)
        area_on_map += abs((b - a).cross(c - a)) * size[0] * size[1]
        a, b, c = (thing.matrix_world @ mesh.vertices[i].co for i in triangle.vertices)
        area += (b - a).cross(c - a).length
    return math.sqrt(area_on_map / area)


def pixel_size(scene):
    """Returns the width of a pixel at distance 1, and whether this width grows with the distance."""
    camera, render = scene.camera.data, scene.render
    corners = camera.view_frame(scene=scene)
    width = (corners[0] - corners[3]).length / (render.resolution_x * render.resolution_percentage / 100)
    return (width, False) if camera.type == "ORTHO" else (width / -corners[0].z, True)


def camera_distance(scene, thing):
    """Returns the distance from the camera to the object's bounding box in the scene."""
    corners = np.array([thing.matrix_world @ type(scene.cursor.location)(corner) for corner in thing.bound_box])
    eye = np.array(scene.camera.matrix_world.translation)
    return float(np.linalg.norm(eye - np.clip(eye, corners.min(axis=0), corners.max(axis=0))))


def level_of(nodes, texels, grows):
    """Adds nodes that compute the level whose texels are as large as a pixel, or a part of a pixel. `texels` is the
    number of texels per pixel, at distance 1 if it `grows` with the distance."""
    geometry = nodes.add("ShaderNodeNewGeometry").outputs
    cosine = nodes.math("ABSOLUTE", nodes.vector("DOT_PRODUCT", geometry["Incoming"], geometry["True Normal"]))
    if grows:
        texels = nodes.math("MULTIPLY", nodes.add("ShaderNodeCameraData").outputs["View Distance"], texels)
    texels = nodes.math("DIVIDE", texels, nodes.math("SQRT", nodes.math("MAXIMUM", cosine, COSINE_MIN)))
    return nodes.math("LOGARITHM", texels, 2.0)


def lobe_image(name, amplitude, mean):
    """Stores (a r, a), which Cycles may filter. Blender's first row is the bottom row."""
    height, width = amplitude.shape
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True, is_data=True)
    image.alpha_mode = "CHANNEL_PACKED"
    texels = np.dstack([mean * amplitude[..., None], amplitude])[::-1]
    image.pixels.foreach_set(np.ascontiguousarray(texels, dtype=np.float32).ravel())
    image.pack()
    return image


def shares_of(nodes, level, levels):
    """Adds nodes that compute the share of each level, and yields the level's number and the socket of its share."""
    level = nodes.math("MINIMUM", nodes.math("MAXIMUM", level, float(levels[0])), float(levels[-1]))
    for number in levels:
        away = nodes.math("ABSOLUTE", nodes.math("SUBTRACT", level, float(number)))
        yield number, nodes.math("SUBTRACT", 1.0, away, clamp=True)


def filtered_lobes(nodes, path, level, levels):
    """Adds nodes that filter the lobes, and returns sockets of (a r, a) per lobe."""
    lobes = []
    for number, share in shares_of(nodes, level, levels):
        amplitudes, means, _, _ = reader.read_lobes(str(path), number)
        lobes = lobes or [((0.0, 0.0, 0.0), 0.0)] * len(amplitudes)
        for j, (vector, amplitude) in enumerate(lobes):
            image = lobe_image(f"{path.name} level {number} lobe {j}", amplitudes[j], means[j])
            texel = nodes.add("ShaderNodeTexImage", image=image, interpolation="Linear").outputs
            lobes[j] = (nodes.vector("MULTIPLY_ADD", texel["Color"], share, vector),
                        nodes.math("MULTIPLY_ADD", texel["Alpha"], share, amplitude))
    return lobes


def filtered_texture(nodes, files, level, levels):
    """Adds nodes that filter one texture, whose levels are the files, and returns the socket of its colour."""
    colour = (0.0, 0.0, 0.0)
    for number, share in shares_of(nodes, level, levels):
        image = bpy.data.images.load(str(files[number]), check_existing=True)
        image.colorspace_settings.name = "Non-Color"
        texel = nodes.add("ShaderNodeTexImage", image=image, interpolation="Linear").outputs["Color"]
        colour = nodes.vector("MULTIPLY_ADD", texel, share, colour)
    return colour


def inputs_of(surface):
    """Returns the constants and sockets that a Principled BSDF uses, by name."""
    return {i.name: i.links[0].from_socket if i.is_linked else None if i.hide_value else i.default_value
            for i in surface.inputs}


def surface_like(nodes, surface, inputs):
    """Copies the Principled BSDF `surface` with other inputs, and returns the socket of its shader."""
    copy = nodes.add("ShaderNodeBsdfPrincipled", distribution=surface.distribution)
    for name, value in inputs.items():
        nodes.put(value, copy.inputs[name])
    return copy.outputs[0]


def lobe_surface(nodes, surface, vector, amplitude):
    """Copies the Principled BSDF `surface` for one lobe."""
    length = nodes.math("DIVIDE", nodes.vector("LENGTH", vector), nodes.math("MAXIMUM", amplitude, 1e-6))
    square = nodes.math("MINIMUM", nodes.math("MULTIPLY", length, length), 1.0)
    variance = nodes.math("DIVIDE", nodes.math("SUBTRACT", 1.0, square), nodes.math("SUBTRACT", 3.0, square))
    inputs = inputs_of(surface)
    alpha_square = nodes.math("MULTIPLY_ADD", variance, SPREAD_FACTOR, nodes.math("POWER", inputs["Roughness"], 4.0))
    inputs["Roughness"] = nodes.math("POWER", alpha_square, 0.25, clamp=True)
    half = (0.5, 0.5, 0.5)
    coded = nodes.vector("MULTIPLY_ADD", nodes.vector("NORMALIZE", vector), half, half)
    inputs["Normal"] = nodes.add("ShaderNodeNormalMap", None, coded).outputs["Normal"]
    return surface_like(nodes, surface, inputs)


def take_out_nodes(tree):
    """Removes the nodes of an earlier call, and returns the material's Principled BSDF, or None."""
    marked = [node for node in tree.nodes if node.get(MARK)]
    targets = [link.to_socket for link in tree.links if link.from_node.get(MARK) and not link.to_node.get(MARK)]
    surface = next((node for node in tree.nodes if node.type == "BSDF_PRINCIPLED" and not node.get(MARK) and
                    (targets or node.outputs[0].is_linked)), None)
    if surface is not None:
        for target in targets:
            tree.links.new(surface.outputs[0], target)
    for node in marked:
        image = getattr(node, "image", None)
        tree.nodes.remove(node)
        if image is not None and image.users == 0:
            bpy.data.images.remove(image)
    return surface


class Target:
    """The material that a call changes, and the levels that the scene needs."""

    def __init__(self, thing, name, scene):
        if scene.camera is None or thing.type != "MESH" or not thing.data.uv_layers:
            raise ValueError(f"{thing.name}: expected a mesh with a UV map, and a camera in the scene")
        self.thing, self.scene, self.material = thing, scene, thing.active_material
        if self.material is None or not self.material.use_nodes:
            self.material = thing.active_material = bpy.data.materials.new(name)
            self.material.use_nodes = True  # makes a Principled BSDF
        self.surface = take_out_nodes(self.material.node_tree)
        if self.surface is None:
            raise ValueError(f"{self.material.name}: expected a Principled BSDF that is linked to an output")
        self.nodes = Nodes(self.material.node_tree)

    def levels(self, size, first_level, nearest):
        """Adds nodes that compute the level of a point. Returns the socket of the level, and the levels to load."""
        pixel, grows = pixel_size(self.scene)
        # Each of n samples stands for 1 / n of the pixel's area.
        texels = pixel * texels_per_unit(self.thing, size) / math.sqrt(max(self.scene.cycles.samples, 1))
        nearest = camera_distance(self.scene, self.thing) if nearest is None else nearest
        last = int(math.log2(max(size)))
        finest = math.floor(math.log2(max(texels * nearest if grows else texels, 1e-6)))
        return level_of(self.nodes, texels, grows), range(min(max(first_level, finest), last), last + 1)

    def show(self, shader):
        for link in list(self.surface.outputs[0].links):
            self.nodes.put(shader, link.to_socket)
        return self.material


def add_lobes(thing, path, scene=None, nearest=None):
    """Adds the lobes of a baked file to the active material of an object, or replaces the lobes of an earlier call.
    Returns the material. Levels that are finer than a pixel at the distance `nearest` are not loaded. By default,
    `nearest` is the present distance of the camera."""
    path, scene = pathlib.Path(path), scene or bpy.context.scene
    file = reader.oiio.ImageInput.open(str(path))
    if file is None:
        raise ValueError(f"cannot read {path}: {reader.oiio.geterror()}")
    spec = file.spec()
    if spec.get("multum:representation") != "movmf":
        raise ValueError(f"{path}: found {spec.get('multum:representation', 'no baked map')}, expected lobes. Bake the "
                         "map with multum bake --ndf vmf")
    target = Target(thing, path.name, scene)
    nodes, shader, total = target.nodes, None, 0.0
    size = (spec["multum:mapWidth"], spec["multum:mapHeight"])
    for vector, amplitude in filtered_lobes(nodes, path, *target.levels(size, spec["multum:firstLevel"], nearest)):
        lobe, total = lobe_surface(nodes, target.surface, vector, amplitude), nodes.math("ADD", amplitude, total)
        share = nodes.math("DIVIDE", amplitude, nodes.math("MAXIMUM", total, 1e-6))
        shader = lobe if shader is None else nodes.add("ShaderNodeMixShader", share, shader, lobe).outputs[0]
    return target.show(shader)


def add_textures(thing, folder, scene=None, nearest=None):
    """Adds the normals and the roughness of `multum export --for blender -o FOLDER` to the active material of an
    object, with their levels, or replaces what an earlier call added. See add_lobes()."""
    folder = pathlib.Path(folder)
    files = {role: sorted(folder.glob(f"{role}_[0-9][0-9].png")) for role in ("normal", "roughness")}
    if not files["normal"] or len(files["normal"]) != len(files["roughness"]):
        raise ValueError(f"{folder}: found {len(files['normal'])} levels of normals and {len(files['roughness'])} of "
                         "roughness, expected the output of multum export --for blender")
    target = Target(thing, folder.name, scene or bpy.context.scene)
    size = tuple(bpy.data.images.load(str(files["normal"][0]), check_existing=True).size)
    level, levels = target.levels(size, 0, nearest)
    inputs = inputs_of(target.surface)
    normal = filtered_texture(target.nodes, files["normal"], level, levels)
    inputs["Normal"] = target.nodes.add("ShaderNodeNormalMap", None, normal).outputs["Normal"]
    inputs["Roughness"] = filtered_texture(target.nodes, files["roughness"], level, levels)
    return target.show(surface_like(target.nodes, target.surface, inputs))


# The extension of the textures per engine. For Blender, multum writes a folder of PNG files.
ENGINES = {"three": ".ktx2", "babylon": ".ktx2", "playcanvas": ".ktx2", "filament": ".ktx2", "unreal": ".dds",
           "unity": ".dds", "unity-hdrp": ".dds", "godot": ".dds", "o3de": ".dds", "blender": ""}


def normal_map_file(material):
    """Returns the file of a material's normal map, and the roughness of the Principled BSDF that uses it."""
    for node in material.node_tree.nodes if material and material.use_nodes else ():
        step = node
        for name in ("Normal", "Color"):
            socket = step.inputs.get(name)
            step = socket.links[0].from_node if socket is not None and socket.is_linked else None
            if step is None:
                break
        if node.type == "BSDF_PRINCIPLED" and step is not None and step.type == "TEX_IMAGE" and step.image:
            return bpy.path.abspath(step.image.filepath), node.inputs["Roughness"].default_value
    raise ValueError("expected a Principled BSDF whose Normal is a Normal Map node with an image file")


def export_material(material, path, engine, program="multum"):
    """Writes the textures of a material with fitted mip levels, in the form that multum chooses for the engine."""
    normals, roughness = normal_map_file(material)
    output = str(pathlib.Path(path).with_suffix(ENGINES[engine]))
    command = [program, "export", normals, "-o", output, "--green", "up", "--base-roughness", f"{roughness:.6g}",
               "--form", "auto", "--for", engine, "--force"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise ValueError(run.stderr.strip())
    return output


class ImportOperator(ImportHelper):
    """Draws the active object with a file that the user chooses."""
    bl_options = {"REGISTER", "UNDO"}
    nearest: bpy.props.FloatProperty(name="Nearest view", default=-1.0, min=-1.0,
                                     description="Smallest distance of the camera; -1: the distance now")

    def execute(self, context):
        try:
            self.draw_with(pathlib.Path(self.filepath), context.object, context.scene,
                           None if self.nearest < 0 else self.nearest)
        except (ValueError, RuntimeError, AssertionError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class ImportLobes(bpy.types.Operator, ImportOperator):
    """Draw the active object with the lobes of a baked file"""
    bl_idname, bl_label = "multum.import_lobes", "multum lobes (.ndf.exr)"
    filter_glob: bpy.props.StringProperty(default="*.ndf.exr", options={"HIDDEN"})

    def draw_with(self, path, thing, scene, nearest):
        add_lobes(thing, str(path), scene, nearest)


class ImportTextures(bpy.types.Operator, ImportOperator):
    """Draw the active object with the textures of multum export --for blender; choose any file of their folder"""
    bl_idname, bl_label = "multum.import_textures", "multum textures (folder)"
    filter_glob: bpy.props.StringProperty(default="*.png", options={"HIDDEN"})

    def draw_with(self, path, thing, scene, nearest):
        add_textures(thing, path if path.is_dir() else path.parent, scene, nearest)


class ExportMaterial(bpy.types.Operator, ExportHelper):
    """Export the normal map and roughness of the active material to an engine"""
    bl_idname, bl_label, filename_ext = "multum.export_material", "Material for an engine (multum)", ""
    engine: bpy.props.EnumProperty(name="Engine", items=[(name, name, "") for name in ENGINES])
    program: bpy.props.StringProperty(name="Program", default="multum", description="Path of the program multum")

    def execute(self, context):
        try:
            path = export_material(context.object.active_material, self.filepath, self.engine, self.program)
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, path)
        return {"FINISHED"}


def import_entry(menu, _context):
    menu.layout.operator(ImportLobes.bl_idname)
    menu.layout.operator(ImportTextures.bl_idname)


def export_entry(menu, _context):
    menu.layout.operator(ExportMaterial.bl_idname)


def register():
    for kind in (ImportLobes, ImportTextures, ExportMaterial):
        bpy.utils.register_class(kind)
    bpy.types.TOPBAR_MT_file_import.append(import_entry)
    bpy.types.TOPBAR_MT_file_export.append(export_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(export_entry)
    bpy.types.TOPBAR_MT_file_import.remove(import_entry)
    for kind in (ExportMaterial, ImportTextures, ImportLobes):
        bpy.utils.unregister_class(kind)
