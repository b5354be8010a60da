#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the lobe shading in every language of `multum shaders` with double precision: GLSL ES 300 and HLSL (through
glslang and spirv-cross) run in Chromium's WebGL 2, WGSL runs in Chromium's WebGPU, and the Metal code runs as C++.
tests/gl tests GLSL 330.

    shading_languages_test.py MULTUM MODULES METAL_PROGRAM

MODULES is a folder of npm packages with playwright-core. METAL_PROGRAM is the C++ program around Metal's text."""
import collections
import json
import math
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "docs/how-to/draw_lobes.md"
SIDE = 32
MULTUM, MODULES, METAL_PROGRAM = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(3))

ES_HEAD = "#version 300 es\nprecision highp float;\nprecision highp sampler2D;\n"
ES_MAIN = """
uniform sampler2D table;
uniform sampler2D cases;
layout(location = 0) out vec4 o;
void main() {
  int i = int(gl_FragCoord.y);
  vec4 lobe = texelFetch(cases, ivec2(0, i), 0), l = texelFetch(cases, ivec2(1, i), 0);
  vec4 v = texelFetch(cases, ivec2(2, i), 0), h = texelFetch(cases, ivec2(3, i), 0);
  float cosine = multum_movmf_highlight_cosine(lobe, h.xyz, l.xyz, multum_vmf_kappa(1.0 / (h.w + 2.0)));
  o = vec4(multum_movmf_lambert(lobe, l.xyz), multum_movmf_blinn_phong(lobe, h.xyz, h.w) * cosine,
           multum_movmf_ggx_specular(table, lobe, l.xyz, v.xyz, h.xyz, l.w),
           multum_schlick(vec3(v.w), dot(v.xyz, h.xyz)).x);
}
"""
HLSL_MAIN = """
Texture2D<float4> table : register(t0);
SamplerState table_sampler : register(s0);
Texture2D<float4> cases : register(t1);
float4 main(float4 place : SV_Position) : SV_Target {
  int i = int(place.y);
  float4 lobe = cases.Load(int3(0, i, 0)), l = cases.Load(int3(1, i, 0));
  float4 v = cases.Load(int3(2, i, 0)), h = cases.Load(int3(3, i, 0));
  float cosine = multum_movmf_highlight_cosine(lobe, h.xyz, l.xyz, multum_vmf_kappa(1.0 / (h.w + 2.0)));
  return float4(multum_movmf_lambert(lobe, l.xyz), multum_movmf_blinn_phong(lobe, h.xyz, h.w) * cosine,
                multum_movmf_ggx_specular(table, table_sampler, lobe, l.xyz, v.xyz, h.xyz, l.w),
                multum_schlick(float3(v.w, v.w, v.w), dot(v.xyz, h.xyz)).x);
}
"""
WGSL_MAIN = """
@group(0) @binding(0) var table: texture_2d<f32>;
@group(0) @binding(1) var table_sampler: sampler;
@group(0) @binding(2) var<storage, read> cases: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> results: array<vec4f>;
@compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {
  let lobe = cases[4 * id.x];
  let l = cases[4 * id.x + 1];
  let v = cases[4 * id.x + 2];
  let h = cases[4 * id.x + 3];
  let cosine = multum_movmf_highlight_cosine(lobe, h.xyz, l.xyz, multum_vmf_kappa(1.0 / (h.w + 2.0)));
  results[id.x] = vec4f(multum_movmf_lambert(lobe, l.xyz), multum_movmf_blinn_phong(lobe, h.xyz, h.w) * cosine,
                        multum_movmf_ggx_specular(table, table_sampler, lobe, l.xyz, v.xyz, h.xyz, l.w),
                        multum_schlick(vec3f(v.w), dot(v.xyz, h.xyz)).x);
}
"""


