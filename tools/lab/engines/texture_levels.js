// SPDX-License-Identifier: Apache-2.0
// Records which levels of 2D textures a page uploads and which textures get mips from WebGL. Reads the texels of all
// levels. Runs before the scripts of the page.
(() => {
  const made = new Map(); // by texture: { gl, levels: sizes by level, generated }
  const TEXTURE_2D = 0x0de1;
  const note = (gl) => {
    const texture = gl.getParameter(gl.TEXTURE_BINDING_2D);
    if (texture === null) return null;
    if (!made.has(texture)) made.set(texture, { gl, levels: new Map(), generated: false });
    return made.get(texture);
  };
  // Returns level, width, height and the format of compressed texels from the arguments of each function.
  const uploads = {
    texImage2D: (a) => (a.length >= 9 ? a[8] !== null && [a[1], a[3], a[4]] : [a[1], a[5].width, a[5].height]),
    compressedTexImage2D: (a) => [a[1], a[3], a[4], a[2]],
    texSubImage2D: (a) => (a.length >= 9 ? [a[1], a[4], a[5]] : [a[1], a[6].width, a[6].height]),
    compressedTexSubImage2D: (a) => [a[1], a[4], a[5], a[6]],
  };
  for (const [name, read] of Object.entries(uploads)) {
    const call = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function upload(...words) {
      call.apply(this, words);
      const found = words[0] === TEXTURE_2D && read(words);
      if (found) note(this)?.levels.set(found[0], { width: found[1], height: found[2], format: found[3] });
    };
  }
  const generate = WebGL2RenderingContext.prototype.generateMipmap;
  WebGL2RenderingContext.prototype.generateMipmap = function generateMipmap(target) {
    generate.call(this, target);
    const one = target === TEXTURE_2D && note(this);
    if (one) one.generated = true;
  };

  const SHADERS = ["#version 300 es\nvoid main() { gl_Position = vec4(vec2[](vec2(-1, -1), vec2(3, -1), vec2(-1, 3))" +
    "[gl_VertexID], 0, 1); }", "#version 300 es\nprecision highp float; precision highp sampler2D; uniform sampler2D " +
    "map; uniform int level; out vec4 texel; void main() { texel = texelFetch(map, ivec2(gl_FragCoord.xy), level); }"];
  function programOf(gl) {
    const program = gl.createProgram();
    SHADERS.forEach((text, i) => {
      const shader = gl.createShader(i ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    return program;
  }
  function texelsOf(gl, texture, level, { width, height }) {
    const target = gl.createTexture(), bytes = new Uint8Array(4 * width * height);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindSampler(0, null);
    gl.bindTexture(TEXTURE_2D, target);
    gl.texStorage2D(TEXTURE_2D, 1, gl.RGBA8, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, TEXTURE_2D, target, 0);
    gl.bindTexture(TEXTURE_2D, texture);
    const program = programOf(gl);
    gl.useProgram(program);
    gl.uniform1i(gl.getUniformLocation(program, "level"), level);
    gl.bindVertexArray(gl.createVertexArray());
    for (const state of [gl.BLEND, gl.DEPTH_TEST, gl.CULL_FACE, gl.SCISSOR_TEST, gl.STENCIL_TEST,
      gl.SAMPLE_ALPHA_TO_COVERAGE, gl.RASTERIZER_DISCARD]) gl.disable(state);
    gl.colorMask(true, true, true, true);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.pixelStorei(gl.PACK_ALIGNMENT, 4);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    let text = "";
    for (const byte of bytes) text += String.fromCharCode(byte);
    return { width, height, texels: btoa(text) };
  }

  /**
   * Returns the textures of at least `side` texels whose levels were uploaded, with the texels of each level in base64:
   * { generated, minFilter, maxLevel, levels }. Changes the state of the context, so draw nothing afterwards.
   */
  globalThis.uploadedTextures = (side) => [...made].filter(([texture, { gl, levels }]) =>
    gl.isTexture(texture) && levels.get(0)?.width >= side).map(([texture, { gl, levels, generated }]) => {
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(TEXTURE_2D, texture);
    const [minFilter, maxLevel] = [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAX_LEVEL].map((name) =>
      gl.getTexParameter(TEXTURE_2D, name));
    return { generated, minFilter, maxLevel, levels: [...levels].sort(([a], [b]) => a - b).map(([level, size]) =>
      ({ level, format: size.format, ...texelsOf(gl, texture, level, size) })), error: gl.getError() };
  });
})();
