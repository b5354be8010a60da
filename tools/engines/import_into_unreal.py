# SPDX-License-Identifier: Apache-2.0
"""Imports the DDS files of `multum export --for unreal` into Unreal, and keeps their stored mip levels.

Run it in the Unreal Editor with the plug-in "Python Editor Script Plugin", on the command line of the Output Log:
  py "C:/multum/import_into_unreal.py" C:/textures /Game/Textures

It has not been run in Unreal, because Unreal was not at hand. tests/cli/engines runs it with a
stand-in for Unreal's Python interface.
"""
import os
import struct
import sys

import unreal

NORMALS, PACKED = ("_n", "_normal"), ("_orm", "_mask")
SINGLE = ("_r", "_roughness", "_m", "_metallic", "_ao")
HEAD_BYTES = 148  # "DDS ", a header of 124 bytes, and the DX10 header of 20 bytes
DXGI_RGBA8 = 28


def fault_of(path):
    """Returns why Unreal would not keep all levels of a file, or an empty text."""
    with open(path, "rb") as file:
        head = file.read(HEAD_BYTES)
    if len(head) < HEAD_BYTES or head[:4] != b"DDS " or head[84:88] != b"DX10":
        return "is not a DDS file with a DX10 header; expected a file of multum export"
    height, width = struct.unpack_from("<2I", head, 12)
    levels, = struct.unpack_from("<I", head, 28)
    texels, = struct.unpack_from("<I", head, 128)
    if texels != DXGI_RGBA8:
        return f"has the DXGI format {texels}; expected an export with --texels rgba8, because Unreal rejects blocks"
    if width & (width - 1) or height & (height - 1):
        return f"has {width} x {height} texels; expected powers of 2, because Unreal makes no other mip levels"
    if levels != max(width, height).bit_length():
        return f"has {levels} levels; expected {max(width, height).bit_length()}"
    return ""


def kind_of(path):
    stem = os.path.splitext(os.path.basename(path))[0].lower()
    return next((ends for ends in (NORMALS, PACKED, SINGLE) if stem.endswith(ends)), None)


def set_up(texture, kind):
    """Sets what keeps the stored levels, before anything makes Unreal build levels of its own."""
    compression = unreal.TextureCompressionSettings
    values = {"mip_gen_settings": unreal.TextureMipGenSettings.TMGS_LEAVE_EXISTING_MIPS,
              "srgb": False,
              "flip_green_channel": False,  # multum wrote green down
              "compression_settings": {NORMALS: compression.TC_NORMALMAP, PACKED: compression.TC_MASKS,
                                       SINGLE: compression.TC_GRAYSCALE}[kind],
              # A composite texture would add the spread of normals to the roughness a second time.
              "composite_texture": None}
    if kind is NORMALS:
        values["lod_group"] = unreal.TextureGroup.TEXTUREGROUP_WORLD_NORMAL_MAP
    for name, value in values.items():
        texture.set_editor_property(name, value)


def tasks_of(folder, destination):
    """Returns (task, kind) for each file that Unreal can import, and logs the others."""
    tasks = []
    for name in sorted(os.listdir(folder)):
        path = os.path.join(folder, name).replace("\\", "/")
        if not name.lower().endswith(".dds"):
            continue
        kind, fault = kind_of(path), fault_of(path)
        if not fault and kind is None:
            fault = "has no known end; expected one of " + ", ".join(NORMALS + PACKED + SINGLE)
        if fault:
            unreal.log_error(f"multum: {path}: {fault}")
            continue
        task = unreal.AssetImportTask()
        for key, value in {"filename": path, "destination_path": destination, "automated": True,
                           "replace_existing": True, "save": False}.items():
            task.set_editor_property(key, value)
        tasks.append((task, kind))
    return tasks


def main(folder, destination):
    tasks = tasks_of(folder, destination)
    if not tasks:
        unreal.log_error(f"multum: {folder}: has no DDS file that can be imported")
        return
    unreal.AssetToolsHelpers.get_asset_tools().import_asset_tasks([task for task, _ in tasks])
    for task, kind in tasks:
        paths = task.get_editor_property("imported_object_paths")
        if not paths:
            unreal.log_error(f"multum: {task.get_editor_property('filename')}: was not imported by Unreal")
        for path in paths:
            texture = unreal.load_asset(path)
            set_up(texture, kind)
            unreal.EditorAssetLibrary.save_loaded_asset(texture)
            unreal.log(f"multum: {path}: imported with its stored levels")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        unreal.log_error("multum: expected import_into_unreal.py FOLDER [/Game/DESTINATION]")
    else:
        main(sys.argv[1], sys.argv[2] if len(sys.argv) == 3 else "/Game/Textures")
