// SPDX-License-Identifier: Apache-2.0
// Draws the page of `multum tradeoff`. For the rows of its JSON, the page shows plots, commands, sortable tables and
// pictures.

const MIB = 1 << 20;
const percent = (share) => (share === undefined ? "-" : (100 * share).toFixed(2));
const milliseconds = (seconds) => (1000 * seconds).toFixed(0);
const mebibytes = (bytes) => (bytes / MIB).toFixed(2);
const frameTime = (ms) => (ms === undefined ? "-" : ms.toFixed(1));

// The costs that plots and fronts use. Each entry has a key of `fronts`, and a function that returns the cost of a row.
// A cost is > 0 if it is known.
const COSTS = [
  { title: "Work of a bake", unit: "milliseconds", front: "bake_work", of: (row) => 1000 * row.bake_work_seconds },
  { title: "Memory on the GPU", unit: "MiB", front: "gpu_bytes", of: (row) => row.gpu_bytes / MIB },
  { title: "Work of a frame", unit: "milliseconds", front: "frame_work", of: (row) => row.frame_work_ms ?? -1 },
];

// Rows that are only drawn have no `fronts`.
const isMeasured = (row) => row.fronts !== undefined;
const isOnFront = (row) => isMeasured(row) && Object.values(row.fronts).includes(true);
const fits = (row) => row.fits !== false;
const rankedError = (row) => row.relative_l1;
const code = (text) => node("code", {}, text);
const nameOf = (row) => row.bake + (row.view ? `, drawn with ${row.view}` : "");
const errorText = (row) => `${percent(row.relative_l1)} +- ${percent(row.confidence_95)} %` +
  (row.rendered_relative_l1 === undefined ? "" : `, ${percent(row.rendered_relative_l1)} % in its picture`);

const octaveText = (octave) => `${2 ** octave} to ${2 ** (octave + 1)} texels`;

function budgetText() {
  const { gpu_bytes, frame_ms, bake_seconds } = data.budget;
  return [gpu_bytes !== undefined && `${general(gpu_bytes / MIB, 4)} MiB on the GPU`,
    frame_ms !== undefined && `${general(frame_ms, 4)} ms per frame`,
    bake_seconds !== undefined && `${general(1000 * bake_seconds, 4)} ms of baking`].filter(Boolean).join(", ");
}

/** The requested target, and the settings chosen for it. */
function choice() {
  const { error, bake_seconds } = data.asked;
  const parts = [];
  if (error !== undefined) parts.push(`an error of ${general(100 * error, 4)} %`);
  else if (bake_seconds !== undefined) parts.push(`${milliseconds(bake_seconds)} ms of baking`);
  if (data.budget) parts.push(budgetText());
  if (parts.length === 0) return [];
  const asked = parts.join(" within ");
  if (data.chosen === undefined) return [node("p", {}, node("b", {}, `No settings reach ${asked}.`))];
  const row = data.rows[data.chosen];
  return [node("h2", {}, `For ${asked}`),
    node("p", {}, `${errorText(row)} (95 % of pixels within ${percent(row.percentile_95)} %; worst: ` +
      `${percent(row.worst_octave_relative_l1)} % for pixels that cover ${octaveText(row.worst_octave)}) in ` +
      `${milliseconds(row.bake_seconds)} ms, ` +
      `${mebibytes(row.gpu_bytes)} MiB on the GPU: the ` +
      `${error !== undefined ? "cheapest" : "most accurate"} settings that meet this.`),
    node("pre", {}, row.command)];
}

// Groups also have different shapes, because a printed page may have no colours. Each shape lists corners around the
// mark's centre. A circle has no corners.
const SHAPES = [
  null,
  [[-3.6, -3.6], [3.6, -3.6], [3.6, 3.6], [-3.6, 3.6]],
  [[0, -5], [5, 0], [0, 5], [-5, 0]],
  [[0, -5], [4.6, 3.8], [-4.6, 3.8]],
  [[-4, -4], [0, -1.5], [4, -4], [1.5, 0], [4, 4], [0, 1.5], [-4, 4], [-1.5, 0]],
  [[0, 5], [4.6, -3.8], [-4.6, -3.8]],
  [[-2, -5], [2, -5], [2, 5], [-2, 5]],
  [[-5, -2], [5, -2], [5, 2], [-5, 2]],
];
const groups = [...new Set(data.rows.filter(isMeasured).map((row) => row.group))];
const shapeOf = (group) => SHAPES[groups.indexOf(group) % SHAPES.length];

function mark(shape, x, y, classes, title) {
  const titled = svgNode("title", {}, title);
  if (shape === null) return svgNode("circle", { class: classes, cx: x.toFixed(1), cy: y.toFixed(1), r: 4 }, titled);
  const points = shape.map(([dx, dy]) => `${(x + dx).toFixed(1)},${(y + dy).toFixed(1)}`).join(" ");
  return svgNode("polygon", { class: classes, points }, titled);
}

