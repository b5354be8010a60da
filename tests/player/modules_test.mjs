// SPDX-License-Identifier: Apache-2.0
// Tests in Node those modules of the player that do not need a browser: checksums, cameras and positions between
// samples, binary glTF, the memory budget, paths, and hostile descriptions and indices.
//
//   node modules_test.mjs [STEP [SEED]]
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { FieldError, UrlSource } from "../../runtime_gl/web/byte_source.js";
import { sectionChecksum } from "../../runtime_gl/web/checksum.js";
import { chunkHead } from "../../runtime_gl/web/chunk_head.js";
import { errorText } from "../../runtime_gl/web/error_text.js";
import { DrawingQuality } from "../../runtime_gl/web/drawing_quality.js";
import { FieldDescription } from "../../runtime_gl/web/field_description.js";
import { mappedCorners, readGlb } from "../../runtime_gl/web/glb.js";
import { cameraParts, identity, mixedCamera, mixedPlace, multiplied } from "../../runtime_gl/web/matrices.js";
import { MptFile } from "../../runtime_gl/web/mpt_file.js";
import { onNextFrame } from "../../runtime_gl/web/next_frame.js";
import { RecordedPath } from "../../runtime_gl/web/recorded_path.js";
import { TextureStore } from "../../runtime_gl/web/texture_store.js";
import { descriptionSection, fileOf } from "./mpt_writing.mjs";

const [only = "", seedText = String(Date.now() % 1e9)] = process.argv.slice(2);
let state = Number(seedText) >>> 0;
const random = () => { // This is a linear congruential generator, whose upper bits are random enough here.
  state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
  return state / 2 ** 32;
};
const among = (list) => list[Math.floor(random() * list.length)];
const near = (found, wanted, tolerance, what) => [...found].forEach((one, i) =>
  assert.ok(Math.abs(one - wanted[i]) <= tolerance, `${what}: ${[...found]}, expected ${[...wanted]}`));

const JUNK = [null, true, -1, 0, 1, 1.5, 7, 1e9, 1e300, "", "x", "__proto__", [], {}, [[]], [1, 2, 3, 4]];

/** Puts junk into up to three places, or removes values. */
function spoil(json) {
  for (let n = 1 + Math.floor(3 * random()); n > 0 && Object.keys(json).length > 0; --n) {
    let [place, key] = [json, among(Object.keys(json))];
    while (place[key] !== null && typeof place[key] === "object" && Object.keys(place[key]).length > 0 &&
        random() < 0.8)
      [place, key] = [place[key], among(Object.keys(place[key]))];
    if (random() < 0.2) delete place[key];
    else place[key] = structuredClone(among(JUNK)); // uses a clone, because otherwise an object might contain itself
  }
}

// ---- Matrices, column by column

const columns = (...rows) => Float64Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]);
const turned = (angle) => columns([Math.cos(angle), 0, Math.sin(angle), 0], [0, 1, 0, 0],
  [-Math.sin(angle), 0, Math.cos(angle), 0], [0, 0, 0, 1]);
const moved = (x, y, z) => columns([1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]);
/** An off-centre projection with OpenGL's near and far planes, and -s in the last row. */
const lens = (s = 1) => columns([2.1, 0, 0.3, 0], [0, 2.9, -0.2, 0], [0, 0, -1.02 * s, -0.2], [0, 0, -s, 0]);
/** The matrix of a camera at `eye` that is rotated by `angle`. */
const camera = (angle, eye, s) => multiplied(lens(s), multiplied(turned(-angle), moved(...eye.map((one) => -one))));

// ---- A binary glTF

function glb(json, binary) {
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc((4 - text.length % 4) % 4, 32)]);
  const word = (value) => {
    const bytes = Buffer.alloc(4);
    bytes.writeUInt32LE(value);
    return bytes;
  };
  const parts = [word(padded.length), word(0x4e4f534a), padded, word(binary.length), word(0x004e4942), binary];
  const length = 12 + parts.reduce((sum, part) => sum + part.length, 0);
  return Buffer.concat([word(0x46546c67), word(2), word(length), ...parts]);
}

