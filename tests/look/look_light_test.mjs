// SPDX-License-Identifier: Apache-2.0
// Tests the light, the shapes, the materials and the reference of multum look's page in headless Chromium: environments
// against brute force in double precision, the reference against the mean of its samples, the sliders, drafts on slow
// machines, and the saved picture. Exits with 77 (skipped) if something is missing.
//
//   node look_light_test.mjs BIN_FOLDER SCREENSHOTS
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import path from "node:path";
import { drop, factsOf, goTo, pixelsOf as pixels, settled, startLook, viewOf as view } from "./look_browser.mjs";

const [bin, screenshots] = process.argv.slice(2);
const look = await startLook(bin);
const { inFolder, run, complaints } = look;
mkdirSync(screenshots, { recursive: true });
const open = (hash, more) => look.open("maps.html", hash, more);
const isFinished = (page) => page.waitForFunction(() => globalThis.multumLook.reference.isDone, undefined,
  { timeout: 120000 });

/**
 * Returns the radiance of a flat, smooth silver plane in the middle of the picture, and by brute force the integral of
 * the environment times the BRDF over all directions: GGX, Smith and Schlick as in glTF 2.0.
 */
const besideBruteForce = (page) => page.evaluate(() => {
  const look = globalThis.multumLook, { gl } = look, scene = look.scene();
  const { width, height } = look.means[0];
  look.setMeans(meanNormals(width, height, new Float32Array(2 * width * height)));
  const [w, h] = gl.size, at = 4 * (Math.floor(h / 2) * w + Math.floor(w / 2));
  const found = [...gl.radiance("mip", scene).subarray(at, at + 3)];
  const v = scene.eye.map((one, c) => one - TARGET[c]), size = Math.hypot(...v);
  const [vx, vy, vz] = v.map((one) => one / size), a2 = scene.alpha ** 2;
  const { radiance } = ENVIRONMENTS[scene.environment], sum = [0, 0, 0];
  const rows = 400, columns = 800;
  for (let i = 0; i < rows; ++i)
    for (let k = 0; k < columns; ++k) {
      const z = (i + 0.5) / rows, phi = 2 * Math.PI * (k + 0.5) / columns, s = Math.sqrt(1 - z * z);
      const l = [s * Math.cos(phi), s * Math.sin(phi), z], half = [l[0] + vx, l[1] + vy, l[2] + vz];
      const n = Math.hypot(...half), nh = half[2] / n, vh = (half[0] * vx + half[1] * vy + half[2] * vz) / n;
      const e = nh * nh * (a2 - 1) + 1, d = a2 / (Math.PI * e * e);
      const visible = 0.5 / (z * Math.sqrt(vz * vz * (1 - a2) + a2) + vz * Math.sqrt(z * z * (1 - a2) + a2));
      const weight = d * visible * z * 2 * Math.PI / (rows * columns), light = radiance(l);
      for (let c = 0; c < 3; ++c)
        sum[c] += weight * light[c] * (scene.tint[c] + (1 - scene.tint[c]) * (1 - vh) ** 5);
    }
  return { found, expected: sum };
});