// Ticks of a logarithmic axis are 1, 2 and 5 times powers of ten within the range. If there are many decades, only the
// powers are used.
function ticks(low, high) {
  const all = [];
  for (let decade = Math.floor(Math.log10(low)); 10 ** decade <= high; ++decade)
    for (const digit of [1, 2, 5]) {
      const value = Number(`${digit}e${decade}`);
      if (value >= low && value <= high) all.push(value);
    }
  if (all.length <= 7) return all;
  const powers = all.filter((value) => value.toExponential().startsWith("1e"));
  return powers.length >= 2 ? powers : all;
}

const WIDTH = 400, HEIGHT = 300, LEFT = 46, TOP = 26, RIGHT = WIDTH - 12, BOTTOM = HEIGHT - 40;

/** Positions of values on a logarithmic axis whose ends are drawn at `from` and `to`. */
function axis(values, margin, from, to) {
  const low = Math.min(...values) / margin, high = Math.max(...values) * margin;
  return { low, high, at: (value) => from + (to - from) * Math.log(value / low) / Math.log(high / low) };
}

const line = (kind, x1, y1, x2, y2) => svgNode("line", { class: kind, x1, y1, x2, y2 });
const label = (x, y, anchor, text) => svgNode("text", { x, y, "text-anchor": anchor }, text);

function axes(x, y, unit) {
  return [
    ticks(x.low, x.high).map((tick) => [line("grid", x.at(tick).toFixed(1), TOP, x.at(tick).toFixed(1), BOTTOM),
      label(x.at(tick).toFixed(1), BOTTOM + 14, "middle", general(tick))]),
    ticks(100 * y.low, 100 * y.high).map((tick) => {
      const at = y.at(tick / 100);
      return [line("grid", LEFT, at.toFixed(1), RIGHT, at.toFixed(1)),
        label(LEFT - 5, (at + 4).toFixed(1), "end", general(tick))];
    }),
    line("axis", LEFT, TOP, LEFT, BOTTOM), line("axis", LEFT, BOTTOM, RIGHT, BOTTOM),
    label(RIGHT, HEIGHT - 8, "end", unit), label(4, HEIGHT - 8, null, "error, %"),
  ].flat(2);
}

/** Plots error against a cost, with the front; null if no row has that cost. */
function plot(cost) {
  const rows = data.rows.filter((row) => isMeasured(row) && cost.of(row) > 0 && rankedError(row) > 0)
    .sort((a, b) => cost.of(a) - cost.of(b));
  if (rows.length === 0) return null;
  const x = axis(rows.map(cost.of), 1.2, LEFT, RIGHT);
  const y = axis(rows.map(rankedError), 1.15, BOTTOM, TOP);
  const front = [];
  for (const row of rows) {
    if (!row.fronts[cost.front]) continue;
    const at = x.at(cost.of(row)).toFixed(1);
    if (front.length > 0) front.push(`${at},${front.at(-1).split(",")[1]}`);
    front.push(`${at},${y.at(rankedError(row)).toFixed(1)}`);
  }
  const marks = rows.map((row) => mark(shapeOf(row.group), x.at(cost.of(row)), y.at(rankedError(row)),
    (row.fronts[cost.front] ? "mark onfront" : "mark") + (fits(row) ? "" : " over"),
    `${nameOf(row)}: ${percent(rankedError(row))} %, ${general(cost.of(row), 4)} ${cost.unit}`));
  const attributes = { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `error against ${cost.title}` };
  return node("figure", {}, svgNode("svg", attributes,
    svgNode("text", { class: "title", x: LEFT, y: 14 }, cost.title), axes(x, y, cost.unit),
    svgNode("polyline", { class: "front", points: front.join(" ") }), marks));
}

function legend() {
  const lines = groups.map((group) => [shapeOf(group), "mark", group, group]);
  if (data.budget) lines.push([null, "mark over", "beyond the budget", "pale: beyond the budget"]);
  lines.push([null, "mark onfront", "on the front", "filled: on the front"]);
  const height = 22 * lines.length + 12;
  const attributes = { viewBox: `0 0 360 ${height}`, role: "img", "aria-label": "meaning of the marks" };
  return node("figure", {}, svgNode("svg", attributes, lines.flatMap(([shape, classes, title, text], i) => [
    mark(shape, 14, 14 + 22 * i, classes, title), label(30, 18 + 22 * i, null, text)])));
}

/** Rows that `row` represents, because they are indistinguishable from it. */
const sameAs = (row) => data.rows.filter((other) => other.same_as === data.rows.indexOf(row));

