#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Translates the lobe shading from GLSL, with which multum itself draws, into other languages.

    tools/shading_languages.py SHADERS OUT

SHADERS is runtime_gl/shaders. OUT gets multum_lobes with four endings: .glsl (330, and ES 300 after `precision highp
float;`), .hlsl (shader model 4 and later), .metal and .wgsl. The input consists of functions and constants in a small
part of GLSL, which has floats, vectors, one texture lookup, `if`, `for` and `?:`. Anything else stops the translation.
"""
import argparse
import pathlib
import re
import sys

FILES = ("common/movmf_shading.glsl", "common/evaluations.glsl", "common/blue_noise.glsl", "brdf/blinn_phong.glsl",
         "brdf/cook_torrance.glsl", "brdf/ggx.glsl", "brdf/ggx_lobe.glsl")
TYPES = ("float", "int", "vec2", "vec3", "vec4")
HEAD = """// SPDX-License-Identifier: Apache-2.0
// Shading of multum's lobes in {language}.
// Generated from runtime_gl/shaders by tools/shading_languages.py; do not edit.
{note}
"""
TYPE = "|".join(TYPES)


def without_blocks(text):
    """Returns the text without its #ifdef ... #endif sections and without the licence in its first comment."""
    kept, depth = [], 0
    for line in text.splitlines():
        word = line.split()[0] if line.split() else ""
        if word in ("#ifdef", "#ifndef", "#if"):
            depth += 1
        elif word == "#endif":
            depth -= 1
        elif not depth and not line.startswith("// SPDX"):
            kept.append(line)
    return "\n".join(kept).strip() + "\n"


def glsl_source(folder):
    return "\n".join(without_blocks((folder / name).read_text()) for name in FILES)


def by_code(text, change):
    """Applies `change` to everything except comments."""
    parts = re.split(r"(//[^\n]*)", text)
    return "".join(part if part.startswith("//") else change(part) for part in parts)


def renamed(names):
    return lambda code: re.sub(r"\b(" + "|".join(names) + r")\b", lambda m: names[m[1]], code)


def closing(code, opening):
    """Returns the place of the parenthesis that closes the one at `opening`."""
    depth = 0
    for place in range(opening, len(code)):
        depth += {"(": 1, ")": -1}.get(code[place], 0)
        if depth == 0:
            return place
    sys.exit(f"shading_languages: no closing parenthesis: {code[opening:opening + 60]}")


def without_choices(code):
    """Rewrites `c ? a : b` as select(b, a, c), innermost and last first."""
    while "?" in code:
        mark = code.rindex("?")
        begin, depth = mark, 0
        while begin > 0:
            symbol = code[begin - 1]
            depth += {")": 1, "(": -1}.get(symbol, 0)
            if depth < 0 or (depth == 0 and (symbol in ",;" or (symbol == "=" and code[begin - 2] not in "<>=!"
                                                                and code[begin] != "="))):
                break
            if depth == 0 and re.search(r"\breturn\s$", code[:begin]):
                break
            begin -= 1
        end, depth, colon = mark, 0, None
        while True:
            symbol = code[end]
            depth += {"(": 1, ")": -1}.get(symbol, 0)
            if depth < 0 or (depth == 0 and symbol in ",;"):
                break
            if depth == 0 and symbol == ":":
                colon = end
            end += 1
        condition, one, other = code[begin:mark].strip(), code[mark + 1:colon].strip(), code[colon + 1:end].strip()
        lead = " " if code[begin] == " " else ""
        code = f"{code[:begin]}{lead}select({other}, {one}, {condition}){code[end:]}"
    return code


def with_samplers(code, declared, lookup):
    """Gives each texture a sampler of its own, in parameters, in calls, and in texture reads."""
    textures = set(re.findall(r"\bsampler2D (\w+)", code))
    for name in textures:
        pattern = re.compile(rf"\btextureLod\({name}, ")
        while match := pattern.search(code):
            end = closing(code, match.start() + len("textureLod"))
            place, level = code[match.end():end].rsplit(", ", 1)
            code = code[:match.start()] + lookup.format(texture=name, place=place, level=level) + code[end + 1:]
        code = re.sub(rf"(\w+\()({name})(, )(?!{name}_sampler)", rf"\1\2, {name}_sampler\3", code)
        code = re.sub(rf"\bsampler2D {name}\b", declared.format(texture=name), code)
    return code


