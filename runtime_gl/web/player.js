// SPDX-License-Identifier: Apache-2.0
// Runs the page of the player. Opens the field that the page's configuration names, the field that `?file=` in its
// address names, or one that the user chooses. Connects controls, path and statistics to the player of the field.
//
// The configuration is a block of JSON in the page: { "file": URL, "geometry": URL, "title": text }. A self-contained
// page has further blocks: data-field, data-geometry, data-wasm (base64) and worker-source (text).
import { BlobSource, FieldError, UrlSource, wholeBody } from "./byte_source.js";
import { errorText, sayUncaughtErrors } from "./error_text.js";
import { FieldDescription } from "./field_description.js";
import { FieldPlayer } from "./field_player.js";
import { readGlb } from "./glb.js";
import { MptFile } from "./mpt_file.js";
import { onNextFrame } from "./next_frame.js";
import { ParameterControls } from "./parameter_controls.js";
import { RecordedPath } from "./recorded_path.js";

const MIB = 2 ** 20;
const GEOMETRY_BYTES_MAX = 1024 * MIB;
const WASM_BYTES_MAX = 16 * MIB;
const WORKERS_MAX = 4;
const PROBLEMS_MAX = 20;
const STATISTICS_MS = 250; // between two updates

const byId = (id) => document.getElementById(id);
const counts = { fetched: 0, retries: 0 };
let player = null;
let controls = null;
let path = null; // recorded or loaded
let playing = null; // { begun, path }
let recording = null; // { begun, path }

// ---- Messages

function say(text) {
  const list = byId("problem-list");
  if ([...list.children].some((one) => one.textContent === text)) return;
  const item = document.createElement("li");
  item.textContent = text;
  list.append(item);
  while (list.children.length > PROBLEMS_MAX) list.firstChild.remove();
  byId("problems").hidden = false;
}

function forget() {
  byId("problem-list").replaceChildren();
  byId("problems").hidden = true;
}

function showState(text) {
  byId("state").textContent = text;
  byId("state").hidden = text === "";
}

/** Shows the loss of the graphics context, which browsers remove when a driver is reset or memory is short. */
function showLoss(isLost) {
  byId("canvas").style.visibility = isLost ? "hidden" : ""; // browsers show a broken picture
  showState(isLost ? "The browser has lost the graphics context. The picture returns as soon as the graphics driver " +
    "recovers. If it does not return, reload the page." : "");
}

sayUncaughtErrors(say);

// ---- Opening

const config = JSON.parse(byId("player-config").textContent);

function bytesOf(id) {
  const element = byId(id);
  if (element === null) return null;
  const text = atob(element.textContent.trim());
  return Uint8Array.from(text, (letter) => letter.charCodeAt(0));
}

async function workerStart() {
  const wasm = bytesOf("data-wasm") ?? await wholeBody(new URL("packed_field.wasm", document.baseURI),
    "packed_field.wasm", counts, WASM_BYTES_MAX);
  const source = byId("worker-source");
  const url = source === null ? new URL("decoding_worker.js", document.baseURI)
    : URL.createObjectURL(new Blob([source.textContent], { type: "text/javascript" }));
  // Chromium 156 rejects a module from a Blob if the page is a local file.
  const type = source === null ? "module" : "classic";
  const count = Math.min(WORKERS_MAX, Math.max(1, (navigator.hardwareConcurrency ?? 2) - 1));
  return { wasm, count, makeWorker: () => new Worker(url, { type }) };
}

/** Returns what to open: `source` of the field, and `geometry(description)`, which returns its bytes and name. */
function configured() {
  const asked = new URLSearchParams(location.search).get("file");
  const inPage = bytesOf("data-field");
  if (inPage !== null && asked === null) {
    return { source: new BlobSource(new Blob([inPage]), config.file), title: config.title,
      geometry: async () => ({ bytes: bytesOf("data-geometry"), name: config.geometry }) };
  }
  const file = asked ?? config.file;
  if (file === undefined) return null;
  const url = new URL(file, document.baseURI);
  const named = asked === null ? config.geometry : undefined;
  return {
    source: new UrlSource(url, counts), title: asked === null ? config.title : undefined,
    geometry: async (description) => {
      const place = named === undefined ? new URL(description.geometry, url) : new URL(named, document.baseURI);
      const name = decodeURIComponent(place.pathname.split("/").pop());
      return { bytes: await wholeBody(place, name, counts, GEOMETRY_BYTES_MAX), name,
        hash: named === undefined ? description.geometryHash : undefined };
    },
  };
}

