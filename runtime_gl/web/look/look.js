// SPDX-License-Identifier: Apache-2.0
// Runs the page of multum look with its controls, its view, and dropped files. Text from files only goes into text
// nodes.
const METHODS = [["reference", "reference"], ["mip", "averaged normals"], ["rule", "engine's rule"],
  ["export", "one-lobe export"], ["lobes", "lobes"]];
const SLOW_MS = 50; // If a frame takes longer, the page names what draws it, and draws drafts while the view moves.
const REST_MS = 200; // time after the last change until the view is drawn in full
const DRAFT_LEAST = 0.25; // width of the smallest draft, as a share of the full width
const ROUGHNESS = [0.05, 1];
const PLAIN = { roughness: 0.3, metalness: 0 }; // of dropped maps
const SCREEN_KEYS = new Set(["split", "exposure", "difference"]); // change the screen, but no picture
const DEGREE = Math.PI / 180;
const TARGET = [0, 0.76, 0]; // target of multum-view's camera on the plane
/**
 * The default view: several texels per pixel, against the light, with the divider in the highlight. A roughness or a
 * metalness of -1 is the map's own.
 */
const HOME = { map: 0, shape: "plane", left: "mip", right: "lobes", rule: "unreal", light: "sky", roughness: -1,
  metalness: -1, split: 0.5, lock: -1, azimuth: 0, elevation: 40, distance: 3, exposure: -1, difference: 0, x: 0,
  y: 0.8, z: 0.6 };
const FRONT = { elevation: 12, distance: MODEL_DISTANCE, x: -0.5, y: -0.6, z: 0.62 }; // for shapes that are not planes
const LIMITS = { map: [0, 63], roughness: [-1, 1], metalness: [-1, 1], split: [0, 1], lock: [-1, 15],
  azimuth: [-180, 180], elevation: [3, 89], distance: [-2, 5], exposure: [-4, 4], difference: [0, 1], x: [-1, 1],
  y: [-1, 1], z: [0, 1] };

const IS_FRAMED = self !== top;
if (IS_FRAMED) document.documentElement.classList.add("framed");

const byId = (id) => document.getElementById(id);
const say = (text) => { byId("problem").textContent = text; byId("problem").hidden = text === ""; };
const bytesOfBase64 = (text) => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
const clamp = (value, [low, high]) => Math.min(high, Math.max(low, value));

