// SPDX-License-Identifier: Apache-2.0
// The extension MULTUM_lobes for glTF-Transform's readers and writers. Section "The extension MULTUM_lobes" of
// docs/reference/gltf.md describes its objects.
import { Extension, PropertyType } from "@gltf-transform/core";
import { Lobes, MaterialLobes, NAME } from "./lobe_properties.js";

const KTX2_TYPE = "image/ktx2";
const KTX2_IDENTIFIER = [0xab, 0x4b, 0x54, 0x58, 0x20, 0x32, 0x30, 0xbb, 0x0d, 0x0a, 0x1a, 0x0a];

function refuse(place, found, expected) {
  throw new Error(`${NAME}: ${place}: found ${found}, expected ${expected}`);
}

/** Returns JSON of a value for a message. */
function shown(value) {
  return JSON.stringify(value)?.slice(0, 40) ?? "nothing";
}

function isIndex(value, count) {
  return Number.isInteger(value) && value >= 0 && value < count;
}

function isKtx2(bytes) {
  return bytes instanceof Uint8Array && KTX2_IDENTIFIER.every((byte, at) => bytes[at] === byte);
}

/** Returns a copy of the bytes of {bufferView, mimeType}. */
function bytesOf(object, context, place) {
  const { bufferView, mimeType } = object ?? {}, views = context.bufferViews;
  if (!isIndex(bufferView, views.length))
    refuse(place, `bufferView ${shown(bufferView)}`, `the index of one of ${views.length} buffer views`);
  if (mimeType !== KTX2_TYPE) refuse(place, `mimeType ${shown(mimeType)}`, KTX2_TYPE);
  const bytes = views[bufferView].slice();
  if (!isKtx2(bytes)) refuse(place, `buffer view ${bufferView} of other content`, "a KTX2 file");
  return bytes;
}

/**
 * Keeps the lobes of a model in glTF-Transform.
 *
 *     const io = new NodeIO().registerExtensions([...ALL_EXTENSIONS, MultumLobes]);
 *
 * Reading fails if the extension is damaged. Lobes that no material uses are not written.
 */
export class MultumLobes extends Extension {
  static EXTENSION_NAME = NAME;
  extensionName = NAME;
  // KHR_texture_transform reads and writes transforms after these steps, so it finds the texture of the extension.
  prereadTypes = [PropertyType.MESH];
  prewriteTypes = [PropertyType.BUFFER, PropertyType.MESH];

  createLobes() {
    return new Lobes(this.document.getGraph());
  }

  createMaterialLobes() {
    return new MaterialLobes(this.document.getGraph());
  }

  preread(context) {
    const { json } = context.jsonDoc, lobes = this.readLobes(context);
    for (const [number, { extensions }] of (json.materials ?? []).entries())
      if (extensions?.[NAME] !== undefined)
        context.materials[number].setExtension(NAME,
          this.readMaterial(extensions[NAME], lobes, context, `material ${number}`));
    return this;
  }

  readLobes(context) {
    const extension = context.jsonDoc.json.extensions?.[NAME];
    if (extension === undefined) return []; // a file that declares the extension need not use it
    if (!Array.isArray(extension?.lobes)) refuse("extensions", `lobes ${shown(extension?.lobes)}`, "an array");
    return extension.lobes.map((object, index) => {
      const lobes = this.createLobes().setImage(bytesOf(object, context, `lobes ${index}`));
      if (object.colours !== undefined)
        lobes.setColours(bytesOf(object.colours, context, `colours of lobes ${index}`));
      return lobes.setExtras(object.extras ?? {});
    });
  }