/** A row on a front: its errors and costs, warnings and command. */
function frontEntry(row) {
  const fronts = COSTS.filter((cost) => row.fronts[cost.front]).map((cost) => cost.title).join(", ");
  const bake = `${milliseconds(row.bake_work_seconds)} ms of work (${milliseconds(row.bake_seconds)} elapsed) to bake`;
  const frame = row.frame_ms === undefined ? "" : `, ${frameTime(row.frame_work_ms)} ms of work per frame`;
  const figures = `; ${bake}, ${mebibytes(row.gpu_bytes)} MiB on the GPU${frame}; front of: ${fronts}` +
    (fits(row) ? "" : "; beyond the budget");
  const warnings = (row.warnings ?? []).flatMap((warning) => [node("br"), `Warning: ${warning}`]);
  const same = sameAs(row).flatMap((other, i) => [i === 0 ? null : ", ", code(nameOf(other))].filter(Boolean));
  if (same.length > 0) same.unshift(node("br"), "Indistinguishable from it: ");
  return [node("p", { class: "soft" }, node("b", {}, errorText(row)), figures, same, warnings),
    node("pre", {}, row.command)];
}

function measuredTable() {
  const columns = [{ head: "settings", isText: true }, { head: "varied", isText: true },
    ...["error", "\u00b1\u00a095\u00a0%", "95th percentile", "worst octave", "rendered", "bake, ms of work",
      "bake, ms elapsed", "frame, ms of work", "frame, ms elapsed",
      "file, MiB", "GPU, MiB"].map((head) => ({ head }))];
  const rows = data.rows.filter(isMeasured).map((row) => {
    const name = row.view ? [code(row.bake), " ", code(row.view)] : [code(row.bake)];
    const error = percent(row.relative_l1);
    return [fits(row) ? name : node("s", {}, name), row.group, isOnFront(row) ? { best: error } : error,
      percent(row.confidence_95), percent(row.percentile_95), percent(row.worst_octave_relative_l1),
      percent(row.rendered_relative_l1), milliseconds(row.bake_work_seconds), milliseconds(row.bake_seconds),
      frameTime(row.frame_work_ms), frameTime(row.frame_ms), mebibytes(row.file_bytes),
      mebibytes(row.gpu_bytes)];
  });
  return table(columns, rows, { class: "sortable" });
}

function othersTable() {
  const columns = [...["baked with", "drawn with", "varied"].map((head) => ({ head, isText: true })),
    ...["error", "\u00b1\u00a095\u00a0%", "rendered", "frame, ms of work"].map((head) => ({ head }))];
  const rows = data.rows.filter((row) => !isMeasured(row)).map((row) => [code(row.bake), code(row.view), row.group,
    percent(row.relative_l1), percent(row.confidence_95), percent(row.rendered_relative_l1),
    frameTime(row.frame_work_ms)]);
  return table(columns, rows, { class: "sortable" });
}

function picture(png, ...caption) {
  return node("figure", {}, node("img", { alt: "", src: `data:image/png;base64,${png}` }),
    node("figcaption", {}, caption));
}

/** Makes a click on a head sort by that column; another click reverses the order. Cells without a number come last. */
function makeSortable(sorted) {
  const heads = [...sorted.rows[0].cells];
  heads.forEach((head, column) => {
    head.tabIndex = 0;
    const sort = () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const isText = head.classList.contains("text");
      const key = (row) => {
        const text = row.cells[column].textContent, number = parseFloat(text);
        return isText ? text : isNaN(number) ? Infinity * (up ? 1 : -1) : number;
      };
      const rows = [...sorted.rows].slice(1);
      rows.sort((a, b) => (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : 0) * (up ? 1 : -1));
      rows.forEach((row) => row.parentNode.append(row));
    };
    head.onclick = sort;
    head.onkeydown = (event) => { if (event.key === "Enter") sort(); };
  });
}

fillTemplate({ wholeSeconds: (seconds) => seconds.toFixed(0), wholePercent: (share) => (100 * share).toFixed(0) });
if (data.budget) byId("budget").append(budgetText());
byId("choice").append(...choice());
byId("plots").append(...COSTS.map(plot).filter(Boolean), legend());
byId("fronts").append(...data.rows.filter((row) => isOnFront(row) && row.same_as === undefined)
  .sort((a, b) => rankedError(a) - rankedError(b))
  .flatMap(frontEntry));
byId("rows").append(measuredTable());
if (data.has_others) byId("others").append(othersTable());
if (data.reference_picture) {
  byId("pictures").append(picture(data.reference_picture, node("b", {}, "reference")));
  for (const row of data.rows.filter((one) => one.picture))
    byId("pictures").append(picture(row.picture, node("b", {}, `error ${percent(row.rendered_relative_l1)} %`),
      `: ${nameOf(row)}`));
}
for (const sortable of document.querySelectorAll("table.sortable")) makeSortable(sortable);