/** Returns the view of an address. Parts that are not understood keep their default. */
function viewOfHash(hash) {
  const view = { ...HOME };
  for (const [key, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    const value = text === "" ? NaN : Number(text);
    if (Object.hasOwn(LIMITS, key) && Number.isFinite(value)) view[key] = clamp(value, LIMITS[key]);
    else if ((key === "left" || key === "right") && METHODS.some(([name]) => name === text)) view[key] = text;
    else if (key === "rule" && Object.hasOwn(ENGINE_RULES, text)) view.rule = text;
    else if (key === "light" && Object.hasOwn(ENVIRONMENTS, text)) view.light = text;
    else if (key === "shape" && (text === "model" || Object.hasOwn(SHAPES, text))) view.shape = text;
  }
  for (const key of ["map", "lock"]) view[key] = Math.round(view[key]);
  return view;
}

function hashOfView(view) {
  const changed = Object.keys(HOME).filter((key) => view[key] !== HOME[key]);
  const text = (value) => (typeof value === "number" ? Number(value.toFixed(4)) : value);
  return changed.map((key) => `${key}=${text(view[key])}`).join("&");
}

function lookCamera(view) {
  const [a, e, d] = [view.azimuth * DEGREE, view.elevation * DEGREE, 2 ** view.distance];
  const back = [Math.sin(a) * Math.cos(e), -Math.cos(a) * Math.cos(e), Math.sin(e)];
  return { eye: TARGET.map((one, i) => one + d * back[i]), target: TARGET, back };
}

/**
 * Returns the directions across, up and ahead of the picture's middle, as columns, for a field of view of 40 degrees.
 */
function raysOf({ back }, aspect) {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const across = cross([0, 0, 1], back);
  const right = across.map((one) => one / Math.hypot(...across));
  const half = Math.tan(20 * DEGREE);
  return [...right.map((one) => one * half * aspect), ...cross(back, right).map((one) => one * half),
    ...back.map((one) => -one)];
}

/** Returns the matrix from world to clip space for the same camera, column by column. */
function clipMatrix(camera, aspect) {
  const rays = raysOf(camera, aspect), half = Math.tan(20 * DEGREE);
  const rows = [rays.slice(0, 3).map((one) => one / (half * aspect)), rays.slice(3, 6).map((one) => one / half),
    camera.back];
  const toEye = new Float64Array(16);
  rows.forEach((row, r) => row.forEach((one, c) => { toEye[4 * c + r] = one; }));
  rows.forEach((row, r) => { toEye[12 + r] = -dot(row, camera.eye); });
  toEye[15] = 1;
  const far = Math.hypot(...camera.eye.map((one, i) => one - camera.target[i])) + 2 * MODEL_RADIUS, near = far / 1000;
  const toClip = new Float64Array(16);
  toClip.set([1 / (half * aspect), 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0,
    2 * far * near / (near - far), 0]);
  return multiplied(toClip, toEye);
}

class LookPage {
  constructor(data) {
    this.data = data;
    this.view = viewOfHash(location.hash);
    const table = new Uint16Array(bytesOfBase64(data.ggxTable).buffer);
    this.makeGl = () => new LookGl(byId("canvas"), data.shaders, table);
    this.gl = this.makeGl();
    this.dropped = null; // the last dropped map
    this.model = null; // the last dropped model
    this.own = { ...PLAIN }; // roughness and metalness of the shown map
    this.colours = null;
    this.drawn = 0; // number of drawn views, from which longer tasks see that the view has changed
    this.reference = new Reference();
    this.hasDrafts = true;
    this.addLoss();
    this.addControls();
    this.showOwn(clamp(this.view.map, [0, data.maps.length - 1]));
    this.listShapes();
    this.addPointers();
    this.addKeys();
    this.drops = new Drops(this, byId("look-worker").textContent);
    byId("main").hidden = false;
    new ResizeObserver(() => this.change({})).observe(byId("stage"));
    document.addEventListener("visibilitychange", () => this.change({}));
    this.change({});
  }

  /** Shows one of the page's maps. If it is damaged, keeps the current map. */
  showOwn(number) {
    const map = this.data.maps[number];
    const normals = parseKtx2(bytesOfBase64(map.normals));
    this.show(map, normals.width, normals.height, normalsOfBytes(normals.levels[0]),
      parseLobes(bytesOfBase64(map.lobes)), exportedLevels(normals, parseKtx2(bytesOfBase64(map.exportedRoughness))));
    this.own = { roughness: map.roughness, metalness: map.metalness };
    this.shown = number;
    this.takeColours(map.colours);
    this.view.map = number;
  }

  /** Shows the base colour of a map, an image in base64, or none. It arrives after the map. */
  async takeColours(base64) {
    this.setColours(null);
    const { request } = this;
    if (base64 === undefined) return;
    try {
      const image = await createImageBitmap(new Blob([bytesOfBase64(base64)]),
        { colorSpaceConversion: "none", premultiplyAlpha: "none" });
      if (this.request !== request) {
        image.close();
        return;
      }
      this.setColours(image);
      this.change({});
    } catch (error) {
      if (this.request === request) say(`The colours of this map cannot be shown: ${errorText(error)}`);
    }
  }

  setColours(image) {
    this.request = {}; // a picture that is still being decoded belongs to an earlier choice
    this.gl.setColours(image);
    this.colours?.close();
    this.colours = image;
  }

  /** Shows a dropped map: decodeExr() of its file, its normals, title and about. It becomes the list's last entry. */
  install(map) {
    this.show(map, map.width, map.height, map.normals, map.file, null);
    this.setColours(null);
    this.own = { ...PLAIN };
    this.dropped = map;
    this.shown = "dropped";
    this.listMaps();
  }

  show({ title, about }, width, height, normals, file, exported) {
    const means = meanNormals(width, height, normals);
    this.checkFits(file, means);
    this.setMeans(means);
    this.setLobes(file);
    this.setExported(exported);
    byId("lock").replaceChildren(...[[-1, "by distance"], ...means.map((_, level) => [level, `level ${level}`])].map(
      ([value, text]) => new Option(text, value)));
    byId("title").textContent = title;
    byId("about").textContent = about;
    document.title = title;
  }

  setExported(levels) {
    if (levels === null) this.gl.removeMaterial("export");
    else this.gl.setMaterial("export", levels);
    this.exported = levels;
  }

  setNormals(width, height, normals) { this.setMeans(meanNormals(width, height, normals)); }

  setMeans(means) {
    this.means = means;
    this.gl.setMaterial("mip", ruledLevels(this.means, 1, () => 1)); // the shader has its roughness
    this.ruled = null;
  }

  checkFits(file, means) {
    const [found, map] = [`${file.lobes.mapWidth} x ${file.lobes.mapHeight}`, `${means[0].width} x ${means[0].height}`];
    if (found !== map) throw new Error(`found lobes of a map of ${found}, expected ${map}, the size of the normal map`);
  }

  setLobes(file) {
    this.checkFits(file, this.means);
    this.gl.setLobes(file, this.means);
    this.file = file;
  }

  /** Uploads all data again when the browser replaces a lost graphics context. */
  addLoss() {
    const canvas = byId("canvas");
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault(); // otherwise the context never comes back
      ++this.drawn; // invalidates a running measurement
      byId("lost").hidden = false;
      canvas.style.visibility = "hidden"; // browsers show a broken picture
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.gl = this.makeGl();
      this.setMeans(this.means);
      this.setLobes(this.file);
      this.setExported(this.exported);
      this.gl.setColours(this.colours);
      this.shape = null; // uploaded again with the next frame
      byId("lost").hidden = true;
      canvas.style.visibility = "";
      this.change({});
    });
  }

  addControls() {
    const options = (id, list) => byId(id).append(...list.map(([value, text]) => new Option(text, value)));
    options("left", METHODS);
    options("right", METHODS);
    options("rule", Object.entries(ENGINE_RULES).map(([id, [name]]) => [id, name]));
    options("around", Object.entries(ENVIRONMENTS).map(([id, { text }]) => [id, text]));
    this.listMaps();
    byId("map").addEventListener("change", (event) => this.choose(event.target.value));
    byId("shape").addEventListener("change", (event) => this.chooseShape(event.target.value));
    for (const id of ["left", "right", "rule"]) byId(id).addEventListener("change", (event) =>
      this.change({ [id]: event.target.value }));
    byId("around").addEventListener("change", (event) => this.change({ light: event.target.value }));
    for (const id of ["split", "distance", "exposure", "roughness", "metalness"])
      byId(id).addEventListener("input", (event) => this.change({ [id]: Number(event.target.value) }));
    byId("lock").addEventListener("change", (event) => this.change({ lock: Number(event.target.value) }));
    byId("difference").addEventListener("change", (event) => this.change({ difference: event.target.checked ? 1 : 0 }));
    byId("reset").addEventListener("click", () => this.change({ ...HOME, map: this.view.map }));
    byId("measure").addEventListener("click", () => this.measure());
    byId("save").addEventListener("click", () => this.savePicture());
    byId("controls").addEventListener("submit", (event) => event.preventDefault());
    // Uses the event's address, because a waiting frame may already have written the previous view into the page's
    // address.
    addEventListener("hashchange", (event) => {
      const { hash } = new URL(event.newURL);
      if (hash.slice(1) !== hashOfView(this.view)) this.take(viewOfHash(hash));
    });
  }

  listMaps() {
    const dropped = this.dropped === null ? [] : [["dropped", `${this.dropped.title} (dropped)`]];
    const all = [...this.data.maps.map(({ title }, i) => [i, title]), ...dropped];
    byId("map").replaceChildren(...all.map(([value, text]) => new Option(text, value)));
    byId("map-label").hidden = all.length < 2;
  }

  /** Shows readModel() of a file, and adds it to the choices. */
  setModel(model, name) {
    this.model = { ...model, name };
    this.listShapes();
    this.shape = null;
    this.chooseShape("model");
  }

  /** Shows a shape from a distance and with a sun that suit it. */
  chooseShape(shape) {
    const { elevation, distance, x, y, z } = shape === "plane" ? HOME : FRONT;
    this.change({ shape, elevation, distance, x, y, z });
  }

  listShapes() {
    const dropped = this.model === null ? [] : [["model", this.model.name]];
    byId("shape").replaceChildren(...[...Object.entries(SHAPES).map(([id, [text]]) => [id, text]), ...dropped].map(
      ([value, text]) => new Option(text, value)));
  }

  /** Uploads the shape of the view if it is not the one on the GPU. */
  takeShape() {
    const { shape } = this.view;
    if (this.shape === shape) return;
    const make = shape === "model" ? null : SHAPES[shape][1];
    this.gl.setModel(shape === "model" ? this.model : make === null ? null : make(TARGET, MODEL_RADIUS));
    this.shape = shape;
  }

  /** Selects one of the page's maps by number, or "dropped". */
  choose(value) {
    say("");
    try {
      if (value === "dropped") this.install(this.dropped);
      else this.showOwn(Number(value));
    } catch (error) {
      say(`This map cannot be shown: ${errorText(error)}`);
    }
    this.change({ roughness: HOME.roughness, metalness: HOME.metalness });
    this.redraw();
  }

  addPointers() {
    const stage = byId("stage");
    const held = new Map(); // last positions of pressed pointers
    stage.addEventListener("pointerdown", (event) => {
      if (event.target === byId("divider")) return;
      stage.setPointerCapture(event.pointerId);
      held.set(event.pointerId, [event.clientX, event.clientY]);
    });
    stage.addEventListener("pointermove", (event) => {
      const now = [event.clientX, event.clientY], before = held.get(event.pointerId);
      if (before === undefined) {
        if (byId("light").checked) this.lightAt(...now);
        return;
      }
      const apart = () => { const [a, b] = [...held.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
      const was = held.size === 2 ? apart() : 0;
      held.set(event.pointerId, now);
      if (held.size === 2) this.change({ distance: this.view.distance + Math.log2(Math.max(was,
        1) / Math.max(apart(), 1)) });
      else if (byId("light").checked) this.lightAt(...now);
      else this.change({ azimuth: this.view.azimuth - 0.3 * (now[0] - before[0]),
        elevation: this.view.elevation + 0.3 * (now[1] - before[1]) });
    });
    for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (event) =>
      held.delete(event.pointerId));
    stage.addEventListener("wheel", (event) => {
      if (IS_FRAMED && !event.ctrlKey && document.activeElement !== stage) return; // scrolls the page around the frame
      event.preventDefault();
      this.change({ distance: this.view.distance + 0.0015 * event.deltaY });
    }, { passive: false });
    const divider = byId("divider");
    divider.addEventListener("pointerdown", (event) => divider.setPointerCapture(event.pointerId));
    divider.addEventListener("pointermove", (event) => {
      const box = stage.getBoundingClientRect();
      if (divider.hasPointerCapture(event.pointerId)) this.change({ split: (event.clientX - box.left) / box.width });
    });
  }

  // The middle of the picture is straight above, and its edges are near the horizon.
  lightAt(x, y) {
    const box = byId("stage").getBoundingClientRect();
    const right = 2 * (x - box.left) / box.width - 1, up = 1 - 2 * (y - box.top) / box.height;
    const size = Math.max(1, Math.hypot(right, up) / 0.98), a = this.view.azimuth * DEGREE;
    const flat = [right / size, up / size];
    this.change({ x: Math.cos(a) * flat[0] - Math.sin(a) * flat[1], y: Math.sin(a) * flat[0] + Math.cos(a) * flat[1],
      z: Math.sqrt(Math.max(0.04, 1 - flat[0] ** 2 - flat[1] ** 2)) });
  }

  addKeys() {
    const turn = (key, step) => () => this.change({ [key]: this.view[key] + step });
    const keys = { ArrowLeft: turn("azimuth", 3), ArrowRight: turn("azimuth", -3), ArrowUp: turn("elevation", 2),
      ArrowDown: turn("elevation", -2), "+": turn("distance", -0.2), "-": turn("distance", 0.2), "[": turn("lock", -1),
      "]": turn("lock", 1), s: turn("split", 0.02), S: turn("split", -0.02),
      d: () => this.change({ difference: 1 - this.view.difference }), l: () => byId("light").click(),
      e: () => byId("measure").click(), p: () => byId("save").click() };
    addEventListener("keydown", (event) => {
      const acts = Object.hasOwn(keys, event.key) && !event.ctrlKey && !event.metaKey && !event.altKey;
      if (!acts || (event.target !== byId("stage") && event.target !== document.body)) return;
      event.preventDefault();
      keys[event.key]();
    });
  }

  /** Applies the view of an address, which may name another map. */
  take(view) {
    const number = clamp(view.map, [0, this.data.maps.length - 1]);
    if (number !== this.view.map) this.choose(number);
    this.change({ ...view, map: this.view.map });
  }

  /** Changes the view and draws it with the next frame. */
  change(more) {
    const view = { ...this.view, ...more };
    view.azimuth = ((view.azimuth + 540) % 360) - 180;
    for (const [key, limits] of Object.entries(LIMITS)) view[key] = clamp(view[key], limits);
    view.lock = Math.min(view.lock, this.means.length - 1);
    if (view.roughness >= 0) view.roughness = Math.max(view.roughness, ROUGHNESS[0]);
    if (view.shape === "model" && this.model === null) view.shape = HOME.shape;
    for (const id of ["left", "right"]) if (view[id] === "export" && !this.hasExport(view)) view[id] = HOME[id];
    const isNew = Object.keys(more).length === 0 ||
      Object.keys(view).some((key) => view[key] !== this.view[key] && !SCREEN_KEYS.has(key));
    this.view = view;
    if (!isNew) {
      this.isOther = true;
      this.drawSoon();
      return;
    }
    this.isAtRest = false;
    this.redraw();
  }

  redraw() {
    this.reference.count = 0;
    this.isChanged = true;
    this.drawSoon();
  }

  /** Exports exist only for the roughness of `multum look`, and not for dropped maps, because the page makes none. */
  hasExport(view) { return this.gl.has("export") && (view.roughness < 0 || view.roughness === this.own.roughness); }

  drawSoon() {
    if (this.waiting !== undefined) return;
    this.waiting = new Promise((resolve) => onNextFrame(() => {
      this.waiting = undefined;
      this.draw();
      resolve();
    }));
  }

  get roughness() { return this.view.roughness < 0 ? this.own.roughness : this.view.roughness; }

  get metalness() { return this.view.metalness < 0 ? this.own.metalness : this.view.metalness; }

  get hasReference() { return this.view.left === "reference" || this.view.right === "reference"; }

  scene() {
    const { view, metalness } = this;
    const camera = lookCamera(view);
    // Without colours, a map is grey paint or silver.
    const tint = this.colours === null ? 0.1 + 0.8 * metalness : 1;
    const [width, height] = this.gl.size;
    const size = Math.hypot(view.x, view.y, view.z), sun = size > 0 ? [view.x, view.y, view.z] : [0, 0, 1];
    return { rays: raysOf(camera, width / height),
      toClip: clipMatrix(camera, width / height), eye: camera.eye,
      light: sun.map((one) => one / (size || 1)), environment: view.light, tint: [tint, tint, tint], metalness,
      alpha: this.roughness ** 2, lock: view.lock < 0 ? null : view.lock, exposure: 2 ** view.exposure,
      split: view.split, difference: view.difference !== 0 };
  }

  draw() {
    if (this.gl.isLost) return; // drawn when the context is back
    const canvas = byId("canvas"), { view } = this;
    const isDraft = this.hasDrafts && this.isChanged && !this.isAtRest && this.frameMs > SLOW_MS;
    const ratio = (this.pixelRatio ?? Math.min(devicePixelRatio, 2)) *
      (isDraft ? Math.max(DRAFT_LEAST, Math.sqrt(SLOW_MS / this.frameMs)) : 1);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (this.gl.resize(canvas.width, canvas.height)) {
      this.reference.count = 0;
      this.isChanged = true;
    }
    this.takeShape();
    this.takeRule();
    const scene = this.scene();
    const isTimed = this.isChanged && !isDraft && !this.hasReference;
    if (this.hasReference) this.reference.refine(this.gl, scene, isDraft ? 1 : undefined);
    const begin = performance.now(), { madeCount } = this.gl;
    if (this.isChanged) this.gl.draw(view.left, view.right, scene);
    else this.gl.show(view.left, view.right, scene); // the reference became finer, or only the screen changes
    if (this.isChanged || this.isOther) {
      ++this.drawn;
      byId("error").textContent = "";
      this.showControls();
    } else {
      this.showLabels();
    }
    this.isChanged = this.isOther = false;
    if (isTimed && this.gl.madeCount === madeCount) this.timeFrame(begin);
    else if (isTimed) this.timeAgain(); // the frame compiled shaders
    else if (this.hasReference) this.frameMs ??= 2 * this.reference.sampleMs;
    if (isDraft) {
      clearTimeout(this.rest);
      this.rest = setTimeout(() => {
        this.isAtRest = true;
        this.redraw();
      }, REST_MS);
    } else if (this.hasReference && !this.reference.isDone) {
      this.drawSoon();
    }
    const hash = hashOfView(view);
    if (location.hash.slice(1) !== hash) history.replaceState(null, "", `#${hash}`);
  }

  /** Makes the textures of the chosen engine's rule, if it is shown and they are not those of the view. */
  takeRule() {
    const { rule, left, right } = this.view, key = `${rule} ${this.roughness}`;
    if (this.ruled === key || (left !== "rule" && right !== "rule")) return;
    this.gl.setMaterial("rule", ruledLevels(this.means, this.roughness, ENGINE_RULES[rule][1]));
    this.ruled = key;
  }

  /** Draws the same frame once more, to time it. */
  timeAgain() {
    const begin = performance.now();
    this.gl.draw(this.view.left, this.view.right, this.scene());
    this.timeFrame(begin);
  }

  // The frame is complete when the GPU has passed the fence.
  timeFrame(begin) {
    const { gl } = this.gl, wasHidden = document.hidden;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      if (gl.isContextLost()) return undefined;
      const state = gl.clientWaitSync(fence, 0, 0);
      if (state === gl.TIMEOUT_EXPIRED) return setTimeout(look, 1);
      gl.deleteSync(fence);
      this.frameMs = performance.now() - begin;
      this.isTimed = !wasHidden && !document.hidden; // timers of background tabs are delayed
      return this.showFacts();
    };
    look();
  }

  /** Shows the error of both pictures against the map itself, unless the view changes first. */
  async measure() {
    if (this.gl.isLost) return;
    await this.drawnInFull();
    const { left, right } = this.view, { drawn } = this, percent = (share) => `${(100 * share).toFixed(1)} %`;
    const methods = [...new Set([left, right])].filter((one) => one !== "reference");
    byId("measure").disabled = true;
    let found = null;
    try {
      found = await errorsBesideMap(this.gl, methods, this.scene(), () => this.drawn !== drawn, (share) => {
        if (this.drawn === drawn) byId("error").textContent = `Measuring: ${Math.round(100 * share)} %`;
      });
    } catch (error) {
      byId("error").textContent = `The error cannot be measured: ${errorText(error)}.`;
    } finally {
      this.showControls();
    }
    if (found === null || this.drawn !== drawn) return;
    const errors = methods.map((one, i) => `${this.nameOf(one)} ${percent(found.errors[i])}`).join(", ");
    byId("error").textContent = `Relative L1 error of the radiance, against ${PLACE_COUNT} samples per pixel of the ` +
      `map itself, without the background: ${errors}; the samples' own noise is about ${percent(found.noise)}.`;
  }

  /** Saves both pictures side by side, with a complete reference. */
  async savePicture() {
    if (this.gl.isLost) return;
    byId("save").disabled = true;
    try {
      await this.drawnInFull();
      const { drawn, view } = this;
      const isStale = () => this.drawn !== drawn || this.view !== view || this.gl.isLost;
      byId("error").textContent = "Saving both pictures ...";
      while (!isStale() && this.hasReference && !this.reference.isDone) {
        this.reference.refine(this.gl, this.scene(), PLACES_ACROSS);
        await giveWay();
      }
      if (isStale()) {
        byId("error").textContent = "The view has changed, so nothing was saved.";
        return;
      }
      byId("error").textContent = "";
      const title = byId("title").textContent;
      const lines = [`${title}: roughness ${this.roughness.toFixed(2)}, metalness ${this.metalness.toFixed(2)}, ` +
        `${ENVIRONMENTS[view.light].text}, distance ${(2 ** view.distance).toFixed(1)}`];
      const blob = await pictureOfBoth(byId("canvas"), [view.left, view.right].map((one) => this.labelOf(one)), lines,
        (split) => this.gl.show(view.left, view.right, { ...this.scene(), split, difference: false }));
      saveFile(blob, `${title.replace(/[^\p{L}\p{N}]+/gu, "_")}_${view.left}_${view.right}.png`);
    } catch (error) {
      say(`The picture cannot be saved: ${errorText(error)}`);
    } finally {
      byId("save").disabled = false;
      this.drawSoon();
    }
  }

  /** Waits until the view is drawn, and not only a draft of it. */
  async drawnInFull() {
    await this.waiting;
    const canvas = byId("canvas"), ratio = this.pixelRatio ?? Math.min(devicePixelRatio, 2);
    if (canvas.width === Math.max(1, Math.round(canvas.clientWidth * ratio))) return;
    this.isAtRest = true;
    this.redraw();
    await this.waiting;
  }

  nameOf(method) { return method === "rule" ? ENGINE_RULES[this.view.rule][0] : Object.fromEntries(METHODS)[method]; }

  showControls() {
    const { view } = this;
    for (const id of ["left", "right", "rule", "shape", "split", "distance", "exposure", "lock"]) byId(id).value =
      String(view[id]);
    byId("around").value = view.light;
    for (const key of ["roughness", "metalness"]) {
      byId(key).value = String(this[key]);
      byId(`${key}-value`).textContent = this[key].toFixed(2);
    }
    for (const id of ["left", "right"]) {
      const option = [...byId(id).options].find(({ value }) => value === "export");
      option.disabled = !this.hasExport(view);
      option.text = this.gl.has("export") ? `one-lobe export, roughness ${this.own.roughness}` : "one-lobe export";
    }
    byId("map").value = String(this.shown);
    byId("difference").checked = view.difference !== 0;
    byId("measure").disabled = view.left === "reference" && view.right === "reference";
    byId("light").disabled = ENVIRONMENTS[view.light].sun.every((one) => one === 0);
    this.showLabels();
    byId("divider").style.left = `${100 * view.split}%`;
    byId("divider").hidden = view.difference !== 0;
    this.showFacts();
  }

  showLabels() {
    byId("left-name").textContent = this.labelOf(this.view.left);
    byId("right-name").textContent = this.labelOf(this.view.right);
  }

  /** Returns a method's name, with what is stored for it. */
  labelOf(method) {
    if (method === "reference") return `reference, ${this.reference.count} of ${PLACE_COUNT} samples per pixel`;
    if (method !== "lobes") return this.nameOf(method);
    return `${this.countText} in ${this.storage} from level ${this.file.lobes.firstLevel} on`;
  }

  get countText() {
    const count = this.file.lobes.lobes.length;
    return `${count} ${count === 1 ? "lobe" : "lobes"}`;
  }

  get storage() { return { [VK_BC5]: "BC5", [VK_RGBA16F]: "RGBA16F" }[this.file.format] ?? "RGBA8"; }

  /** Returns a method's memory on a GPU, and the formats that it is counted with. */
  factsOf(method) {
    if (method === "reference") return "reference: the map's finest level only";
    const bytes = `${this.nameOf(method)} ${(this.gl.bytesOf(method) / 1e6).toFixed(2)} MB`;
    if (method !== "lobes") return `${bytes} (normal as BC5, roughness as BC4)`;
    return `${bytes} (${this.storage} from level ${this.file.lobes.firstLevel} on, and the normal map as BC5)`;
  }

  /** Names what draws, if it is slow. */
  get slowText() {
    if (this.hasReference || !this.isTimed || !(this.frameMs > SLOW_MS)) return "";
    return ` This browser draws with ${this.gl.rendererName}.`;
  }

  showFacts() {
    const { means, view, gl: { size } } = this;
    const methods = [...new Set([view.left, view.right])];
    const time = this.hasReference ? "is not timed next to the reference"
      : this.frameMs === undefined ? "is being timed"
        : this.isTimed ? `takes ${this.frameMs.toFixed(1)} ms from the first command until the GPU is done`
          : "is not timed while this page is in the background";
    byId("facts").replaceChildren(...[
      `Map of ${means[0].width} x ${means[0].height}, ${this.countText}.`,
      `Memory on the GPU, all mip levels, as engines keep them: ${methods.map((method) =>
        this.factsOf(method)).join("; ")}.`,
      `Time: one frame here, with both methods drawn in all ${size[0]} x ${size[1]} pixels, ${time}.${this.slowText}`,
    ].map((text) => Object.assign(document.createElement("li"), { textContent: text })));
  }
}

sayUncaughtErrors(say);
try {
  globalThis.multumLook = new LookPage(JSON.parse(byId("look-data").textContent));
} catch (error) {
  say(`This page cannot be shown: ${errorText(error)}`);
}
