// SPDX-License-Identifier: Apache-2.0
// Runs functions of glTF-Transform on models, with the settings file of @multum/gltf-transform.
//
//   node gltf_transforming.mjs PLAN.json
//
// A copy of this file must be next to a node_modules folder with both packages. PLAN.json is an array of {"in", "out",
// "steps"}; "steps" are names of `functions` below, and "plain": true leaves out @multum/gltf-transform. The output is
// a JSON array with one object per model: {"error"} if the model cannot be read or written, otherwise {"compressed",
// "warnings"}.
import { Document, Logger, NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import {
  center, cloneDocument, dedup, flatten, instance, join, mergeDocuments, meshopt, partition, prune, quantize,
  reorder, resample, simplify, sparse, textureCompress, unpartition, weld,
} from "@gltf-transform/functions";
import { MultumLobes } from "@multum/gltf-transform";
import settings from "@multum/gltf-transform/gltf-transform.config.mjs";
import { MeshoptDecoder, MeshoptEncoder, MeshoptSimplifier } from "meshoptimizer";
import { readFileSync } from "node:fs";

// A WebP file of one texel.
const WEBP = Buffer.from("UklGRh4AAABXRUJQVlA4TBEAAAAvAAAAAAdQwAL2v/+BiOh/AAA=", "base64");
let compressed = 0;

/** Replaces each image by WEBP. Has the interface of sharp. */
function encoder() {
  ++compressed;
  return { toFormat: () => ({ toBuffer: async () => WEBP }) };
}

let replaced; // the document that a step made instead of changing its own

/** Makes a document with the lobes of the first material and no buffer. */
function onlyLobes(document) {
  const [source] = document.getRoot().listMaterials();
  replaced = new Document();
  const extension = replaced.createExtension(MultumLobes);
  const lobes = extension.createLobes().setImage(source.getExtension("MULTUM_lobes").getLobes().getImage());
  const normals = replaced.createTexture().setMimeType("image/png").setImage(source.getNormalTexture().getImage());
  replaced.createMaterial(source.getName()).setNormalTexture(normals).setExtension("MULTUM_lobes",
    extension.createMaterialLobes().setLobes(lobes).setRoughnessFactor(0.25));
}

const functions = {
  center: () => center(),
  clone: () => (document) => { replaced = cloneDocument(document); },
  dedup: () => dedup(),
  flatten: () => flatten(),
  instance: () => instance({ min: 2 }),
  join: () => join(),
  merge: () => (document) => { mergeDocuments(replaced = new Document(), document); },
  meshopt: () => meshopt({ encoder: MeshoptEncoder }),
  partition: () => partition(),
  prune: () => prune(),
  quantize: () => quantize(),
  reorder: () => reorder({ encoder: MeshoptEncoder }),
  resample: () => resample(),
  simplify: () => simplify({ simplifier: MeshoptSimplifier }),
  sparse: () => sparse(),
  textureCompress: () => textureCompress({ encoder, targetFormat: "webp" }),
  unpartition: () => unpartition(),
  weld: () => weld(),
  // Changes that a program makes.
  dropMaterial: () => (document) => { document.getRoot().listMaterials()[0].dispose(); },
  dropNormals: () => (document) => { document.getRoot().listMaterials()[0].setNormalTexture(null); },
  dropLobes: () => (document) => {
    document.getRoot().listMaterials()[0].getExtension("MULTUM_lobes").setLobes(null);
  },
  onlyLobes: () => onlyLobes,
};

async function transform({ in: input, out, steps, plain }) {
  const warnings = [];
  const logger = new class extends Logger {
    warn(text) { warnings.push(text); }
  }(Logger.Verbosity.WARN);
  const io = new NodeIO().setLogger(logger).registerExtensions(plain ? ALL_EXTENSIONS : settings.extensions)
    .registerDependencies({ "meshopt.decoder": MeshoptDecoder, "meshopt.encoder": MeshoptEncoder });
  compressed = 0;
  let document = await io.read(input);
  for (const step of steps) {
    replaced = undefined;
    await document.transform(functions[step]());
    document = replaced?.setLogger(logger) ?? document;
  }
  await io.write(out, document);
  return { compressed, warnings };
}

await Promise.all([MeshoptDecoder.ready, MeshoptEncoder.ready, MeshoptSimplifier.ready]);
const found = [];
for (const one of JSON.parse(readFileSync(process.argv[2], "utf8")))
  found.push(await transform(one).catch((error) => ({ error: error.message })));
console.log(JSON.stringify(found));
