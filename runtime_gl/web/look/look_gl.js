// SPDX-License-Identifier: Apache-2.0
// Draws a plane, or a model with the map on it, with WebGL 2 and the same shading as multum-view (runtime_gl/shaders),
// plus an environment (look_light.js). It draws lobes, or one normal per texel. Each method is drawn to a texture. The
// screen shows one method to the left and one to the right of a divider, or their difference.
const FILTER = { taps: 4, bias: -0.5 }; // docs/evidence/FILTER.md

const SCREEN_VERTEX = `#version 300 es
void main() {
  gl_Position = vec4(vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0), 0.0, 1.0);
}`;

// The light that the surface at st sends to the eye.
const LOOK_SHADED = `
const float BRIGHTEST = 60000.0;  // floats of 16 bits end at 65504
uniform float u_locked_level;  // level of the surface's texture to show; below -100 if none is chosen
uniform float u_locked_colours;  // level of the colours to show with it
uniform sampler2D u_colours;  // a base colour, as in glTF 2.0
uniform vec3 u_tint;          // multiplies it
uniform float u_metalness;
vec3 look_shaded(vec2 st, mat3 to_world, vec3 position, vec3 v) {
  MultumFootprint footprint = multum_surface_footprint(st), colours = multum_footprint(u_colours, st);
  if (u_locked_level > -100.0) {
    footprint.level = u_locked_level;
    colours.level = u_locked_colours;
  }
  vec3 base = u_tint * multum_filtered(u_colours, st, colours).rgb;
  multum_diffuse = (1.0 - u_metalness) * base;
  multum_f0 = mix(vec3(0.04), base, u_metalness);
  return multum_lights(multum_fetch_surface(st, footprint), to_world, position, v);
}
`;

const RAY = `
uniform mat3 u_rays;  // matrix from a pixel's place (across, up: -1 to 1) and 1 to its ray
uniform vec2 u_size;  // in pixels
vec3 look_ray() { return u_rays * vec3(2.0 * gl_FragCoord.xy / u_size - 1.0, 1.0); }
`;

// multum-view's plane has its map once per unit, with row 0 at y = 60. The plane is drawn by intersecting it with rays,
// because SwiftShader has an error of up to half a pixel for polygons that reach from behind the eye to the horizon.
const LOOK_MAIN = `${RAY}
uniform vec3 u_eye;
layout(location = 0) out vec4 o_colour;
void main() {
  vec3 ray = look_ray();
  float reach = u_eye.z / max(-ray.z, 1e-4);
  vec3 position = vec3((u_eye + reach * ray).xy, 0.0);
  mat3 to_world = mat3(1.0);
  vec3 v = normalize(u_eye - position);
  vec2 st = vec2(position.x + 30.0, 60.0 - position.y);
  vec3 seen = look_shaded(st, to_world, position, v);
  if (ray.z >= 0.0) discard;
  o_colour = vec4(min(seen, vec3(BRIGHTEST)), 1.0);
}`;

const MODEL_VERTEX = `#version 300 es
uniform mat4 u_to_clip;
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec2 a_st;
out vec3 v_position;
out vec3 v_normal;
out vec2 v_st;
void main() {
  v_position = a_position;
  v_normal = a_normal;
  v_st = a_st;
  gl_Position = u_to_clip * vec4(a_position, 1.0);
}`;

// The orthonormal tangent frame comes from the texture coordinates' derivatives (Schueler 2013, "Followup: Normal
// Mapping Without Precomputed Tangents"). +Y of normal maps is the direction in which v shrinks.
const MODEL_MAIN = `
uniform vec3 u_eye;
in vec3 v_position;
in vec3 v_normal;
in vec2 v_st;
layout(location = 0) out vec4 o_colour;
void main() {
  vec3 n = normalize(gl_FrontFacing ? v_normal : -v_normal);
  vec3 across = cross(dFdy(v_position), n), along = cross(n, dFdx(v_position));
  vec2 st_x = dFdx(v_st), st_y = dFdy(v_st);
  vec3 t = across * st_x.x + along * st_y.x, b = -(across * st_x.y + along * st_y.y);
  t = normalize(t - n * dot(n, t) + vec3(1e-20, 0.0, 0.0));
  vec3 up = cross(n, t);
  mat3 to_world = mat3(t, dot(up, b) < 0.0 ? -up : up, n);
  vec3 v = normalize(u_eye - v_position) * to_world;
  o_colour = vec4(min(look_shaded(v_st, to_world, v_position, v), vec3(BRIGHTEST)), 1.0);
}`;