try {
  run("multum", "testmap", "hammered", "--size", "128");
  run("multum", "testmap", "bricks", "--size", "128");
  for (const name of ["hammered", "bricks"])
    run("multum", "bake", `${name}_normal.png`, "-o", `${name}.ndf.exr`, "--no-measure");
  run("multum", "look", "hammered.ndf.exr", "bricks.ndf.exr", "--title", "Hammered metal", "--title", "Bricks",
    "--albedo", "hammered_albedo.png", "--albedo", "bricks_albedo.png", "--metalness", "1", "--metalness", "0",
    "--base-roughness", "0.22", "--base-roughness", "0.7", "--no-open", "-o", "maps.html");
  run("multum", "look", "hammered.ndf.exr", "--no-open", "-o", "plain.html");
  const wrong = (...words) => {
    assert.throws(() => run("multum", "look", "bricks.ndf.exr", "--no-open", ...words), (error) => {
      assert.equal(error.status, words[0] === "--albedo" && words.length === 2 ? 3 : 2);
      return true;
    });
  };
  wrong("--metalness", "2");
  wrong("--metalness", "nan");
  wrong("--metalness", "1", "--metalness", "0");
  wrong("--albedo", "bricks.ndf.exr", "--albedo", "bricks_albedo.png");
  wrong("--albedo", "maps.html");

  const plain = await look.open("plain.html", "#metalness=1", {});
  for (const [hash, most] of [["light=sky&elevation=89&roughness=0.5", 0.04],
    ["light=studio&elevation=89&roughness=0.5", 0.05], ["light=sky&elevation=45&roughness=0.2", 0.06],
    ["light=sky&elevation=45&roughness=0.6", 0.1]]) {
    await goTo(plain, `metalness=1&${hash}&x=0&y=0&z=0`);
    await settled(plain);
    await plain.evaluate(() => { ENVIRONMENTS.sky.sun = [0, 0, 0]; });
    const { found, expected } = await besideBruteForce(plain);
    const error = Math.max(...found.map((one, c) => Math.abs(one / expected[c] - 1)));
    console.log(`  ${hash}: ${found.map((one) => one.toFixed(3))}, brute force ` +
      `${expected.map((one) => one.toFixed(3))}: ${(100 * error).toFixed(1)} %`);
    assert.ok(error < most, `${hash}: ${found}, expected ${expected}`);
  }

  // The reference becomes the mean of its samples.
  const page = await open("#left=reference&distance=4");
  await isFinished(page);
  const apart = await page.evaluate(() => {
    const { gl } = globalThis.multumLook, scene = globalThis.multumLook.scene();
    const shown = gl.radiance("reference", scene), mean = new Float32Array(shown.length);
    for (let i = 0; i < PLACE_COUNT; ++i)
      gl.radiance("mip", { ...sceneAtPlace(scene, gl.size, i), lock: 0 }).forEach((one, k) => {
        mean[k] += one / PLACE_COUNT;
      });
    return differenceOf(shown, mean, mean) / differenceOf(mean, new Float32Array(mean.length), mean);
  });
  assert.ok(apart < 1e-3, `the reference differs by ${apart} from the mean of its samples`);
  assert.match(await page.textContent("#left-name"), /^reference, 144 of 144/);
  assert.equal(await page.textContent("#right-name"), "4 lobes in BC5 from level 1 on");
  assert.equal(await page.textContent("#title"), "Hammered metal");

  // Both pictures are saved side by side, with the names above them.
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  assert.equal(download.suggestedFilename(), "Hammered_metal_reference_lobes.png");
  await download.saveAs(path.join(screenshots, "side_by_side.png"));
  const png = readFileSync(path.join(screenshots, "side_by_side.png"));
  const [width, height] = await page.evaluate(() => globalThis.multumLook.gl.size);
  assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [2 * width + 4, height + 68]);
  assert.ok(png.length > 20000, `${png.length} bytes`);

  // The sliders begin at the map's own values. The export belongs to one roughness.
  const value = (id) => page.inputValue(`#${id}`);
  assert.deepEqual([await value("roughness"), await value("metalness")], ["0.22", "1"]);
  const changes = async (what, act) => {
    const before = await pixels(page);
    await act();
    await settled(page);
    assert.notEqual(await pixels(page), before, `${what} changes no picture`);
  };
  await goTo(page, "left=export&distance=4");
  await settled(page);
  assert.equal((await view(page)).left, "export");
  await changes("roughness", () => page.locator("#roughness").fill("0.6"));
  assert.equal((await view(page)).left, "mip");
  assert.equal(await page.locator("#left option[value=export]").evaluate((one) => one.disabled), true);
  await page.selectOption("#left", "rule");
  await settled(page);
  await changes("roughness of an engine's rule", () => page.locator("#roughness").fill("0.3"));
  await changes("metalness", () => page.locator("#metalness").fill("0"));
  await changes("the other map", () => page.selectOption("#map", "1"));
  await page.click("#reset");
  await settled(page);
  await page.waitForFunction(() => globalThis.multumLook.colours !== null);
  for (const shape of ["sphere", "ring", "plane"])
    await changes(shape, () => page.selectOption("#shape", shape));
  for (const light of ["studio", "sun", "sky"]) await changes(light, () => page.selectOption("#around", light));

  // Colours that are still being decoded do not replace those of a later choice.
  const sizes = await page.evaluate(async () => {
    const look = globalThis.multumLook, base64 = look.data.maps[0].colours;
    const early = look.takeColours(base64);
    await look.takeColours(undefined);
    await early;
    return [look.colours, ...look.scene().tint];
  });
  assert.deepEqual(sizes, [null, 0.1, 0.1, 0.1]);
  await page.evaluate(() => globalThis.multumLook.choose(1));
  await page.waitForFunction(() => globalThis.multumLook.colours !== null);

  // A move of the divider keeps the reference. Another view begins it anew.
  await page.selectOption("#left", "reference");
  await isFinished(page);
  await page.locator("#split").fill("0.3");
  await settled(page);
  assert.equal(await page.evaluate(() => globalThis.multumLook.reference.isDone), true);
  await page.locator("#distance").fill("2");
  assert.equal(await page.evaluate(() => globalThis.multumLook.reference.isDone), false);
  await page.selectOption("#right", "reference");
  await settled(page);
  assert.equal(await page.locator("#measure").isDisabled(), true);
  await page.selectOption("#left", "mip");
  await page.selectOption("#right", "lobes");
  await page.selectOption("#around", "studio");
  await settled(page);
  assert.equal(await page.locator("#light").isDisabled(), true);

  // Other maps bring their own roughness. A reset keeps the map.
  await page.locator("#metalness").fill("0.4");
  await page.selectOption("#map", "0");
  await settled(page);
  assert.deepEqual([await value("roughness"), await value("metalness")], ["0.22", "1"]);
  await page.selectOption("#map", "1");
  await page.click("#reset");
  await settled(page);
  assert.match(await page.evaluate(() => location.hash), /map=1/);
  assert.equal(await page.textContent("#title"), "Bricks");

  // The error leaves out the background: it does not fall with the sphere's part of the picture.
  const errorOf = async (hash) => {
    await goTo(page, hash);
    await settled(page);
    await page.click("#measure");
    await page.getByText("noise is about").waitFor();
    return Number((await page.textContent("#error")).match(/averaged normals ([\d.]+) %/)[1]);
  };
  const small = await errorOf("map=0&shape=sphere&left=mip&right=mip&elevation=12&distance=3");
  assert.ok(small > 15, `an error of ${small} %`);

  // The sharpest highlights stay finite.
  await goTo(page, "map=0&left=mip&right=lobes&roughness=0.05&elevation=4&distance=0");
  await settled(page);
  const isFinite = await page.evaluate(() => ["mip", "lobes"].every((method) =>
    globalThis.multumLook.gl.radiance(method, globalThis.multumLook.scene()).every(Number.isFinite)));
  assert.ok(isFinite);
  await goTo(page, "map=1");
  await settled(page);

  // An odd address is the default view.
  const odd = await open("#toString=1&light=x&shape=__proto__&roughness=nan&metalness=7");
  assert.deepEqual([(await view(odd)).light, (await view(odd)).shape, (await view(odd)).roughness,
    (await view(odd)).metalness], ["sky", "plane", -1, 1]);

  // Slow machines see drafts while the view moves, and the name of what draws.
  await page.evaluate(() => {
    Object.assign(globalThis.multumLook, { hasDrafts: true, frameMs: 1000, isTimed: true });
    globalThis.multumLook.change({ azimuth: 10 });
  });
  const draft = await page.evaluate(async () => {
    await globalThis.multumLook.waiting;
    return globalThis.multumLook.gl.size[0];
  });
  assert.ok(draft < 0.3 * width && draft > 0.2 * width, `a draft of ${draft} pixels of ${width}`);
  await page.waitForFunction((wide) => globalThis.multumLook.gl.size[0] === wide, width);
  // A picture that is saved during a draft is not a draft.
  await page.evaluate(() => {
    Object.assign(globalThis.multumLook, { hasDrafts: true, frameMs: 1000, isTimed: true });
    globalThis.multumLook.change({ azimuth: 20 });
  });
  const [full] = await Promise.all([page.waitForEvent("download"), page.evaluate(async () => {
    await globalThis.multumLook.waiting;
    await globalThis.multumLook.savePicture();
  })]);
  await full.saveAs(path.join(screenshots, "after_draft.png"));
  assert.equal(readFileSync(path.join(screenshots, "after_draft.png")).readUInt32BE(16), 2 * width + 4);
  await page.evaluate(() => Object.assign(globalThis.multumLook, { frameMs: 1000, isTimed: true }).showFacts());
  assert.match(await page.textContent("#facts"), /This browser draws with .*SwiftShader/);
  await page.evaluate(() => Object.assign(globalThis.multumLook, { frameMs: 10, isTimed: true }).showFacts());
  assert.doesNotMatch(await factsOf(page), /draws with/);

  // A dropped map has no export, and keeps the light and the shape.
  const other = await open("#shape=ring&light=studio");
  assert.equal(await drop(other, ["hammered.ndf.exr", readFileSync(inFolder("hammered.ndf.exr"))]), "");
  await settled(other);
  const { shape, light } = await view(other);
  assert.deepEqual([shape, light], ["ring", "studio"]);
  assert.equal(await other.evaluate(() => globalThis.multumLook.colours), null);

  for (const [name, hash] of [["sphere", "shape=sphere&left=reference&elevation=12&distance=0.9&x=-0.5&y=-0.6&z=0.6"],
    ["bricks", "map=1&left=reference&distance=3"], ["ring", "shape=ring&light=studio&elevation=12&distance=0.9"]]) {
    const wide = await open(`#${hash}`, { width: 480, height: 600 });
    if (/reference/.test(hash)) await isFinished(wide);
    await wide.screenshot({ path: path.join(screenshots, `${name}.png`) });
    await wide.close();
  }
  assert.deepEqual(complaints, []);
} finally {
  await look.end();
}