/** A triangle, interleaved: positions, then texture coordinates as 16-bit integers; indices of one byte. */
function triangle() {
  const binary = Buffer.alloc(52);
  [[0, 0, 0], [1, 0, 0], [0, 2, 0]].forEach((position, i) => {
    position.forEach((one, c) => binary.writeFloatLE(one, 16 * i + 4 * c));
    [i * 16384, 65535].forEach((one, c) => binary.writeUInt16LE(one, 16 * i + 12 + 2 * c));
  });
  [2, 0, 1].forEach((one, i) => binary.writeUInt8(one, 48 + i));
  return { binary, json: {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }],
    nodes: [{ translation: [1, 2, 3], children: [1] },
      { name: "thing", mesh: 0, rotation: [0, Math.SQRT1_2, 0, Math.SQRT1_2], scale: [2, 2, 2] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_1: 1 }, indices: 2 }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3" },
      { bufferView: 0, byteOffset: 12, componentType: 5123, normalized: true, count: 3, type: "VEC2" },
      { bufferView: 1, componentType: 5121, count: 3, type: "SCALAR" }],
    bufferViews: [{ buffer: 0, byteLength: 48, byteStride: 16 }, { buffer: 0, byteOffset: 48, byteLength: 3 }],
    buffers: [{ byteLength: 52 }],
  } };
}

/** A valid description: three views by two lights, one object with a layer for all samples and one for each light. */
function description() {
  const views = [0, 1, 2].map((v) => [[1, 0, 0, v], [0, 1, 0, 0], [0, 0, -1, -0.1], [0, 0, -1, 2]]);
  const mapping = { linear: [1, 0, 0, 1], offset: [0, 0], hasCut: [false, true], cut: [0, 0.5], wrapS: "clamp",
    wrapT: "periodic", width: 20, height: 10 };
  return {
    geometry: "g.glb", geometryHash: "00", uvSet: 0, width: 32, height: 24, supersampling: 4,
    parameters: ["view", "light"], views, moves: [{}],
    samples: [0, 1, 2].flatMap((v) => [0, 1].map((l) => [`s${v}${l}`, [v, l], v, 0])),
    objects: [{ name: "a", mesh: "a", anisotropy: 1, mappings: [mapping], mappingOfSample: [0, 0, 0, 0, 0, 0],
      layers: [{ name: "diffuse", unseen: [1], blocks: [[[0, 0], [3, 2], [1]]] },
        { name: "all", unseen: [], blocks: [[[0, 0], [2, 2], [0, 1]], [[2, 0], [1, 2], [0, 1]]] }] }],
  };
}

// ---- Steps

