// SPDX-License-Identifier: Apache-2.0
// Decodes the levels of a KTX2 file, given in base64, with the transcoder of three.js.
async function levels(text) {
  const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
  return (await globalThis.basisLevels(bytes)).levels.map(({ data }) => {
    let made = "";
    for (const byte of data) made += String.fromCharCode(byte);
    return btoa(made);
  });
}

globalThis.engine = { levels };
