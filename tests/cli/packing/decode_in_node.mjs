// SPDX-License-Identifier: Apache-2.0
// Decodes every chunk of a packed field with tools/multum_wasm, for tests. Writes the texture of each chunk and sample
// in the order of the index, first as 32-bit floats and then as 16-bit floats.
//   node decode_in_node.mjs FOLDER_OF_MODULE FILE OUTPUT      prints a line of JSON about what it read
import { readFileSync, writeFileSync } from 'node:fs'
import { pathToFileURL } from 'node:url'

const [folder, file, output] = process.argv.slice(2)
const { loadDecoder } = await import(pathToFileURL(`${folder}/packed_field.mjs`))
const decoder = await loadDecoder(readFileSync(`${folder}/packed_field.wasm`))
const bytes = readFileSync(file)
const refused = []
for (const damaged of [bytes.subarray(0, bytes.length - 1), bytes.map((b, i) => i === 12 ? b ^ 1 : b),
  bytes.map((b, i) => i + 1 === bytes.length ? b ^ 1 : b)]) {
  try {
    const field = decoder.open(damaged)
    field.chunk(field.chunkCount - 1)
  } catch (error) {
    refused.push(error.message)
  }
}
const field = decoder.open(bytes)
const parts = [], chunks = []
for (let i = 0; i < field.chunkCount; ++i) {
  const chunk = field.chunk(i)
  chunks.push([chunk.layer, chunk.block, chunk.width, chunk.height, chunk.sampleCount])
  for (let sample = 0; sample < chunk.sampleCount; ++sample)
    for (const values of [chunk.texture(sample), chunk.radianceHalves(sample)])
      parts.push(Buffer.from(values.buffer, values.byteOffset, values.byteLength))
  chunk.close()
}
writeFileSync(output, Buffer.concat(parts))
console.log(JSON.stringify({ chunks, refused, description: await field.description() }))
field.close()
