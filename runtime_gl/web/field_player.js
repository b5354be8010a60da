// SPDX-License-Identifier: Apache-2.0
// Plays a field. Finds the textures that a position in its parameters needs, fetches and decodes textures ahead, and
// draws while some are missing. A position between samples is drawn as their weighted mean (multilinear), or as the
// nearest sample.
import { DecodingPool } from "./decoding_pool.js";
import { DrawingQuality } from "./drawing_quality.js";
import { errorText } from "./error_text.js";
import { mappedCorners } from "./glb.js";
import { mixedCamera, mixedPlace, multiplied } from "./matrices.js";
import { onNextFrame } from "./next_frame.js";
import { PlayerGl, textureBytes } from "./player_gl.js";
import { TextureStore } from "./texture_store.js";

const REST_MS = 250; // after this time without movement, a picture is drawn with the description's quality
const AHEAD_SHARE = 0.8; // share of the budget for textures that are decoded before they are needed
const CORNERS_MAX = 4; // most samples that a picture mixes, because texture units are few

export class FieldPlayer {
  /**
   * `file` is an MptFile, and `objects` come from readGlb. `startWorkers` is { count, makeWorker, wasm }. `budget`
   * limits the bytes of textures and compressed chunks. `say` is called with problems, and `changed` after each
   * picture. `showLoss(isLost)` is called when the graphics context is lost, and when it is back.
   */
  constructor({ canvas, file, description, objects, startWorkers, budget, counts, say, changed, showLoss }) {
    Object.assign(this, { canvas, file, description, objects, counts, say, changed });
    this.position = description.sizes.map(() => 0);
    this.velocity = description.sizes.map(() => 0);
    this.isSmooth = true;
    this.isFull = true; // draws all sub-pixels at rest
    this.exposure = 1;
    this.cancelFrame = null; // set while a picture waits to be drawn
    this.movedAt = -Infinity;
    this.hasMoved = true; // true if the position has moved since the last picture
    this.failed = new Set(); // names of chunks that are damaged or cannot be fetched
    this.refused = new Set(); // keys of textures that do not fit into the budget
    this.statistics = { frames: 0, decoded: 0, decodeMs: 0, misses: 0 };
    this.meshesDrawn = new Set(); // keys of textures in the last picture
    this.store = new TextureStore(budget, (entry) => this.release(entry));
    this.checkObjects();
    this.startGl();
    this.pool = new DecodingPool({
      ...startWorkers, fetchSection: (wish, signal) => this.section(wish, signal),
      deliver: (wish, levels, ms) => this.deliver(wish, levels, ms), fail: (wish, error) => this.fail(wish, error),
    });
    this.lastDrawn = new Map(); // keys of textures by layer
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault(); // otherwise the context never comes back
      showLoss(true);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      const { release } = this.store; // the old context's textures are gone
      this.store.release = () => {};
      this.store.clear();
      this.store.release = release;
      this.lastDrawn.clear();
      this.startGl();
      this.moveTo(this.position);
      showLoss(false);
    });
    this.moveTo(this.position);
  }

  checkObjects() {
    for (const { mesh } of this.description.objects)
      if (!this.objects.has(mesh))
        throw new Error(`the geometry has no object '${mesh}'; it has ${[...this.objects.keys()].join(", ")}`);
  }

  startGl() {
    this.gl = new PlayerGl(this.canvas);
    this.finest = this.gl.affordable(this.description.width, this.description.height, this.description.supersampling);
    this.quality = new DrawingQuality(this.finest);
    this.places = this.description.objects.map((object) => {
      const { positions } = this.objects.get(object.mesh);
      return { buffer: this.gl.makeBuffer(new Float32Array(positions)), count: positions.length / 3 };
    });
  }

  release({ texture, mesh, uvs }) {
    const { gl } = this.gl;
    if (texture) gl.deleteTexture(texture);
    if (mesh) gl.deleteVertexArray(mesh.array);
    if (uvs) gl.deleteBuffer(uvs);
  }

  // ---- The position

  /** Sets the fractional index along each parameter, clamped to the grid. */
  moveTo(at) {
    const now = performance.now();
    const place = this.description.sizes.map((size, d) => Math.min(size - 1, Math.max(0, Number(at[d]) || 0)));
    this.velocity = place.map((one, d) => one - this.position[d]);
    if (this.velocity.some((one) => one !== 0)) {
      this.movedAt = now;
      this.hasMoved = true;
    }
    this.position = place;
    this.refused.clear();
    this.want();
    this.requestDraw();
  }

  nearest() { return this.description.sampleAt(this.position.map((one) => Math.round(one))); }

  /** Returns the samples that the picture mixes, with weights that sum to 1. The largest weight is first. */
  corners() {
    if (!this.isSmooth) return [{ sample: this.nearest(), weight: 1 }];
    let corners = [{ at: [], weight: 1 }];
    for (const one of this.position) {
      const low = Math.floor(one);
      const share = one - low;
      corners = corners.flatMap(({ at, weight }) => [{ at: [...at, low], weight: weight * (1 - share) },
        ...(share > 0 ? [{ at: [...at, low + 1], weight: weight * share }] : [])]);
    }
    corners = corners.sort((a, b) => b.weight - a.weight).slice(0, CORNERS_MAX);
    const sum = corners.reduce((total, { weight }) => total + weight, 0);
    return corners.map(({ at, weight }) => ({ sample: this.description.sampleAt(at), weight: weight / sum }));
  }

  setBudget(bytes) {
    this.store.setBudget(bytes);
    this.refused.clear();
    this.want();
    this.requestDraw();
  }

  setSmooth(isSmooth) {
    this.isSmooth = isSmooth;
    this.moveTo(this.position);
  }

  setFull(isFull) {
    this.isFull = isFull;
    this.requestDraw();
  }

  /** Retries everything that failed. */
  retry() {
    this.failed.clear();
    this.want();
    this.requestDraw();
  }

  // ---- Textures

  texturesOf(sample) {
    return this.description.layers.map((layer) => this.description.textureOf(layer, sample))
      .filter((one) => one !== null && !this.failed.has(this.chunkName(one)));
  }
  chunkName({ layer, block }) { return `${layer.number}:${block.number}`; }

  wishOf(texture) {
    const { layer, block } = texture;
    const { width, height } = block.mapping;
    return { key: texture.key, chunk: this.chunkName(texture), texture: texture.texture, textures: block.textures,
      width, height, layer, block };
  }

  /** Returns the samples next to the nearest one. The first is in the direction of movement along all parameters. */
  neighbours() {
    const { description, velocity } = this;
    const at = this.position.map((one) => Math.round(one));
    const next = at.map((one, d) => Math.min(description.sizes[d] - 1, Math.max(0, one + Math.sign(velocity[d]))));
    const found = [{ ahead: Infinity, sample: description.sampleAt(next) }];
    at.forEach((one, d) => {
      for (const step of [1, -1]) {
        const there = one + step;
        if (there < 0 || there >= description.sizes[d]) continue;
        found.push({ ahead: step * velocity[d], sample: description.sampleAt(at.with(d, there)) });
      }
    });
    return found.sort((a, b) => b.ahead - a.ahead).map(({ sample }) => sample);
  }

  want() {
    this.needed = new Map();
    for (const { sample } of this.corners())
      for (const texture of this.texturesOf(sample)) this.needed.set(texture.key, texture);
    const wanted = new Map(this.needed);
    let bytes = [...wanted.values()].reduce((sum, one) => sum + this.bytesOf(one), 0);
    for (const sample of this.neighbours())
      for (const texture of this.texturesOf(sample)) {
        if (wanted.has(texture.key)) continue;
        bytes += this.bytesOf(texture);
        if (bytes > AHEAD_SHARE * this.store.budget) break;
        wanted.set(texture.key, texture);
      }
    this.wanted = wanted;
    for (const [key, texture] of wanted) if (this.bytesOf(texture) > this.store.budget) this.refused.add(key);
    const missing = [...wanted.values()].filter(({ key }) =>
      this.store.get(key) === undefined && !this.refused.has(key));
    this.pool?.want(missing.map((texture) => this.wishOf(texture)));
  }

  bytesOf({ block: { mapping } }) { return textureBytes(mapping.width, mapping.height); }

  async section(wish, signal) {
    const key = `section ${wish.chunk}`;
    const kept = this.store.get(key);
    if (kept !== undefined) return kept.section;
    const section = this.file.chunks.get(wish.chunk);
    if (section === undefined) throw new Error(`${this.file.source.name}: has no chunk for ${this.nameOf(wish)}`);
    const bytes = await this.file.section(section, this.nameOf(wish), signal);
    if (!this.store.has(key) && this.store.makeRoom(bytes.length, (one) => this.isHeld(one)))
      this.store.put(key, { bytes: bytes.length, section: bytes });
    return bytes;
  }

  nameOf({ layer, block }) { return `layer '${layer.name}' of object '${layer.object.name}', block ${block.number}`; }

  /** Returns whether a key is in the current or next picture, and so must not be removed for others. */
  isHeld(key) { return this.needed.has(key) || this.meshesDrawn.has(key); }

  deliver(wish, levels, ms) {
    ++this.statistics.decoded;
    this.statistics.decodeMs += 0.1 * (ms - this.statistics.decodeMs);
    const bytes = textureBytes(wish.width, wish.height);
    if (this.store.has(wish.key) || !this.wanted.has(wish.key)) return;
    const isAhead = !this.needed.has(wish.key);
    if (!this.store.makeRoom(bytes, (key) => this.isHeld(key) || (isAhead && this.wanted.has(key)))) {
      this.refused.add(wish.key);
      this.requestDraw();
      return;
    }
    const texture = this.gl.makeTexture(levels, wish.block.mapping, wish.layer.object.anisotropy);
    this.store.put(wish.key, { bytes, texture });
    if (this.needed.has(wish.key)) this.requestDraw();
  }

  fail(wish, error) {
    if (wish !== null) {
      this.failed.add(wish.chunk);
      for (const key of this.needed.keys()) if (key.startsWith(`${wish.chunk}:`)) this.needed.delete(key);
      const name = this.file.source.name;
      const reason = errorText(error);
      const text = reason.startsWith(name) ? reason : `${name}: ${this.nameOf(wish)}: ${reason}`;
      this.say(`${text}. The rest is played without it.`);
    } else {
      this.say(errorText(error));
    }
    this.requestDraw();
  }

  /** Returns whether all textures of the current picture are present or cannot be loaded. */
  get isComplete() {
    return [...this.needed.keys()].every((key) => this.store.has(key) || this.refused.has(key));
  }

  // ---- Drawing

  requestDraw() {
    if (this.cancelFrame !== null) return;
    this.cancelFrame = onNextFrame((now) => {
      this.cancelFrame = null;
      // Browsers accept some pictures before a slow driver has drawn them. Such pictures would be shown late, and the
      // times measured for them would be too short.
      if (this.gl.isBusy()) this.requestDraw();
      else this.drawNow(now);
    });
  }

  meshOf(i, mapping) {
    const key = `mesh ${i}:${mapping}`;
    this.meshesDrawn.add(key);
    const kept = this.store.get(key);
    if (kept !== undefined) return kept.mesh;
    const object = this.description.objects[i];
    const { uvs } = this.objects.get(object.mesh);
    const bytes = 4 * uvs.length;
    if (!this.store.makeRoom(bytes, (one) => this.isHeld(one))) return null;
    const buffer = this.gl.makeBuffer(mappedCorners(uvs, object.mappings[mapping]));
    const mesh = this.gl.makeMesh(this.places[i].buffer, buffer, this.places[i].count);
    this.store.put(key, { bytes, mesh, uvs: buffer });
    return mesh;
  }

  /** Adds the loaded textures of a layer to `drawn`. Returns false if a texture that should be loaded is missing. */
  addLayer(layer, corners, mapping, drawn) {
    const { mappingOfSample } = layer.object;
    const shares = new Map(); // weights by key
    let isAllThere = true;
    for (const { sample, weight } of corners) {
      const texture = this.description.textureOf(layer, sample);
      if (texture === null || mappingOfSample[sample] !== mapping || this.failed.has(this.chunkName(texture))) continue;
      if (this.store.get(texture.key)) shares.set(texture.key, weight + (shares.get(texture.key) ?? 0));
      else isAllThere = false;
    }
    let entries = [...shares];
    if (entries.length === 0 && !isAllThere) // keeps the last textures, which is better than drawing none
      entries = (this.lastDrawn.get(layer)?.entries ?? []).filter(([key]) =>
        this.lastDrawn.get(layer).mapping === mapping && this.store.get(key));
    const sum = entries.reduce((total, [, weight]) => total + weight, 0);
    for (const [key, weight] of entries) {
      drawn.textures.push(this.store.get(key).texture);
      drawn.weights.push(weight / sum);
    }
    this.lastDrawn.set(layer, { entries, mapping });
    return isAllThere;
  }

  drawnObjects() {
    const { samples } = this.description;
    const corners = this.corners();
    const weights = corners.map(({ weight }) => weight);
    const worldToClip = mixedCamera(corners.map(({ sample }) => samples[sample].worldToClip), weights);
    const [{ sample: main }] = corners;
    let isAllThere = true;
    this.meshesDrawn.clear();
    const objects = this.description.objects.map((object, i) => {
      const { objectToWorld } = this.objects.get(object.mesh);
      const place = mixedPlace(corners.map(({ sample }) => samples[sample].moved.get(object.mesh) ?? objectToWorld),
        weights);
      const mapping = object.mappingOfSample[main];
      const drawn = { mesh: this.meshOf(i, mapping), objectToClip: multiplied(worldToClip, place), textures: [],
        weights: [] };
      for (const layer of object.layers) isAllThere = this.addLayer(layer, corners, mapping, drawn) && isAllThere;
      drawn.textures.splice(this.gl.unitsMax);
      drawn.weights.splice(this.gl.unitsMax);
      return drawn;
    });
    return { objects: objects.filter(({ mesh }) => mesh !== null), isAllThere };
  }

  drawNow(now = performance.now()) {
    if (this.gl.gl.isContextLost()) return;
    const begun = performance.now();
    const isAtRest = !this.hasMoved && begun - this.movedAt > REST_MS;
    if (this.hasMoved) this.quality.frame(now);
    this.hasMoved = false;
    const supersampling = isAtRest && this.isFull ? this.finest : this.quality.side;
    const { objects, isAllThere } = this.drawnObjects();
    const { width, height } = this.description;
    const hasOneLevel = !isAtRest && supersampling < this.finest; // the device is slow, and a fine picture follows soon
    this.gl.draw({ width, height, supersampling, exposure: this.exposure, objects, hasOneLevel });
    if (!isAllThere) ++this.statistics.misses;
    ++this.statistics.frames;
    this.statistics.supersampling = supersampling;
    this.isSettled = isAtRest && this.isComplete;
    // Draws with full quality when the position rests.
    clearTimeout(this.restTimer);
    if (!isAtRest) this.restTimer = setTimeout(() => this.requestDraw(), REST_MS + 20);
    this.changed();
  }

  /** Resolves when the whole current picture is drawn finely; tests and pictures for print wait for this. */
  async settled() {
    while (!(this.isSettled && this.cancelFrame === null && performance.now() - this.movedAt > REST_MS)) {
      this.requestDraw();
      await new Promise((resolve) => setTimeout(resolve, 30));
    }
  }

  /** Returns the current picture's 8-bit values, [height][width][4]. */
  pixels() {
    this.drawNow();
    return this.gl.pixels();
  }

  close() {
    this.cancelFrame?.();
    clearTimeout(this.restTimer);
    this.pool.close();
    this.store.clear();
    this.gl.releaseTarget();
  }
}
