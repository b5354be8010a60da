// SPDX-License-Identifier: Apache-2.0
// Reads the levels of KTX2 files in Basis Universal formats with the transcoder of three.js, which must be loaded as
// the global BASIS.
let basis;

/** Returns { width, height, levels: [{ width, height, data }] } with RGBA bytes. */
globalThis.basisLevels = async (bytes) => {
  basis ??= BASIS({ locateFile: (name) => `/three/examples/jsm/libs/basis/${name}` }).then((made) => {
    made.initializeBasis();
    return made;
  });
  const { KTX2File } = await basis, file = new KTX2File(new Uint8Array(bytes)), levels = [], kRgba32 = 13;
  if (!file.isValid() || !file.startTranscoding()) throw new Error("not a KTX2 file of Basis Universal");
  for (let level = 0; level < file.getLevels(); ++level) {
    const { origWidth: width, origHeight: height } = file.getImageLevelInfo(level, 0, 0);
    const data = new Uint8Array(file.getImageTranscodedSizeInBytes(level, 0, 0, kRgba32));
    if (!file.transcodeImage(data, level, 0, 0, kRgba32, 0, -1, -1)) throw new Error(`cannot transcode level ${level}`);
    levels.push({ width, height, data });
  }
  const size = { width: file.getWidth(), height: file.getHeight() };
  file.close();
  file.delete();
  return { ...size, levels };
};
