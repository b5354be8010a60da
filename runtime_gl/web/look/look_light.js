// SPDX-License-Identifier: Apache-2.0
// Makes the light of the page: a sun, and around it a procedural sky, a studio, or nothing. As in an engine, a
// highlight reads the environment from levels that are convolved with GGX (Karis 2013, "Real Shading in Unreal Engine
// 4"), and diffuse light comes from harmonics (Ramamoorthi and Hanrahan 2001). A lobe counts as a normal whose GGX is
// wider. World axes: z is up.
const SKY_SIZE = [512, 256]; // texels of the finest level, in longitude and latitude
const SKY_LEVELS = 7; // level k has the perceptual roughness k / 6
const SHARES_SIDE = 32;
const SKY_SAMPLES = (level) => Math.min(1024, 64 * 4 ** (level - 1)); // directions per texel of a convolved level

const smoothStep = (low, high, x) => { const t = Math.min(1, Math.max(0, (x - low) / (high - low)));
  return t * t * (3 - 2 * t); };
const mixed3 = (a, b, t) => a.map((one, c) => one + t * (b[c] - one));

/** Returns smooth noise of three numbers, in 0..1. */
function valueNoise(x, y, z) {
  const hash = (i, j, k) => {
    let n = Math.imul(i, 374761393) + Math.imul(j, 668265263) + Math.imul(k, 2147483647);
    n = Math.imul(n ^ (n >>> 13), 1274126177);
    return ((n ^ (n >>> 16)) >>> 0) / 4294967296;
  };
  const cell = [x, y, z].map(Math.floor), [u, v, w] = [x, y, z].map((one, i) => smoothStep(0, 1, one - cell[i]));
  let sum = 0;
  for (let k = 0; k < 8; ++k) {
    const [a, b, c] = [k & 1, (k >> 1) & 1, k >> 2];
    sum += (a ? u : 1 - u) * (b ? v : 1 - v) * (c ? w : 1 - w) * hash(cell[0] + a, cell[1] + b, cell[2] + c);
  }
  return sum;
}

/** Returns the radiance of a bright day from the unit direction d: clouds, haze at the horizon, and warm ground. */
function skyRadiance(d) {
  const haze = [0.95, 0.97, 1.0], zenith = [0.16, 0.36, 0.86];
  if (d[2] < 0) return mixed3([0.62, 0.6, 0.56], [0.2, 0.165, 0.13], smoothStep(0, 0.12, -d[2]));
  const clear = mixed3(haze, zenith, d[2] ** 0.45);
  const reach = 1 / (d[2] + 0.18); // the clouds are a layer above
  let thick = 0;
  for (let octave = 0; octave < 5; ++octave) {
    const scale = 1.3 * 2 ** octave;
    thick += 0.5 ** octave * valueNoise(scale * d[0] * reach, scale * d[1] * reach, 17 * octave);
  }
  const cloud = smoothStep(0.95, 1.35, thick) * smoothStep(0.02, 0.2, d[2]);
  return mixed3(clear, mixed3([1.9, 1.88, 1.85], [0.85, 0.88, 0.93], smoothStep(1.1, 1.6, thick)), 0.85 * cloud);
}

/** Returns the radiance of a dark room with three soft boxes and a light floor. */
function studioRadiance(d) {
  const boxes = [ // direction, across, half sizes as tangents, radiance
    [[-0.6, -0.45, 0.66], [0.6, -0.8, 0], [0.5, 0.32], [9, 8.8, 8.4]],
    [[0.92, -0.2, 0.33], [0.21, 0.98, 0], [0.16, 0.75], [5, 5.4, 6]],
    [[0.05, 0.75, 0.66], [1, 0, 0], [1.1, 0.12], [6.5, 6.3, 6]],
  ];
  let light = d[2] < 0 ? mixed3([0.12, 0.12, 0.13], [0.05, 0.05, 0.055], smoothStep(0, 0.5, -d[2]))
    : mixed3([0.16, 0.165, 0.18], [0.03, 0.03, 0.035], smoothStep(0, 0.7, d[2]));
  for (const [towards, across, [wide, high], radiance] of boxes) {
    const unit = (a) => a.map((one) => one / Math.hypot(...a));
    const n = unit(towards), x = unit(across.map((one, c) => one - dot(across, n) * n[c]));
    const y = [n[1] * x[2] - n[2] * x[1], n[2] * x[0] - n[0] * x[2], n[0] * x[1] - n[1] * x[0]];
    const ahead = dot(d, n);
    if (ahead <= 0.05) continue;
    const edge = (at, half) => 1 - smoothStep(half - 0.04, half + 0.04, Math.abs(at) / ahead);
    light = mixed3(light, radiance, edge(dot(d, x), wide) * edge(dot(d, y), high));
  }
  return light;
}