def hlsl(text):
    names = {"vec2": "float2", "vec3": "float3", "vec4": "float4", "mix": "lerp", "fract": "frac",
             "inversesqrt": "rsqrt"}

    def change(code):
        code = re.sub(r"\bconst float\b", "static const float", code)
        # HLSL has no constructor float3(x) for a single number, so a cast is used instead.
        code = re.sub(r"\bvec([234])\(([^(),]+|\w+\([^()]*\))\)", r"((vec\1)(\2))", code)
        return renamed(names)(code)
    text = with_samplers(text, "Texture2D<float4> {texture}, SamplerState {texture}_sampler",
                         "{texture}.SampleLevel({texture}_sampler, {place}, {level})")
    return by_code(text, change)


def metal(text):
    names = {"vec2": "float2", "vec3": "float3", "vec4": "float4", "inversesqrt": "rsqrt"}

    def change(code):
        code = re.sub(r"^const float\b", "constant float", code, flags=re.M)
        code = re.sub(rf"^({TYPE})(?= \w+\()", r"inline \1", code, flags=re.M)
        code = re.sub(r"(?<![\w.])(\d+\.\d+(?:e-?\d+)?|\d+e-?\d+)(?!\w)", r"\1f", code)
        return renamed(names)(code)
    text = with_samplers(text, "texture2d<float> {texture}, sampler {texture}_sampler",
                         "{texture}.sample({texture}_sampler, {place}, level({level}))")
    return by_code(text, change)


def wgsl(text):
    names = {"float": "f32", "int": "i32", "vec2": "vec2f", "vec3": "vec3f", "vec4": "vec4f", "inversesqrt":
             "inverseSqrt"}

    def function(match):
        result, name, parameters = match.groups()
        listed = ", ".join(re.sub(rf"^({TYPE}) (\w+)$", r"\2: \1", one.strip()) for one in parameters.split(","))
        return f"fn {name}({listed}) -> {result} {{"

    def change(code):
        code = re.sub(r"\bconst float (\w+) =", r"const \1: float =", code)
        code = re.sub(rf"^({TYPE}) (\w+)\(([^)]*)\) {{", function, code, flags=re.M)
        code = re.sub(rf"\bfor \(({TYPE}) (\w+) =([^;]*);([^;]*); \+\+\w+\)", r"for (var \2: \1 =\3;\4; \2++)", code)
        code = re.sub(rf"^(\s+)({TYPE}) (\w+) =", r"\1var \3: \2 =", code, flags=re.M)
        code = re.sub(r"\bif (\([^\n]*\)) (return [^\n;]*;)", r"if \1 { \2 }", code)
        code = without_choices(code)
        return renamed(names)(code)
    text = with_samplers(text, "{texture}: texture_2d<f32>, {texture}_sampler: sampler",
                         "textureSampleLevel({texture}, {texture}_sampler, {place}, {level})")
    return by_code(text, change)


LANGUAGES = {
    "glsl": ("GLSL 330 and ES 300", "// ES 300: `precision highp float;` before it.", lambda text: text),
    "hlsl": ("HLSL", "// Shader model 4 and later.", hlsl),
    "metal": ("the Metal Shading Language", "#include <metal_stdlib>\nusing namespace metal;", metal),
    "wgsl": ("WGSL", "// No part of it needs an extension.", wgsl),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shaders", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    text = glsl_source(arguments.shaders)
    foreign = re.search(r"\b(uniform|struct|inout|out|mat[234]|while|discard)\b", re.sub(r"//[^\n]*", "", text))
    if foreign:
        sys.exit(f"shading_languages: '{foreign[0]}' cannot be translated")
    for ending, (language, note, translate) in LANGUAGES.items():
        head = HEAD.format(language=language, note=note)
        (arguments.out / f"multum_lobes.{ending}").write_text(head + "\n" + translate(text))


if __name__ == "__main__":
    main()
