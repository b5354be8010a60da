// SPDX-License-Identifier: Apache-2.0
// Measures how fast a player's page plays in headless Chromium with its software renderer, SwiftShader, and prints
// JSON.
// tools/lab/playback/playing.py runs it.
//
//   node browser_speed.mjs CHROMIUM PAGE.html [SECONDS]
//
// On the path "cached", the first two samples along the first parameter are decoded, and the position moves between
// these samples.
// On the path "diagonal", all textures are dropped first. Every frame then moves one sample further along all
// parameters, wrapping around at the ends, until all samples have been shown once. Each frame waits for all of its
// textures.
import { pathToFileURL } from "node:url";
import { chromium } from "../../tests/service/web/node_modules/playwright-core/index.mjs";

const [executablePath, file, seconds = "3"] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--headless=new", "--disable-dev-shm-usage", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader"],
});

/** Within the page. */
async function measure(patience) {
  const player = globalThis.multumPlayer;
  const { gl } = player.gl;
  const { sizes, supersampling } = player.description;
  const pixel = new Uint8Array(4);
  const finish = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits until drawing has finished
  const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const channel = new MessageChannel();
  const turn = () => new Promise((resolve) => { // one turn of the browser's event loop; setTimeout would take 4 ms
    channel.port1.onmessage = resolve;
    channel.port2.postMessage(null);
  });
  const quantile = (list, p) => list.toSorted((a, b) => a - b)[Math.max(0, Math.ceil(p * list.length) - 1)];
  const times = (list) => ({ frames: list.length, p50Ms: quantile(list, 0.5), p99Ms: quantile(list, 0.99),
    perSecond: 1000 * list.length / list.reduce((a, b) => a + b, 0) });
  const automatic = player.quality;
  const fixedQuality = (side) => ({ side, frame() {}, framesPerSecond: 0 });
  const result = { renderer: gl.getParameter(gl.RENDERER), width: player.description.width,
    height: player.description.height, supersampling };
  await player.settled();
  for (const sample of [[0, 0], [1, 0]]) {
    player.moveTo(sizes.map((_, d) => sample[d] ?? 0));
    await player.settled();
  }

  // Only draws, without decoding or showing anything.
  result.draw = [];
  for (const isSmooth of [false, true]) {
    player.isSmooth = isSmooth;
    for (let side = 1; side <= supersampling; side *= 2) {
      player.quality = fixedQuality(side);
      const list = [];
      for (let i = 0; i < 30; ++i) {
        player.position = sizes.map((_, d) => (d === 0 ? i / 30 : 0));
        player.hasMoved = true;
        player.movedAt = performance.now();
        const begun = performance.now();
        player.drawNow();
        finish();
        if (i >= 5) list.push(performance.now() - begun);
      }
      result.draw.push({ isSmooth, side, ...times(list) });
    }
  }

  // Divides the time of a picture with one sub-pixel per pixel into parts. For this purpose, measures three other
  // pictures. The first picture has no objects. The second picture has only 16 x 12 pixels, so most of its time is
  // spent on vertices. The third picture uses lookups in two mip levels, as when the view is at rest.
  player.isSmooth = false;
  player.quality = fixedQuality(1);
  const p50 = () => {
    const list = [];
    for (let i = 0; i < 25; ++i) {
      player.hasMoved = true;
      player.movedAt = performance.now();
      const begun = performance.now();
      player.drawNow();
      finish();
      list.push(performance.now() - begun);
    }
    return quantile(list, 0.5);
  };
  const draw = player.gl.draw.bind(player.gl);
  const drawnWith = (change) => {
    player.gl.draw = (all) => draw(change(all));
    const ms = p50();
    player.gl.draw = draw;
    return ms;
  };
  player.moveTo(sizes.map(() => 0));
  await player.settled();
  result.profile = { wholeMs: p50(), withoutObjectsMs: drawnWith((all) => ({ ...all, objects: [] })),
    smallMs: drawnWith((all) => ({ ...all, width: 16, height: 12 })),
    twoLevelsMs: drawnWith((all) => ({ ...all, hasOneLevel: false })) };

  // Measures the page as a person sees it, with frames at the browser's rate and the number of sub-pixels that the page
  // chooses.
  result.cached = [];
  for (const isSmooth of [false, true]) {
    player.setSmooth(isSmooth);
    player.quality = automatic;
    let begun = performance.now();
    let [pictures, last] = [0, begun];
    while (last - begun < 1000 * patience) {
      player.moveTo(sizes.map((_, d) => (d === 0 ? 0.5 - 0.5 * Math.cos((last - begun) / 500) : 0)));
      last = await frame();
      if (pictures === 0 && last - begun > 500 * patience) { // before this time, the page adapts the number of
                                                             // sub-pixels
        [pictures, begun] = [player.statistics.frames, last];
      }
    }
    finish();
    result.cached.push({ isSmooth, side: automatic.side, frames: player.statistics.frames - pictures,
      perSecond: 1000 * (player.statistics.frames - pictures) / (performance.now() - begun) });
  }

  player.setSmooth(false);
  const whole = Math.max(...sizes);
  const count = sizes.reduce((a, b) => a * b, 1);
  result.diagonal = [];
  for (const side of [1, 2]) {
    player.moveTo(sizes.map((size) => size - 1));
    await player.settled();
    player.quality = fixedQuality(side);
    player.store.clear();
    player.requestDraw = () => {}; // prevents additional pictures
    const decodedBefore = player.statistics.decoded;
    const parts = { waiting: 0, drawing: 0 };
    const list = [];
    for (let n = 0; n < count; ++n) {
      const begun = performance.now();
      player.moveTo(sizes.map((size, d) => (n % whole + (d === 0 ? 0 : Math.floor(n / whole))) % size));
      while (!player.isComplete) await turn();
      const there = performance.now();
      player.drawNow();
      finish();
      parts.waiting += there - begun;
      parts.drawing += performance.now() - there;
      list.push(performance.now() - begun);
    }
    result.diagonal.push({ side, ...times(list), waitingMs: parts.waiting / count, drawingMs: parts.drawing / count,
      texturesDecoded: player.statistics.decoded - decodedBefore, workers: player.pool.workers.length });
    delete player.requestDraw;
  }
  player.quality = automatic;
  return result;
}

try {
  const page = await browser.newPage({ viewport: { width: 360, height: 640 } });
  await page.goto(pathToFileURL(file).href);
  await page.waitForFunction(() => globalThis.multumPlayer !== undefined);
  const measured = await page.evaluate(measure, Number(seconds));
  console.log(JSON.stringify({ browser: browser.version(), ...measured }, null, 1));
} finally {
  await browser.close();
}