  readMaterial(object, lobes, context, place) {
    if (!isIndex(object?.lobes, lobes.length))
      refuse(place, `lobes ${shown(object?.lobes)}`, `the index of one of ${lobes.length} lobes`);
    const { roughnessFactor = 1, metallicRoughnessTexture: info } = object;
    if (!(typeof roughnessFactor === "number" && roughnessFactor >= 0 && roughnessFactor <= 1))
      refuse(place, `roughnessFactor ${shown(roughnessFactor)}`, "a number between 0 and 1");
    const made = this.createMaterialLobes().setLobes(lobes[object.lobes]).setRoughnessFactor(roughnessFactor);
    if (info !== undefined) {
      const textures = context.jsonDoc.json.textures ?? [];
      if (!isIndex(info?.index, textures.length))
        refuse(place, `metallicRoughnessTexture ${shown(info)}`, `the index of one of ${textures.length} textures`);
      const image = context.textures[textures[info.index].source];
      if (image === undefined)
        refuse(place, `texture ${info.index} without an image`, "an image. Register the extension that supplies it");
      made.setMetallicRoughnessTexture(image);
      context.setTextureInfo(made.getMetallicRoughnessTextureInfo(), info);
    }
    return made.setExtras(object.extras ?? {});
  }

  read() {
    return this;
  }

  prewrite(context, type) {
    if (type === PropertyType.BUFFER) this.writeViews(context);
    if (type === PropertyType.MESH) this.writeMaterials(context);
    return this;
  }

  /** Returns [material, its MaterialLobes] of every material whose lobes are written. */
  materials() {
    return this.document.getRoot().listMaterials().map((material) => [material, material.getExtension(NAME)])
      .filter(([material, own]) => own && material.getNormalTexture());
  }

  /** Returns the lobes that materials use, in the order of the materials. */
  usedLobes() {
    return [...new Set(this.materials().map(([material, own]) => {
      const lobes = own.getLobes(), place = `material "${material.getName()}"`;
      if (lobes === null) refuse(place, "MaterialLobes without lobes", "a call of setLobes()");
      if (!isKtx2(lobes.getImage())) refuse(place, "lobes whose image is not KTX2", "the bytes of a KTX2 file");
      if (lobes.getColours() !== null && !isKtx2(lobes.getColours()))
        refuse(place, "lobes whose colours are not KTX2", "the bytes of a KTX2 file, or null");
      return lobes;
    }))];
  }

  writeViews(context) {
    for (const material of this.document.getRoot().listMaterials())
      if (material.getExtension(NAME) && !material.getNormalTexture())
        context.logger.warn(
          `${NAME}: material "${material.getName()}" has no normal texture, which lobes need; its lobes are removed`);
    const views = new Set(this.usedLobes().flatMap((lobes) => [lobes.getImage(), lobes.getColours()]));
    views.delete(null);
    if (views.size === 0) return;
    const buffer = this.document.getRoot().listBuffers()[0] ?? this.document.createBuffer();
    context.otherBufferViews.set(buffer, [...(context.otherBufferViews.get(buffer) ?? []), ...views]);
  }

  writeMaterials(context) {
    const { json } = context.jsonDoc, lobes = this.usedLobes();
    if (lobes.length === 0) return;
    const viewed = (bytes) => ({ bufferView: context.otherBufferViewsIndexMap.get(bytes), mimeType: KTX2_TYPE });
    json.extensions ??= {};
    json.extensions[NAME] = { lobes: lobes.map((one) => ({
      ...viewed(one.getImage()), ...(one.getColours() && { colours: viewed(one.getColours()) }),
      ...extrasOf(one) })) };
    for (const [material, own] of this.materials()) {
      const made = { lobes: lobes.indexOf(own.getLobes()), ...extrasOf(own) };
      if (own.getRoughnessFactor() !== 1) made.roughnessFactor = own.getRoughnessFactor();
      const texture = own.getMetallicRoughnessTexture();
      if (texture !== null)
        made.metallicRoughnessTexture = context.createTextureInfoDef(texture, own.getMetallicRoughnessTextureInfo());
      const object = json.materials[context.materialIndexMap.get(material)];
      object.extensions ??= {};
      object.extensions[NAME] = made;
    }
  }

  write() {
    return this;
  }
}

/** Returns the object's extras, if any, as a member of its JSON. */
function extrasOf(property) {
  const extras = property.getExtras();
  return Object.keys(extras).length > 0 ? { extras } : {};
}
