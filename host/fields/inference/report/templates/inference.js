// SPDX-License-Identifier: Apache-2.0
// Fills the page of `multum infer` with the errors, pictures, times and counts of report.json. The C++ code adds
// `samples` with their places on the parameter grid, `pictures`, and the `texels` of layers.

// The seconds per point of the parameter space in the paper's table "System Performance". The table lists texture
// coordinate optimisation (.93 s), obtaining matrix A (2.15 min) and solving for textures (2.68 min).
const PAPER_SECONDS = { mapping: 0.93, probing: 2.15 * 60, solving: 2.68 * 60 };
const NONE = "\u2013";

const { objects, layers, frames, comparison, parameters, samples, pictures, seconds } = data;
// Formats a number with three digits. The value null means that there is no number.
const mse = (value) => (value === null ? NONE : value.toFixed(value < 9.995 ? 2 : value < 99.95 ? 1 : 0));
const secondsText = (value) => value.toFixed(value < 9.95 ? 2 : 1);
const counted = (count, what) => `${count} ${what}${count === 1 ? "" : "s"}`;
const sum = (values) => values.reduce((total, value) => total + value, 0);
const totalSeconds = sum(Object.values(seconds));
const allLayers = objects.flatMap((object) => object.layers);

function sourceText() {
  const grid = parameters.map(({ count, name }) => `${count} ${name}`).join(" \u00d7 ");
  const textures = counted(sum(allLayers.map((layer) => layer.textures)), "texture");
  return `${textures} of ${counted(objects.length, "object")} were inferred from ` +
    `${counted(samples.length, "ray-traced picture")} of ${data.width} \u00d7 ${data.height} pixels (${grid}), so ` +
    "that OpenGL renderers that draw the objects with them reproduce these pictures (Hakura et al. 2000).";
}

function framesText() {
  if (frames === null) return ["No frames were drawn with them (", node("code", {}, "--no-frames"), ")."];
  if (!(frames.pixels > 0)) return ["No frame has a pixel that objects cover completely."];
  const uncovered = sum(frames.samples.map((frame) => frame.uncovered_pixels));
  const notFinite = sum(frames.samples.map((frame) => frame.not_finite_pixels));
  const rms = Math.sqrt(frames.mse);
  const ratio = rms > 0 ? ` (PSNR ${(20 * Math.log10(255 / rms)).toFixed(1)} dB)` : "";
  const count = counted(frames.samples.length, "frame"), all = uncovered + notFinite + frames.pixels;
  return [
    node("b", {}, `${count} drawn with them by multum-view have a mean squared error of ${mse(frames.mse)}`),
    `, or a root mean square error of ${mse(rms)} of 255 steps${ratio}.`,
    uncovered > 0 ? ` ${uncovered} of ${all} pixels are not covered completely by objects and are left out.` : "",
    notFinite > 0 ? ` ${notFinite} pixels are left out because they are not finite.` : "",
  ];
}

function layersText() {
  const pixels = sum(allLayers.map((layer) => layer.pixels));
  if (!(pixels > 0)) return "";
  const squares = sum(allLayers.map((layer) => (layer.mse ?? 0) * layer.pixels));
  let text = "By itself, each texture fits the pixels of its layer with a mean squared error of " +
    mse(squares / pixels);
  if (allLayers.every((layer) => layer.forward_mapping_mse !== null)) {
    const forward = sum(allLayers.map((layer) => layer.forward_mapping_mse * layer.pixels));
    text += ". Forward mapping puts the same pixels into textures but ignores OpenGL's filter; it " +
      `has ${mse(forward / pixels)}: ${(forward / Math.max(squares, 1e-12)).toFixed(1)} times as much`;
  }
  text += ".";
  const heldOut = allLayers.map((layer) => layer.held_out).filter(Boolean);
  const heldOutPixels = sum(heldOut.map((one) => one.pixels));
  const heldOutSquares = sum(heldOut.map((one) => one.mse * one.pixels));
  if (heldOutPixels > 0) text += ` In held-out pictures the error is ${mse(heldOutSquares / heldOutPixels)}.`;
  return text;
}