/** By name: what the list shows, radiance(d) or null, and the irradiance of the light that the pointer moves. */
const ENVIRONMENTS = {
  sky: { text: "sky and sun", radiance: skyRadiance, sun: [2.9, 2.75, 2.5] },
  studio: { text: "studio", radiance: studioRadiance, sun: [0, 0, 0] },
  sun: { text: "sun only", radiance: null, sun: [Math.PI, Math.PI, Math.PI] },
};

/** Returns the unit direction of a place in the map: s, t in 0..1, t from straight up to straight down. */
function skyDirection(s, t) {
  const phi = 2 * Math.PI * (s - 0.5), theta = Math.PI * t;
  return [Math.sin(theta) * Math.sin(phi), Math.sin(theta) * Math.cos(phi), Math.cos(theta)];
}

/** Returns the real harmonics up to l = 2 of a unit direction. */
const harmonicsOf = ([x, y, z]) => [0.282095, 0.488603 * y, 0.488603 * z, 0.488603 * x, 1.092548 * x * y,
  1.092548 * y * z, 0.315392 * (3 * z * z - 1), 1.092548 * x * z, 0.546274 * (x * x - y * y)];

/**
 * Returns `texels`, RGBA of the finest level, and `harmonics`: per coefficient three numbers whose sum, weighted with
 * the harmonics of a normal, is the irradiance.
 */
function makeSky(radiance) {
  const [width, height] = SKY_SIZE;
  const texels = new Float32Array(4 * width * height), harmonics = new Float32Array(27);
  const cosine = [Math.PI, 2 * Math.PI / 3, 2 * Math.PI / 3, 2 * Math.PI / 3, ...Array(5).fill(Math.PI / 4)];
  for (let row = 0; row < height; ++row) {
    const t = (row + 0.5) / height, area = 2 * Math.PI / width * Math.PI / height * Math.sin(Math.PI * t);
    for (let column = 0; column < width; ++column) {
      const d = skyDirection((column + 0.5) / width, t), light = radiance(d);
      texels.set([...light, 1], 4 * (row * width + column));
      harmonicsOf(d).forEach((one, i) => light.forEach((value, c) => {
        harmonics[3 * i + c] += cosine[i] * area * one * value;
      }));
    }
  }
  return { texels, harmonics };
}

/**
 * Returns the parts (x, y, 0, 1) of the light of a white environment that GGX reflects, f0 x + y, for n.v = 0..1 along
 * rows and roughness = 0..1 along columns. Half vectors are drawn from GGX.
 */
function sharesTexels() {
  const texels = new Float32Array(4 * SHARES_SIDE ** 2), count = 256;
  for (let row = 0; row < SHARES_SIDE; ++row)
    for (let column = 0; column < SHARES_SIDE; ++column) {
      const n_v = Math.max(column / (SHARES_SIDE - 1), 1e-3), a2 = Math.max((row / (SHARES_SIDE - 1)) ** 4, 1e-6);
      const v = [Math.sqrt(1 - n_v * n_v), n_v], sum = [0, 0];
      for (let i = 0; i < count; ++i) {
        const u = (i + 0.5) / count, turn = 2 * Math.PI * ((0.6180339887 * i) % 1);
        const n_h = Math.sqrt((1 - u) / (1 + (a2 - 1) * u)), x = Math.sqrt(1 - n_h * n_h) * Math.cos(turn);
        const v_h = x * v[0] + n_h * v[1], n_l = 2 * v_h * n_h - v[1];
        if (n_l <= 0 || v_h <= 0) continue;
        const visibility = 0.5 / (n_l * Math.sqrt(n_v * n_v * (1 - a2) + a2) +
          n_v * Math.sqrt(n_l * n_l * (1 - a2) + a2));
        const share = 4 * visibility * n_l * v_h / n_h / count, fresnel = (1 - v_h) ** 5;
        sum[0] += share * (1 - fresnel);
        sum[1] += share * fresnel;
      }
      texels.set([...sum, 0, 1], 4 * (row * SHARES_SIDE + column));
    }
  return texels;
}

