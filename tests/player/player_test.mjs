// SPDX-License-Identifier: Apache-2.0
// Walks through the player of packed fields in headless Chromium. player_page_test.cpp starts this script and makes
// FOLDER, which has player/, page.html, expected.json, and the pictures that expected.json names.
//
//   node player_test.mjs CHROMIUM FOLDER SCREENSHOTS [STEP [SECONDS_OF_WANDERING]]
import assert from "node:assert/strict";
import { copyFile, readFile, readdir, rm, writeFile } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { lowContrasts } from "../service/page_contrast.mjs";
import { NARROW, misplaced } from "../service/page_layout.mjs";
import { chromium } from "../service/web/node_modules/playwright-core/index.mjs";
import { descriptionOf, descriptionSection, fileOf, sectionsOf } from "./mpt_writing.mjs";
import { RangeServer } from "./range_server.mjs";

const [executablePath, folder, screenshots, only = "", seconds = "10"] = process.argv.slice(2);
const PATIENCE = 30000; // ms; the machine may be busy
// This is the allowed difference from the pictures of multum-view, in 8-bit values. This GL has 4 bits of sub-pixel
// position, and the GL of multum-view has 8, so the coverage of pixels at edges differs. Other pixels differ by the
// rounding of 16-bit floats and of sRGB.
const NEAR = 2;
const NEAR_SHARE_LEAST = 0.995;
const MEAN_MOST = 0.15;

const server = await RangeServer.start(folder);
const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--headless=new", "--disable-dev-shm-usage", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--enable-precise-memory-info"],
});
const field = (await readdir(path.join(folder, "player"))).find((name) => name.endsWith(".mpt"));
const bytes = await readFile(path.join(folder, "player", field));
const expected = JSON.parse(await readFile(path.join(folder, "expected.json")));
const complaints = []; // the errors of all pages
const expectedNoise = /GL Driver Message|Failed to load resource|GPU stall/;

async function openPage(url, { width = 1280, height = 800, colorScheme = "light", hasTouch = false } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme, hasTouch,
    reducedMotion: "reduce" });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !expectedNoise.test(message.text()))
      complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("dialog", (dialog) => complaints.push(`a foreign script says ${dialog.message()}`));
  page.on("request", (request) => {
    if (!/^(data|blob|file):/.test(request.url()) && !request.url().startsWith(server.url))
      complaints.push(`a request to ${request.url()}`);
  });
  await page.goto(url);
  return page;
}
async function openPlayer(url, options) {
  const page = await openPage(url, options);
  await page.waitForFunction(() => globalThis.multumPlayer !== undefined);
  return page;
}
const goTo = (page, at) => page.evaluate(async (place) => {
  globalThis.multumPlayer.moveTo(place);
  await globalThis.multumPlayer.settled();
}, at);
const position = (page) => page.evaluate(() => globalThis.multumPlayer.position);
const problems = (page) => page.locator("#problem-list li").allTextContents();
const problem = (page, pattern) => until(`a problem like ${pattern}`, async () =>
  (await problems(page)).some((text) => pattern.test(text)));

/** Returns the difference of the current picture from a PNG, given as base64. */
const difference = (page, png) => page.evaluate(async (data) => {
  const image = new Image();
  image.src = `data:image/png;base64,${data}`;
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const want = context.getImageData(0, 0, image.width, image.height).data;
  const found = globalThis.multumPlayer.pixels();
  if (found.length !== want.length) throw new Error(`${found.length} values, expected ${want.length}`);
  const differences = [...want].flatMap((value, i) => (i % 4 === 3 ? [] : [Math.abs(value - found[i])]));
  const spread = Math.max(...want.filter((_, i) => i % 4 === 1));
  return { spread, mean: differences.reduce((sum, one) => sum + one, 0) / differences.length,
    most: differences.reduce((a, b) => Math.max(a, b), 0), histogram: differences.reduce((counts, one) => {
      counts[one] = (counts[one] ?? 0) + 1;
      return counts;
    }, []) };
}, png.toString("base64"));