function tookNodes() {
  const there = sum(allLayers.map((layer) => layer.textures_there));
  if (there === sum(allLayers.map((layer) => layer.textures)))
    return [node("p", {}, "All textures were made by an earlier run, so the times of this run do not include " +
      "inferring them.")];
  return [
    there === 0 ? null :
      node("p", {}, `${there} of the textures were made by an earlier run; times are for the others.`),
    node("p", {}, `Measuring OpenGL's filter took ${secondsText(seconds.probing)} s, solving for the ` +
      `textures ${secondsText(seconds.systems + seconds.solving)} s, and all stages together ` +
      `${secondsText(totalSeconds)} s. This scene has ${samples.length} points of the parameter space. For another ` +
      "scene, the paper reports 2.15 min and 2.68 min per point on machines of its time."),
  ].filter(Boolean);
}

/** `scale` is the number of CSS pixels per pixel, so that small objects are visible. */
function picture({ file, width, height }, scale, alt, ...caption) {
  return node("figure", {}, node("img", { src: file, width: scale * width, height: scale * height, alt }),
    node("figcaption", {}, caption));
}

function threePictures(row, what) {
  const { width, height } = row.error;
  const scale = Math.min(8, Math.max(1, Math.min(Math.floor(380 / width), Math.floor(340 / height))));
  return node("div", { class: "three" },
    picture(row.ray_traced, scale, `${what}, ray-traced`, node("b", {}, "ray-traced"),
      scale > 1 ? `, ${scale} times enlarged` : ""),
    picture(row.rendered, scale, `${what}, drawn with inferred textures`,
      node("b", {}, "drawn with inferred textures")),
    picture(row.error, scale, `${what}, absolute error times 20`, node("b", {}, "error \u00d7 20"),
      `, black for none; MSE ${mse(row.mse)}`));
}

function objectTable() {
  const hasHeldOut = allLayers.some((layer) => layer.held_out);
  const heads = ["textures", "texels", "MSE", "forward mapping", "ratio", hasHeldOut && "held out", "worst sample",
    "iterations, median", "at most", "not converged", frames && "in frames"].filter(Boolean);
  const columns = [{ head: "object", isText: true }, { head: "layer", isText: true },
    ...heads.map((head) => ({ head }))];
  const rows = objects.flatMap((object) => object.layers.map((layer, i) => {
    const { iterations, worst_sample: worst } = layer;
    return [i === 0 ? object.name : "", layer.name, layer.textures, layer.texels, mse(layer.mse),
      mse(layer.forward_mapping_mse), layer.ratio === null ? NONE : layer.ratio.toFixed(2),
      ...(hasHeldOut ? [mse(layer.held_out?.mse ?? null)] : []),
      worst ? `${mse(worst.mse)} (${worst.name})` : NONE,
      iterations ? general(iterations.median) : NONE, iterations ? iterations.max : NONE, layer.not_converged,
      ...(frames ? [i === 0 && object.frames.mse !== null ? mse(object.frames.mse) : ""] : [])];
  }));
  return table(columns, rows);
}

/** Shows the least value of each column in bold. */
function comparisonTable() {
  const least = objects.map(({ name }) =>
    Math.min(...comparison.rows.map((row) => row.mse[name]).filter((value) => value !== null)));
  const rows = comparison.rows.map((row) => [row.name, ...objects.map(({ name }, k) => {
    const value = row.mse[name];
    return value !== null && value <= least[k] ? { best: mse(value) } : mse(value);
  })]);
  return table([{ head: "inferred with", isText: true }, ...objects.map(({ name }) => ({ head: name }))], rows);
}

const LEFT = 44, TOP = 4; // position of a heat map's cells
const label = (x, y, anchor, text, kind = null) =>
  svgNode("text", { class: kind, x: general(x), y: general(y), "text-anchor": anchor }, text);

