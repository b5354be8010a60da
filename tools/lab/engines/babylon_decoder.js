// SPDX-License-Identifier: Apache-2.0
// Decodes KTX2 files for Babylon.js with the transcoder of three.js. Babylon's own decoder exists only on its servers,
// not in the package babylonjs. The page loads basis_levels.js before.
globalThis.KTX2DECODER = { MSCTranscoder: {}, WASMMemoryManager: {}, Transcoder: {}, ZSTDDecoder: {},
  KTX2Decoder: class {
    async decode(bytes) {
      const { width, height, levels } = await globalThis.basisLevels(bytes), kRgba8 = 0x8058;
      return { width, height, transcodedFormat: kRgba8, isInGammaSpace: false, hasAlpha: false,
        transcoderName: "basis_transcoder of three.js", mipmaps: levels };
    }
  } };
