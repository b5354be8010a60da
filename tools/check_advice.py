#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds shared code whose messages name an option literally. Commands that do not have this option would also print
these messages.

advice() and option_text() of host/foundation/base/messages/option_words.h name options of the command that runs.

    tools/check_advice.py [--root DIR]     # exit code 1, and a line for each message

Refusals of a setting's value (ErrorCode::kUsage) may name the value that was given. Options of other programs, and
options with which a file was made, follow the program's name: "multum bake --ndf vmf", "baked without --roughness".
"""
import argparse
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
SHARED = ("accuracy", "asset", "averages", "bake", "base", "brdf", "export", "gltf", "image", "light", "look",
          "manifest", "mesh", "movmf", "opencl", "pyramid", "sandbox", "scene", "target")
# The sources that only one command uses, each with the command whose options it names, and the sources that run command
# lines.
OF_ONE_COMMAND = {
    "host/bakes/bake/region_bake.cpp": "bake --region", "host/foundation/base/share_record.cpp": "those with --shard",
    "host/delivery/export/export_job.cpp": "export", "host/delivery/export/lobes/lobe_export.cpp": "export --lobes",
    "host/delivery/export/uastc/uastc_encoder.cpp": "export and gltf have --encoder",
    "host/delivery/gltf/gltf_job.cpp": "gltf", "host/delivery/look/look_page.cpp": "look",
    "host/bakes/movmf/map_shard.cpp": "those with --shard",
    "host/bakes/movmf/bake_plan.cpp": "names what the plan was made with",
    "host/bakes/bake/movmf_file_bake.cpp": "names --shard or --merge, which was given",
    "host/bakes/pyramid/reflectance_bake.cpp": "reflectance",
    "host/bakes/settings_search/plane_picture.cpp": "runs multum-view",
    "host/bakes/settings_search/pending_views.cpp": "runs multum-view",
    "host/bakes/settings_search/tradeoff_page.cpp": "shows a command line",
    "host/bakes/settings_search/tradeoff_sweep.cpp": "runs multum-view",
}
LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]+")
NAMED = re.compile(r"(?:multum [a-z]+|oiiotool|maketx|baked with|baked without)(?: [\w:=,.-]+)*? (?=--[a-z])[^;()]*")


def advised(text):
    """Returns the options that a source names literally, each with its line."""
    text = re.sub(r"//[^\n]*", "", text)
    position = 0
    for statement in re.split(r"(;|\{\n|\}\n)", text):
        literals = "".join(LITERAL.findall(statement))
        if "ErrorCode::kUsage" not in statement:
            for found in OPTION.findall(NAMED.sub("", literals)):
                at = position + max(0, statement.find(found))
                yield 1 + text.count("\n", 0, at), found
        position += len(statement)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path, default=ROOT)
    root = parser.parse_args().root
    found = []
    for folder in SHARED:
        for path in sorted((root / "host" / folder).rglob("*.cpp")):
            name = path.relative_to(root).as_posix()
            if name not in OF_ONE_COMMAND:
                found += [f"{name}:{line}: {option}: name it by advice()" for line, option in advised(path.read_text())]
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
