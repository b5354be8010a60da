// SPDX-License-Identifier: Apache-2.0
// Decodes packed fields of animations (docs/reference/packed_fields.md) in JavaScript, for browsers and Node. Two
// classes wrap packed_field.wasm, which tools/wasm_decoder compiles.
//
//     const decoder = await loadDecoder(bytesOfWasm)
//     const field = decoder.open(bytesOfFile)
//     const chunk = field.chunk(0)                  // below field.chunkCount; has layer, block, width and height
//     chunk.radianceHalves(sample)                  // Uint16Array, [height][width][3], for a texture of half floats
//     chunk.close(); field.close()
//     decoder.chunkOf(bytesOfSection)               // for callers that fetch single byte ranges of a file

const notSupported = 52  // ENOSYS of WASI; the decoder uses neither files nor time

export async function loadDecoder(bytes) {
  const module = await WebAssembly.compile(bytes)
  const imports = {}
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {}
    imports[from][name] = name === 'proc_exit'
      ? () => { throw new Error('the decoder ended: out of memory') }
      : () => notSupported
  }
  const { exports } = await WebAssembly.instantiate(module, imports)
  exports._initialize?.()
  return new Decoder(exports)
}

class Decoder {
  constructor(wasm) { this.wasm = wasm }

  // Throws Error with the reason if the bytes are bad.
  open(bytes) {
    const memory = this.allocated(bytes.length)
    new Uint8Array(this.wasm.memory.buffer, memory, bytes.length).set(bytes)
    const field = this.wasm.multum_open(memory, bytes.length)
    if (field === 0) {
      this.wasm.multum_release(memory)
      throw new Error(this.problem())
    }
    return new PackedField(this, memory, field)
  }

  // Decodes a chunk from the bytes of its section. The caller must have verified the checksum. Throws Error with the
  // reason if the bytes are bad.
  chunkOf(bytes) {
    const memory = this.allocated(bytes.length)
    new Uint8Array(this.wasm.memory.buffer, memory, bytes.length).set(bytes)
    const chunk = this.wasm.multum_decode_section(memory, bytes.length)
    this.wasm.multum_release(memory)
    if (chunk === 0) throw new Error(this.problem())
    return new TextureChunk(this, chunk, null, null)
  }

  allocated(size) {
    const memory = this.wasm.multum_allocate(size) >>> 0
    if (memory === 0) throw new Error(`no memory for ${size} bytes`)
    return memory
  }

  problem() {
    const begin = this.wasm.multum_problem() >>> 0
    const bytes = new Uint8Array(this.wasm.memory.buffer, begin)
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)))
  }
}

class PackedField {
  constructor(decoder, memory, field) {
    Object.assign(this, { decoder, memory, field })
    this.chunkCount = decoder.wasm.multum_chunk_count(field)
  }

  // Returns the object that docs/reference/packed_fields.md, "The description", describes, or null if it is damaged or
  // missing.
  async description() {
    const { wasm } = this.decoder
    const length = wasm.multum_description_length(this.field)
    if (length === 0) return null
    const begin = this.memory + wasm.multum_description_offset(this.field)
    const section = new Uint8Array(wasm.memory.buffer, begin, length).slice()
    const text = section.subarray(section.findIndex(byte => byte < 128) + 1)  // skips the length of the text
    const inflated = new Blob([text]).stream().pipeThrough(new DecompressionStream('deflate'))
    return new Response(inflated).json()
  }

  // Throws Error with the reason if the chunk's bytes are bad.
  chunk(number) {
    if (!(number >= 0 && number < this.chunkCount)) throw new RangeError(`there is no chunk ${number}`)
    const { wasm } = this.decoder
    const chunk = wasm.multum_decode(this.field, number)
    if (chunk === 0) throw new Error(this.decoder.problem())
    return new TextureChunk(this.decoder, chunk, wasm.multum_chunk_layer(this.field, number),
                            wasm.multum_chunk_block(this.field, number))
  }

  close() {
    this.decoder.wasm.multum_close(this.field)
    this.decoder.wasm.multum_release(this.memory)
  }
}

class TextureChunk {
  constructor(decoder, chunk, layer, block) {
    Object.assign(this, { decoder, chunk, layer, block })
    this.width = decoder.wasm.multum_width(chunk)
    this.height = decoder.wasm.multum_height(chunk)
    this.sampleCount = decoder.wasm.multum_sample_count(chunk)
  }

  // Returns gamma-coded floats [height][width][3], with 255 for a radiance of 1.
  texture(sample) { return this.values(sample, 'multum_texture', Float32Array) }

  // Returns radiance as the bits of half floats.
  radianceHalves(sample) { return this.values(sample, 'multum_radiance_halves', Uint16Array) }

  // Returns the radiance of all mip levels, the finest first, as `multum unpack` writes it: [texels][3].
  radianceLevels(sample) {
    return this.values(sample, 'multum_radiance_levels', Uint16Array, this.decoder.wasm.multum_level_texels(this.chunk))
  }

  values(sample, name, List, texels = this.width * this.height) {
    if (!(sample >= 0 && sample < this.sampleCount)) throw new RangeError(`there is no sample ${sample}`)
    const count = 3 * texels
    const memory = this.decoder.allocated(count * List.BYTES_PER_ELEMENT)
    this.decoder.wasm[name](this.chunk, sample, memory)
    const values = new List(this.decoder.wasm.memory.buffer, memory, count).slice()
    this.decoder.wasm.multum_release(memory)
    return values
  }

  close() { this.decoder.wasm.multum_chunk_close(this.chunk) }
}
