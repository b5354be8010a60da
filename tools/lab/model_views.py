# SPDX-License-Identifier: Apache-2.0
"""Draws models with three.js in Chromium from near and far, for docs/evidence/GLTF_EXAMPLE.md and
docs/evidence/GLTF_MODELS.md."""
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODULES = ROOT / "tests" / "service" / "web" / "node_modules"
DISTANCES = (1, 5, 25, 50)  # metres
VIEW = {"direction": [0.3, 0.1, 1.0], "angle": 45, "width": 200, "height": 250, "samples": 12, "frames": 1, "edges": 4,
        "light": [1.0, 1.0, 0.6], "intensity": 3.0, "room": 0.3}


def fail(what):
    sys.exit(f"{os.path.basename(sys.argv[0])}: {what}")


def run(*arguments):
    """Returns the output of a program. Ends this program if the other one fails."""
    done = subprocess.run([str(one) for one in arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        fail(f"{arguments[0]} failed: {done.stderr or done.stdout}")
    return done.stdout


def files_of(model):
    """Lists the model and the files to which it refers, as paths from the model's folder."""
    text = json.loads(model.read_text(encoding="utf-8")) if model.suffix == ".gltf" else {}
    names = [one["uri"] for kind in ("buffers", "images") for one in text.get(kind, []) if "uri" in one]
    return [model.name] + [urllib.parse.unquote(name) for name in names if not name.startswith("data:")]


def link_model(model, folder):
    """Links the model and the files to which it refers into `folder`, under the model's name."""
    for name in files_of(model):
        link = folder / name
        link.parent.mkdir(parents=True, exist_ok=True)
        link.unlink(missing_ok=True)
        link.symlink_to((model.parent / name).resolve())


def digest(model):
    """Returns 16 digits of the SHA-256 of this file."""
    return hashlib.sha256(model.read_bytes()).hexdigest()[:16]


def dress(multum, model, out, report, *options):
    """Writes the converted model, with UASTC."""
    run(multum, "gltf", model, *options, "-o", out, "--encoder", MODULES, "--report", report)


def draw(package, plan, folder):
    """Runs model_pictures.mjs on `plan`, whose files are in `folder`, and returns its report. Pictures go to
    `folder`."""
    (folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    drawn = json.loads(run("node", ROOT / "tests/three/model_pictures.mjs", package, folder / "plan.json", folder))
    if drawn["complaints"]:
        fail(f"three.js complains: {drawn['complaints']}")
    return drawn["views"]


def megabytes(count):
    return f"{count / 1e6:.2f} MB"


def counted(number, noun):
    return f"{number} {noun}{'' if number == 1 else 's'}"


def byte_text(report):
    texts = []
    for kind, name in (("normal", "Fitted normals need"), ("metallic_roughness", "fitted roughness and metalness need"),
                       ("lobes", "and lobes need")):
        texts.append(f"{name} {megabytes(sum(one['bytes'].get(kind, 0) for one in report['textures']))}")
    fitted = sum(one["fitted"] for one in report["materials"])
    before, after = (megabytes(report[key]) for key in ("bytes_before", "bytes_after"))
    return (f"The size of the model file is {before} before the conversion and {after} after it. "
            f"The conversion fitted {fitted} of {counted(len(report['materials']), 'material')}, with "
            f"{counted(len(report['textures']), 'texture set')}. {', '.join(texts)}.")