const steps = {
  whateverIsThrownHasAText() {
    for (const [thrown, text] of [["why", "why"], [new Error(" why "), "why"],
      [{ message: "", error: new Error("inner") }, "inner"], [{ reason: "of a rejection" }, "of a rejection"],
      [{ reason: new TypeError("of one") }, "of one"], [new TypeError(""), "no reason (TypeError)"],
      [{ message: undefined }, "no reason"], [{ message: 7 }, "no reason"]])
      assert.equal(errorText(thrown, "no reason"), text);
    for (const thrown of [undefined, null, "", " ", 0, {}, [], Symbol("s"), new Error("")])
      assert.equal(errorText(thrown), "the browser gives no reason");
  },

  async whatIsDrawnWaitsForNoFrameForEver() {
    const names = ["document", "requestAnimationFrame", "cancelAnimationFrame"];
    const before = names.map((name) => globalThis[name]);
    const frames = [];
    const cancelled = [];
    Object.assign(globalThis, { document: { hidden: true }, cancelAnimationFrame: (frame) => cancelled.push(frame),
      requestAnimationFrame: (draw) => frames.push(draw) });
    const drawn = [];
    // Simulates a page that gets no animation frame.
    await new Promise((resolve) => onNextFrame((now) => { drawn.push(now); resolve(); }));
    assert.deepEqual(cancelled, [1]);
    onNextFrame((now) => drawn.push(now));
    frames[1](7); // simulates an animation frame with no timer after it
    onNextFrame((now) => drawn.push(now))(); // is cancelled
    await new Promise((resolve) => setTimeout(resolve, 120));
    assert.deepEqual([drawn.length, drawn[1]], [2, 7]);
    names.forEach((name, i) => { globalThis[name] = before[i]; });
  },

  checksumsAreThoseOfCrc64() {
    // The lower half of the check value of CRC-64/XZ.
    assert.equal(sectionChecksum(Buffer.from("123456789")), 0xdf1939fa);
    assert.equal(sectionChecksum(Buffer.alloc(0)), 0);
  },

  camerasAreTakenApartAndMixed() {
    for (let i = 0; i < 200; ++i) {
      const [angle, turn] = [6 * random(), 0.8 * random()];
      const eyes = [0, 1].map(() => [0, 1, 2].map(() => 10 * random() - 5));
      const s = 0.5 + random();
      const [from, to] = [camera(angle, eyes[0], s), camera(angle + turn, eyes[1], s)];
      near(cameraParts(from).eye, eyes[0], 1e-9, "the eye");
      const middle = mixedCamera([from, to], [0.5, 0.5]);
      near(middle, camera(angle + turn / 2, eyes[0].map((one, d) => (one + eyes[1][d]) / 2), s), 1e-9, "half way");
      assert.equal(mixedCamera([from, to], [1, 0]), from);
      near(mixedCamera([from, from], [0.3, 0.7]), from, 0, "of one camera");
    }
    const parallel = identity();
    assert.equal(cameraParts(parallel), null);
    near(mixedCamera([parallel, moved(1, 0, 0)], [0.6, 0.4]), parallel, 0, "what is no perspective: the nearer");
  },

  placesAreTurnedNotSheared() {
    const place = (angle, x) => multiplied(moved(x, 0, 0), multiplied(turned(angle), columns([3, 0, 0, 0], [0, 3, 0, 0],
      [0, 0, 3, 0], [0, 0, 0, 1])));
    for (const angle of [0, 1, 2.5])
      near(mixedPlace([place(angle, 0), place(angle + 1.5, 4)], [0.5, 0.5]), place(angle + 0.75, 2), 1e-9, "half way");
    const sheared = columns([1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]);
    near(mixedPlace([sheared, identity()], [0.5, 0.5]), columns([1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0],
      [0, 0, 0, 1]), 1e-12, "linearly");
  },

  glbIsRead() {
    const { json, binary } = triangle();
    const objects = readGlb(glb(json, binary), "t.glb", 1);
    assert.deepEqual([...objects.keys()], ["thing"]);
    const thing = objects.get("thing");
    near(thing.positions, [0, 2, 0, 0, 0, 0, 1, 0, 0], 0, "corners in the indices' order");
    near(thing.uvs, [32768 / 65535, 0, 0, 0, 16384 / 65535, 0], 1e-6, "texture coordinates, upwards");
    // The node is rotated by 90 degrees about y, so x goes to -z. The node is scaled by 2, and the parent moves it.
    const corner = [0, 1, 2].map((row) => thing.objectToWorld[row] + thing.objectToWorld[12 + row]);
    near(corner, [1, 2, 3 - 2], 1e-12, "where (1, 0, 0) is");
    for (const [change, pattern] of [
      [(one) => { one.meshes[0].primitives[0].attributes.TEXCOORD_1 = undefined; }, /no texture coordinates of set 1/],
      [(one) => { one.accessors[0].count = 1000; }, /accessors\[0\] extends beyond its buffer/],
      [(one) => { one.accessors[2].count = 2 ** 40; }, /beyond its buffer/],
      [(one) => { one.accessors[0].sparse = {}; }, /sparse/],
      [(one) => { one.nodes[1].children = [0]; }, /nodes\[0\] in two places, or inside itself/],
      [(one) => { one.nodes[1].rotation = ["x", 0, 0, 1]; }, /transform is not numeric/],
      [(one) => { one.extensionsRequired = ["KHR_draco_mesh_compression"]; }, /KHR_draco_mesh_compression/],
      [(one) => { one.nodes.push({ name: "thing", mesh: 0 }); one.scenes[0].nodes.push(2); }, /'thing' appears twice/],
      [(one) => { one.buffers[0].uri = "http://elsewhere/b.bin"; }, /other files/]]) {
      const changed = structuredClone(json);
      change(changed);
      assert.throws(() => readGlb(glb(changed, binary), "t.glb", 1), (error) => error instanceof FieldError &&
        error.message.startsWith("t.glb: ") && pattern.test(error.message), pattern);
    }
    const infinite = Buffer.from(binary);
    infinite.writeFloatLE(Infinity, 4);
    assert.throws(() => readGlb(glb(json, infinite), "t.glb", 1), /accessors\[0\] has a number that is not finite/);
    const cut = Buffer.from(binary);
    cut.writeUInt8(3, 49);
    assert.throws(() => readGlb(glb(json, cut), "t.glb", 1), /vertex 3, expected one below 3/);
  },

  /** Any glTF is either refused with a message, or has complete triangles. */
  glbOfStrangersDoesNotBreakIt() {
    let refused = 0;
    for (let i = 0; i < 20000; ++i) {
      const { json, binary } = triangle();
      spoil(json);
      try {
        for (const { positions, uvs, objectToWorld } of readGlb(glb(json, binary), "t.glb", 1).values()) {
          assert.ok(positions.length % 9 === 0 && uvs.length === positions.length / 3 * 2);
          assert.ok([...objectToWorld].every(Number.isFinite));
        }
      } catch (error) {
        assert.ok(error instanceof FieldError && error.message.startsWith("t.glb: "), error.stack);
        ++refused;
      }
    }
    assert.ok(refused > 5000, `${refused} were refused`);
  },

  cutsGoToTheTrianglesSide() {
    const mapping = { linear: [0.5, 0, 0, 2], offset: [0.25, 0], hasCut: [true, false], cut: [0.6, 0] };
    // One triangle is left of the cut, and one is right of it. Neither triangle is split.
    near(mappedCorners([0.1, 0, 0.2, 0, 0.3, 1, 0.7, 0, 0.8, 0, 0.9, 1], mapping),
      [0.8, 0, 0.85, 0, 0.9, 2, 0.6, 0, 0.65, 0, 0.7, 2], 1e-6, "mapped");
  },

  theBudgetIsNeverExceeded() {
    for (let round = 0; round < 50; ++round) {
      const budget = 100 + Math.floor(900 * random());
      let held = 0;
      const store = new TextureStore(budget, (entry) => { held -= entry.bytes; });
      const needed = new Set();
      for (let i = 0; i < 500; ++i) {
        const key = `k${Math.floor(30 * random())}`;
        const bytes = Math.floor(200 * random());
        if (random() < 0.2) needed.add(key);
        if (random() < 0.2) needed.clear();
        if (random() < 0.02) store.setBudget(budget * (0.5 + random()));
        if (store.get(key) === undefined) {
          const before = [...needed].filter((one) => store.has(one));
          if (store.makeRoom(bytes, (one) => needed.has(one))) {
            store.put(key, { bytes });
            held += bytes;
          }
          for (const one of before) assert.ok(store.has(one), "a needed texture was released");
        }
        assert.ok(store.bytes <= store.budget && store.bytes === held, `${store.bytes}, ${held} of ${store.budget}`);
      }
      store.clear();
      assert.equal(held, 0);
    }
    const store = new TextureStore(10, () => {});
    for (const key of ["a", "b"]) store.put(key, { bytes: 5 });
    store.get("a");
    assert.ok(store.makeRoom(5, () => false));
    assert.deepEqual([store.has("a"), store.has("b")], [true, false], "the least recently used must go first");
  },

  pathsGoThroughTheirPositions() {
    const path = new RecordedPath(["a"]);
    for (const [t, at] of [[0, 1], [0.01, 9], [1, 2], [3, 0]]) path.add(t, [at]);
    assert.deepEqual(path.positions, [[0, 1], [1, 2], [3, 0]], "not every frame");
    near([0, 0.5, 1, 2, 2.999, 3, 3.5].map((t) => path.at(t)[0]), [1, 1.5, 2, 1, 0.001, 1, 1.5], 1e-9, "places");
    assert.deepEqual(RecordedPath.parse(path.text(), ["a"]).positions, path.positions);
    const file = readFileSync(new URL("recorded_path.json", import.meta.url), "utf8"); // as in recorded_path_test.cpp
    const kept = RecordedPath.parse(file, ["view", "light"]);
    for (const [t, at] of [[0, [0, 1]], [0.25, [0.5, 1]], [0.5, [2, 0]], [1.5, [1, 0.25]], [2.5, [0, 1]],
      [2.75, [0.5, 1]]])
      near(kept.at(t), at, 1e-12, `${t} s`);
    const tour = RecordedPath.tour(["a", "b"], [5, 1]);
    for (let t = 0; t < 30; t += 0.37) {
      const [a, b] = tour.at(t);
      assert.ok(a >= 0 && a <= 4 && b === 0);
    }
  },

  fewerSubPixelsAreDrawnWhereFramesAreSlow() {
    const quality = new DrawingQuality(4);
    let now = 1e6;
    // Simulates frames that take 10 ms, plus `ms` for each sub-pixel per pixel.
    const move = (ms, frames) => {
      const sides = [];
      for (let i = 0; i < frames; ++i) {
        now += Math.max(16.7, 10 + ms * quality.side ** 2);
        quality.frame(now);
        sides.push(quality.side);
      }
      return sides;
    };
    assert.deepEqual(new Set(move(0.1, 100)), new Set([4]), "a fast machine uses the finest images");
    const slow = move(30, 40); // frames first take 490 ms, which gives fewer than 3 frames per second
    assert.equal(slow.at(-1), 1);
    assert.ok(slow.indexOf(1) < 10, `${slow}`);
    assert.ok(Math.abs(quality.framesPerSecond - 25) < 1, `${quality.framesPerSecond}`);
    now += 1e5; // a pause does not count as a slow frame
    quality.frame(now);
    assert.ok(quality.framesPerSecond > 20);
    assert.equal(move(0.1, 60).at(-1), 4, "fast again");
  },

  headsOfChunksAreRead() {
    assert.deepEqual(chunkHead(Uint8Array.from([0, 0xd8, 6, 0x81, 1, 2, 4, 3, 0x80, 2])), { width: 856, height: 129,
      textures: 768 });
    assert.deepEqual(chunkHead(new Uint8Array(0)), { width: 0, height: 0, textures: 0 });
  },

  descriptionsSayWhichTextureASampleHas() {
    const read = new FieldDescription(description(), "f.mpt");
    const [diffuse, all] = read.layers;
    const keys = (layer) => read.samples.map((_, i) => read.textureOf(layer, i)?.key ?? null);
    assert.deepEqual(keys(diffuse), ["0:0:0", null, "0:0:0", "0:0:1", "0:0:0", "0:0:1"]);
    assert.deepEqual(keys(all), ["1:0:0", "1:0:1", "1:0:2", "1:0:3", "1:1:0", "1:1:1"]);
    assert.deepEqual(all.blocks.map(({ textures }) => textures), [4, 2]);
    assert.equal(read.sampleAt([2, 1]), 5);
  },

  async requestsAreTriedAgain() {
    const bytes = Uint8Array.from({ length: 100 }, (_, i) => i);
    const { fetch: realFetch, setTimeout: realTimeout } = globalThis;
    // 20 s without an answer take 20 ms in this test.
    globalThis.setTimeout = (run, ms, ...more) => realTimeout(run, ms / 1000, ...more);
    const part = (range, more = {}) => {
      const [, first, last] = /^bytes=(\d+)-(\d+)$/.exec(range).map(Number);
      const body = bytes.slice(first, last + 1);
      return new Response(more.body ?? body, { status: 206,
        headers: { "Content-Range": `bytes ${more.first ?? first}-${last}/${more.size ?? 100}` } });
    };
    const silent = (signal, begin = []) => new ReadableStream({ start(controller) {
      if (begin.length > 0) controller.enqueue(Uint8Array.from(begin));
      signal.addEventListener("abort", () => controller.error(new Error("aborted")));
    } });
    const never = (signal) => new Promise((_, reject) => {
      signal.addEventListener("abort", () => reject(new Error("aborted")));
    });
    const read = async (answers, signal) => {
      const counts = { fetched: 0, retries: 0 };
      let count = 0;
      globalThis.fetch = async (_, { headers, signal: own }) => {
        if (own.aborted) throw new Error("aborted");
        return answers[Math.min(count++, answers.length - 1)](headers.Range, own);
      };
      const found = await new UrlSource("http://x/a%20b.mpt", counts).read(10, 20, signal);
      return { found, counts };
    };
    const bad = {
      unreachable: () => { throw new TypeError("failed"); },
      mute: (_, signal) => never(signal),
      silent: (range, signal) => part(range, { body: silent(signal, [10, 11]) }),
      short: (range) => part(range, { body: bytes.slice(10, 15) }),
      busy: () => new Response("", { status: 503 }),
    };
    try {
      for (const [name, answer] of Object.entries(bad)) {
        const { found, counts } = await read([answer, answer, (range) => part(range)]);
        assert.deepEqual(found, bytes.slice(10, 30), name);
        assert.equal(counts.retries, 2, name);
        await assert.rejects(read([answer]), (error) => error instanceof FieldError &&
          /^a b\.mpt: .*(reached|cut after \d of 20 bytes|answered 503).*; tried 4 times$/.test(error.message), name);
      }
      for (const [answer, pattern] of [
        [(range) => part(range, { first: 11 }), /another range/],
        [() => new Response("", { status: 416 }), /ends before byte 10/],
        [() => new Response("", { status: 404 }), /answered 404, expected 200 or 206/]])
        await assert.rejects(read([answer]), pattern);
      const whole = await read([() => new Response(bytes)]);
      assert.deepEqual(whole.found, bytes.slice(10, 30));
      const counts = { fetched: 0, retries: 0 };
      const source = new UrlSource("http://x/y", counts);
      globalThis.fetch = async (_, { headers }) => part(headers.Range);
      await source.read(0, 5);
      globalThis.fetch = async (_, { headers }) => part(headers.Range, { size: 120 });
      await assert.rejects(source.read(5, 5), /has 120 bytes now, had 100 before/);
      // A cancelled request does not wait for anything.
      const abort = new AbortController();
      realTimeout(() => abort.abort(), 5);
      await assert.rejects(read([bad.mute], abort.signal), (error) => !(error instanceof FieldError));
    } finally {
      Object.assign(globalThis, { fetch: realFetch, setTimeout: realTimeout });
    }
  },

  /** Any description is either refused with a message, or has everything that playing needs. */
  async descriptionsOfStrangersDoNotBreakIt() {
    let refused = 0;
    for (let i = 0; i < 20000; ++i) {
      const json = description();
      spoil(json);
      try {
        const read = new FieldDescription(JSON.parse(JSON.stringify(json)), "f.mpt");
        for (const layer of read.layers)
          for (let sample = 0; sample < read.samples.length; ++sample) {
            const texture = read.textureOf(layer, sample);
            assert.ok(texture === null || (texture.texture < texture.block.textures && texture.block.mapping !== null));
            assert.ok(layer.object.mappings[layer.object.mappingOfSample[sample]] !== undefined);
          }
        assert.ok(read.samples.every(({ worldToClip }) => worldToClip.every(Number.isFinite)));
      } catch (error) {
        assert.ok(error instanceof FieldError && error.message.startsWith("f.mpt: its description is damaged: "),
          error.stack);
        ++refused;
      }
    }
    assert.ok(refused > 10000, `${refused} were refused`);
  },

  /** Any file is read or refused with a message. Bytes change, are cut or doubled, and some checksums are corrected. */
  async filesOfStrangersDoNotBreakIt() {
    const sound = fileOf([descriptionSection(description()), { kind: 1, layer: 0, block: 0, bytes: Buffer.from("abc") },
      { kind: 7, layer: 0, block: 0, bytes: Buffer.alloc(10) }]);
    const source = (bytes) => ({ name: "f.mpt", size: bytes.length,
      read: async (offset, length) => Uint8Array.from(bytes.subarray(offset, offset + length)) });
    const file = await MptFile.open(source(sound));
    assert.equal(new FieldDescription(await file.descriptionObject(), "f.mpt").samples.length, 6);
    assert.equal(Buffer.from(await file.section(file.chunks.get("0:0"), "chunk")).toString(), "abc");
    let refused = 0;
    const rounds = 3000;
    for (let i = 0; i < rounds; ++i) {
      let bytes = Buffer.from(sound);
      const at = Math.floor(random() * (random() < 0.5 ? 60 : bytes.length));
      if (random() < 0.7) bytes[at] ^= 1 << Math.floor(8 * random());
      else if (random() < 0.5) bytes = bytes.subarray(0, at);
      else bytes = Buffer.concat([bytes.subarray(0, at), bytes.subarray(at >> 1)]);
      if (random() < 0.5 && bytes.length > 13) { // and corrects the checksum of the index
        const end = 9 + bytes.readUInt32LE(5);
        if (end + 4 <= bytes.length) bytes.writeUInt32LE(sectionChecksum(bytes.subarray(0, end)), end);
      }
      try {
        const opened = await MptFile.open(source(bytes));
        new FieldDescription(await opened.descriptionObject(), "f.mpt");
        for (const section of opened.chunks.values()) await opened.section(section, "chunk");
      } catch (error) {
        assert.ok(error instanceof FieldError && error.message.startsWith("f.mpt: "), error.stack);
        ++refused;
      }
    }
    assert.ok(refused > 0.8 * rounds, `${refused} of ${rounds} were refused`);
  },
};

for (const [name, step] of Object.entries(steps)) {
  if (!name.includes(only)) continue;
  try {
    await step();
    console.log(`ok ${name}`);
  } catch (error) {
    console.log(`FAILED ${name}, seed ${seedText}: ${error.stack}`);
    process.exitCode = 1;
  }
}
