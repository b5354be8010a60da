// SPDX-License-Identifier: Apache-2.0
// Takes the place of the npm package sharp in tests. glTF-Transform's functions import sharp but call it only to read
// or write pixels.
export default function sharp() {
  throw new Error("tests install no sharp: found a call that reads or writes pixels");
}