// The columns are the last parameter, which changes fastest between samples. The rows are all other parameters
// together.
const columnCount = parameters.length > 0 ? parameters.at(-1).count : 1;
const rowCount = Math.floor(samples.length / columnCount);
const cellWidth = Math.min(42, Math.max(4, 336 / columnCount)), cellHeight = cellWidth < 30 ? cellWidth : 24;

/**
 * Returns a text that names the parameters across and down a heat map. It is below the map, because names may be long.
 */
function axesText() {
  if (parameters.length === 0) return "";
  const others = parameters.slice(0, -1).map(({ name }) => name);
  return `; across: ${parameters.at(-1).name} 0 to ${columnCount - 1}` +
    (others.length > 0 ? `, down: ${others.join(", ")}` : "");
}

function rowLabels() {
  if (parameters.length < 2) return [];
  const labels = [];
  const step = Math.max(1, Math.ceil(12 / cellHeight)); // labels are 12 units high
  for (let row = 0; row < rowCount; row += step)
    labels.push(label(LEFT - 6, TOP + (row + 0.5) * cellHeight + 4, "end",
      samples[row * columnCount].at.slice(0, -1).join(",")));
  return labels;
}

/** Draws a cell for each frame by its error `valueOf(frame)`. Returns null if no frame shows the object. */
function heatMap(what, valueOf) {
  const known = frames.samples.map(valueOf).filter((value) => value !== null);
  if (known.length === 0) return null;
  const least = Math.min(...known), most = Math.max(...known);
  const cells = frames.samples.flatMap((frame) => {
    const x = LEFT + frame.sample % columnCount * cellWidth;
    const y = TOP + Math.floor(frame.sample / columnCount) * cellHeight;
    const box = { x: general(x + 0.5), y: general(y + 0.5), width: general(cellWidth - 1),
      height: general(cellHeight - 1) };
    const value = valueOf(frame), made = [];
    if (value === null) {
      made.push(svgNode("rect", { class: "none", ...box }, svgNode("title", {}, `${frame.name}: not seen`)));
    } else {
      const share = most > least ? (value - least) / (most - least) : 0;
      made.push(svgNode("rect", { class: "cell", ...box, "fill-opacity": (0.08 + 0.57 * share).toFixed(3) },
        svgNode("title", {}, `${frame.name}: MSE ${mse(value)}`)));
      if (cellWidth >= 30)
        made.push(label(x + 0.5 * cellWidth, y + 0.5 * cellHeight + 4, "middle", mse(value), "value"));
    }
    if (frame.name === data.report_sample) made.push(svgNode("rect", { class: "shown", ...box }));
    return made;
  });
  const range = `${mse(least)} to ${mse(most)}`;
  const width = LEFT + columnCount * cellWidth + 4, height = TOP + rowCount * cellHeight + 4;
  const attributes = { viewBox: `0 0 ${general(width)} ${general(height)}`, role: "img",
    style: `max-width: ${general(1.25 * width)}px`,
    "aria-label": `MSE of ${what} by sample, ${range}` };
  return node("figure", {}, svgNode("svg", attributes, rowLabels(), cells),
    node("figcaption", {}, node("b", {}, what), `, ${range}${axesText()}`));
}

function timeTable() {
  const stages = [["texture coordinates", "mapping"], ["measuring filter matrices", "probing"],
    ["splitting pictures into objects", "segmentation"], ["setting up systems", "systems"],
    ["solving for textures", "solving"], ["forward mapping, for comparison", "baseline"],
    ["drawing and comparing frames", "rendering"]];
  const row = (name, value, paper) => [name, secondsText(value), (value / samples.length).toFixed(3),
    paper ? secondsText(paper) : ""];
  const columns = [{ head: "stage", isText: true }, { head: "seconds" }, { head: "per sample" },
    { head: "paper, per sample" }];
  return table(columns, [...stages.map(([name, key]) => row(name, seconds[key], PAPER_SECONDS[key])),
    row("together", totalSeconds)]);
}

