// SPDX-License-Identifier: Apache-2.0
// Fills the page of `multum export --page` with tables, pictures and moving pictures of every filtering method.

const { names, distances, motions, report } = data;
const ids = Object.keys(names);
const percent = (share) => (100 * share).toFixed(share < 0.0995 ? 1 : 0);
const twoPlaces = (value) => value.toFixed(2);
const OWN = report.anisotropy ? "anisotropic" : "isotropic";
// Shows the lowest number of a row in bold.
const withBest = (values, text) => {
  const least = Math.min(...values);
  return values.map((value) => (value === least ? { best: text(value) } : text(value)));
};
const columnsOf = (heads) => [{ head: "", isText: true }, ...heads.map((head) => ({ head }))];
const transposed = (columns) => columns[0].map((_, row) => columns.map((column) => column[row]));

function measuredTable() {
  const { levels, names: rules } = report.accuracy;
  const rows = Object.keys(rules);
  const columns = levels.flatMap(({ rules: of }) => [
    withBest(rows.map((id) => of[id].error), percent).map((cell, i) => {
      const wide = ` (${percent(of[rows[i]].wide.error)})`;
      return cell.best ? { best: cell.best + wide } : cell + wide;
    }),
    rows.map((id) => twoPlaces(of[id].energy))]);
  const heads = levels.flatMap(({ level }) => [`level ${level}`, "energy"]);
  return table(columnsOf(heads), transposed([rows.map((id) => rules[id]), ...columns]));
}

function distanceSection({ level, models, pictures }) {
  const texels = 2 ** level;
  const figure = (id, caption) => node("figure", {},
    node("img", { src: `data:image/png;base64,${pictures[id]}`, alt: `${id}, ${texels} texels per pixel`, width: 96,
      height: 96 }), node("figcaption", {}, caption));
  return [node("h3", {}, `A pixel covers ${texels} \u00d7 ${texels} texels`), node("div", { class: "pictures" },
    figure("reference", node("b", {}, "reference")),
    ids.map((id) => figure(id, [node("b", {}, names[id]),
      `: error ${percent(models[id].error)} %, energy ${twoPlaces(models[id].energy)}`])))];
}

function motionTable() {
  const heads = motions.flatMap(({ id }) => [`${id}: error, %`, "flicker, %", "change, %"]);
  const reference = motions.flatMap(({ reference_change: change }) => ["0", "0", percent(change)]);
  const columns = motions.flatMap(({ models }) => [
    withBest(ids.map((id) => models[id].error), percent), withBest(ids.map((id) => models[id].flicker), percent),
    ids.map((id) => percent(models[id].change))]);
  return table(columnsOf(heads), [["reference", ...reference],
    ...transposed([ids.map((id) => names[id]), ...columns])]);
}

function limitText() {
  const last = distances.at(-1).models, one = percent(last[OWN].error);
  const side = 2 ** distances.at(-1).level;
  const text = `Here the error of one lobe is ${one} % where a pixel covers ${side} texels per side`;
  return last.baked ? `${text}; the error of ${names.baked} per texel is ${percent(last.baked.error)} %.`
    : `${text}. Baked lobes (multum bake) have a lower error; a run without --no-measure compares them.`;
}

function movingPictures() {
  const video = node("video", { src: `data:video/webm;base64,${data.video}`, autoplay: true, loop: true, muted: true,
    playsinline: true, controls: true });
  video.muted = true;
  const shown = ["reference", ...ids.map((id) => names[id])];
  const rows = Math.ceil(shown.length / 3);
  return [video, node("ol", { style: `grid-template-rows: repeat(${rows}, 1fr)` },
    shown.map((name) => node("li", {}, name)))];
}

fillTemplate();
byId("base").append(report.roughness ? "its roughness from a map" : `base roughness ${report.base_roughness}`);
byId("kind").append(report.anisotropy ? "with anisotropy" : "isotropic");
byId("limit").append(limitText());
if (report.accuracy) {
  byId("cells").append(String(report.accuracy.cells.length));
  const noises = report.accuracy.levels.map(({ level, noise }) => `${(100 * noise).toFixed(2)} % (level ${level})`);
  byId("noise").append(noises.join(", "));
  byId("measured").append(measuredTable());
}
byId("distances").append(...distances.flatMap(distanceSection));
byId("motions").append(motionTable());
if (data.video) byId("moving").append(...movingPictures());
else byId("no-video").append("No moving pictures: ffmpeg (Debian package ffmpeg) is missing or failed.");