/** Returns what to open from files that the user chose: one field and its geometry. */
function chosen(files) {
  const find = (end) => files.find((file) => file.name.toLowerCase().endsWith(end));
  const field = find(".mpt");
  const scene = find(".glb");
  if (field === undefined || scene === undefined)
    throw new FieldError("Choose two files together: a packed field, .mpt, and its geometry, .glb");
  return {
    source: new BlobSource(field, field.name),
    geometry: async () => ({ bytes: new Uint8Array(await scene.arrayBuffer()), name: scene.name }),
  };
}

async function checkHash({ bytes, name, hash }) {
  if (hash === undefined || !globalThis.crypto?.subtle) return; // http: from another machine has no crypto.subtle
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
  const found = [...digest].map((one) => one.toString(16).padStart(2, "0")).join("");
  if (found !== hash) throw new FieldError(`${name}: is not the geometry of this field's textures (SHA-256 ` +
    `${found}, expected ${hash})`);
}

let startOfWorkers = null;

let opened = null; // opens the current or last field again

async function open(make) {
  opened = make;
  forget();
  stopPlaying();
  stopRecording();
  player?.close();
  player = controls = null;
  byId("main").hidden = true;
  try {
    const what = make();
    if (what === null)
      return showState("No field is named. Open a packed field, .mpt, together with its geometry, .glb.");
    showState(`Opening ${what.source.name} ...`);
    const file = await MptFile.open(what.source);
    const description = new FieldDescription(await file.descriptionObject(), what.source.name);
    showState("Reading the geometry ...");
    const geometry = await what.geometry(description);
    await checkHash(geometry);
    const objects = readGlb(geometry.bytes, geometry.name, description.uvSet);
    startOfWorkers ??= workerStart();
    start({ file, description, objects, startWorkers: await startOfWorkers, title: what.title ?? what.source.name });
  } catch (error) {
    startOfWorkers?.catch(() => { startOfWorkers = null; });
    showState("");
    say(errorText(error));
  }
}

function start({ file, description, objects, startWorkers, title }) {
  byId("main").hidden = false;
  byId("title").textContent = title;
  document.title = title;
  byId("about").textContent = `${description.sizes.join(" \u00d7 ")} samples of ` +
    `${description.parameters.join(", ")}; ${description.width} \u00d7 ${description.height} pixels`;
  const stage = byId("stage"); // replaces the stage, because a canvas keeps its context forever, and to remove old
                               // controls
  const freshStage = stage.cloneNode(false);
  const canvas = Object.assign(document.createElement("canvas"), { id: "canvas" });
  canvas.style.aspectRatio = `${description.width} / ${description.height}`;
  byId("player").style.setProperty("--shape", description.width / description.height);
  freshStage.append(canvas);
  stage.replaceWith(freshStage);
  const pad = byId("pad").cloneNode(false);
  byId("pad").replaceWith(pad);
  byId("sliders").replaceChildren();
  player = new FieldPlayer({ canvas, file, description, objects, startWorkers, counts, say, showLoss,
    budget: Number(byId("budget").value) * MIB, changed: () => controls?.show(player.position) });
  player.exposure = 2 ** Number(byId("exposure").value);
  player.setSmooth(byId("smooth").checked);
  player.setFull(byId("fine").checked);
  controls = new ParameterControls({ sliders: byId("sliders"), pad, stage: freshStage, description, move: goTo });
  path = null;
  controls.show(player.position);
  showPath();
  showState("");
  globalThis.multumPlayer = player; // global variable for other scripts and tests
}

// ---- Moving

function moveTo(at) {
  player.moveTo(at);
  controls.show(player.position);
  recording?.path.add((performance.now() - recording.begun) / 1000, player.position);
}

/** Moves by hand and stops playing. */
function goTo(at) {
  stopPlaying();
  moveTo(at);
}

function showPath() {
  byId("play").textContent = playing ? "Pause" : "Play";
  byId("play").setAttribute("aria-pressed", String(playing !== null));
  byId("record").textContent = recording ? "Stop" : "Record";
  byId("record").setAttribute("aria-pressed", String(recording !== null));
  byId("export").disabled = path === null;
  byId("path-state").textContent = recording ? "Recording ..." : path ? `Path of ${path.seconds.toFixed(1)} s` : "";
}

function stopPlaying() {
  if (playing === null) return;
  playing = null;
  showPath();
}

function startPlaying() {
  if (player === null) return;
  stopRecording();
  playing = { begun: performance.now(), path: path ?? RecordedPath.tour(player.description.parameters,
    player.description.sizes) };
  const mine = playing;
  const step = (now) => {
    if (playing !== mine) return;
    moveTo(playing.path.at(Math.max(0, now - playing.begun) / 1000));
    onNextFrame(step);
  };
  onNextFrame(step);
  showPath();
}

