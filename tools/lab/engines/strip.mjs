// SPDX-License-Identifier: Apache-2.0
// Draws the pictures of an engine next to each other, with labels.
import { Buffer } from "node:buffer";
import { toByte } from "../../../tests/three/linear_pictures.js";
import { open } from "./browser.mjs";
import { VIEW } from "./engine_list.mjs";

/** Returns a JPEG. `near` and `far` are pictures of the original and of multum's model, as RGBA bytes. */
export async function stripOf(browser, server, title, { near, far, reference }) {
  const { side, crop } = VIEW, base64 = (bytes) => Buffer.from(bytes).toString("base64");
  const referenceBytes = Uint8Array.from({ length: 4 * crop ** 2 }, (_, i) =>
    (i % 4 === 3 ? 255 : toByte(reference[3 * Math.floor(i / 4) + i % 4])));
  const shown = [["original, near", near[0], side], ["multum, near", near[1], side], ["original, far", far[0], side],
    ["multum, far", far[1], side], ["reference, far", referenceBytes, crop]].map(([label, bytes, width]) =>
    ({ label, bytes: base64(bytes), width, crop: label.endsWith("far") ? crop : side }));
  const { page } = await open(browser, server, { module: "/engines/strip_page.js" });
  const text = await page.evaluate(([name, pictures, size]) => globalThis.engine.strip(name, pictures, size),
    [title, shown, side]);
  await page.close();
  return Buffer.from(text, "base64");
}