// Draws the environment, slightly out of focus. Its alpha is 0, so that errors leave it out.
const BACKGROUND_FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
${RAY}${SKY_PLACES}
uniform sampler2D u_sky;
out vec4 o_colour;
void main() { o_colour = vec4(textureLod(u_sky, look_sky_st(normalize(look_ray())), 0.7).rgb, 0.0); }`;

// Shades one normal and one roughness per texel, filtered as in an engine.
const ONE_NORMAL = `
uniform sampler2D u_material;
uniform float u_material_alpha;  // multiplies alpha, the square of the texture's roughness
struct MultumSurface { vec3 n; };
MultumFootprint multum_surface_footprint(vec2 st) { return multum_footprint(u_material, st); }
MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint) {
  vec4 texel = multum_filtered(u_material, st, footprint);
  multum_alpha = max(u_material_alpha * texel.w * texel.w, 1e-3);
  return MultumSurface(normalize(2.0 * texel.xyz - 1.0));
}
MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
  float n_l = max(dot(surface.n, l), 0.0), n_v = max(dot(surface.n, v), 0.0);
  float visibility = multum_visibility(n_l, n_v, max(dot(surface.n, h), 0.0), dot(v, h));
  return MultumReflection(vec3(n_l), multum_facets(surface.n, h) * visibility * n_l);
}
#ifdef MULTUM_ENVIRONMENT
MultumReflection multum_reflect_environment(MultumSurface surface, vec3 v) {
  return look_environment(surface.n, 0.0, v);
}
#endif`;

// Copies a picture; the mean of many pictures is made with it.
const COPY_FRAGMENT = `#version 300 es
precision highp float;
uniform highp sampler2D u_picture;
out vec4 o_colour;
void main() { o_colour = texelFetch(u_picture, ivec2(gl_FragCoord.xy), 0); }`;

