// SPDX-License-Identifier: Apache-2.0
// Stores the contents of the extension MULTUM_lobes (docs/reference/gltf.md) in a document of glTF-Transform.
//
//   Material --setExtension--> MaterialLobes --setLobes--> Lobes, which any number of materials share
//                                            --setMetallicRoughnessTexture--> Texture
//
// Lobes are bytes and not a Texture, because functions that resize, compress or remove textures would change them.
import { ExtensionProperty, PropertyType, TextureChannel, TextureInfo } from "@gltf-transform/core";

export const NAME = "MULTUM_lobes";

/** The lobes of a normal map, and their colours if they have any. */
export class Lobes extends ExtensionProperty {
  static EXTENSION_NAME = NAME;

  init() {
    this.extensionName = NAME;
    this.propertyType = "Lobes";
    this.parentTypes = []; // only MaterialLobes refers to lobes
  }

  getDefaults() {
    return Object.assign(super.getDefaults(), { image: null, colours: null });
  }

  getImage() {
    return this.get("image");
  }

  setImage(bytes) {
    return this.set("image", bytes);
  }

  getColours() {
    return this.get("colours");
  }

  setColours(bytes) {
    return this.set("colours", bytes);
  }
}

/** The lobes of a material, and the roughness of its surface itself. */
export class MaterialLobes extends ExtensionProperty {
  static EXTENSION_NAME = NAME;

  init() {
    this.extensionName = NAME;
    this.propertyType = "MaterialLobes";
    this.parentTypes = [PropertyType.MATERIAL];
  }

  getDefaults() {
    return Object.assign(super.getDefaults(), {
      lobes: null,
      roughnessFactor: 1,
      metallicRoughnessTexture: null,
      metallicRoughnessTextureInfo: new TextureInfo(this.graph, "metallicRoughnessTextureInfo"),
    });
  }

  getLobes() {
    return this.getRef("lobes");
  }

  setLobes(lobes) {
    return this.setRef("lobes", lobes);
  }

  getRoughnessFactor() {
    return this.get("roughnessFactor");
  }

  setRoughnessFactor(factor) {
    return this.set("roughnessFactor", factor);
  }

  getMetallicRoughnessTexture() {
    return this.getRef("metallicRoughnessTexture");
  }

  getMetallicRoughnessTextureInfo() {
    return this.getMetallicRoughnessTexture() ? this.getRef("metallicRoughnessTextureInfo") : null;
  }

  setMetallicRoughnessTexture(texture) {
    return this.setRef("metallicRoughnessTexture", texture, { channels: TextureChannel.G });
  }
}
