// SPDX-License-Identifier: Apache-2.0
// Tests baked files on multum look's page: .ndf.exr files of every kind, pages of several maps, damaged and hostile
// files. The page's worker decodes a file, and the drawing equals the page that multum look makes of the same file.
// Exits with 77 (skipped) if something is missing.
//
//   node look_files_test.mjs BIN_FOLDER SCREENSHOTS
import assert from "node:assert/strict";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import path from "node:path";
import { deflateSync } from "node:zlib";
import { drop, factsOf, goTo, pixelsOf, settled, startLook, viewOf } from "./look_browser.mjs";
import { lowContrasts } from "../service/page_contrast.mjs";

const [bin, screenshots] = process.argv.slice(2);
const look = await startLook(bin);
const { inFolder, run, complaints } = look;
// The window is small, because a processor needs a long time to draw a picture.
const open = (file, hash = "", more = {}) => look.open(file, hash, { width: 240, height: 600, ...more });
mkdirSync(screenshots, { recursive: true });
// The limit is in units of 1/255. The page of multum look has lobes in BC5 and 8-bit normals, whereas the decoded file
// has 16-bit floats and normals of full precision.
const CLOSE = 8;
const MEAN_MOST = 2.5, CLOSE_LEAST = 0.95;
const SAME_MOST = 0.5; // the limit for a page whose lobes are also 16-bit floats
const bake = (name, ...words) => run("multum", "bake", "map_normal.png", "-o", name, "--no-measure", "-q", ...words);
const bytesOf = (name) => readFileSync(inFolder(name));
const dropped = (page, ...names) => drop(page, ...names.map((name) => [name, bytesOf(name)]));

/** Returns the offset of the value of the header attribute `name` of type `type` in `file`, searching from `from`. */
function valueAt(file, name, type, from = 0) {
  const at = file.indexOf(Buffer.from(`${name}\0${type}\0`, "latin1"), from);
  assert.ok(at >= 0, `no attribute ${name}`);
  return at + name.length + type.length + 2 + 4;
}
const changed = (file, change) => { const bytes = Buffer.from(file); return change(bytes) ?? bytes; };

/** Returns the mean difference of two pages' pictures at a view, in 1/255, and the share of values within CLOSE. */
async function apart(one, other, hash) {
  for (const page of [one, other]) {
    await goTo(page, hash);
    await settled(page);
    await settled(page);
  }
  return other.evaluate(async ([url, close]) => {
    const rgba = (source) => {
      const context = new OffscreenCanvas(source.width, source.height).getContext("2d");
      context.drawImage(source, 0, 0);
      return context.getImageData(0, 0, source.width, source.height).data;
    };
    const image = new Image();
    image.src = url;
    await image.decode();
    const [want, found] = [rgba(image), rgba(document.getElementById("canvas"))];
    let [sum, count, near, brightest] = [0, 0, 0, 0];
    for (let i = 0; i < Math.max(want.length, found.length); ++i) {
      if (i % 4 === 3) continue;
      const off = Math.abs(want[i] - found[i]);
      count += 1;
      sum += off;
      near += off <= close ? 1 : 0;
      brightest = Math.max(brightest, want[i]);
    }
    return { mean: sum / count, close: near / count, brightest };
  }, [await pixelsOf(one), CLOSE]);
}

