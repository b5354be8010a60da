// SPDX-License-Identifier: Apache-2.0
// Types of @multum/gltf-transform. README.md describes the package.
import { Extension, ExtensionProperty, PropertyType, Texture, TextureInfo } from "@gltf-transform/core";
import type { IProperty, Nullable, ReaderContext, WriterContext } from "@gltf-transform/core";

interface ILobes extends IProperty {
  image: Uint8Array;
  colours: Uint8Array;
}

interface IMaterialLobes extends IProperty {
  lobes: Lobes;
  roughnessFactor: number;
  metallicRoughnessTexture: Texture;
  metallicRoughnessTextureInfo: TextureInfo;
}

/** The lobes of a normal map, and their colours if they have any. */
export declare class Lobes extends ExtensionProperty<ILobes> {
  static EXTENSION_NAME: "MULTUM_lobes";
  extensionName: "MULTUM_lobes";
  propertyType: "Lobes";
  parentTypes: [];
  protected init(): void;
  protected getDefaults(): Nullable<ILobes>;
  /** Returns the bytes of the lobe texture, a KTX2 file. */
  getImage(): Uint8Array | null;
  setImage(bytes: Uint8Array): this;
  /** Returns the bytes of the texture of tints, a KTX2 file, or null if all lobes have the base colour. */
  getColours(): Uint8Array | null;
  setColours(bytes: Uint8Array | null): this;
}

/** The lobes of a material, and the roughness of its surface itself, which replaces the roughness of the material. */
export declare class MaterialLobes extends ExtensionProperty<IMaterialLobes> {
  static EXTENSION_NAME: "MULTUM_lobes";
  extensionName: "MULTUM_lobes";
  propertyType: "MaterialLobes";
  parentTypes: [PropertyType.MATERIAL];
  protected init(): void;
  protected getDefaults(): Nullable<IMaterialLobes>;
  getLobes(): Lobes | null;
  setLobes(lobes: Lobes | null): this;
  /** Returns a factor between 0 and 1; the default is 1. */
  getRoughnessFactor(): number;
  setRoughnessFactor(factor: number): this;
  /** Returns the texture whose green channel is the roughness. */
  getMetallicRoughnessTexture(): Texture | null;
  /** Returns coordinates and wrap modes of the texture, or null if there is no texture. */
  getMetallicRoughnessTextureInfo(): TextureInfo | null;
  setMetallicRoughnessTexture(texture: Texture | null): this;
}

/** Reads and writes MULTUM_lobes. Register the class with NodeIO or WebIO. */
export declare class MultumLobes extends Extension {
  static readonly EXTENSION_NAME: "MULTUM_lobes";
  readonly extensionName: "MULTUM_lobes";
  readonly prereadTypes: PropertyType[];
  readonly prewriteTypes: PropertyType[];
  createLobes(): Lobes;
  createMaterialLobes(): MaterialLobes;
  preread(context: ReaderContext, type: PropertyType): this;
  read(context: ReaderContext): this;
  prewrite(context: WriterContext, type: PropertyType): this;
  write(context: WriterContext): this;
}
