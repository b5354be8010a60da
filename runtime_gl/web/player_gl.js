// SPDX-License-Identifier: Apache-2.0
// Draws textured objects with WebGL 2, in the same way as runtime_gl/animation with desktop GL
// (runtime_gl/shaders/textured.vert and .frag). Looks up radiance in textures of 16-bit floats with mip levels, adds it
// up, and computes no lighting. Averages supersampling^2 sub-pixels per pixel in linear light, and encodes the result
// as sRGB.

const BYTES_PER_TEXEL = 8; // three 16-bit floats, padded to four by most drivers
const SUB_PIXELS_MAX = 1 << 24; // limit for the framebuffer; each has 8 bytes of colour and 4 of depth
const POSITION = 0;
const UV = 1;

const OBJECT_VERTEX = `#version 300 es
layout(location = ${POSITION}) in vec3 a_position;
layout(location = ${UV}) in vec2 a_uv;
uniform mat4 u_object_to_clip;
out vec2 v_st;
void main() {
  v_st = vec2(a_uv.x, 1.0 - a_uv.y);
  gl_Position = u_object_to_clip * vec4(a_position, 1.0);
}`;

// In the GLSL of WebGL 2, only constants may index samplers.
const objectFragment = (count) => `#version 300 es
precision highp float;
precision highp sampler2D;
in vec2 v_st;
${count > 0 ? `uniform sampler2D u_layers[${count}];\nuniform float u_weights[${count}];` : ""}
out vec4 o_radiance;
void main() {
  vec3 sum = vec3(0.0);
${Array.from({ length: count }, (_, i) => `  sum += u_weights[${i}] * texture(u_layers[${i}], v_st).rgb;`).join("\n")}
  o_radiance = vec4(sum, 1.0);
}`;

const SCREEN_VERTEX = `#version 300 es
void main() {
  gl_Position = vec4(vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0), 0.0, 1.0);
}`;