def of_drawn(main, end):
    """Returns a program that computes a normal drawn from the lobe, and one number of blue noise from the table."""
    vec2, result = ("float2", "return float4(") if "float4 main" in main else ("vec2f", "results[id.x] = vec4f(") \
        if "vec4f" in main else ("vec2", "o = vec4(")
    begin = re.search(r"\n[^\n]*cosine = ", main).start()
    sampler = "" if vec2 == "vec2" else "table_sampler, "
    return (f"{main[:begin]}\n  {result}multum_movmf_drawn_normal(lobe, {vec2}(v.w, l.w)), "
            f"multum_blue_noise(table, {sampler}100.0 * l.xy + 200.0, floor(h.w)).y);\n{end}")


# ---- double precision, without the guards that single precision needs


def kappa_of(d):
    a = 1 - d
    x = a * a
    return a * (3 - x + x * (1 - x) * (-0.20753 + x * (-0.12665 + x * (-1.04417 + x * 0.90242)))) / max(d * (2 - d),
                                                                                                        1e-12)


def spread_of(kappa):
    return 1 - kappa / 3 + kappa**3 / 45 if kappa < 0.01 else 1 / kappa - (2 / math.expm1(2 * kappa) if kappa < 300
                                                                           else 0)


def density(kappa, e):
    return kappa / (2 * math.pi * -math.expm1(-2 * kappa)) * math.exp(-kappa * e) if kappa > 1e-9 else 0.25 / math.pi


def mean_cosine(d, t):
    r = 1 - d
    m, v = r * t, d * (0.25 + r * (0.2343 + r * 0.15232))
    x = min(m * m / max(v, 1e-20), 200)
    return 0.5 * (m + math.sqrt(m * m + v * math.exp(-x * (0.4117 + r * (0.2857 - r * 0.3658) + 0.008 * x))))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def highlight_cosine(kappa, facets, mu, h, l):
    total = [facets * x + kappa * y for x, y in zip(h, mu)]
    size = math.sqrt(dot(total, total))
    return mean_cosine(spread_of(size), dot(total, l) / size)


def blinn_phong_over_lobe(d, e, s):
    r, q = 1 - d, d + (1 - d) / (s + 2)
    power = max((1 - 2 * q) / q, 0)
    weight = r * r / (r * r + 1.4 * d * (s + 2))
    cosine = (power + 1) / (2 * math.pi) * (1 - e)**power if e < 1 else 0
    return density(kappa_of(q), e) * (1 - weight) + cosine * weight


def table_at(table, alpha, d):
    s = math.sqrt(alpha * alpha + 2 * d)
    x, y = min(alpha / s, 1) * (SIDE - 1), min(s / math.sqrt(3), 1) * (SIDE - 1)
    i, j = min(int(x), SIDE - 2), min(int(y), SIDE - 2)
    return [sum(table[4 * ((j + b) * SIDE + i + a) + k] * (x - i if a else 1 - x + i) * (y - j if b else 1 - y + j)
                for a in (0, 1) for b in (0, 1)) for k in range(4)]


def ggx_over_lobe(table, alpha, d, e):
    peak, slope, bend, power = table_at(table, alpha, d)  # the value at the peak times 1 / pi, and the power below 0
    square = alpha * alpha + 2 * d
    u = min(max(0.5 + 0.5 * (1 - e) / math.sqrt(4.5 * d / (1.001 - d)), 0), 1)
    y = slope * e * (1 - 0.5 * e * alpha * alpha / square) / square
    return peak / square * u * u * (3 - 2 * u) * (1 + y * (1 + bend * y))**power


def reflecting_cosines(alpha, d, e, mu, h, to):
    """Returns the density of the normals that reflect light, for each direction of `to`."""
    of_lobe, of_facets = d / (1.001 - d), 0.6 * alpha * alpha + 0.1 * e
    total = [of_lobe * x + of_facets * y for x, y in zip(h, mu)]
    both = of_lobe * of_facets
    scale = 1 / (math.sqrt(dot(total, total)) + both)
    cosines = [scale * dot(total, one) for one in to]
    return [0.5 * (m + math.sqrt(m * m + 0.15 * scale * both)) for m in cosines]