const SKY_PLACES = `
const float SKY_PI = 3.14159265358979;
vec2 look_sky_st(vec3 d) {
  float ahead = d.x == 0.0 && d.y == 0.0 ? 1.0 : d.y;
  return vec2(0.5 + atan(d.x, ahead) / (2.0 * SKY_PI), acos(clamp(d.z, -1.0, 1.0)) / SKY_PI);
}
`;

// Convolves with GGX by half vectors that are drawn from it, with n = v. Samples read a level whose texels are as large
// as the sample's share of the directions (Krivanek and Colbert 2008).
const SKY_FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
${SKY_PLACES}
uniform sampler2D u_source;
uniform float u_alpha;
uniform vec2 u_size;  // texels of this level
uniform int u_count;
out vec4 o_colour;
void main() {
  vec2 st = gl_FragCoord.xy / u_size;
  float phi = 2.0 * SKY_PI * (st.x - 0.5), theta = SKY_PI * st.y;
  vec3 n = vec3(sin(theta) * sin(phi), sin(theta) * cos(phi), cos(theta));
  vec3 x = normalize(abs(n.z) < 0.9 ? cross(n, vec3(0.0, 0.0, 1.0)) : cross(n, vec3(1.0, 0.0, 0.0)));
  vec3 y = cross(n, x);
  float texel = 4.0 * SKY_PI / float(${SKY_SIZE[0] * SKY_SIZE[1]}), a2 = u_alpha * u_alpha;
  vec3 sum = vec3(0.0);
  float total = 0.0;
  for (int i = 0; i < u_count; ++i) {
    float u = (float(i) + 0.5) / float(u_count), turn = 2.0 * SKY_PI * fract(0.6180339887 * float(i));
    float cosine2 = (1.0 - u) / (1.0 + (a2 - 1.0) * u), cosine = sqrt(cosine2), sine = sqrt(1.0 - cosine2);
    vec3 h = sine * cos(turn) * x + sine * sin(turn) * y + cosine * n;
    vec3 l = 2.0 * cosine * h - n;
    float n_l = dot(n, l);
    if (n_l <= 0.0) continue;
    float e = cosine2 * (a2 - 1.0) + 1.0, density = a2 / (SKY_PI * e * e) / 4.0;
    float level = max(0.5 * log2(1.0 / (float(u_count) * density) / texel) + 1.0, 0.0);
    float weight = n_l / (n_l + sqrt(n_l * n_l * (1.0 - a2) + a2));  // Smith's masking and the cosine
    sum += weight * textureLod(u_source, look_sky_st(l), level).rgb;
    total += weight;
  }
  o_colour = vec4(sum / total, 1.0);
}`;

// Goes between the common shaders and a surface, for which it defines multum_environment_lobe(). The amount of
// reflected light follows from the surface's own roughness.
const SKY_SHADING = `${SKY_PLACES}
uniform sampler2D u_sky;
uniform vec3 u_sky_harmonics[9];
mat3 look_frame;
void multum_set_environment_frame(mat3 to_world) { look_frame = to_world; }
vec3 look_sky(vec3 d, float roughness) {
  return textureLod(u_sky, look_sky_st(d), roughness * float(${SKY_LEVELS - 1})).rgb;
}
vec3 look_irradiance(vec3 n, float a1, float a2) {
  vec3 linear = n.y * u_sky_harmonics[1] + n.z * u_sky_harmonics[2] + n.x * u_sky_harmonics[3];
  vec3 quadratic = 1.092548 * (n.x * n.y * u_sky_harmonics[4] + n.y * n.z * u_sky_harmonics[5] +
                               n.x * n.z * u_sky_harmonics[7]) +
                   0.315392 * (3.0 * n.z * n.z - 1.0) * u_sky_harmonics[6] +
                   0.546274 * (n.x * n.x - n.y * n.y) * u_sky_harmonics[8];
  return max(0.282095 * u_sky_harmonics[0] + 0.488603 * a1 * linear + a2 * quadratic, vec3(0.0));
}
uniform sampler2D u_shares;  // sharesTexels()
vec3 look_reflected_share(float roughness, float n_v) {
  vec2 place = (0.5 + vec2(n_v, roughness) * float(${SHARES_SIDE - 1})) / float(${SHARES_SIDE});
  vec4 share = textureLod(u_shares, place, 0.0);
  return multum_f0 * share.x + share.y;
}
// The reflection of normals around mu: d is 1 minus the length of their mean.
MultumReflection look_environment(vec3 mu, float d, vec3 v) {
  float roughness = sqrt(multum_alpha), kappa = max(multum_vmf_kappa(d), 1e-6);
  float wider = sqrt(sqrt(min(multum_alpha * multum_alpha + (d > 0.0 ? 2.0 / kappa : 0.0), 1.0)));
  vec3 share = look_reflected_share(roughness, multum_vmf_mean_cosine(d, dot(mu, v)));
  float r = 1.0 - d, second = d <= 0.0 ? 1.0 : r > 0.1 ? 1.0 - 3.0 * r / kappa : 0.6 * r * r;  // zonal harmonics
  vec3 diffuse = look_irradiance(look_frame * mu, r, second);
  return MultumReflection(diffuse * (1.0 - share), share * look_sky(look_frame * (2.0 * dot(mu, v) * mu - v), wider));
}
MultumReflection multum_environment_lobe(vec4 lobe, vec3 v) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return MultumReflection(vec3(0.0), vec3(0.0));
  MultumReflection one = look_environment(multum_movmf_mean_direction(lobe), multum_movmf_spread(lobe), v);
  return MultumReflection(lobe.w * one.diffuse, lobe.w * one.specular);
}
`;

/** Makes environments as textures, when they are first shown. */
class LookLight {
  constructor(gl, makeProgram) {
    this.gl = gl;
    this.makeProgram = makeProgram; // (vertex, fragment) -> program
    this.made = new Map();
    this.shares = this.emptyLevels(1, [SHARES_SIDE, SHARES_SIDE], gl.CLAMP_TO_EDGE);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, SHARES_SIDE, SHARES_SIDE, gl.RGBA, gl.FLOAT, sharesTexels());
  }

  /** Returns { texture, harmonics } of an environment, or null if it has none. Calls `onMade` if it is new. */
  environment(name, onMade) {
    const { radiance } = ENVIRONMENTS[name];
    if (radiance === null) return null;
    if (!this.made.has(name)) {
      this.made.set(name, this.make(makeSky(radiance)));
      onMade();
    }
    return this.made.get(name);
  }

  emptyLevels(levels, size = SKY_SIZE, wrap = this.gl.REPEAT) {
    const { gl } = this, texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, levels, gl.RGBA16F, ...size);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, levels > 1 ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, wrap);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  }

  make({ texels, harmonics }) {
    const { gl } = this, [width, height] = SKY_SIZE;
    const texture = this.emptyLevels(SKY_LEVELS);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.FLOAT, texels);
    const source = this.emptyLevels(1 + Math.log2(width));
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.FLOAT, texels);
    gl.generateMipmap(gl.TEXTURE_2D);
    const program = this.makeProgram(SCREEN_VERTEX, SKY_FRAGMENT), frame = gl.createFramebuffer();
    gl.useProgram(program);
    const at = (name) => gl.getUniformLocation(program, name);
    gl.uniform1i(at("u_source"), 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    for (let level = 1; level < SKY_LEVELS; ++level) {
      const size = [width >> level, height >> level];
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, level);
      gl.viewport(0, 0, ...size);
      gl.uniform1f(at("u_alpha"), (level / (SKY_LEVELS - 1)) ** 2);
      gl.uniform2f(at("u_size"), ...size);
      gl.uniform1i(at("u_count"), SKY_SAMPLES(level));
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(frame);
    gl.deleteProgram(program);
    gl.deleteTexture(source);
    return { texture, harmonics };
  }
}
