// SPDX-License-Identifier: Apache-2.0
// Walks through the page of multum look in headless Chromium. Compares pictures with those of multum-view, and tests
// every control, keys, touch, the address, dropped lobe textures, damaged files, a width of 360 px, and light and dark
// mode. Exits with 77 (skipped) if something is missing. look_files_test.mjs tests the other files.
//
//   node look_page_test.mjs BIN_FOLDER SCREENSHOTS
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import path from "node:path";
import { drop, factsOf, goTo, pixelsOf as pixels, settled, startLook, viewOf as view } from "./look_browser.mjs";
import { lowContrasts } from "../service/page_contrast.mjs";
import { NARROW, misplaced } from "../service/page_layout.mjs";

const [bin, screenshots] = process.argv.slice(2);
const look = await startLook(bin);
const { inFolder, run, complaints } = look;
mkdirSync(screenshots, { recursive: true });
const CLOSE = 8; // in units of 1/255; this GL and llvmpipe round differently when they filter compressed blocks and
                 // 16-bit floats
const MEAN_MOST = 1.5;

const open = (hash, more) => look.open("map.html", hash, more);

try {
  run("multum", "testmap", "map", "--size", "128");
  run("multum", "bake", "map_normal.png", "-o", "map.ndf.exr", "--no-measure");
  run("multum", "look", "map.ndf.exr", "--source", "map_normal.png", "--no-open");
  run("multum", "export", "map.ndf.exr", "--lobes", "-o", "map.ktx2");
  run("multum", "export", "map.ndf.exr", "--lobes", "--texels", "rgba16f", "-o", "halves.ktx2");
  const changes = async (page, what, act) => {
    const before = await pixels(page);
    await act();
    await settled(page);
    assert.notEqual(await pixels(page), before, `${what} changes no picture`);
  };

  // Compares pictures with those of multum-view for the same file, map, camera and light.
  const page = await open("#light=sun&left=lobes&split=1");
  const [width, height] = await page.evaluate(() => globalThis.multumLook.gl.size);
  const beside = async (file, hash) => {
    // These are the camera and the light of multum-view, unless `hash` sets others.
    const defaults = "light=sun&elevation=21.5&distance=-0.288&exposure=0&x=0.303&y=0.808&z=0.505";
    await goTo(page, `${defaults}&${hash}`);
    await settled(page);
    await settled(page);
    const camera = await page.evaluate(() => {
      const { eye, target } = globalThis.lookCamera(globalThis.multumLook.view);
      return { place: [...eye, ...target, 40].join(","), light: globalThis.multumLook.scene().light.join(",") };
    });
    run("multum-view", file, "--source", "map_normal.png", "--size", `${width}x${height}`, "--brdf", "ggx:0.3",
      "--diffuse", "0.1", "--specular", "1", "--evaluations", "0", "--light", camera.light,
      "--camera", camera.place, "-o", "view.png");
    return page.evaluate(async (base64) => {
      const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
      const rgba = (source) => {
        const canvas = new OffscreenCanvas(source.width, source.height);
        canvas.getContext("2d").drawImage(source, 0, 0);
        return canvas.getContext("2d").getImageData(0, 0, source.width, source.height).data;
      };
      const want = rgba(image), found = rgba(document.getElementById("canvas"));
      const differences = [...want].flatMap((one, i) => (i % 4 === 3 ? [] : [Math.abs(one - found[i])]));
      return { count: want.length - found.length, mean: differences.reduce((a, b) => a + b) / differences.length,
        histogram: differences.reduce((list, one) => { list[one] = (list[one] ?? 0) + 1; return list; }, []),
        brightest: want.reduce((a, b, i) => (i % 4 === 3 ? a : Math.max(a, b)), 0) };
    }, readFileSync(inFolder("view.png")).toString("base64")).catch((error) => assert.fail(String(error)));
  };
  // The plane of multum-view begins at y = 0, whereas the plane of the page is endless.
  for (const [name, hash] of [["lobes", "left=lobes&split=1"],
    ["steep", "left=lobes&split=1&elevation=75&distance=-0.5"],
    ["turned", "left=lobes&split=1&azimuth=30&elevation=45&distance=-0.5&exposure=0&x=-0.5&y=0.5&z=0.7071"]]) {
    const found = await beside("map.ktx2", hash);
    const total = found.histogram.reduce((sum, one) => sum + (one ?? 0), 0);
    const close = found.histogram.slice(0, CLOSE + 1).reduce((sum, one) => sum + (one ?? 0), 0) / total;
    const share = `${(100 * close).toFixed(1)} %`;
    console.log(`  ${name}: mean difference ${found.mean.toFixed(2)} of 255, within ${CLOSE}: ${share}`);
    assert.equal(found.count, 0);
    assert.ok(found.brightest > 100, `${name} is dark`);
    assert.ok(found.mean <= MEAN_MOST && close > 0.95, `${name}: mean ${found.mean}, within ${CLOSE}: ${close}`);
  }

  // Controls.
  await goTo(page, "light=sun");
  await settled(page);
  await settled(page);
  for (const [id, value] of [["left", "rule"], ["rule", "godot"], ["left", "export"], ["left", "lobes"],
    ["right", "mip"], ["lock", "3"]])
    await changes(page, `${id} ${value}`, () => page.selectOption(`#${id}`, value));
  for (const [id, value] of [["split", "0.25"], ["distance", "1"], ["exposure", "1"], ["metalness", "0.5"]])
    await changes(page, id, () => page.locator(`#${id}`).fill(value));
  await changes(page, "difference", () => page.check("#difference"));
  await changes(page, "reset", () => page.click("#reset"));
  for (const value of ["studio", "sun"]) await changes(page, `light ${value}`, () =>
    page.selectOption("#around", value));
  await page.focus("#stage");
  for (const key of ["ArrowLeft", "ArrowUp", "+", "-", "]", "[", "s", "S", "d", "d"])
    await changes(page, `key ${key}`, () => page.keyboard.press(key));
  const box = await page.locator("#stage").boundingBox();
  const drag = async (from, to) => {
    await page.mouse.move(box.x + from[0] * box.width, box.y + from[1] * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + to[0] * box.width, box.y + to[1] * box.height, { steps: 3 });
    await page.mouse.up();
  };
  await changes(page, "a drag", () => drag([0.2, 0.5], [0.4, 0.6]));
  await changes(page, "the wheel", () => page.mouse.wheel(0, 300));
  const split = (await view(page)).split;
  await changes(page, "the divider", () => drag([split, 0.5], [0.8, 0.5]));
  assert.ok(Math.abs((await view(page)).split - 0.8) < 0.02);
  await page.check("#light");
  await changes(page, "the light", () => page.hover("#stage", { position: { x: 0.8 * box.width,
    y: 0.2 * box.height } }));
  const facts = await factsOf(page);
  assert.match(facts, /128 x 128, 4 lobes.*all mip levels.*roughness as BC4.*lobes 0.06 MB \(BC5.*takes [\d.]+ ms/);

  // The page shows the error of the picture, compared with a picture of the normal map itself. The error is almost 0
  // where texels are larger than pixels, and it is low for distant lobes. When the view changes, the page removes the
  // number.
  const errors = async (hash) => {
    await goTo(page, hash);
    await settled(page);
    await page.click("#measure");
    await page.waitForFunction(() => /noise/.test(document.getElementById("error").textContent), undefined,
      { timeout: 120000 });
    const text = await page.textContent("#error");
    console.log(`  ${hash || "home"}: ${text}`);
    return text.match(/[\d.]+(?= %)/g).map(Number);
  };
  const [near, far] = [await errors("#light=sun&distance=-2"), await errors("#light=sun")];
  assert.ok(near[0] < 3 && near[1] < 3 && near[2] < 1, near);
  // Each lobe is evaluated once. If two taps were shaded separately, the ratio would be below 0.6.
  assert.ok(far[1] < 0.7 * far[0] && far[2] < far[1], far);
  await changes(page, "a view after its error", () => page.locator("#exposure").fill("0"));
  assert.equal(await page.textContent("#error"), "");

  // The address stores the view. Values from addresses that the page did not make are clamped.
  const kept = await page.evaluate(() => location.hash);
  const again = await open(kept);
  const [one, other] = [await view(page), await view(again)];
  for (const key of Object.keys(one)) {
    if (typeof one[key] === "number") assert.ok(Math.abs(one[key] - other[key]) < 1e-3, key);
    else assert.equal(one[key], other[key]);
  }
  const odd = await open("#left=%3Cscript%3E&rule=__proto__&split=9e99&lock=1e9&azimuth=NaN&distance=-Infinity&x=abc");
  assert.deepEqual([(await view(odd)).left, (await view(odd)).rule, (await view(odd)).split], ["mip", "unreal", 1]);

  // Tests files that are dropped onto the page.
  assert.equal(await drop(again, ["halves.ktx2", readFileSync(inFolder("halves.ktx2"))]), "");
  assert.equal(await again.evaluate(() => globalThis.multumLook.file.format), 97);
  assert.equal(await drop(again, ["map_normal.png", readFileSync(inFolder("map_normal.png"))]), "");
  const good = readFileSync(inFolder("map.ktx2"));
  const changed = (at, value) => { const bytes = Buffer.from(good); bytes[at] = value; return bytes; };
  const rough = Buffer.from(good); // replaces a key by another key of the same length
  rough.write('"meanCosine"   ', good.indexOf('"layersPerLobe"'), "latin1");
  for (const [bytes, words] of [[rough, "found roughness"], [changed(12, 99), "VkFormat 99"],
    [changed(24, 3), "bytes of level"], [changed(32, 200), "layers"], [changed(40, 30), "levels"],
    [changed(44, 2), "supercompression"], [good.subarray(0, good.length - 9), "beyond the end"],
    [good.subarray(0, 90), "cut"], [Buffer.from("no picture"), "odd.ktx2"], [changed(87, 9), "beyond the end"]]) {
    const said = await drop(again, ["odd.ktx2", bytes]);
    assert.ok(said.includes(words), `${words}: ${said}`);
  }
  assert.equal(await again.locator("#problem").isVisible(), true);

  // Uses the page with touch input in a small window, in light and dark mode.
  for (const colorScheme of ["light", "dark"]) {
    const small = await open("", { width: 360, height: 740, colorScheme, hasTouch: true, isMobile: true });
    const [scroll, client] = await small.evaluate(() =>
      [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
    assert.ok(scroll <= client, `the page is ${scroll} px wide in ${client}`);
    await small.screenshot({ path: path.join(screenshots, `look_360_${colorScheme}.png`), fullPage: true });
    const session = await small.context().newCDPSession(small);
    const touch = (type, points) =>
      session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const at = await small.locator("#stage").boundingBox();
    const place = (x, y) => [at.x + x * at.width, at.y + y * at.height];
    const before = await view(small);
    await touch("touchStart", [place(0.2, 0.5), place(0.3, 0.5)]);
    await touch("touchMove", [place(0.1, 0.5), place(0.45, 0.5)]);
    await touch("touchEnd", []);
    await small.waitForFunction((from) => globalThis.multumLook.view.distance < from - 0.5, before.distance); // nearer
    assert.deepEqual((await lowContrasts(small)).found, []);
  }
  for (const { viewport, deviceScaleFactor } of NARROW) {
    const narrow = await open("", { ...viewport, deviceScaleFactor });
    assert.deepEqual(await misplaced(narrow), [], `${viewport.width} px`);
  }

  // The page reports a lost GL context and later restores its picture. The page does not show errors that were measured
  // in the meantime.
  const lost = await open("#left=export&right=lobes");
  const picture = await pixels(lost);
  await lost.click("#measure");
  await lost.evaluate(() => {
    globalThis.loss = globalThis.multumLook.gl.gl.getExtension("WEBGL_lose_context");
    globalThis.loss.loseContext();
  });
  await lost.getByText("has lost the graphics context").waitFor();
  assert.equal(await drop(lost, ["map.ktx2", good]), "");
  await lost.evaluate(() => globalThis.multumLook.change({ exposure: 0 }));
  await lost.evaluate(() => globalThis.multumLook.change({ exposure: -1 }));
  await lost.evaluate(() => globalThis.loss.restoreContext());
  await lost.getByText("has lost the graphics context").waitFor({ state: "hidden" });
  await settled(lost);
  await settled(lost);
  assert.equal(await pixels(lost), picture);
  await lost.waitForFunction(() => !document.getElementById("measure").disabled);
  assert.doesNotMatch(await lost.textContent("#error"), /noise|cannot/);

  // The page works even in a background tab, which has no animation frames.
  const behind = await open("", { before: () => { globalThis.requestAnimationFrame = () => 0; } });
  await behind.click("#measure");
  await behind.waitForFunction(() => /noise/.test(document.getElementById("error").textContent), undefined,
    { polling: 100, timeout: 120000 });
  const hidden = await open("", { before: () => Object.defineProperty(document, "hidden", { value: true }) });
  await hidden.getByText("is not timed while this page is in the background").waitFor();

  // The page shows every error that is thrown.
  assert.deepEqual(complaints, []);
  for (const thrown of [undefined, null, "", {}, new Error("")]) {
    await behind.evaluate((one) => { say(""); setTimeout(() => Promise.reject(one)); }, thrown);
    await behind.locator("#problem:not(:empty)").waitFor();
    const said = await behind.textContent("#problem");
    assert.match(said, /failed: the browser gives no reason/);
    assert.doesNotMatch(said, /undefined|null|\[object/);
  }
  complaints.length = 0; // errors that the test has thrown itself

  const wide = await open("#left=export&right=lobes&distance=0.5", { width: 1280, height: 900 });
  await wide.screenshot({ path: path.join(screenshots, "look.png") });
  assert.deepEqual(complaints, []);
} finally {
  await look.end();
}
