// SPDX-License-Identifier: Apache-2.0
// Handles files that the user drops onto the page or opens with its button. Finds their type, and decodes .ndf.exr in a
// worker.
const FILE_BYTES_MAX = 256e6;
const DECODING_MS_MAX = 120000;
const NORMALS_APART_MAX = 0.1; // root mean square difference of x and y; different maps differ several times as much

/** Returns "exr", "ktx2", "glb", "gltf" or "image", by a file's first bytes. */
async function kindOf(file) {
  const head = new Uint8Array(await file.slice(0, 12).arrayBuffer());
  if (/^(\u00ef\u00bb\u00bf)?\s*\{/.test(String.fromCharCode(...head))) return "gltf";
  if (head[0] === 0x76 && head[1] === 0x2f && head[2] === 0x31) return "exr";
  if (new TextDecoder().decode(head.subarray(0, 4)) === "glTF") return "glb";
  return KTX2_IDENTIFIER[1] === head[1] && KTX2_IDENTIFIER[2] === head[2] ? "ktx2" : "image";
}

async function bytesOfFile(file) {
  if (file.size > FILE_BYTES_MAX)
    throw new Error(`found ${(file.size / 1e6).toFixed(0)} MB, expected at most ${FILE_BYTES_MAX / 1e6}`);
  return new Uint8Array(await file.arrayBuffer());
}

/** Runs decodeExr() of `source`, the text of look_exr.js, on `bytes` in a worker. `progress` gets done and total. */
function decodeInWorker(source, bytes, progress) {
  const url = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
  const worker = new Worker(url);
  let timer;
  return new Promise((resolve, reject) => {
    timer = setTimeout(() => reject(new Error(`is not decoded within ${DECODING_MS_MAX / 1000} s`)), DECODING_MS_MAX);
    worker.onerror = (event) => reject(new Error(errorText(event, "its decoding worker failed")));
    worker.onmessage = ({ data }) => {
      if (data.error !== undefined) reject(new Error(data.error));
      else if (data.decoded !== undefined) resolve(data.decoded);
      else progress(data.done, data.total);
    };
    worker.postMessage(bytes, [bytes.buffer]);
  }).finally(() => {
    clearTimeout(timer);
    worker.terminate();
    URL.revokeObjectURL(url);
  });
}

/** Returns x and y from an image's red and green, with +Y up. */
function normalsOfImage(image) {
  const { width, height } = image;
  const context = new OffscreenCanvas(width, height).getContext("2d");
  context.drawImage(image, 0, 0);
  const rgba = context.getImageData(0, 0, width, height).data;
  return normalsOfBytes(Uint8Array.from({ length: 2 * width * height }, (_, i) => rgba[4 * (i >> 1) + (i & 1)]));
}

/**
 * Returns the root mean square difference between x and y of `level`, a level of meanNormals(), and of `means`. First
 * multiplies the y of `level` by `sign`.
 */
function normalsApart(level, means, sign) {
  let sum = 0;
  for (let i = 0; i < means.length / 2; ++i)
    sum += (level.texels[4 * i] - means[2 * i]) ** 2 + (sign * level.texels[4 * i + 1] - means[2 * i + 1]) ** 2;
  return Math.sqrt(sum / means.length);
}

/**
 * Returns the image's x and y, with green flipped if it points down. `means` has x and y of level `level` of the lobes.
 * Throws if the image is not the lobes' map and `isStrict`.
 */
function matchingNormals(image, level, means, isStrict) {
  const normals = normalsOfImage(image);
  const averaged = meanNormals(image.width, image.height, normals)[level];
  const [up, down] = [1, -1].map((sign) => normalsApart(averaged, means, sign));
  if (isStrict && Math.min(up, down) > NORMALS_APART_MAX)
    throw new Error(`found normals that differ by ${Math.min(up, down).toFixed(2)} from those of the lobes, expected ` +
      `the map that the lobes were baked from (a difference of at most ${NORMALS_APART_MAX})`);
  if (down < up) for (let i = 1; i < normals.length; i += 2) normals[i] = -normals[i];
  return normals;
}

/** Passes files to `page`, a LookPage, by install(map) and setNormals(), and errors by say(). */
class Drops {
  constructor(page, workerSource) {
    this.page = page;
    this.workerSource = workerSource;
    this.unfinished = null; // a decoded file that waits for its map
    this.last = Promise.resolve(); // handles one file after another, in any order of arrival
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      this.take(event.dataTransfer.files);
    });
    byId("open").addEventListener("change", (event) => {
      this.take(event.target.files);
      event.target.value = "";
    });
  }

  /** Takes lobes before maps, because a map is compared with them. */
  take(files) {
    const list = [...files];
    this.last = this.last.then(async () => {
      const kinds = await Promise.all(list.map((file) => kindOf(file).catch(() => "image")));
      const order = ["exr", "ktx2", "image", "glb", "gltf"];
      say("");
      const { models, isCompanion } = await this.gltfModels(list, kinds);
      const sorted = list.map((file, i) => [file, kinds[i]]).filter(([file, kind]) => !isCompanion(file, kind))
        .sort((a, b) => order.indexOf(a[1]) - order.indexOf(b[1]));
      for (const [file, kind] of sorted) await this.takeOne(file, kind, models.get(file));
    });
    return this.last;
  }

  /**
   * Returns `models`, the JSON of each glTF or an Error if it is damaged, and `isCompanion`, a function that tells
   * whether a glTF uses a file. The files of a damaged glTF are unknown, so every
   * picture and every file of an unknown type then counts as used.
   */
  async gltfModels(list, kinds) {
    const models = new Map(), named = new Set();
    const files = new Map(list.map((file) => [file.name, file]));
    for (const [i, file] of list.entries()) {
      if (kinds[i] !== "gltf") continue;
      try {
        const json = parsedGltf(await bytesOfFile(file));
        for (const name of filesOfGltf(json)) named.add(name);
        models.set(file, { json, files });
      } catch (error) {
        models.set(file, { error });
      }
    }
    const isAnyDamaged = [...models.values()].some(({ error }) => error !== undefined);
    return { models, isCompanion: (file, kind) => kind === "image" && (isAnyDamaged || named.has(file.name)) };
  }

  async takeOne(file, kind, model) {
    const reading = byId("reading");
    reading.textContent = `Reading ${file.name} ...`;
    try {
      const progress = (share) => { reading.textContent = `Reading ${file.name}: ${share} %`; };
      if (kind === "exr") await this.takeExr(file, progress);
      else if (kind === "ktx2") this.page.setLobes(parseLobes(await bytesOfFile(file)));
      else if (kind === "glb") await this.takeModel(file.name, await bytesOfFile(file));
      else if (kind === "gltf") await this.takeGltf(file.name, model);
      else this.takeImage(await createImageBitmap(file, { colorSpaceConversion: "none", premultiplyAlpha: "none" }));
    } catch (error) {
      say(`${file.name}: ${errorText(error)}`);
    }
    reading.textContent = this.unfinished === null ? ""
      : `${this.unfinished.title} leaves level 0 to its normal map: drop that map too.`;
    this.page.change({});
  }

  async takeExr(file, progress) {
    const bytes = await bytesOfFile(file);
    const decoded = await decodeInWorker(this.workerSource, bytes, (done, total) =>
      progress(Math.floor((100 * done) / total)));
    const map = { ...decoded, title: file.name, about: `${file.name}, decoded here` };
    this.unfinished = decoded.normals === null ? map : null;
    if (this.unfinished === null) this.page.install(map);
  }

  async takeGltf(name, { json, files, error }) {
    if (error !== undefined) throw error;
    await this.takeModel(name, await glbOfGltf(json, files));
  }

  /** Draws with the lobes' own normal map if it has the size of their map, otherwise with the map on the page. */
  async takeModel(name, bytes) {
    const model = readModel(bytes, TARGET);
    this.page.setModel(model, name);
    if (model.image === null) return;
    const image = await createImageBitmap(model.image, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    const { width, height } = this.unfinished ?? this.page.means[0];
    if (image.width === width && image.height === height) this.takeImage(image);
  }

  takeImage(image) {
    const { page, unfinished } = this;
    const { width, height } = unfinished ?? page.means[0];
    if (image.width !== width || image.height !== height)
      throw new Error(`found ${image.width} x ${image.height}, expected ${width} x ${height}, the lobes' size`);
    if (unfinished !== null) {
      const { file, means } = unfinished;
      page.install({ ...unfinished, normals: matchingNormals(image, file.lobes.firstLevel, means, true) });
      this.unfinished = null;
    } else {
      const level = Math.min(3, page.means.length - 1), texels = page.means[level].texels;
      const means = Float32Array.from({ length: texels.length / 2 }, (_, i) => texels[4 * (i >> 1) + (i & 1)]);
      page.setNormals(width, height, matchingNormals(image, level, means, false));
      page.setLobes(page.file);
    }
  }
}