const MEAN_FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D u_sub_pixels;
uniform int u_side;
uniform float u_exposure;
out vec4 o_colour;
void main() {
  vec3 sum = vec3(0.0);
  ivec2 corner = ivec2(gl_FragCoord.xy) * u_side;
  for (int y = 0; y < u_side; ++y)
    for (int x = 0; x < u_side; ++x) sum += texelFetch(u_sub_pixels, corner + ivec2(x, y), 0).rgb;
  vec3 linear = clamp(u_exposure * sum / float(u_side * u_side), 0.0, 1.0);
  vec3 curved = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  o_colour = vec4(mix(curved, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308))), 1.0);
}`;

/** Returns the bytes counted for a texture with its mip levels. */
export function textureBytes(width, height) {
  let texels = 0;
  for (let w = width, h = height; ; w = Math.max(1, w >> 1), h = Math.max(1, h >> 1)) {
    texels += w * h;
    if (w === 1 && h === 1) return BYTES_PER_TEXEL * texels;
  }
}

export class PlayerGl {
  /** Throws Error with the feature that the browser lacks. */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false });
    if (gl === null) throw new Error("this browser has no WebGL 2, or it is switched off");
    if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
      throw new Error("this WebGL 2 cannot draw half floats (EXT_color_buffer_half_float)");
    this.gl = gl;
    this.canvas = canvas;
    this.anisotropic = gl.getExtension("EXT_texture_filter_anisotropic");
    this.unitsMax = gl.getParameter(gl.MAX_TEXTURE_IMAGE_UNITS);
    this.sideMax = Math.min(gl.getParameter(gl.MAX_TEXTURE_SIZE), gl.getParameter(gl.MAX_RENDERBUFFER_SIZE));
    this.programs = new Map(); // shader programs by number of textures
    this.screen = this.program(SCREEN_VERTEX, MEAN_FRAGMENT);
    this.nothing = gl.createVertexArray();
    this.target = null;
    this.fences = []; // fences after pictures that the driver may still be drawing
  }

  program(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
        throw new Error(`the driver rejects a shader: ${gl.getShaderInfoLog(shader)}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(`the driver rejects a program: ${gl.getProgramInfoLog(program)}`);
    return program;
  }

  objectProgram(count) {
    if (!this.programs.has(count)) {
      const { gl } = this;
      const program = this.program(OBJECT_VERTEX, objectFragment(count));
      gl.useProgram(program);
      const units = Int32Array.from({ length: count }, (_, i) => i);
      if (count > 0) gl.uniform1iv(gl.getUniformLocation(program, "u_layers"), units);
      this.programs.set(count, {
        program, toClip: gl.getUniformLocation(program, "u_object_to_clip"),
        weights: count > 0 ? gl.getUniformLocation(program, "u_weights") : null,
      });
    }
    return this.programs.get(count);
  }

  /** `levels` has 16-bit floats for all mip levels, the finest first, [texels][3]. */
  makeTexture(levels, { width, height, wrapS, wrapT }, anisotropy) {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
    const count = 1 + Math.floor(Math.log2(Math.max(width, height)));
    gl.texStorage2D(gl.TEXTURE_2D, count, gl.RGB16F, width, height);
    for (let level = 0, at = 0; level < count; ++level) {
      const [w, h] = [Math.max(1, width >> level), Math.max(1, height >> level)];
      gl.texSubImage2D(gl.TEXTURE_2D, level, 0, 0, w, h, gl.RGB, gl.HALF_FLOAT, levels, at);
      at += 3 * w * h;
    }
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, wrapS === "periodic" ? gl.REPEAT : gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, wrapT === "periodic" ? gl.REPEAT : gl.CLAMP_TO_EDGE);
    if (anisotropy > 1 && this.anisotropic)
      gl.texParameterf(gl.TEXTURE_2D, this.anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, anisotropy);
    return texture;
  }

  makeBuffer(values) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindVertexArray(null);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    return buffer;
  }

  makeMesh(positions, uvs, count) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    for (const [place, buffer, width] of [[POSITION, positions, 3], [UV, uvs, 2]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, width, gl.FLOAT, false, 0, 0);
    }
    gl.bindVertexArray(null);
    return { array, count };
  }

  /** Returns the most sub-pixels along each side of a pixel, up to `wanted`, that this device supports. */
  affordable(width, height, wanted) {
    let side = wanted;
    while (side > 1 && (Math.max(width, height) * side > this.sideMax || width * height * side * side > SUB_PIXELS_MAX))
      --side;
    return side;
  }

  /** Creates the framebuffer of sub-pixels, and creates it again when its size changes. */
  prepareTarget(width, height) {
    const { gl } = this;
    if (this.target?.width === width && this.target.height === height) return;
    this.releaseTarget();
    const target = { width, height, frame: gl.createFramebuffer(), colour: gl.createTexture(),
      depth: gl.createRenderbuffer() };
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, target.colour);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA16F, width, height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.bindRenderbuffer(gl.RENDERBUFFER, target.depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT32F, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target.colour, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, target.depth);
    const status = gl.checkFramebufferStatus(gl.FRAMEBUFFER);
    if (status !== gl.FRAMEBUFFER_COMPLETE && !gl.isContextLost())
      throw new Error(`the driver rejects a framebuffer of ${width} x ${height} halves (status ${status})`);
    this.target = target;
  }

  releaseTarget() {
    if (this.target === null) return;
    this.gl.deleteFramebuffer(this.target.frame);
    this.gl.deleteTexture(this.target.colour);
    this.gl.deleteRenderbuffer(this.target.depth);
    this.target = null;
  }

  /**
   * `objects` are `{ mesh, objectToClip, textures, weights }`. Textures times weights are added up. An object without
   * textures is black and hides objects behind it. `hasOneLevel` looks up only the nearest mip level instead of two,
   * which halves the time of software renderers.
   */
  draw({ width, height, supersampling, exposure, objects, hasOneLevel }) {
    const { gl, canvas } = this;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    this.prepareTarget(width * supersampling, height * supersampling);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target.frame);
    gl.viewport(0, 0, this.target.width, this.target.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    for (const { mesh, objectToClip, textures, weights } of objects) {
      const { program, toClip, weights: place } = this.objectProgram(textures.length);
      gl.useProgram(program);
      gl.uniformMatrix4fv(toClip, false, Float32Array.from(objectToClip));
      if (place !== null) gl.uniform1fv(place, weights);
      textures.forEach((texture, unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER,
          hasOneLevel ? gl.LINEAR_MIPMAP_NEAREST : gl.LINEAR_MIPMAP_LINEAR);
      });
      gl.bindVertexArray(mesh.array);
      gl.drawArrays(gl.TRIANGLES, 0, mesh.count);
    }
    gl.disable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.useProgram(this.screen);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.target.colour);
    gl.uniform1i(gl.getUniformLocation(this.screen, "u_side"), supersampling);
    gl.uniform1f(gl.getUniformLocation(this.screen, "u_exposure"), exposure);
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindTexture(gl.TEXTURE_2D, null);
    this.fences.push(gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0));
    gl.flush();
  }

  /** Returns whether more than one picture is unfinished, as known at the last return to the browser. */
  isBusy() {
    const { gl } = this;
    while (this.fences.length > 0 &&
        (gl.isContextLost() || gl.getSyncParameter(this.fences[0], gl.SYNC_STATUS) === gl.SIGNALED))
      gl.deleteSync(this.fences.shift());
    return this.fences.length > 1;
  }

  /** Returns the last picture's 8-bit values, [height][width][4], the top row first. */
  pixels() {
    const { gl, canvas: { width, height } } = this;
    const values = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, values);
    const rows = new Uint8Array(values.length);
    for (let y = 0; y < height; ++y)
      rows.set(values.subarray(4 * width * (height - 1 - y), 4 * width * (height - y)), 4 * width * y);
    return rows;
  }
}