try {
  run("multum", "testmap", "map", "--size", "128", "--seed", "11");
  run("multum", "testmap", "other", "--size", "96", "--seed", "3");
  bake("map.ndf.exr");
  run("multum", "bake", "other_normal.png", "-o", "other.ndf.exr", "--no-measure", "-q", "--lobes", "2");
  run("multum", "look", "map.ndf.exr", "--source", "map_normal.png", "--no-open");
  run("multum", "look", "other.ndf.exr", "map.ndf.exr", "--no-open", "-o", "both.html");
  run("multum", "export", "map.ndf.exr", "--lobes", "--texels", "rgba16f", "-o", "halves.ktx2");

  // Tests the refusals of the command.
  const refused = (words, ...more) => assert.throws(() => run("multum", "look", ...more, "--no-open", "-o", "no.html"),
    (error) => error.status !== 0 && error.stderr.includes(words) && !existsSync(inFolder("no.html")));
  bake("rest.ndf.exr", "--first-level", "1");
  refused("expected level 0 too, or the normal map (--source)", "rest.ndf.exr");
  refused("found 1 --source, expected none, or one for each of the 2 files", "map.ndf.exr", "other.ndf.exr", "--source",
    "map_normal.png");
  refused("expected 96 x 96", "other.ndf.exr", "--source", "map_normal.png");
  refused("is not the file that other.ndf.exr was baked from", "other.ndf.exr", "--source", "map_normal.png",
    "--same-source");

  // On a page with two maps, the user chooses one from a list, and the address stores the choice.
  const both = await open("both.html");
  assert.match(await factsOf(both), /96 x 96, 2 lobes/);
  assert.deepEqual(await both.locator("#map option").allTextContents(), ["other.ndf.exr", "map.ndf.exr"]);
  await both.focus("#map");
  await both.keyboard.press("ArrowDown");
  await both.waitForFunction(() => globalThis.multumLook.shown === 1);
  await settled(both);
  assert.match(await factsOf(both), /128 x 128, 4 lobes/);
  assert.equal(await both.textContent("#title"), "map.ndf.exr");
  const kept = await open("both.html", await both.evaluate(() => location.hash));
  assert.match(await factsOf(kept), /128 x 128, 4 lobes/);
  await kept.evaluate(() => { location.hash = "map=40"; });
  await settled(kept);
  assert.equal((await viewOf(kept)).map, 1, "values of a foreign address must be clamped");
  // The picture equals the picture on a page that has only this map and reads the map instead of level 0.
  const page = await open("map.html");
  const same = await apart(page, kept, "left=export&right=lobes&map=1");
  assert.ok(same.mean < 0.05, `maps of several: ${same.mean}`);

  // A file that is dropped onto the page of another map looks the same as on its own page.
  const other = await open("both.html");
  assert.equal(await dropped(other, "map.ndf.exr"), "");
  assert.equal(await other.textContent("#about"), "map.ndf.exr, decoded here");
  assert.equal(await other.locator("#right option[value=export]").evaluate((one) => one.disabled), true);
  const halves = await open("map.html");
  assert.equal(await dropped(halves, "halves.ktx2"), "");
  for (const hash of ["left=lobes&split=1", "left=lobes&split=1&elevation=75&distance=-0.5&lock=2",
    "left=mip&right=rule&azimuth=30"]) {
    const { mean, close, brightest } = await apart(page, other, hash);
    const same = await apart(halves, other, hash);
    console.log(`  ${hash}: mean difference ${mean.toFixed(3)} of 255, within ${CLOSE}: ${(100 *
      close).toFixed(1)} %; beside halfs ${same.mean.toFixed(3)}`);
    assert.ok(brightest > 100, `${hash} is dark`);
    assert.ok(mean <= MEAN_MOST && close > CLOSE_LEAST, `${hash}: mean ${mean}, within ${CLOSE}: ${close}`);
    assert.ok(same.mean <= SAME_MOST, `${hash}: mean ${same.mean} against half floats`);
  }
  // The lobes equal the lobes of multum export --texels rgba16f, except that sums are rounded differently in single and
  // double precision.
  const [count, far] = await other.evaluate((base64) => {
    const halvesOf = (file) => file.levels.map((bytes) => new Uint16Array(bytes.slice().buffer));
    const value = (bits) => (bits & 0x8000 ? -1 : 1) * ((bits & 0x7c00) === 0 ? (bits & 1023) * 2 ** -24
      : (1024 + (bits & 1023)) * 2 ** (((bits >> 10) & 31) - 25));
    const want = halvesOf(globalThis.parseLobes(Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))));
    const found = halvesOf(globalThis.multumLook.file);
    const pairs = want.flatMap((level, l) => [...level].map((one, i) => Math.abs(value(one) - value(found[l][i]))));
    return [pairs.length, pairs.filter((one) => one > 2 ** -16).length];
  }, bytesOf("halves.ktx2").toString("base64"));
  assert.equal(count, 4 * 4 * (64 * 64 * 4 - 1) / 3);
  assert.ok(far < count / 1000, `${far} of ${count} half floats differ`);
  // The dropped file is now in the list with the page's own maps.
  assert.equal(await other.locator("#map option").last().textContent(), "map.ndf.exr (dropped)");
  await other.selectOption("#map", "0");
  assert.match(await factsOf(other), /96 x 96, 2 lobes/);
  assert.equal(await other.locator("#right option[value=export]").evaluate((one) => one.disabled), false);
  await other.selectOption("#map", "dropped");
  assert.match(await factsOf(other), /128 x 128, 4 lobes/);

  // Every supported compression gives the same texture.
  const texture = () => other.evaluate(async () => {
    const { file, means } = globalThis.multumLook;
    const bytes = new Uint8Array(await new Blob([...file.levels, means[0].texels]).arrayBuffer());
    return [...bytes].reduce((sum, one) => (Math.imul(sum, 31) + one) | 0, 7);
  });
  const hash = await texture();
  let plain;
  for (const compression of ["none", "rle", "zips", "zip:9"]) {
    bake("packed.ndf.exr", "--compression", compression, "--force");
    plain ??= bytesOf("packed.ndf.exr");
    await other.selectOption("#map", "0");
    assert.equal(await dropped(other, "packed.ndf.exr"), "", compression);
    assert.equal(await texture(), hash, compression);
  }
  // Tests 16-bit floats, 32-bit floats and colours.
  for (const words of [["-d", "half"], ["-d", "float"], ["--albedo", "map_albedo.png"]]) {
    bake("kind.ndf.exr", ...words, "--force");
    assert.equal(await dropped(other, "kind.ndf.exr"), "", words.join(" "));
    const { mean } = await apart(halves, other, "left=lobes&split=1");
    assert.ok(mean <= 1, `${words}: mean ${mean}`);
  }

  // A file without level 0 waits for its map and recognises it. The map and the file can be dropped in any order. A
  // green channel that points down is inverted.
  for (const green of ["up", "down"]) {
    bake("one.ndf.exr", "--lobes", "1", "--first-level", "2", "--green", green, "--force"); // a file that has one part
    bake("full.ndf.exr", "--green", green, "--force");
    const full = await open("both.html");
    assert.equal(await dropped(full, "full.ndf.exr"), "");
    assert.equal(await dropped(other, "one.ndf.exr"), "");
    assert.match(await other.textContent("#reading"), /one.ndf.exr leaves level 0 to its normal map/);
    assert.match(await dropped(other, "map_albedo.png"), /found normals that differ by .* from those of the lobes/);
    assert.match(await dropped(other, "other_normal.png"), /found 96 x 96, expected 128 x 128/);
    assert.equal(await dropped(other, "map_normal.png"), "");
    assert.match(await factsOf(other), /128 x 128, 1 lobe\./);
    const { mean } = await apart(full, other, "left=mip&split=1");
    console.log(`  8-bit map with green ${green}: mean difference ${mean.toFixed(3)} of 255`);
    assert.ok(mean < MEAN_MOST, `green ${green}: mean ${mean}`);
  }
  assert.equal(await dropped(other, "map_normal.png", "rest.ndf.exr"), "");
  assert.match(await factsOf(other), /128 x 128, 4 lobes/);
  assert.ok((await apart(halves, other, "left=lobes&split=1")).mean < 0.5);

  // An unsupported file is refused with a message, and the shown picture stays.
  bake("piz.ndf.exr", "--compression", "piz");
  bake("moments.ndf.exr", "--ndf", "moments");
  const shown = await pixelsOf(other);
  const good = bytesOf("map.ndf.exr");
  const windowAt = valueAt(good, "dataWindow", "box2i"), tilesAt = valueAt(good, "tiles", "tiledesc");
  const widthAt = valueAt(good, "multum:mapWidth", "int"), channelsAt = valueAt(good, "channels", "chlist");
  // The list of headers ends with an empty header. The offset table of the finest level follows it.
  const tableOf = (file) => file.lastIndexOf(Buffer.from("periodic,periodic\0\0", "latin1")) + 19;
  const tileOf = (file) => Number(file.readBigUInt64LE(tableOf(file)));
  const [tableAt, tileAt] = [tableOf(good), tileOf(good)];
  // This position is after the header of the tile and after one row of lobe values, which are 16-bit floats.
  const valuesAt = tileOf(plain) + 24 + 2 * 128;
  const bomb = deflateSync(Buffer.alloc(50e6));
  assert.equal(good.readInt32LE(tileAt), 0, "the first tile's part");
  for (const [words, bytes] of [
    ["compression PIZ", bytesOf("piz.ndf.exr")],
    ["representation moments", bytesOf("moments.ndf.exr")],
    ["ends after", good.subarray(0, 2000)],
    ["ends after", good.subarray(0, tableAt + 4)],
    ["no offset of tile", good.subarray(0, tileAt + 8)],
    ["beyond the end", good.subarray(0, tileAt + 40)],
    ["no magic number", changed(good, (b) => { b[3] = 2; })],
    ["version and flags", changed(good, (b) => { b[4] = 3; })],
    ["version and flags", changed(good, (b) => { b[5] = 0x08; })],
    ["data window", changed(good, (b) => { b.writeInt32LE(1e9, windowAt + 8); })],
    ["sides of 1 to 2048", changed(good, (b) => { b.writeInt32LE(1 << 30, widthAt); })],
    ["sides of 1 to 2048", changed(good, (b) => { b.writeInt32LE(-1, widthAt); })],
    ["a data window from", changed(good, (b) => { b.writeInt32LE(64, widthAt); })],
    ["tiles of 0 x", changed(good, (b) => { b.writeInt32LE(0, tilesAt); })],
    ["a tile of", changed(good, (b) => { b.writeInt32LE(1, tilesAt); b.writeInt32LE(1, tilesAt + 4); })],
    ["level mode 2", changed(good, (b) => { b[tilesAt + 8] = 2; })],
    ["channel finest.lobe.X of type 7", changed(good, (b) => { b[channelsAt + 14] = 7; })],
    ["no channel finest.normalX.X", changed(good, (b) => { b[b.indexOf("finest.normalX.X") + 7] = 78; })],
    ["compression DWAA", changed(good, (b) => { b[valueAt(b, "compression", "compression")] = 8; })],
    ["100 lobes", changed(good, (b) => { b[valueAt(b, "multum:lobeCount", "int")] = 100; })],
    ["no part lobe.4", changed(good, (b) => { b[valueAt(b, "multum:lobeCount", "int")] = 5; })],
    ["first level 30", changed(good, (b) => { b[valueAt(b, "multum:firstLevel", "int")] = 30; })],
    ["version 4 of the format", changed(good, (b) => { b[valueAt(b, "multum:formatVersion", "int")] = 4; })],
    ["a negative size", changed(good, (b) => { b.writeInt32LE(-8, windowAt - 4); })],
    ["ends after", changed(good, (b) => { b.writeInt32LE(1 << 30, windowAt - 4); })],
    ["a name of more than", changed(good, (b) => { b.fill(65, 8, 600); })],
    ["no offset of tile", changed(good, (b) => { b.fill(0, tableAt, tableAt + 8); })],
    ["no offset of tile", changed(good, (b) => { b.fill(255, tableAt, tableAt + 8); })],
    ["another tile at the offset", changed(good, (b) => { b.writeInt32LE(3, tileAt); })],
    ["beyond the end", changed(good, (b) => { b.writeInt32LE(0x7fffffff, tileAt + 20); })],
    ["beyond the end", changed(good, (b) => { b.writeInt32LE(-1, tileAt + 20); })],
    ["not a complete zlib stream", changed(good, (b) => { b[tileAt + 24] ^= 255; })],
    ["not a complete zlib stream", changed(good, (b) => { b.fill(0x55, tileAt + 60, tileAt + 400); })],
    ["not a complete zlib stream", changed(good, (b) => { b.writeInt32LE(100, tileAt + 20); })],
    ["NaN in channel finest.normalX.X", changed(plain, (b) => { b.writeFloatLE(NaN, valuesAt); })],
    ["5 in channel finest.normalX.X", changed(plain, (b) => { b.writeFloatLE(5, valuesAt); })],
    ["a tile of more than", changed(good, (b) => {
      const begin = b.length; // the last tile, which decompresses to 50 MB
      b.writeBigUInt64LE(BigInt(begin), tableAt);
      const head = Buffer.alloc(24);
      head.writeInt32LE(bomb.length, 20);
      return Buffer.concat([b, head, bomb]);
    })],
  ]) {
    const said = await drop(other, ["odd.ndf.exr", bytes]);
    assert.ok(said.includes(words) && said.startsWith("odd.ndf.exr: "), `expected ${words}: ${said}`);
  }
  await settled(other);
  assert.equal(await pixelsOf(other), shown);
  assert.equal(await other.textContent("#reading"), "");

  // Opens a file with the button of the page, in a small window, in light and dark mode.
  for (const colorScheme of ["light", "dark"]) {
    const small = await open("both.html", "", { width: 360, height: 740, colorScheme, hasTouch: true, isMobile: true });
    await small.setInputFiles("#open", [inFolder("map.ndf.exr")]);
    await small.waitForFunction(() => globalThis.multumLook.shown === "dropped");
    await settled(small);
    const [scroll, client] = await small.evaluate(() =>
      [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
    assert.ok(scroll <= client, `the page is ${scroll} px wide in ${client}`);
    assert.deepEqual((await lowContrasts(small)).found, []);
    await small.screenshot({ path: path.join(screenshots, `look_files_360_${colorScheme}.png`), fullPage: true });
  }
  assert.deepEqual(complaints, []);
} finally {
  await look.end();
}
