# SPDX-License-Identifier: Apache-2.0
"""Stands in for the part of Unreal's Python interface that tools/engines/import_into_unreal.py uses. The names follow
Epic's documentation of the Python API."""
import pathlib

errors, textures = [], {}


def reset():
    errors.clear()
    textures.clear()


class _Names:
    """Gives every constant of an enumeration its own name as value. Only names of the documentation exist."""

    def __init__(self, *names):
        for name in names:
            setattr(self, name, name)


TextureMipGenSettings = _Names("TMGS_LEAVE_EXISTING_MIPS")
TextureCompressionSettings = _Names("TC_NORMALMAP", "TC_MASKS", "TC_GRAYSCALE")
TextureGroup = _Names("TEXTUREGROUP_WORLD_NORMAL_MAP")


class _Object:
    PROPERTIES = ()

    def __init__(self):
        self.values = {}

    def set_editor_property(self, name, value):
        if name not in self.PROPERTIES:
            raise AttributeError(name)
        self.values[name] = value

    def get_editor_property(self, name):
        return self.values[name]


class AssetImportTask(_Object):
    PROPERTIES = ("filename", "destination_path", "automated", "replace_existing", "save", "imported_object_paths")


class Texture2D(_Object):
    PROPERTIES = ("mip_gen_settings", "srgb", "flip_green_channel", "compression_settings", "lod_group",
                  "composite_texture")
    is_saved = False


class AssetToolsHelpers:
    @staticmethod
    def get_asset_tools():
        return AssetToolsHelpers

    @staticmethod
    def import_asset_tasks(tasks):
        for task in tasks:
            path = f"{task.values['destination_path']}/{pathlib.Path(task.values['filename']).stem}"
            textures[path] = Texture2D()
            task.values["imported_object_paths"] = [path]


class EditorAssetLibrary:
    @staticmethod
    def save_loaded_asset(texture):
        texture.is_saved = True


def load_asset(path):
    return textures[path]


def log(_text):
    pass


def log_error(text):
    errors.append(text)
