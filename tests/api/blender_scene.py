# SPDX-License-Identifier: Apache-2.0
"""Draws a plane in Blender for tests/api/blender_test.py. The plane, the camera and the light are those of multum-view.

blender -b --python blender_scene.py -- JOB.json. The job contains the map and the pictures. A picture with `lobes` or
`textures` uses the add-on; with `width`, the normal map scaled by Blender; otherwise, the normal map itself. A job with
`engines` tests the operators.
"""
import json
import math
import sys
import time

import bpy
from mathutils import Vector

with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
    JOB = json.load(file)
sys.path.insert(0, JOB["package"])
from multum import blender_lobes  # noqa: E402


def make_scene(camera):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.seed = "CYCLES", "CPU", 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0
    scene.render.resolution_x = scene.render.resolution_y = JOB["size"]
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    bpy.ops.mesh.primitive_plane_add(size=60, location=(0, 30, 0))
    plane = bpy.context.object
    for corner in plane.data.uv_layers.active.data:
        corner.uv *= 60
    eye, target = Vector(camera[:3]), Vector(camera[3:6])
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.clip_start = 0.001
    scene.camera.location, scene.camera.data.angle = eye, math.radians(camera[6])
    scene.camera.rotation_euler = (target - eye).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle = JOB["irradiance"], 0
    sun.rotation_euler = Vector(JOB["light"]).to_track_quat("Z", "Y").to_euler()
    for thing in (scene.camera, sun):
        scene.collection.objects.link(thing)
    bpy.context.view_layer.update()
    return scene, plane


def normal_map(width):
    image = bpy.data.images.load(JOB["normals"], check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    if width is None:
        return image
    image.pixels[0]  # loads the file; scale() does not
    image.scale(width, width)
    image.file_format, image.filepath_raw = "OPEN_EXR", f"{JOB['folder']}/scaled_{width}.exr"
    image.save()
    image = bpy.data.images.load(image.filepath_raw)
    image.colorspace_settings.name = "Non-Color"
    return image


def metal(width):
    """Returns a metal with the normal map. Blender has no mip levels, so a reduced map is an image of its own."""
    material = bpy.data.materials.new("metal")
    material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    for name, value in {"Base Color": [JOB["f0"]] * 3 + [1], "Metallic": 1, "Roughness": JOB["roughness"]}.items():
        surface.inputs[name].default_value = value
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = normal_map(width), "Linear" if width else "Closest"
    mapping, links = material.node_tree.nodes.new("ShaderNodeNormalMap"), material.node_tree.links
    links.new(texture.outputs["Color"], mapping.inputs["Color"])
    links.new(mapping.outputs["Normal"], surface.inputs["Normal"])
    return material


def draw(picture):
    scene, plane = make_scene(picture["camera"])
    scene.cycles.samples = picture["samples"]
    plane.data.materials.append(metal(picture.get("width")))
    if "lobes" in picture:
        blender_lobes.add_lobes(plane, picture["lobes"])
    if "textures" in picture:
        blender_lobes.add_textures(plane, picture["textures"])
    if "blend" in picture:  # the material must survive in a saved file
        bpy.ops.wm.save_as_mainfile(filepath=picture["blend"])
        bpy.ops.wm.open_mainfile(filepath=picture["blend"])
        scene = bpy.context.scene
    scene.render.filepath = f"{JOB['folder']}/{picture['name']}.exr"
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    print(f"{picture['name']}: {time.perf_counter() - start:.2f} s, {len(bpy.data.images)} images")


def use_operators():
    """Installs the add-on as a user does, and prints what its operators return or refuse."""
    scene, plane = make_scene(JOB["camera"])
    scene.cycles.samples = 16
    plane.data.materials.append(metal(None))
    bpy.ops.preferences.addon_install(filepath=blender_lobes.__file__, overwrite=True)
    bpy.ops.preferences.addon_enable(module="blender_lobes")
    for engine in JOB["engines"]:
        print(engine, bpy.ops.multum.export_material(filepath=f"{JOB['folder']}/{engine}", engine=engine,
                                                     program=JOB["program"]))
    for name in JOB["refused"]:
        try:
            print("imported", bpy.ops.multum.import_lobes(filepath=name))
        except RuntimeError as error:
            print("refused", error)
    for nearest in (-1.0, 0.01):  # the second import replaces the first
        print("import", bpy.ops.multum.import_lobes(filepath=JOB["lobes"], nearest=nearest))
        names = {node.image.name.split(" lobe")[0] for node in plane.active_material.node_tree.nodes
                 if node.type == "TEX_IMAGE" and "lobe" in node.image.name}
        print("levels", sorted(int(name.split()[-1]) for name in names), "of", len(bpy.data.images), "images")
    print("textures", bpy.ops.multum.import_textures(filepath=JOB["textures"]))
    names = [node.image.name for node in plane.active_material.node_tree.nodes
             if node.type == "TEX_IMAGE" and node.get("multum")]
    print("levels of textures", sorted(names))
    scene.camera = None
    try:
        bpy.ops.multum.import_lobes(filepath=JOB["lobes"])
    except RuntimeError as error:
        print("refused", error)
    bpy.ops.preferences.addon_disable(module="blender_lobes")


if "engines" in JOB:
    use_operators()
for each in JOB.get("pictures", []):
    draw(each)