function mappingTable() {
  const hasBlocks = data.blocks.length > 1;
  const figures = (mapping) => {
    if (mapping === null) return ["not seen"];
    const cuts = mapping.cut.map((at, d) => (at === null ? null : `${"uv"[d]} = ${at.toFixed(3)}`)).filter(Boolean);
    return [`${mapping.width} \u00d7 ${mapping.height}`, mapping.stretch_max.toFixed(3), mapping.stretch_rounds,
      cuts.join(", ") || "none", mapping.visible_pixels, mapping.degenerate_pixels];
  };
  const columns = [{ head: "object", isText: true }, ...(hasBlocks ? [{ head: "samples", isText: true }] : []),
    ...["texels", "stretch", "rounds of scaling", "cut at", "visible pixels", "degenerate"].map((head) => ({ head }))];
  return table(columns, objects.flatMap((object) => object.mappings.map((mapping, block) => [
    block === 0 ? object.name : "", ...(hasBlocks ? [data.blocks[block]] : []), ...figures(mapping)])));
}

function countTable() {
  const s = data.segmentation;
  return table([{ head: "what", isText: true }, { head: "count" }], [
    ["pixels of objects' layers that were not finite", s.not_finite_pixels],
    ["negative pixels", s.negative_pixels],
    ["of these, repaired from neighbours", s.repaired_pixels],
    ["of these, dropped", s.dropped_pixels],
    ["mixed pixels, split into objects", s.mixed_pixels],
    ["of these, without a completely covered pixel nearby", s.unguided_pixels],
    ["values below 0 after that, set to 0", s.clamped_values],
    ["values above the radiance maximum, clipped", s.clipped_values],
    ["depths that are not numbers", data.nan_depths],
    ["rows of filter matrices", data.rows],
    ["of these, rejected", data.rows_rejected],
    ["matrices measured in this run", data.matrices_measured],
    ["systems solved in normal form", data.systems.normal],
    ["systems solved with the matrix", data.systems.matrix],
  ]);
}

data.has_held_out = data.settings.hold_out >= 2;
fillTemplate({
  general: (value) => general(value),
  rendererName: (name) => name || "not used in this run",
  heldOut: (number) => (number >= 2 ? `every view number ${number} held out` : "no view held out"),
});
byId("source").append(sourceText());
byId("frames").append(...framesText());
const fits = layersText();
if (fits) byId("layers").append(fits);
else byId("layers").remove();
byId("took").replaceWith(...tookNodes());
byId("object-table").append(objectTable());
if (comparison?.rows.length) byId("comparison").append(comparisonTable());
if (frames?.samples.length)
  byId("heat-maps").append(...[heatMap("whole frames", (frame) => frame.mse),
    ...objects.map((object, k) => heatMap(object.name, (frame) => frame.objects[k].mse))].filter(Boolean));
if (pictures.frame) {
  byId("frame-pictures").append(threePictures(pictures.frame, `the whole frame ${data.report_sample}`));
  pictures.objects.forEach((row, k) => {
    if (row) byId("object-pictures").append(node("h3", {}, objects[k].name), threePictures(row, objects[k].name));
  });
}
for (const { object, layer, picture: one } of pictures.textures) {
  const name = `${objects[object].name} ${layers[layer]}`;
  byId("textures").append(picture(one, 1, `texture of ${name}`, node("b", {}, name),
    `, ${one.width} \u00d7 ${one.height} texels`));
}
byId("times").append(timeTable());
byId("mappings").append(mappingTable());
byId("counts").append(countTable());
// The player is loaded only on request. If the file is missing, the object's content is shown.
byId("player").addEventListener("toggle", ({ target }) => {
  target.replaceWith(node("object", { id: "player", type: "text/html", data: "player.html", "aria-label": "player" },
    "This page's folder has no player.html yet. The command above writes it if FOLDER is this page's folder."));
});