const SCREEN_FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D u_left, u_right;
uniform float u_split;  // in pixels
uniform float u_exposure;
uniform bool u_difference;
uniform bool u_neutral;
out vec4 o_colour;
// Compresses bright light instead of cutting it off (Khronos PBR Neutral Tone Mapper).
vec3 look_neutral(vec3 colour) {
  const float start = 0.76, keep = 0.15;
  float low = min(colour.r, min(colour.g, colour.b));
  colour -= low < 0.08 ? low - 6.25 * low * low : 0.04;
  float peak = max(colour.r, max(colour.g, colour.b));
  if (peak < start) return colour;
  float seen = 1.0 - (1.0 - start) * (1.0 - start) / (peak + 1.0 - 2.0 * start);
  return mix(colour * seen / peak, vec3(seen), 1.0 - 1.0 / (keep * (peak - seen) + 1.0));
}
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  vec3 left = texelFetch(u_left, place, 0).rgb, right = texelFetch(u_right, place, 0).rgb;
  vec3 radiance = u_difference ? 4.0 * abs(left - right) : gl_FragCoord.x < u_split ? left : right;
  vec3 linear = clamp(u_neutral ? look_neutral(u_exposure * radiance) : u_exposure * radiance, 0.0, 1.0);
  vec3 curved = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  o_colour = vec4(mix(curved, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308))), 1.0);
}`;

class LookGl {
  /**
   * `shaders` has texts by name. `table` has GGX over lobes in 16-bit floats. Throws Error if a feature is missing.
   */
  constructor(canvas, shaders, table) {
    const gl = canvas.getContext("webgl2",
      { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true });
    if (gl === null) throw new Error("this browser has no WebGL 2, or it is switched off");
    if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
      throw new Error("this WebGL 2 cannot draw half floats (EXT_color_buffer_half_float)");
    this.gl = gl;
    this.rgtc = gl.getExtension("EXT_texture_compression_rgtc");
    this.shaders = shaders;
    this.nothing = gl.createVertexArray();
    gl.bindVertexArray(this.nothing);
    this.screen = this.program(SCREEN_VERTEX, SCREEN_FRAGMENT);
    this.background = this.program(SCREEN_VERTEX, BACKGROUND_FRAGMENT);
    this.copy = this.program(SCREEN_VERTEX, COPY_FRAGMENT);
    this.light = new LookLight(gl, (vertex, fragment) => this.program(vertex, fragment));
    this.madeCount = 0; // programs and environments made so far, from which timings see that a frame made some
    this.model = null; // the model drawn in place of the plane: an array of vertices and their count
    this.oneNormal = this.programs(["MULTUM_ROUGHNESS_TEXTURE"], "", ONE_NORMAL);
    this.setColours(null);
    this.ggxTable = this.texture(gl.TEXTURE_2D, gl.RGBA16F, { width: 32, height: 32 }, 1, gl.CLAMP_TO_EDGE, () =>
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 32, 32, gl.RGBA, gl.HALF_FLOAT, table));
    this.materials = new Map(); // { texture, bytes } by method
    this.targets = [];
    this.size = [0, 0];
  }

  /** Returns the programs of a surface. They are compiled when they are first used. */
  programs(flags, brdf, surface) {
    const made = new Map();
    return {
      take: (isModel, hasSky) => {
        const key = `${isModel} ${hasSky}`;
        if (!made.has(key)) ++this.madeCount;
        if (!made.has(key)) made.set(key, this.program(isModel ? MODEL_VERTEX : SCREEN_VERTEX,
          this.fragment(hasSky ? ["MULTUM_ENVIRONMENT", ...flags] : flags, brdf, surface,
            LOOK_SHADED + (isModel ? MODEL_MAIN : LOOK_MAIN))));
        return made.get(key);
      },
      free: () => made.forEach((program) => this.gl.deleteProgram(program)),
    };
  }

  /** `model` is the readModel() of a file, or null for the plane. */
  setModel(model) {
    const { gl } = this;
    if (this.model !== null) {
      gl.deleteVertexArray(this.model.array);
      gl.deleteBuffer(this.model.buffer);
    }
    this.model = null;
    if (model === null) return;
    const array = gl.createVertexArray(), buffer = gl.createBuffer();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, model.vertices, gl.STATIC_DRAW);
    [[3, 0], [3, 12], [2, 24]].forEach(([size, offset], location) => {
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, size, gl.FLOAT, false, 32, offset);
    });
    gl.bindVertexArray(this.nothing);
    this.model = { array, buffer, count: model.count, isClosed: model.isClosed === true };
  }

  fragment(flags, brdf, surface, main) {
    const all = [`MULTUM_TAPS ${FILTER.taps}`, "MULTUM_GGX", "MULTUM_VISIBILITY", "MULTUM_FRESNEL",
      "MULTUM_FRESNEL_DIFFUSE", "MULTUM_COLOURED_PLACES", "MULTUM_DIRECTIONAL_LIGHTS 1", ...flags];
    const sky = flags.includes("MULTUM_ENVIRONMENT") ? SKY_SHADING : "";
    return `#version 300 es\nprecision highp float;\nprecision highp sampler2D;\nprecision highp sampler2DArray;\n` +
      `${all.map((flag) => `#define ${flag}\n`).join("")}${this.shaders.common}${brdf}${sky}${surface}\n` +
      `${this.shaders.lights}${main}`;
  }

  program(vertex, fragment) {
    const { gl } = this;
    if (gl.isContextLost()) return null; // everything is created again when the context is back
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
        throw new Error(`a shader was refused: ${gl.getShaderInfoLog(shader)}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(`shaders were refused: ${gl.getProgramInfoLog(program)}`);
    return program;
  }

  texture(target, format, { width, height, layers = 0 }, levels, wrap, upload) {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(target, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    if (layers > 0) gl.texStorage3D(target, levels, format, width, height, layers);
    else gl.texStorage2D(target, levels, format, width, height);
    gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, levels > 1 ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR);
    gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(target, axis, wrap);
    upload();
    const error = gl.getError();
    if (error !== gl.NO_ERROR && !gl.isContextLost())
      throw new Error(`cannot create a texture of ${width} x ${height} (GL error ${error})`);
    return texture;
  }

  /** Uploads RGBA8 levels of one normal per texel. */
  setMaterial(method, levels) {
    const { gl } = this;
    gl.deleteTexture(this.materials.get(method)?.texture ?? null);
    const texture = this.texture(gl.TEXTURE_2D, gl.RGBA8, levels[0], levels.length, gl.REPEAT, () => levels.forEach(
      (level, l) => gl.texSubImage2D(gl.TEXTURE_2D, l, 0, 0, level.width, level.height, gl.RGBA, gl.UNSIGNED_BYTE,
        level.bytes)));
    // Counts the bytes of BC5 and BC4, which engines store, although the textures here are RGBA8. LookPage.factsOf
    // shows the result.
    this.materials.set(method, { texture, bytes: levels.reduce((sum, { width, height }) =>
      sum + 1.5 * texelBytes(VK_BC5, width, height), 0) });
  }

  /** `image` is the base colour, an ImageBitmap in sRGB of the map's size or another, or null for white. */
  setColours(image) {
    const { gl } = this, [width, height] = image === null ? [1, 1] : [image.width, image.height];
    gl.deleteTexture(this.colours?.texture ?? null);
    const texture = this.texture(gl.TEXTURE_2D, gl.SRGB8_ALPHA8, { width, height }, levelCount(width, height),
      gl.REPEAT, () => {
        if (image === null) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE,
          new Uint8Array([255, 255, 255, 255]));
        else gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, image);
        gl.generateMipmap(gl.TEXTURE_2D);
      });
    this.colours = { texture, size: Math.max(width, height) };
  }

  removeMaterial(method) {
    this.gl.deleteTexture(this.materials.get(method)?.texture ?? null);
    this.materials.delete(method);
  }

  /** `file` is the parseLobes() of a file. `normals` has the mean normals of the finer levels. */
  setLobes(file, normals) {
    const { gl } = this;
    const blocks = file.format === VK_BC5;
    const [format, kind] = file.format === VK_RGBA16F ? [gl.RGBA16F, gl.HALF_FLOAT]
      : blocks ? [this.rgtc ? this.rgtc.COMPRESSED_RED_GREEN_RGTC2_EXT : gl.RG8, gl.UNSIGNED_BYTE] : [gl.RGBA8,
        gl.UNSIGNED_BYTE];
    const texture = this.texture(gl.TEXTURE_2D_ARRAY, format, file, file.levels.length, gl.REPEAT, () =>
      file.levels.forEach((bytes, level) => {
        const size = [levelSize(file.width, level), levelSize(file.height, level), file.layers];
        const place = [gl.TEXTURE_2D_ARRAY, level, 0, 0, 0, ...size];
        if (blocks && this.rgtc) gl.compressedTexSubImage3D(...place, format, bytes);
        else if (blocks) gl.texSubImage3D(...place, gl.RG, kind, decodeBc5(bytes, ...size));
        else gl.texSubImage3D(...place, gl.RGBA, kind, kind ===
          gl.HALF_FLOAT ? new Uint16Array(bytes.slice().buffer) : bytes);
      }));
    const map = this.texture(gl.TEXTURE_2D, gl.RGBA16F, normals[0], file.lobes.firstLevel, gl.REPEAT, () =>
      normals.slice(0, file.lobes.firstLevel).forEach((level, l) =>
        gl.texSubImage2D(gl.TEXTURE_2D, l, 0, 0, level.width, level.height, gl.RGBA, gl.FLOAT, level.texels)));
    const programs = this.programs([`MULTUM_LOBE_COUNT ${file.lobes.lobes.length}`,
      `MULTUM_LOBE_LAYERS ${file.lobes.layersPerLobe}`, "MULTUM_NORMAL_MAP"], this.shaders.lobeBrdf,
    this.shaders.lobes);
    for (const old of [this.lobes?.texture, this.lobes?.map]) gl.deleteTexture(old ?? null);
    this.lobes?.programs.free();
    this.lobes = { texture, map, programs, unpacking: file.unpacking, firstLevel: file.lobes.firstLevel,
      size: Math.max(normals[0].width, normals[0].height),
      bytes: file.levels.reduce((sum, level) => sum + level.length, 0) + texelBytes(VK_BC5, normals[0].width,
        normals[0].height) };
  }

  get isLost() { return this.gl.isContextLost(); }

  /** Returns whether a method can be drawn. Textures for an engine's rule are made when they are first drawn. */
  has(method) { return method !== "export" || this.materials.has(method); }

  bytesOf(method) { return method === "lobes" ? this.lobes.bytes : this.materials.get(method).bytes; }

  /** Waits until everything is drawn. */
  finish() {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets[2].frame);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, new Float32Array(4));
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** The name of the GPU or of the software that draws. */
  get rendererName() {
    const { gl } = this, more = gl.getExtension("WEBGL_debug_renderer_info");
    return String(gl.getParameter(more === null ? gl.RENDERER : more.UNMASKED_RENDERER_WEBGL));
  }

  /** Makes empty pictures of a size. Returns whether the size is new. */
  resize(width, height) {
    const { gl } = this;
    if (this.size[0] === width && this.size[1] === height) return false;
    for (const { texture, frame } of this.targets) { gl.deleteTexture(texture); gl.deleteFramebuffer(frame); }
    gl.deleteRenderbuffer(this.depth ?? null);
    this.depth = gl.createRenderbuffer(); // shared by both pictures
    gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    // Both sides' pictures, the mean of the reference's samples, if possible as floats of 32 bits, and a sample.
    const isFine = gl.getExtension("EXT_color_buffer_float") !== null && gl.getExtension("EXT_float_blend") !== null;
    this.targets = [gl.RGBA16F, gl.RGBA16F, isFine ? gl.RGBA32F : gl.RGBA16F, gl.RGBA16F].map((format) => {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      const frame = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depth);
      return { texture, frame };
    });
    this.size = [width, height];
    return true;
  }

  /**
   * `scene` has rays, toClip, eye, light, environment (a name), tint, metalness, alpha, lock (a level or null),
   * exposure, split (0..1), difference. A side that shows the reference shows the
   * mean that addToReference() has made.
   */
  draw(left, right, scene) {
    [left, right].forEach((method, side) => {
      if (method !== "reference") this.drawMethod(method, this.targets[side].frame, scene);
    });
    this.show(left, right, scene);
  }

  /** Shows the pictures of the last draw() again, with the reference as it is now. */
  show(left, right, scene) {
    const { gl } = this, [width, height] = this.size;
    gl.viewport(0, 0, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const shown = [left, right].map((method, side) => this.targets[method === "reference" ? 2 : side].texture);
    const at = this.use(this.screen, [["u_left", gl.TEXTURE_2D, shown[0]], ["u_right", gl.TEXTURE_2D, shown[1]]]);
    gl.uniform1f(at("u_split"), scene.split * width);
    gl.uniform1f(at("u_exposure"), scene.exposure);
    gl.uniform1i(at("u_difference"), scene.difference ? 1 : 0);
    gl.uniform1i(at("u_neutral"), ENVIRONMENTS[scene.environment].radiance !== null && !scene.difference ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Adds sample number `index` (from 0) of a pixel to the mean of the reference. `scene` is moved within the pixel. */
  addToReference(index, scene) {
    const { gl } = this, share = 1 / (index + 1);
    this.drawMethod("mip", this.targets[3].frame, { ...scene, lock: 0 });
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets[2].frame);
    this.use(this.copy, [["u_picture", gl.TEXTURE_2D, this.targets[3].texture]]);
    gl.enable(gl.BLEND);
    gl.blendColor(share, share, share, share);
    gl.blendFunc(index === 0 ? gl.ONE : gl.CONSTANT_COLOR, index === 0 ? gl.ZERO : gl.ONE_MINUS_CONSTANT_COLOR);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** Returns a method's picture of the scene without exposure. It is RGBA, row by row from the lowest one. */
  radiance(method, scene) {
    const { gl } = this, [width, height] = this.size;
    const { frame } = this.targets[method === "reference" ? 2 : 3];
    if (method === "reference") gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    else this.drawMethod(method, frame, scene);
    const texels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, texels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return texels;
  }

  use(program, textures) {
    const { gl } = this;
    gl.useProgram(program);
    const at = (name) => gl.getUniformLocation(program, name);
    textures.forEach(([name, target, texture], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(target, texture);
      gl.uniform1i(at(name), unit);
    });
    return at;
  }

  setRays(at, scene) {
    this.gl.uniformMatrix3fv(at("u_rays"), false, scene.rays);
    this.gl.uniform2f(at("u_size"), ...this.size);
  }

  drawMethod(method, frame, scene) {
    const { gl } = this;
    const lobes = method === "lobes" ? this.lobes : null;
    const sky = this.light.environment(scene.environment, () => ++this.madeCount);
    gl.viewport(0, 0, ...this.size);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (sky !== null) {
      this.setRays(this.use(this.background, [["u_sky", gl.TEXTURE_2D, sky.texture]]), scene);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    const textures = lobes
      ? [["u_lobe_layers", gl.TEXTURE_2D_ARRAY, lobes.texture], ["u_normal_map", gl.TEXTURE_2D, lobes.map],
        ["u_ggx_lobe_table", gl.TEXTURE_2D, this.ggxTable]]
      : [["u_material", gl.TEXTURE_2D, this.materials.get(method).texture]];
    if (sky !== null)
      textures.push(["u_sky", gl.TEXTURE_2D, sky.texture], ["u_shares", gl.TEXTURE_2D, this.light.shares]);
    const program = (lobes ? lobes.programs : this.oneNormal).take(this.model !== null, sky !== null);
    const at = this.use(program, [...textures, ["u_colours", gl.TEXTURE_2D, this.colours.texture]]);
    if (this.model === null) this.setRays(at, scene);
    else gl.uniformMatrix4fv(at("u_to_clip"), false, scene.toClip);
    gl.uniform3fv(at("u_eye"), scene.eye);
    gl.uniform3fv(at("u_light_directions"), scene.light);
    gl.uniform3fv(at("u_light_irradiances"), ENVIRONMENTS[scene.environment].sun);
    if (sky !== null) gl.uniform3fv(at("u_sky_harmonics"), sky.harmonics);
    gl.uniform3f(at("u_specular"), 1, 1, 1);
    gl.uniform3fv(at("u_tint"), scene.tint);
    gl.uniform1f(at("u_metalness"), scene.metalness);
    gl.uniform1f(at("u_alpha"), scene.alpha);
    gl.uniform1f(at("u_exponent"), 2 / scene.alpha ** 2);
    gl.uniform1f(at("u_material_alpha"), method === "mip" ? scene.alpha : 1);
    gl.uniform1f(at("u_level_bias"), FILTER.bias);
    gl.uniform1f(at("u_locked_level"), scene.lock === null ? -1000 : scene.lock - (lobes?.firstLevel ?? 0));
    gl.uniform1f(at("u_locked_colours"), Math.max(0,
      (scene.lock ?? 0) + Math.log2(this.colours.size / this.lobes.size)));
    if (lobes) gl.uniform1fv(at("u_lobe_unpacking"), lobes.unpacking);
    if (this.model === null) {
      gl.drawArrays(gl.TRIANGLES, 0, 3);
      return;
    }
    gl.bindVertexArray(this.model.array);
    gl.enable(gl.DEPTH_TEST);
    if (this.model.isClosed) gl.enable(gl.CULL_FACE);
    gl.drawArrays(gl.TRIANGLES, 0, this.model.count);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.nothing);
  }
}