async function comparePictures(page, list = expected) {
  let most = 0;
  let meanMost = 0;
  for (const { at, picture } of list) {
    await goTo(page, at);
    const found = await difference(page, await readFile(path.join(folder, picture)));
    const total = found.histogram.reduce((sum, one) => sum + (one ?? 0), 0);
    const near = found.histogram.slice(0, NEAR + 1).reduce((sum, one) => sum + (one ?? 0), 0);
    assert.ok(found.spread > 100, `${picture} is dark: ${found.spread}`);
    assert.ok(near / total >= NEAR_SHARE_LEAST && found.mean <= MEAN_MOST, `${picture} at ${at}: mean ${found.mean}, ` +
      `within ${NEAR}: ${near / total}, at most ${found.most}`);
    most = Math.max(most, found.most);
    meanMost = Math.max(meanMost, found.mean);
  }
  console.log(`  ${list.length} pictures: mean difference ${meanMost.toFixed(3)} at most, single values ${most}`);
}

async function until(what, check) {
  const deadline = Date.now() + PATIENCE;
  for (;;) {
    if (await check()) return;
    assert.ok(Date.now() < deadline, `still not: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
}

const noSideways = async (page) => {
  const [scroll, client] = await page.evaluate(() =>
    [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
  assert.ok(scroll <= client, `the page is ${scroll} px wide in ${client}`);
};
const shoot = (page, name) => page.screenshot({ path: path.join(screenshots, `${name}.png`), fullPage: true });
const close = (page) => page.context().close();
const variant = (name, file, behave) => server.copy(name, "player", { [field]: file }, behave);
const described = (change) => {
  const sections = sectionsOf(bytes);
  const place = sections.findIndex(({ kind }) => kind === 0);
  const json = descriptionOf(sections[place]);
  sections[place] = descriptionSection(change(json) ?? json);
  return fileOf(sections);
};
/** Returns a file with a section in front of all others, so that these are beyond the bytes that are read first. */
const farApart = fileOf([{ kind: 9, layer: 0, block: 0, bytes: Buffer.alloc(200000, 7) }, ...sectionsOf(bytes)]);

// ---- Steps

const steps = {
  async picturesAreThoseOfMultumView() {
    const page = await openPlayer(`${server.url}/player/index.html`);
    await comparePictures(page);
    await goTo(page, [0.5, 0]);
    assert.deepEqual(await problems(page), []);
    // The picture between two samples differs from the pictures of both samples.
    for (const { picture } of expected.slice(0, 2)) {
      const found = await difference(page, await readFile(path.join(folder, picture)));
      assert.ok(found.mean > 0.3, `half way is ${picture}`);
    }
    await close(page);
  },

  async oneFileOpensFromDisk() {
    const page = await openPlayer(pathToFileURL(path.join(folder, "page.html")).href);
    await comparePictures(page, expected.slice(-2));
    assert.deepEqual(await problems(page), []);
    await close(page);
  },

  async sectionsAreFetchedByRanges() {
    const url = variant("far", farApart);
    server.requests = [];
    const page = await openPlayer(url);
    await comparePictures(page, expected.slice(0, 1));
    const asked = server.requests.filter(({ name }) => name.endsWith(field)).map(({ range }) => range);
    assert.ok(asked.length >= 3 && asked.every((range) => range !== undefined), asked.join(" "));
    const fetched = asked.map((range) => /(\d+)-(\d+)/.exec(range).slice(1).map(Number))
      .reduce((sum, [first, last]) => sum + last - first + 1, 0);
    assert.ok(fetched < farApart.length / 2, `${fetched} of ${farApart.length} bytes were requested`);
    await close(page);
  },

  async aServerWithoutRangesServesToo() {
    const page = await openPlayer(variant("rangeless", farApart, () => ({ noRanges: true })));
    await comparePictures(page, expected.slice(1, 2));
    await close(page);
  },

  async cutConnectionsAreTriedAgain() {
    let cuts = 0;
    const page = await openPlayer(variant("cut", farApart, (file, count) => {
      if (file !== field || count % 2 === 1) return {};
      ++cuts;
      return { cut: count === 0 ? 0 : 10 };
    }));
    await comparePictures(page, expected.slice(0, 1));
    assert.deepEqual(await problems(page), []);
    assert.ok(cuts >= 2);
    await page.keyboard.press("s");
    await page.getByText("Requests tried again").waitFor();
    await close(page);
  },

  async whatStaysCutIsSaidAndTriedByHand() {
    let isUp = false;
    const page = await openPage(variant("down", bytes, (file) => (file === field && !isUp ? { cut: 5 } : {})));
    await problem(page, new RegExp(`${field}: .*(cut after 5 of \\d+ bytes|cannot be reached).*tried 4 times`));
    await shoot(page, "cut");
    isUp = true;
    await page.getByRole("button", { name: "Try again" }).click();
    await page.waitForFunction(() => globalThis.multumPlayer !== undefined);
    await comparePictures(page, expected.slice(0, 1));
    await close(page);
    // If the download of a single chunk fails, the rest plays, and a later request gets the chunk.
    let isThere = false;
    let failed = null;
    const other = await openPlayer(variant("chunkless", farApart, (file, count) => {
      if (file !== field || count < 2) return {};
      failed ??= count;
      return isThere || count % 2 === failed % 2 ? {} : { status: 503 };
    }));
    await goTo(other, [0, 0]);
    isThere = true;
    if ((await problems(other)).length > 0) await other.getByRole("button", { name: "Try again" }).click();
    await comparePictures(other, expected.slice(0, 1));
    await close(other);
  },

  async aDamagedBlockIsNamedAndTheRestPlays() {
    const sections = sectionsOf(bytes);
    const place = sections.findLastIndex(({ kind }) => kind === 1);
    const damaged = Buffer.from(bytes);
    const begin = bytes.length - sections.slice(place).reduce((sum, one) => sum + one.bytes.length, 0);
    damaged[begin + 9] ^= 64;
    const page = await openPlayer(variant("damaged", damaged));
    for (const { at } of expected) await goTo(page, at);
    await problem(page, /section \d+ \(layer '.+' of object '.+', block \d+\) is damaged: its checksum differs/);
    const picture = await page.evaluate(() =>
      Math.max(...globalThis.multumPlayer.pixels().filter((_, i) => i % 4 === 1)));
    assert.ok(picture > 60, "nothing is drawn");
    await shoot(page, "damaged");
    // If data is damaged but its checksum is correct, the decoder decodes or refuses it, and the page survives.
    for (const change of [(b) => { b[9] ^= 64; }, (b) => b.fill(255, 1, 8), (b) => { b[1] = 1; }]) {
      const own = sectionsOf(bytes);
      own[place].bytes = Buffer.from(own[place].bytes);
      change(own[place].bytes);
      const live = await openPlayer(variant("rotten", fileOf(own)));
      for (const { at } of expected) await goTo(live, at);
      await close(live);
    }
    await close(page);
  },

  async hostileFilesAreRefusedWithWords() {
    const cases = {
      empty: [Buffer.alloc(0), /has 0 bytes|another range|ends before byte 0/],
      text: [Buffer.from("this is no packed field at all"), /does not begin with MPTF/],
      version: [Buffer.from(bytes.map((b, i) => (i === 4 ? 3 : b))), /version 3, expected 2/],
      short: [bytes.subarray(0, bytes.length - 20), /has \d+ bytes, but its index says \d+/],
      index: [Buffer.from(bytes.map((b, i) => (i === 12 ? b ^ 1 : b))), /checksum of its index differs/],
      tiny: [bytes.subarray(0, 30), /cut short within its index/],
      hugeIndex: [Buffer.from(bytes.map((b, i) => (i >= 5 && i < 9 ? 255 : b))), /expected at most 2\^26/],
      bomb: [fileOf([descriptionSection(`"${" ".repeat(50000000)}"`, 1000)]), /longer than its stated length/],
      noJson: [fileOf([descriptionSection("{", 1)]), /not JSON/],
      nothing: [fileOf([]), /no description/],
      list: [fileOf([descriptionSection("[]")]), /is not an object/],
      wide: [described((json) => { json.width = 1e9; }), /width is 1000000000, expected 1 to 16384/],
      matrix: [described((json) => { json.views[0][1][2] = "1"; }), /views is not a finite number/],
      sample: [described((json) => { json.samples.pop(); }), /samples are 5, expected 3 x 2/],
      view: [described((json) => { json.samples[0][2] = 77; }), /samples is 77/],
      mapping: [described((json) => { json.objects[0].mappingOfSample[0] = -1; }), /mappingOfSample is -1/],
      block: [described((json) => { json.objects[0].layers[0].blocks[0][1][0] = 99; }), /layers is 99/],
      holes: [described((json) => { json.objects[0].layers[0].blocks.pop(); }), /leave samples out/],
      mesh: [described((json) => { json.objects[0].mesh = "<img src=x onerror=alert(1)>"; }), /no object '<img/],
    };
    for (const [name, [file, pattern]] of Object.entries(cases)) {
      const page = await openPage(variant(`hostile_${name}`, file));
      await problem(page, pattern);
      assert.equal(await page.locator("#problem-list img").count(), 0);
      assert.equal(await page.evaluate(() => globalThis.multumPlayer), undefined, name);
      await close(page);
    }
    // Damaged geometry is also refused.
    const geometry = await readFile(path.join(folder, "player", "geometry.glb"));
    for (const [name, file, pattern] of [["glb_text", Buffer.from("o quad\nv 0 0 0\n and so on"), /not a binary glTF/],
      ["glb_cut", geometry.subarray(0, geometry.length - 100), /its head says/],
      ["glb_json", Buffer.from(geometry.map((b, i) => (i === 20 ? 0 : b))), /JSON is damaged/]]) {
      const page = await openPage(server.copy(name, "player", { "geometry.glb": file }));
      await problem(page, pattern);
      await close(page);
    }
    const page = await openPage(server.copy("absent", "player", {}, (file) =>
      (file === "geometry.glb" ? { status: 404 } : {})));
    await problem(page, /geometry\.glb: the server answered 404/);
    await close(page);
  },

  async partsThatAreMissingAreNamed() {
    for (const [name, file, content, pattern] of [
      ["no_wasm", "packed_field.wasm", null, /packed_field\.wasm: the server answered 404, expected 200/],
      ["bad_wasm", "packed_field.wasm", Buffer.from("no module"), /layer '.+' of object '.+', block \d: .*WebAssembly/],
      ["no_worker", "decoding_worker.js", null, /a decoding worker failed/]]) {
      const page = await openPage(server.copy(name, "player", content ? { [file]: content } : {}, (one) =>
        (one === file && content === null ? { status: 404 } : {})));
      await problem(page, pattern);
      // No request waits forever.
      if (name !== "no_wasm") await page.evaluate(() => globalThis.multumPlayer.settled());
      await close(page);
    }
  },

  async theReportOfInferenceEndsWithIt() {
    const report = pathToFileURL(path.join(folder, "out", "report.html")).href;
    const page = await openPage(report);
    await page.getByText("Open the player").click();
    await page.getByText("This page's folder has no player.html yet").waitFor();
    await close(page);
    await copyFile(path.join(folder, "page.html"), path.join(folder, "out", "player.html"));
    const other = await openPage(report);
    await other.getByText("Open the player").click();
    await until("the player is in the report", async () => {
      for (const frame of other.frames())
        if (await frame.evaluate(() => globalThis.multumPlayer !== undefined).catch(() => false)) return true;
      return false;
    });
    await close(other);
    await rm(path.join(folder, "out", "player.html"));
  },

  async itLooksAsItShould() {
    for (const [name, options] of [["light", {}], ["dark", { colorScheme: "dark" }],
      ["narrow", { width: 360, height: 720 }], ["narrow_dark", { width: 360, height: 720, colorScheme: "dark" }]]) {
      const page = await openPlayer(`${server.url}/player/index.html`, options);
      await goTo(page, [1, 1]);
      await noSideways(page);
      await shoot(page, name);
      for (const summary of await page.locator("summary").all()) await summary.click();
      await page.locator("#statistics-list dt").first().waitFor();
      await page.locator("#record").click();
      await page.evaluate(() => globalThis.multumPlayer.say("a problem, as it is shown"));
      await noSideways(page);
      const { count, found } = await lowContrasts(page);
      assert.ok(count > 40, `${count} texts were checked`);
      assert.deepEqual(found, []);
      await shoot(page, `${name}_open`);
      await close(page);
    }
  },

  async everythingByKeyboardAlone() {
    const page = await openPlayer(`${server.url}/player/index.html`);
    const seen = [];
    for (let i = 0; i < 14; ++i) {
      await page.keyboard.press("Tab");
      const [name, isSeen] = await page.evaluate(() => {
        const element = document.activeElement;
        const around = element.type === "file" ? element.closest("label") : element;
        const style = getComputedStyle(around);
        return [element.id || element.tagName, style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2];
      });
      if (name !== "BODY") assert.ok(isSeen, `no visible focus on ${name}`);
      seen.push(name);
    }
    const places = ["open", "stage", "play", "record", "full-screen", "pad", "parameter-0", "parameter-1"];
    assert.deepEqual(seen.filter((one) => places.includes(one)).slice(0, places.length), places);
    await page.locator("#stage").focus();
    const from = await position(page);
    await page.keyboard.press("Shift+ArrowUp");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("Shift+ArrowRight");
    await page.keyboard.press("Shift+ArrowLeft");
    const there = await position(page);
    assert.notDeepEqual(there, from);
    assert.equal(there[1], 1);
    await page.locator("#parameter-0").focus();
    await page.keyboard.press("End");
    assert.equal((await position(page))[0], 2);
    await page.locator("#pad").focus();
    await page.keyboard.press("ArrowLeft");
    assert.equal((await position(page))[0], 1.75);
    await page.keyboard.press("f");
    await page.waitForFunction(() => document.fullscreenElement?.id === "player");
    await page.keyboard.press("f");
    await page.waitForFunction(() => document.fullscreenElement === null);
    for (const element of await page.locator("button, input, select, [tabindex]").all()) {
      const name = await element.evaluate((one) => one.getAttribute("aria-label") || one.labels?.[0]?.textContent ||
        one.textContent);
      assert.ok(name.trim().length > 0, await element.evaluate((one) => one.outerHTML));
    }
    await close(page);
  },

  async draggingTurnsAndTouchDoes() {
    const page = await openPlayer(`${server.url}/player/index.html`, { hasTouch: true });
    const box = await page.locator("#stage").boundingBox();
    await goTo(page, [1, 0]);
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + box.width / 8, box.y + box.height / 2 - 40, { steps: 5 });
    await page.mouse.up();
    const dragged = await position(page);
    assert.ok(Math.abs(Math.abs(dragged[0] - 1) - 2 / 8 / 0.75) < 0.05, `${dragged}`);
    assert.ok(dragged[1] > 0);
    const pad = await page.locator("#pad").boundingBox();
    await page.touchscreen.tap(pad.x + pad.width * 0.5, pad.y + pad.height * 0.25);
    const tapped = await position(page);
    assert.ok(Math.abs(tapped[0] - 1) < 0.02 && Math.abs(tapped[1] - 0.75) < 0.02, `${tapped}`);
    await close(page);
  },

  async aPathIsRecordedKeptAndPlayed() {
    const page = await openPlayer(`${server.url}/player/index.html`);
    await page.keyboard.press("r");
    for (const at of [[0, 0], [1, 0.5], [2, 1]]) {
      await page.locator("#parameter-0").fill(String(at[0]));
      await page.locator("#parameter-1").fill(String(at[1]));
      await page.waitForTimeout(120);
    }
    await page.keyboard.press("r");
    await page.getByText(/Path of \d/).waitFor();
    await page.getByText("Settings").click();
    const downloading = page.waitForEvent("download");
    await page.getByRole("button", { name: "Save path" }).click();
    const text = await readFile(await (await downloading).path(), "utf8");
    const kept = JSON.parse(text);
    assert.equal(kept.multumPath, 1);
    assert.deepEqual(kept.positions[0].slice(1), [0, 0]);
    assert.deepEqual(kept.positions.at(-1).slice(1), [2, 1]);
    await goTo(page, [0, 0]);
    await page.getByRole("button", { name: "Play" }).click();
    await page.waitForFunction(() => globalThis.multumPlayer.position[0] > 0.9);
    await page.getByRole("button", { name: "Pause" }).click();
    const file = path.join(folder, "path.json");
    const load = async (content) => {
      await writeFile(file, content);
      await page.locator("#import").setInputFiles(file);
    };
    await load(JSON.stringify({ ...kept, positions: [[0, 0, 0], [30, 2, 1]] }));
    await page.getByText("Path of 30.0 s").waitFor();
    for (const [content, pattern] of [["x", /not JSON/], ["{}", /not a path/],
      [JSON.stringify({ ...kept, parameters: ["a"] }), /the field's parameters view,light/],
      [JSON.stringify({ ...kept, positions: [[0, 0, 0], [-1, 2, 1]] }), /positions are damaged/]]) {
      await load(content);
      await problem(page, pattern);
    }
    await close(page);
  },

  async filesThatAreChosenPlay() {
    const html = await readFile(path.join(folder, "player", "index.html"), "utf8");
    const bare = Buffer.from(html.replace(/("player-config">)\{[^<]*\}/, "$1{}"));
    const page = await openPage(server.copy("bare", "player", { "index.html": bare }));
    await page.getByText("No field is named").waitFor();
    await page.locator("#open").setInputFiles([path.join(folder, "player", field)]);
    await problem(page, /Choose two files/);
    await page.locator("#open").setInputFiles([path.join(folder, "player", field), path.join(folder, "player",
      "geometry.glb")]);
    await page.waitForFunction(() => globalThis.multumPlayer !== undefined);
    await comparePictures(page, expected.slice(0, 1));
    await close(page);
  },

  async aLostContextComesBack() {
    const page = await openPlayer(`${server.url}/player/index.html`);
    await goTo(page, expected[0].at);
    await page.evaluate(() => {
      globalThis.loss = globalThis.multumPlayer.gl.gl.getExtension("WEBGL_lose_context");
      globalThis.loss.loseContext();
    });
    await page.getByText("has lost the graphics context").waitFor();
    await page.evaluate(() => globalThis.loss.restoreContext());
    await page.getByText("has lost the graphics context").waitFor({ state: "hidden" });
    await comparePictures(page, expected.slice(1, 2));
    assert.deepEqual(await problems(page), []);
    await close(page);
  },

  async aTabInTheBackgroundGoesOn() {
    const context = await browser.newContext();
    // Simulates a page without animation frames.
    await context.addInitScript(() => { globalThis.requestAnimationFrame = () => 0; });
    const page = await context.newPage();
    await page.goto(`${server.url}/player/index.html`);
    const soon = (check) => page.waitForFunction(check, undefined, { polling: 50 });
    await soon(() => globalThis.multumPlayer !== undefined);
    await comparePictures(page, expected.slice(0, 1));
    await goTo(page, [0, 0]);
    await page.getByRole("button", { name: "Play" }).click();
    await soon(() => globalThis.multumPlayer.position[0] > 0.1);
    await close(page);
  },

  async whateverIsThrownIsSaid() {
    const page = await openPage(`${server.url}/player/index.html`);
    await page.waitForFunction(() => globalThis.multumPlayer !== undefined);
    for (const thrown of [undefined, null, ""])
      await page.evaluate((one) => { setTimeout(() => Promise.reject(one)); }, thrown);
    await problem(page, /failed: the browser gives no reason/);
    assert.ok((await problems(page)).every((text) => !/undefined|null/.test(text)));
    complaints.length = 0; // errors that the test has thrown itself
    await close(page);
  },

  async nothingIsCutInNarrowWindows() {
    for (const options of NARROW) {
      const page = await (await browser.newContext(options)).newPage();
      await page.goto(`${server.url}/player/index.html`);
      await page.waitForFunction(() => globalThis.multumPlayer !== undefined);
      await page.evaluate(() => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
      await page.waitForTimeout(300);
      assert.deepEqual(await misplaced(page), [], `${options.viewport.width} px`);
      await close(page);
    }
  },

  async noPictureIsBegunWhileTwoAreNotFinished() {
    const page = await openPlayer(`${server.url}/player/index.html`);
    await goTo(page, expected[0].at);
    const { most, pictures } = await page.evaluate(async () => {
      const player = globalThis.multumPlayer;
      const { gl } = player.gl;
      // The page counts its own fences. Here the fences of the driver are signalled late, as with a slow driver.
      const known = gl.getSyncParameter.bind(gl);
      const made = new Map();
      const fenceSync = gl.fenceSync.bind(gl);
      gl.fenceSync = (...all) => {
        const fence = fenceSync(...all);
        made.set(fence, performance.now());
        return fence;
      };
      gl.getSyncParameter = (fence, name) =>
        (performance.now() - made.get(fence) < 100 ? gl.UNSIGNALED : known(fence, name));
      player.gl.isBusy();
      const before = player.statistics.frames;
      let longest = 0;
      const begun = performance.now();
      for (let n = 0; performance.now() - begun < 1500; ++n) {
        player.moveTo(player.description.sizes.map((size, d) => (d === 0 ? 0.01 * (n % 50) : 0)));
        await new Promise((resolve) => requestAnimationFrame(resolve));
        longest = Math.max(longest, player.gl.fences.length);
      }
      return { most: longest, pictures: player.statistics.frames - before };
    });
    assert.ok(most <= 2, `${most} pictures at once`);
    assert.ok(pictures > 3 && pictures <= 34, `${pictures} pictures in 1.5 s of a driver that takes 0.1 s for two`);
    await close(page);
  },

  async oneMipLevelIsLookedUpOnlyWhileASlowDeviceMoves() {
    const page = await openPlayer(`${server.url}/player/index.html`);
    await goTo(page, expected[0].at);
    const found = await page.evaluate(async () => {
      const player = globalThis.multumPlayer;
      const draw = player.gl.draw.bind(player.gl);
      const told = [];
      player.gl.draw = (all) => {
        told.push([all.supersampling, all.hasOneLevel]);
        draw(all);
      };
      for (const side of [player.finest, 1]) {
        player.quality = { side, frame() {}, framesPerSecond: 0 };
        player.moveTo(player.position.map((one, d) => (d === 0 ? one + 0.01 : one)));
        player.drawNow();
      }
      await player.settled();
      return { first: told[0], moving: told.find(([side]) => side === 1), rest: told.at(-1), finest: player.finest };
    });
    assert.ok(found.finest > 1);
    assert.deepEqual(found.first, [found.finest, false]);
    assert.deepEqual(found.moving, [1, true]);
    assert.deepEqual(found.rest, [found.finest, false]);
    await comparePictures(page, expected.slice(0, 1));
    await close(page);
  },

  async wanderingStaysWithinTheBudget() {
    const page = await openPlayer(`${server.url}/player/index.html`);
    for (const { at } of expected) await goTo(page, at);
    const whole = await page.evaluate(() => globalThis.multumPlayer.store.bytes);
    const needed = await page.evaluate(() => [...globalThis.multumPlayer.needed.values()]
      .reduce((sum, one) => sum + globalThis.multumPlayer.bytesOf(one), 0));
    const budget = Math.ceil(1.5 * needed);
    assert.ok(whole > 1.2 * budget, `all is ${whole} bytes, the budget ${budget}`);
    const cdp = await page.context().newCDPSession(page);
    const heap = async () => {
      await cdp.send("HeapProfiler.collectGarbage");
      return (await cdp.send("Runtime.getHeapUsage")).usedSize;
    };
    const wander = (duration) => page.evaluate(async ([bytes, ms]) => {
      const player = globalThis.multumPlayer;
      if (player.store.budget !== bytes) player.setBudget(bytes);
      player.store.peak = 0;
      const begun = performance.now();
      let most = 0;
      let frames = 0;
      for (let state = 1; performance.now() - begun < ms; ++frames) {
        state = (state * 1103515245 + 12345) % 2147483648;
        const t = (performance.now() - begun) / 1000;
        // Moves smoothly, with a jump from time to time.
        const leap = state % 97 === 0 ? 1 : 0;
        player.moveTo(player.description.sizes.map((size, d) =>
          (size - 1) * (0.5 + 0.5 * Math.sin((1.3 + d) * t + leap * state))));
        await new Promise((resolve) => requestAnimationFrame(resolve));
        most = Math.max(most, player.store.bytes);
      }
      return { most, peak: player.store.peak, frames, evictions: player.store.evictions,
        misses: player.statistics.misses, decoded: player.statistics.decoded, workers: player.pool.memory };
    }, [budget, duration]);
    await wander(2000); // waits until all shaders have been compiled
    const before = await heap();
    const found = await wander(1000 * Number(seconds));
    const after = await heap();
    console.log(`  ${seconds} s: ${found.frames} frames, ${found.decoded} decoded, ${found.evictions} given up, ` +
      `${found.misses} misses, ${found.peak} of ${budget} bytes at most; JavaScript's heap ${before} before, ` +
      `${after} after; decoders ${found.workers}`);
    assert.ok(found.peak <= budget && found.most <= budget, `${found.peak} bytes, the budget is ${budget}`);
    assert.ok(found.evictions > 0, "the budget is enough for all images");
    assert.ok(after < before * 1.15 + 2e5, `the heap has grown from ${before} to ${after}`);
    assert.ok(found.workers < 200e6);
    await comparePictures(page, expected.slice(0, 1));
    // If the budget is too small for a single picture, the page draws as much as it can.
    await page.evaluate(() => globalThis.multumPlayer.setBudget(3000));
    await page.waitForTimeout(500);
    assert.ok(await page.evaluate(() => globalThis.multumPlayer.store.bytes) <= 3000);
    await close(page);
  },
};

let failed = 0;
for (const [name, step] of Object.entries(steps)) {
  if (!name.includes(only)) continue;
  const begun = Date.now();
  complaints.length = 0;
  try {
    await Promise.race([step(), new Promise((_, reject) => {
      setTimeout(() => reject(new Error("takes too long")), 3 * PATIENCE + 1000 * Number(seconds)).unref();
    })]);
    assert.deepEqual(complaints, []);
    console.log(`ok ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failed;
    console.log(`FAILED ${name}: ${error.stack}`);
  }
}
await browser.close();
server.stop();
process.exit(failed > 0 ? 1 : 0);