function stopRecording() {
  if (recording === null) return;
  if (player !== null) recording.path.add((performance.now() - recording.begun) / 1000, player.position);
  if (recording.path.positions.length >= 2) ({ path } = recording);
  recording = null;
  showPath();
}

function startRecording() {
  if (player === null) return;
  stopPlaying();
  recording = { begun: performance.now(), path: new RecordedPath(player.description.parameters) };
  recording.path.add(0, player.position);
  showPath();
}

const togglePlaying = () => (playing ? stopPlaying() : startPlaying());
const toggleRecording = () => (recording ? stopRecording() : startRecording());

function toggleFullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else byId("player").requestFullscreen?.().catch((error) => say(`Full screen is not available: ${errorText(error)}`));
}

// ---- Statistics

const mib = (bytes) => `${(bytes / MIB).toFixed(1)} MiB`;

function statisticsRows() {
  const { statistics, store, pool, quality } = player;
  return {
    "Frames a second": quality.framesPerSecond.toFixed(1),
    "Sub-pixels a pixel": String((statistics.supersampling ?? 0) ** 2),
    "Textures decoded": String(statistics.decoded),
    "Decoding one": `${statistics.decodeMs.toFixed(1)} ms`,
    Fetched: counts.fetched < MIB ? `${(counts.fetched / 1024).toFixed(1)} KiB` : mib(counts.fetched),
    "Requests tried again": String(counts.retries),
    Resident: mib(store.bytes),
    "Most resident": mib(store.peak),
    "Removed for others": String(store.evictions),
    "Without room": String(player.refused.size),
    "Decoders' memory": mib(pool.memory),
    "Frames with misses": `${statistics.misses} of ${statistics.frames}`,
  };
}

function showStatistics() {
  if (player === null || !byId("statistics").open) return;
  const rows = Object.entries(statisticsRows()).flatMap(([name, value]) => ["dt", "dd"].map((tag, i) =>
    Object.assign(document.createElement(tag), { textContent: i === 0 ? name : value })));
  byId("statistics-list").replaceChildren(...rows);
}

// ---- Events

byId("play").addEventListener("click", togglePlaying);
byId("record").addEventListener("click", toggleRecording);
byId("full-screen").addEventListener("click", toggleFullScreen);
byId("retry").addEventListener("click", () => {
  if (player !== null) {
    forget();
    player.retry();
  } else if (opened !== null) {
    open(opened);
  }
});
byId("smooth").addEventListener("change", () => player?.setSmooth(byId("smooth").checked));
byId("fine").addEventListener("change", () => player?.setFull(byId("fine").checked));
byId("budget").addEventListener("change", () => player?.setBudget(Number(byId("budget").value) * MIB));
byId("exposure").addEventListener("input", () => {
  if (player === null) return;
  player.exposure = 2 ** Number(byId("exposure").value);
  player.requestDraw();
});
byId("theme").addEventListener("change", () => {
  const { value } = byId("theme");
  if (value) document.documentElement.dataset.theme = value;
  else delete document.documentElement.dataset.theme;
});
byId("export").addEventListener("click", () => {
  const url = URL.createObjectURL(new Blob([path.text()], { type: "application/json" }));
  Object.assign(document.createElement("a"), { href: url, download: "path.json" }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
});
byId("import").addEventListener("change", async ({ target }) => {
  const [file] = target.files;
  target.value = "";
  if (file === undefined || player === null) return;
  try {
    path = RecordedPath.parse(await file.text(), player.description.parameters);
    showPath();
  } catch (error) {
    say(`${file.name}: ${errorText(error)}`);
  }
});
byId("open").addEventListener("change", ({ target }) => {
  try {
    const files = [...target.files];
    chosen(files);
    open(() => chosen(files));
  } catch (error) {
    say(errorText(error));
  }
  target.value = "";
});
document.addEventListener("keydown", (event) => {
  const isTyping = event.target.closest("input:not([type=range], [type=checkbox]), select, textarea");
  if (isTyping || event.altKey || event.ctrlKey || event.metaKey) return;
  const isButton = event.target.closest("button, summary, input");
  const actions = { f: toggleFullScreen, r: toggleRecording,
    s: () => { byId("statistics").open = !byId("statistics").open; showStatistics(); },
    ...(isButton ? {} : { " ": togglePlaying }) };
  const action = actions[event.key.toLowerCase()];
  if (action === undefined || player === null) return;
  event.preventDefault();
  action();
});
setInterval(showStatistics, STATISTICS_MS);

open(configured);
