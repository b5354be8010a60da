// SPDX-License-Identifier: Apache-2.0
// Runs shaders in Chromium: run_shaders.mjs MODULES CHROMIUM JOB.json. The job has the table, the cases, and the shader
// text of each language. For each language, prints four numbers per case, or the reason why the shader could not run.
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { pathToFileURL } from "node:url";

const [modules, chromium, jobFile] = process.argv.slice(2);
const { chromium: browserType } = await import(pathToFileURL(`${modules}/playwright-core/index.mjs`));
const job = JSON.parse(await readFile(jobFile, "utf8"));

// A server on loopback serves the page, because WebGPU needs a secure context.
const server = createServer((request, response) => {
  response.setHeader("content-type", "text/html");
  response.end("<p>shaders");
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));

function runWebgl({ side, table, count, cases }, source) {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl || !gl.getExtension("EXT_color_buffer_float")) return "no WebGL 2 that draws into floats";
  const compiled = (kind, text) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compiled(gl.VERTEX_SHADER, `#version 300 es
    void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`));
  gl.attachShader(program, compiled(gl.FRAGMENT_SHADER, source));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  const texture = (unit, format, width, height, type, data, filter) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, gl.RGBA, type, data);
    for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], filter);
    for (const name of ["S", "T"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_WRAP_${name}`], gl.CLAMP_TO_EDGE);
  };
  texture(0, gl.RGBA16F, side, side, gl.HALF_FLOAT, Uint16Array.from(table), gl.LINEAR);
  texture(1, gl.RGBA32F, 4, count, gl.FLOAT, Float32Array.from(cases), gl.NEAREST);
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
    const { name } = gl.getActiveUniform(program, i);
    gl.uniform1i(gl.getUniformLocation(program, name), name.includes("table") ? 0 : 1);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.activeTexture(gl.TEXTURE2);
  const target = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, 1, count);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.viewport(0, 0, 1, count);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const values = new Float32Array(4 * count);
  gl.readPixels(0, 0, 1, count, gl.RGBA, gl.FLOAT, values);
  return Array.from(values, String);
}

async function runWebgpu({ side, table, count, cases }, code) {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) return "no WebGPU adapter";
  const device = await adapter.requestDevice();
  const module = device.createShaderModule({ code });
  const problems = (await module.getCompilationInfo()).messages.filter((one) => one.type === "error");
  if (problems.length > 0) throw new Error(problems.map((one) => `${one.lineNum}: ${one.message}`).join("\n"));
  if (!count) return [];
  const texture = device.createTexture({ size: [side, side], format: "rgba16float", usage: 4 | 2 });
  device.queue.writeTexture({ texture }, Uint16Array.from(table), { bytesPerRow: 8 * side }, [side, side]);
  const bytes = Float32Array.from(cases);
  const input = device.createBuffer({ size: bytes.byteLength, usage: 0x80 | 8 });
  device.queue.writeBuffer(input, 0, bytes);
  const output = device.createBuffer({ size: 16 * count, usage: 0x80 | 4 });
  const read = device.createBuffer({ size: 16 * count, usage: 1 | 8 });
  const pipeline = device.createComputePipeline({ layout: "auto", compute: { module, entryPoint: "main" } });
  const sampler = device.createSampler({ magFilter: "linear", minFilter: "linear" });
  const group = device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries: [
    { binding: 0, resource: texture.createView() }, { binding: 1, resource: sampler },
    { binding: 2, resource: { buffer: input } }, { binding: 3, resource: { buffer: output } }] });
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, group);
  pass.dispatchWorkgroups(count);
  pass.end();
  encoder.copyBufferToBuffer(output, 0, read, 0, 16 * count);
  device.queue.submit([encoder.finish()]);
  await read.mapAsync(1);
  return Array.from(new Float32Array(read.getMappedRange()), String);
}

const browser = await browserType.launch({ executablePath: chromium, args: ["--no-sandbox", "--enable-unsafe-webgpu",
  "--use-webgpu-adapter=swiftshader", "--enable-unsafe-swiftshader"] });
try {
  const page = await browser.newPage();
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  const results = {};
  for (const [name, { kind, source }] of Object.entries(job.shaders)) {
    const run = kind.startsWith("wgsl") ? runWebgpu : runWebgl;
    const data = JSON.stringify(kind === "wgsl-compile" ? {} : job.data);
    results[name] = await page.evaluate(`(${run})(${data}, ${JSON.stringify(source)})`);
  }
  console.log(JSON.stringify(results));
} finally {
  await browser.close();
  server.close();
}
