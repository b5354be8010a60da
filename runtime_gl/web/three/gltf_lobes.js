// SPDX-License-Identifier: Apache-2.0
// Reads the extension MULTUM_lobes, written by `multum gltf IN.glb --lobes -o OUT.glb` (docs/reference/gltf.md), for
// three.js's GLTFLoader.
import { addLobes, addPoints } from "./lobe_material.js";
import { LobeLoader } from "./lobe_texture.js";

const NAME = "MULTUM_lobes";

/**
 * A plugin for GLTFLoader that makes a model's materials draw its lobes.
 *
 *     loader.register((parser) => new GltfLobes(parser, renderer));
 *
 * The result of GLTFLoader has the LobeTextures in `userData.lobes`; dispose of them with the model. `options` are as
 * in addLobes(). Materials with normal maps and no lobes get addPoints() with the same `evaluations`. Maps get the
 * renderer's most anisotropic filter. Loading fails if the extension is damaged. A material that cannot have lobes
 * keeps its own textures, with a warning on the console.
 */
export class GltfLobes {
  constructor(parser, renderer, options = {}) {
    this.name = NAME;
    this.parser = parser;
    this.options = options;
    this.anisotropy = renderer.capabilities.getMaxAnisotropy();
    this.loader = new LobeLoader().detectSupport(renderer);
  }

  async afterRoot(result) {
    const { json } = this.parser, all = json.extensions?.[NAME]?.lobes ?? [];
    const textures = new Map(); // promises by index
    const lobesAt = (index) => {
      if (!textures.has(index)) textures.set(index, this.lobes(all, index));
      return textures.get(index);
    };
    const materials = new Map(); // the extension's objects; GLTFLoader may draw with clones of its materials
    const others = new Set();
    for (const scene of result.scenes)
      scene.traverse(({ material }) => {
        const index = this.parser.associations.get(material)?.materials;
        const extension = json.materials?.[index]?.extensions?.[NAME];
        if (extension !== undefined) materials.set(material, extension);
        else if (material?.isMeshStandardMaterial && material.normalMap) others.add(material);
      });
    const loaded = await Promise.allSettled([...materials.values()].map(({ lobes }) => lobesAt(lobes)));
    const failed = loaded.find(({ status }) => status === "rejected");
    if (failed !== undefined) {
      for (const { value } of loaded) value?.dispose();
      throw failed.reason;
    }
    for (const [material, extension] of materials)
      await this.dress(material, extension, await lobesAt(extension.lobes));
    for (const material of others) {
      addPoints(material, { evaluations: this.options.evaluations });
      this.sharpen(material);
    }
    result.userData.lobes = await Promise.all(textures.values());
  }

  async lobes(all, index) {
    const view = Array.isArray(all) ? all[index]?.bufferView : undefined;
    if (!Number.isInteger(view) || this.parser.json.bufferViews?.[view] === undefined)
      throw new Error(`${NAME}: found a material of lobes ${index}, expected the index of an object with a bufferView`);
    const bytesOf = (number) => this.parser.getDependency("bufferView", number);
    const lobes = await this.loader.parse(await bytesOf(view), `${NAME}, lobes ${index}`);
    const { colours } = all[index], name = `${NAME}, colours of lobes ${index}`;
    if (colours === undefined) return lobes;
    try {
      if (this.parser.json.bufferViews[colours?.bufferView] === undefined)
        throw new Error(`${name}: found buffer view ${colours?.bufferView}, expected the index of one`);
      await this.loader.parseColours(await bytesOf(colours.bufferView), lobes, name);
    } catch (error) {
      lobes.dispose();
      throw error;
    }
    return lobes;
  }

  async dress(material, extension, lobes) {
    try {
      addLobes(material, lobes, this.options);
    } catch (error) {
      console.warn(`${NAME}: ${error.message}; it is drawn without lobes`);
      return;
    }
    // Uses only the roughness of the surface, because the material's roughness includes the spread of the normals.
    material.roughness = extension.roughnessFactor ?? 1;
    material.roughnessMap = null;
    if (extension.metallicRoughnessTexture !== undefined)
      await this.parser.assignTexture(material, "roughnessMap", extension.metallicRoughnessTexture);
    this.sharpen(material);
  }

  sharpen(material) {
    for (const map of Object.values(material))
      if (map?.isTexture) map.anisotropy = this.anisotropy;
  }
}