def exact(case, table):
    lobe, l, alpha, v, f0, h, s = case[:4], case[4:7], case[7], case[8:11], case[11], case[12:15], case[15]
    amplitude, size = lobe[3], math.sqrt(dot(lobe[:3], lobe[:3]))
    schlick = f0 + (1 - f0) * (1 - dot(v, h))**5
    if amplitude == 0:
        return [0, 0, 0, schlick]
    d, mu = 1 - size / amplitude, [x / size for x in lobe[:3]]
    kappa, e = kappa_of(d), 1 - dot(mu, h)
    n_l, n_v = reflecting_cosines(alpha, d, e, mu, h, (l, v))
    x = alpha * alpha
    smith = 0.5 / (n_l * math.sqrt(n_v * n_v * (1 - x) + x) + n_v * math.sqrt(n_l * n_l * (1 - x) + x))
    return [amplitude * mean_cosine(d, dot(mu, l)),
            amplitude * blinn_phong_over_lobe(d, e, s) * highlight_cosine(kappa, kappa_of(1 / (s + 2)), mu, h, l),
            amplitude * ggx_over_lobe(table, alpha, d, e) * n_l * smith, schlick]


def drawn(case, table):
    lobe, l, alpha, f0, frame = case[:4], case[4:7], case[7], case[11], math.floor(case[15])
    size = math.sqrt(dot(lobe[:3], lobe[:3]))
    mu = [x / size for x in lobe[:3]] if size else [0, 0, 1]
    kappa = kappa_of(1 - size / lobe[3] if size else 0)
    e = -math.log(1 - f0 * -math.expm1(-2 * kappa)) / kappa
    side = math.copysign(1, mu[2])
    a = -1 / (side + mu[2])
    s = [1 + side * mu[0]**2 * a, side * mu[0] * mu[1] * a, -side * mu[0]]
    t = [mu[0] * mu[1] * a, side + mu[1]**2 * a, -mu[1]]
    across, phi = math.sqrt(e * (2 - e)), 2 * math.pi * alpha
    normal = [(1 - e) * m + across * (math.cos(phi) * x + math.sin(phi) * y) for m, x, y in zip(mu, s, t)]
    # Interpolates linearly between the texels of a table that is half as wide as the blue noise.
    x, y = (min(max((math.floor(100 * k + 200) % 64 + 0.5) / 64 * SIDE - 0.5, 0), SIDE - 1) for k in l[:2])
    i, j = min(int(x), SIDE - 2), min(int(y), SIDE - 2)
    texel = sum(table[4 * ((j + q) * SIDE + i + p) + 1] * (x - i if p else 1 - x + i) * (y - j if q else 1 - y + j)
                for p in (0, 1) for q in (0, 1))
    return normal + [(texel * 255 / 256 + frame % 1024 * 0.754877666246693) % 1]


# ---- cases


def single(values):
    return list(struct.unpack(f"{len(values)}f", struct.pack(f"{len(values)}f", *values)))


def unit(generator, tilt):
    theta, phi = tilt * generator.random(), 2 * math.pi * generator.random()
    return [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]


def make_cases(count):
    generator, cases = random.Random(20261126), []
    while len(cases) < count:
        l, v, mu = unit(generator, 1.4), unit(generator, 1.4), unit(generator, 0.8)
        h = [x + y for x, y in zip(l, v)]
        h = [x / math.sqrt(dot(h, h)) for x in h]
        d, amplitude = 10**(-4 * generator.random()), 0.1 + 0.9 * generator.random()
        lobe = [amplitude * (1 - d) * x for x in mu] + [amplitude]
        roughness = 0.1 + 0.9 * generator.random()
        cases.append(single([*lobe, *l, roughness**2, *v, generator.random(), *h, 10**(3 * generator.random())]))
    cases[0][:4] = [0.0] * 4
    return cases


def read_table(path):
    """Returns the 16-bit floats in the only level of a KTX2 file."""
    data = path.read_bytes()
    offset, length = struct.unpack_from("<QQ", data, 80)
    return struct.unpack_from(f"<{length // 2}H", data, offset)


class ShadingLanguagesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        subprocess.run([MULTUM, "shaders", "-o", cls.path, "--quiet"], check=True)
        cls.halves = read_table(cls.path / "ggx_lobe_table.ktx2")
        cls.table = struct.unpack(f"{len(cls.halves)}e", struct.pack(f"{len(cls.halves)}H", *cls.halves))
        cls.cases = make_cases(400)
        cls.exact = [exact(case, cls.table) for case in cls.cases]
        cls.drawn = [drawn(case, cls.table) for case in cls.cases]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def text(self, ending):
        return (self.path / f"multum_lobes.{ending}").read_text()

    def hold(self, name, values):
        """Texture filters may round the position of a lookup to 1/256 of a texel, and single precision loses digits in
        sharp lobes."""
        self.assertEqual(len(values), 4 * len(self.cases), name)
        for k, what in enumerate(("Lambert", "Blinn-Phong", "GGX", "Schlick")):
            scale = max(row[k] for row in self.exact)
            for i, row in enumerate(self.exact):
                self.assertTrue(math.isfinite(values[4 * i + k]), f"{name}: {what}, case {i}: {self.cases[i]}")
                self.assertLess(abs(values[4 * i + k] - row[k]), 5e-3 * row[k] + 1e-6 * scale,
                                f"{name}: {what}, case {i}: {values[4 * i + k]} for {row[k]}: {self.cases[i]}")

    def hold_drawn(self, name, values):
        """Single precision has an error of 3e-3 of the spread for the sharpest lobes, and of 6e-5 for large frame
        numbers."""
        self.assertEqual(len(values), 4 * len(self.cases), name)
        for i, row in enumerate(self.drawn):
            found = values[4 * i:4 * i + 4]
            for value, expected in zip(found[:3], row):
                self.assertLess(abs(value - expected), 2e-3, f"{name}: normal, case {i}: {self.cases[i]}")
            apart = abs(found[3] - row[3])
            self.assertLess(min(apart, 1 - apart), 0.02, f"{name}: noise, case {i}: {self.cases[i]}")

    def in_browser(self, shaders):
        chromium = shutil.which("chromium-headless-shell") or shutil.which("chromium")
        node = shutil.which("node")
        if not chromium or not node or not (MODULES / "playwright-core").exists():
            self.skipTest("no Chromium, node or playwright-core here")
        job = self.path / "job.json"
        flat = [value for case in self.cases for value in case]
        job.write_text(json.dumps({"shaders": shaders, "data": {
            "side": SIDE, "table": self.halves, "count": len(self.cases), "cases": flat}}))
        done = subprocess.run([node, HERE / "run_shaders.mjs", MODULES, chromium, job], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_glsl_es_and_wgsl_run_in_browsers(self):
        es, wgsl = ES_HEAD + self.text("glsl"), self.text("wgsl")
        results = self.in_browser({"GLSL ES 300": {"kind": "es", "source": es + ES_MAIN},
                                   "WGSL": {"kind": "wgsl", "source": wgsl + WGSL_MAIN},
                                   "GLSL ES 300, drawn": {"kind": "es", "source": es + of_drawn(ES_MAIN, "}")},
                                   "WGSL, drawn": {"kind": "wgsl", "source": wgsl + of_drawn(WGSL_MAIN, "}")}})
        for name, values in results.items():
            if isinstance(values, str):
                self.skipTest(f"{name}: {values}")
            hold = self.hold_drawn if "drawn" in name else self.hold
            hold(name, [float(value) for value in values])

    def test_hlsl_runs_translated(self):
        if not shutil.which("glslangValidator") or not shutil.which("spirv-cross"):
            self.skipTest("no glslangValidator or spirv-cross here")
        for main, hold in ((HLSL_MAIN, self.hold), (of_drawn(HLSL_MAIN, "}"), self.hold_drawn)):
            with self.subTest(hold.__name__):
                self.run_hlsl(main, hold)

    def run_hlsl(self, main, hold):
        (self.path / "main.hlsl").write_text(self.text("hlsl") + main)
        done = subprocess.run(["glslangValidator", "-D", "-V", "-e", "main", "-S", "frag", self.path / "main.hlsl",
                               "-o", self.path / "main.spv"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        source = subprocess.run(["spirv-cross", self.path / "main.spv", "--es", "--version", "300"], check=True,
                                capture_output=True, text=True).stdout
        source = source.replace("precision mediump float;", "precision highp float;")
        values = self.in_browser({"HLSL": {"kind": "es", "source": source}})["HLSL"]
        if isinstance(values, str):
            self.skipTest(values)
        hold("HLSL", [float(value) for value in values])

    def instructions(self, body):
        """Returns the SPIR-V instructions of an optimised fragment shader that compute values. A product and the sum
        with its only use count as one instruction, as on GPUs. Some versions of spirv-opt join them, others do not."""
        source = self.path / "counted.frag"
        inputs = ("layout(location = 0) in vec4 lobe; layout(location = 1) in vec3 l; layout(location = 2) in vec3 v;\n"
                  "layout(location = 3) in vec3 h; layout(location = 4) in float alpha;\n"
                  "layout(location = 5) in vec4 other; layout(location = 6) in vec3 f0;\n"
                  "layout(binding = 0) uniform sampler2D table; layout(location = 0) out vec3 o;\n")
        source.write_text(f"#version 450\n{self.text('glsl')}\n{inputs}void main() {{ {body} }}\n")
        for command in (["glslangValidator", "-V", source, "-o", self.path / "counted.spv"],
                        ["spirv-opt", "-O", self.path / "counted.spv", "-o", self.path / "optimised.spv"]):
            subprocess.run(command, check=True, capture_output=True)
        listed = subprocess.run(["spirv-dis", self.path / "optimised.spv"], check=True, capture_output=True,
                                text=True).stdout
        counted = re.findall(r"(%\w+) = (Op(?:F|Dot|ExtInst |Image|Select|Vector|Composite|Convert)\w*)(.*)", listed)
        uses = collections.Counter(re.findall(r"%\w+", listed))
        products = {name for name, kind, _ in counted if kind == "OpFMul" and uses[name] == 2}  # defined and used once
        fused = 0
        for _, kind, rest in counted:
            added = products.intersection(re.findall(r"%\w+", rest))
            if kind in ("OpFAdd", "OpFSub") and added:
                products.remove(min(added))
                fused += 1
        return len(counted) - fused

    def test_lobes_cost_what_the_page_says(self):
        if not all(shutil.which(tool) for tool in ("glslangValidator", "spirv-opt", "spirv-dis")):
            self.skipTest("no glslangValidator or spirv-tools here")
        fresnel = "multum_schlick(f0, max(dot(v, h), 0.0))"
        single = self.instructions("vec3 n = normalize(lobe.xyz); "
                                   "float n_l = max(dot(n, l), 0.0), n_v = max(dot(n, v), 0.0); "
                                   "o = multum_ggx(alpha, multum_one_minus_cosine(n, h)) * n_l * "
                                   f"multum_smith_visibility(alpha, n_l, n_v) * {fresnel};")
        over = [f"multum_movmf_ggx_specular(table, {lobe}, l, v, h, alpha)" for lobe in ("lobe", "other")]
        whole = self.instructions(f"o = {over[0]} * {fresnel};")
        further = self.instructions(f"o = ({over[0]} + {over[1]}) * {fresnel};") - whole
        facets = self.instructions("o = vec3(multum_movmf_ggx(table, lobe, h, alpha));")
        light = self.instructions("o = multum_ggx_lobe_specular(other, lobe.xyz, lobe.w, l, v, h, alpha) * "
                                  f"{fresnel};")
        print(f"instructions: one GGX {single}, over a lobe {whole}, each further {further}, its density {facets}, "
              f"each further light {light}")
        self.assertLessEqual(whole, 2 * single)
        self.assertLess(further, 1.75 * single)
        self.assertLess(light, 1.65 * single)
        self.assertLess(facets, 1.1 * single)

    def page_block(self, language):
        """Returns the page's fragment shader in that language."""
        blocks = re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), re.S)
        return next(block for block in blocks if " main(" in block)

    def page_function(self, begin):
        return re.search(rf"^{re.escape(begin)}\(.*?\n}}\n", PAGE.read_text(), re.S | re.M)[0]

    def test_the_pages_fragments_compile(self):
        blocks = {"frag.glsl": "#version 330\n" + self.text("glsl") + self.page_block("glsl"),
                  "drawn.glsl": "#version 330\n" + self.text("glsl") + self.page_function("vec4 drawn_normal") +
                                "uniform sampler2D noise;\nin vec4 lobe;\nout vec4 normal;\n"
                                "void main() { normal = drawn_normal(noise, vec4[4](lobe, lobe, lobe, lobe), 3.0); "
                                "}\n",
                  "frag.hlsl": self.text("hlsl") + self.page_block("hlsl")}
        if shutil.which("glslangValidator"):
            for name, source in blocks.items():
                (self.path / name).write_text(source)
                options = ["-S", "frag"]
                if name.endswith("hlsl"):
                    options += ["-D", "-V", "-e", "main", "-o", self.path / "page.spv"]
                done = subprocess.run(["glslangValidator", *options, self.path / name], capture_output=True, text=True,
                                      check=False)
                self.assertEqual(done.returncode, 0, done.stdout)
        result = self.in_browser({"page": {"kind": "wgsl-compile", "source": self.text("wgsl") +
                                           self.page_block("wgsl")}})["page"]
        if result != []:
            self.skipTest(result)

    def test_metals_text_runs_as_cpp(self):
        program = self.path / "metal"
        subprocess.run(["c++", "-std=c++17", "-O1", "-Wno-unused-function", f"-I{self.path}", f"-I{HERE}",
                        METAL_PROGRAM, "-o", program], check=True)
        floats = [SIDE, len(self.cases), *self.table, *(value for case in self.cases for value in case)]
        done = subprocess.run([program], input=struct.pack(f"{len(floats)}f", *floats), capture_output=True, check=True)
        values = struct.unpack(f"{len(done.stdout) // 4}f", done.stdout)
        rows = [values[i:i + 8] for i in range(0, len(values), 8)]
        self.hold("Metal", [value for row in rows for value in row[:4]])
        self.hold_drawn("Metal", [value for row in rows for value in row[4:]])

    def test_javascript_module_holds_the_same(self):
        text = self.text("js")
        glsl = json.loads(re.search(r'lobesGlsl = (".*");\n', text)[1])
        self.assertEqual(glsl, self.text("glsl"))
        fetching = re.search(r'lobeTextureGlsl = (".*") \+\n  (".*");\n', text)
        shaders = HERE.parents[1] / "runtime_gl" / "shaders"
        for number, name in enumerate(("common/texture_filter.glsl", "surface/lobes.glsl"), start=1):
            self.assertEqual(json.loads(fetching[number]), (shaders / name).read_text())
        self.assertEqual((self.path / "three" / "multum_lobes.js").read_text(), text)
        numbers = re.search(r"Uint16Array\(\[([\d,]*)\]\)", text)[1]
        self.assertEqual(tuple(map(int, numbers.split(","))), self.halves)

    def test_what_cannot_be_translated_is_refused(self):
        shaders = self.path / "shaders"
        for part in ("common", "brdf"):
            shutil.copytree(HERE.parents[1] / "runtime_gl" / "shaders" / part, shaders / part)
        script = HERE.parents[1] / "tools" / "shading_languages.py"
        with open(shaders / "brdf" / "ggx.glsl", "a", encoding="utf-8") as file:
            file.write("\nuniform float u_new;\n")
        done = subprocess.run([sys.executable, script, shaders, self.path / "out"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("'uniform' cannot be translated", done.stderr)


if __name__ == "__main__":
    unittest.main()
