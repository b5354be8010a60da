// SPDX-License-Identifier: Apache-2.0
// A worker that decodes chunks of a packed field, one request after another. The worker keeps the last few decoded
// chunks, because the page will ask for their other textures. If the module's memory, which never shrinks, has grown
// too far, the worker restarts the module.
//
//   gets { wasm }                                                 bytes of packed_field.wasm, once
//   gets { id, chunk, bytes, texture, textures, width, height }   bytes is null if the worker should still have the
//   chunk
//   answers { id, levels, memory } | { id, isGone, memory } | { id, problem, memory }   levels: 16-bit floats, all mips
import { loadDecoder } from "./packed_field.js";
import { chunkHead } from "./chunk_head.js";
import { errorText } from "./error_text.js";

const CHUNKS_MAX = 64; // more than a picture needs; otherwise each picture would decode all its chunks again
const MEMORY_BYTES_MAX = 128 * 2 ** 20;

let wasm = null;
let decoder = null; // promise of the decoder
const chunks = new Map(); // decoded chunks by name, least recently used first

const restart = () => {
  chunks.clear();
  decoder = loadDecoder(wasm);
};

async function decodedChunk({ chunk: name, bytes, textures, width, height }) {
  const { wasm: module } = await decoder;
  if (module.memory.buffer.byteLength > MEMORY_BYTES_MAX) restart();
  let chunk = chunks.get(name);
  chunks.delete(name);
  if (chunk === undefined) {
    if (bytes === null) return null;
    // Checks the head before allocating memory for sizes in untrusted bytes.
    const head = chunkHead(bytes);
    if (head.width !== width || head.height !== height || head.textures !== textures)
      throw new Error(`has ${head.textures} textures of ${head.width} x ${head.height}, ` +
        `its description says ${textures} of ${width} x ${height}`);
    while (chunks.size >= CHUNKS_MAX) {
      const [oldest] = chunks.keys();
      chunks.get(oldest).close();
      chunks.delete(oldest);
    }
    chunk = (await decoder).chunkOf(bytes);
  }
  chunks.set(name, chunk);
  return chunk;
}

async function answer(request) {
  try {
    const chunk = await decodedChunk(request);
    return chunk === null ? { isGone: true } : { levels: chunk.radianceLevels(request.texture) };
  } catch (error) {
    const problem = errorText(error);
    if (error instanceof WebAssembly.RuntimeError || /memory/.test(problem)) restart(); // the module's state is unknown
    return { problem };
  }
}

let last = Promise.resolve();
if (typeof WorkerGlobalScope !== "undefined")
  addEventListener("message", ({ data }) => {
    if (data.wasm !== undefined) {
      wasm = data.wasm;
      restart();
      return;
    }
    last = last.then(async () => {
      const reply = { id: data.id, ...await answer(data) };
      reply.memory = await decoder.then((one) => one.wasm.memory.buffer.byteLength, () => 0);
      postMessage(reply, reply.levels ? [reply.levels.buffer] : []);
    });
  });
