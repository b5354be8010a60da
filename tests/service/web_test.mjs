// SPDX-License-Identifier: Apache-2.0
// Walks through the service's page in headless Chromium. web_test.py starts this script. It also starts and stops
// daemons when this script prints a line that begins with "@".
//
//   node web_test.mjs CHROMIUM SCREENSHOTS [STEP]
import assert from "node:assert/strict";
import { readFile, rm, writeFile } from "node:fs/promises";
import readline from "node:readline";
import { lowContrasts } from "./page_contrast.mjs";
import { NARROW, misplaced } from "./page_layout.mjs";
import { chromium } from "./web/node_modules/playwright-core/index.mjs";

const [executablePath, screenshots, only] = process.argv.slice(2);
const HOSTILE = `<img src=x onerror="window.isHacked = true">`;
const PATIENCE = 30000; // ms; the machine may be busy
const ROWS_MAX = 50;

const answers = readline.createInterface({ input: process.stdin })[Symbol.asyncIterator]();
async function drive(...request) {
  process.stdout.write(`@${JSON.stringify(request)}\n`);
  return JSON.parse((await answers.next()).value);
}

const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--disable-gpu", "--headless=new", "--disable-dev-shm-usage"],
});
const service = await drive("start", "open");
const complaints = []; // console errors of all pages, and their requests to other hosts
let isStopped = false; // if true, network errors are expected

async function openPage(path = "", { width = 1280, height = 800, deviceScaleFactor = 1, colorScheme = "light",
  at = service } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, deviceScaleFactor, colorScheme,
    reducedMotion: "reduce" });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.on("console", (message) => {
    const isNetwork = /Failed to load resource/.test(message.text());
    if (["error", "warning"].includes(message.type()) && !(isNetwork && (isStopped || page.expectsRefusal)))
      complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("dialog", (dialog) => complaints.push(`a foreign script says ${dialog.message()}`));
  page.on("request", (request) => {
    if (!request.url().startsWith(at.url) && !request.url().startsWith(`blob:${at.url}`))
      complaints.push(`a request to ${request.url()}`);
  });
  await page.goto(at.url + "/" + path);
  if (at === service) await page.waitForSelector("#line[data-state=live]");
  return page;
}

async function ask(method, path, body, at = service) {
  const response = await fetch(at.url + path, { method, body: body && JSON.stringify(body) });
  const answer = await response.json();
  assert.ok(response.ok, JSON.stringify(answer));
  return answer;
}
const drill = async (seconds, more = {}) => {
  const { then, ...job } = more;
  return (await ask("POST", "/v1/jobs", { type: "drill", parameters: { seconds, ...(then && { then }) }, ...job })).id;
};
const jobOf = (id) => ask("GET", `/v1/jobs/${id}`);

async function until(what, check, patience = PATIENCE) {
  const deadline = Date.now() + patience;
  for (;;) {
    const found = await check();
    if (found) return found;
    assert.ok(Date.now() < deadline, `still not: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
}
const stateOf = (id, state) => until(`job ${id} ${state}`, async () => (await jobOf(id)).state === state);
const row = (page, id) => page.locator(`#rows tr[data-id="${id}"]`);
const shows = (page, id, state) => row(page, id).locator(`.badge[data-state=${state}]`).waitFor();
const focusedRow = (page) => page.evaluate(() => Number(document.activeElement.closest("#rows tr")?.dataset.id ?? 0));
const focusedId = (page) => page.evaluate(() => document.activeElement.id);

async function bake(name, parameters = {}) {
  await drive("testmap", `${service.root}/${name}`);
  const job = await ask("POST", "/v1/jobs", {
    type: "bake", label: name, output: `${service.root}/${name}.ndf.exr`,
    parameters: { input: `${service.root}/${name}_normal.png`, lobes: 4, ...parameters },
  });
  await stateOf(job.id, "succeeded");
  return job.id;
}

/** Returns the bake of an earlier step, or a new one. */
const rock = async () => (await ask("GET", "/v1/jobs?state=succeeded&limit=1000")).jobs
  .find((job) => job.label === "rock")?.id ?? bake("rock");

async function checkContrast(page, least) {
  const { count, found } = await lowContrasts(page);
  assert.ok(count >= least, `${count} texts were checked, expected at least ${least}`);
  assert.deepEqual(found, []);
}

const noSideways = async (page, what) => {
  const [scroll, client] = await page.evaluate(() =>
    [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
  assert.ok(scroll <= client, `${what} is ${scroll} px wide in ${client}`);
};

// ---- Steps. Each step begins in the state in which the previous steps ended.

const steps = {
  async filesAreServedAsTheyShould() {
    const first = await fetch(service.url + "/");
    const policy = first.headers.get("content-security-policy");
    assert.match(policy, /default-src 'self'/);
    assert.doesNotMatch(policy, /unsafe|data:/);
    assert.equal(first.headers.get("referrer-policy"), "no-referrer");
    assert.equal(first.headers.get("cache-control"), "no-cache");
    const html = await first.text();
    assert.doesNotMatch(html, /https?:\/\/|<style|\son[a-z]+=|style=/, "nothing inline, nothing from elsewhere");
    for (const path of ["/", "/app.js", "/style.css", "/icon.svg"]) {
      const etag = (await fetch(service.url + path)).headers.get("etag");
      const again = await fetch(service.url + path, { headers: { "If-None-Match": etag } });
      assert.equal(again.status, 304, path);
    }
    // The embedded bytes equal the bytes of the file.
    const source = await readFile(new URL("../../host/farm/service/web/job_list.js", import.meta.url), "utf8");
    assert.equal(await (await fetch(service.url + "/job_list.js")).text(), source);
  },

  async anEmptyListSaysWhatToDo() {
    const page = await openPage();
    await page.getByText("multum jobs submit bake").waitFor();
    await page.context().close();
  },

  async theListFillsAndLivesWithoutReload() {
    const page = await openPage();
    await page.evaluate(() => { window.isThisPage = true; });
    const hostile = await drill(0, { label: HOSTILE, then: "refuse" });
    await shows(page, hostile, "dead");
    assert.ok((await row(page, hostile).innerText()).includes(HOSTILE), "a label is text");
    const long = await drill(600, { label: "long one" });
    await shows(page, long, "running");
    const bar = row(page, long).locator("progress");
    await bar.waitFor();
    const share = await bar.evaluate((one) => one.value);
    await until("progress moves", async () => (await bar.evaluate((one) => one.value)) > share);
    await until("time left", async () => /left/.test(await row(page, long).innerText()));
    await page.getByRole("button", { name: "Retry all dead (1)" }).waitFor();
    await row(page, hostile).click();
    await page.locator("#detail .why").getByText("this drill had to be refused").waitFor();
    assert.ok((await page.locator("#detail-title").innerText()).includes(HOSTILE));
    assert.equal(await page.evaluate(() => document.querySelectorAll("#rows img, #detail img").length), 0);
    assert.equal(await page.evaluate(() => window.isHacked), undefined);
    assert.equal(await page.evaluate(() => window.isThisPage), true);
    await page.context().close();
  },

  async aBakeHasPicturesAndALog() {
    const id = await bake("rock");
    const page = await openPage(`#job-${id}`);
    await page.locator("#detail .log").getByText("in total on").waitFor();
    await page.locator("#detail figure img").nth(2).waitFor();
    const measure = (images) => Promise.all(images.map(async (image) => {
      await image.decode();
      const { naturalWidth: width, naturalHeight: height } = image;
      const canvas = Object.assign(document.createElement("canvas"), { width, height });
      const context = canvas.getContext("2d");
      context.drawImage(image, 0, 0);
      const values = context.getImageData(0, 0, width, height).data.filter((_, i) => i % 4 === 1);
      const mean = values.reduce((sum, v) => sum + v, 0) / values.length;
      const spread = Math.sqrt(values.reduce((sum, v) => sum + (v - mean) ** 2, 0) / values.length);
      return { width, height, spread };
    }));
    const pictures = await page.locator("#detail figure img").evaluateAll(measure);
    assert.deepEqual(pictures.map(({ width, height }) => [width, height]), [[64, 64], [384, 288], [384, 288]]);
    for (const { spread } of pictures) assert.ok(spread > 10, `a picture of one colour: ${spread}`);
    await page.locator("#detail figure button").first().click();
    await page.locator("#picture img").waitFor();
    await page.keyboard.press("Escape");
    const downloading = page.waitForEvent("download");
    await page.getByText("Download the result").click();
    const download = await downloading;
    assert.equal(download.suggestedFilename(), "rock.ndf.exr");
    await page.context().close();
  },

  async aFolderIsDownloadedAsAnArchive() {
    await drive("testmap", `${service.root}/folder`);
    const scene = `${service.root}/scene.toml`;
    await writeFile(scene, `[[map]]\nname = "wall"\nnormal = "folder_normal.png"\n[[material]]\nname = "paint"\n
      brdf = "lambert"\n[[object]]\nname = "front"\nmap = "wall"\nmaterial = "paint"\nwidth = 2.0\n
      distance = [1, 20]\n[[light]]\ndirection = [0.3, 0.8, 0.5]\n`);
    const { id } = await ask("POST", "/v1/jobs", { type: "scene", parameters: { scene }, output: "maps.v2" });
    await stateOf(id, "succeeded");
    const page = await openPage(`#job-${id}`);
    for (const hasToken of [false, true]) { // the service does not require a token, but the page sends one anyway
      if (hasToken) await page.evaluate(() => sessionStorage.setItem("multum-token", "any"));
      const downloading = page.waitForEvent("download");
      await page.getByText("Download the result").click();
      assert.equal((await downloading).suggestedFilename(), "maps.v2.tar");
    }
    await page.context().close();
  },

  async aPackedFieldIsPlayedInATabOfItsOwn() {
    await drive("field", service.root);
    const { id } = await ask("POST", "/v1/jobs", { type: "pack", output: `${service.root}/field.mpt`,
      parameters: { manifest: `${service.root}/field/inferred.json`, lambda: 20 } });
    await stateOf(id, "succeeded");
    const page = await openPage(`#job-${id}`);
    const opening = page.context().waitForEvent("page");
    await page.getByText("Play it", { exact: true }).click();
    const player = await opening;
    player.on("console", (message) => { if (message.type() === "error") complaints.push(message.text()); });
    player.on("pageerror", (error) => complaints.push(String(error)));
    await player.waitForLoadState();
    const text = await player.locator("body").innerText();
    if (!text.includes("built without the decoder")) {
      await player.waitForFunction(() => globalThis.multumPlayer !== undefined);
      const brightest = await player.evaluate(async () => {
        await globalThis.multumPlayer.settled();
        return Math.max(...globalThis.multumPlayer.pixels().filter((_, i) => i % 4 === 1));
      });
      assert.ok(Math.abs(brightest - 137) <= 3, `${brightest}`); // a radiance of 0.25, encoded as sRGB
      assert.deepEqual(await player.locator("#problem-list li").allTextContents(), []);
      assert.equal(await player.evaluate(() => globalThis.origin), "null", "sandboxed");
    }
    await page.context().close();
  },

  async aBakesLobesAreLookedAtInATabOfItsOwn() {
    await drive("testmap", `${service.root}/look`);
    const { id } = await ask("POST", "/v1/jobs", { type: "bake", output: `${service.root}/look.ndf.exr`,
      parameters: { input: `${service.root}/look_normal.png`, no_measure: true } });
    await stateOf(id, "succeeded");
    const page = await openPage(`#job-${id}`, { width: 360, height: 740 });
    const link = page.locator("#detail a", { hasText: "its lobes" });
    const opening = page.context().waitForEvent("page");
    await link.press("Enter");
    const look = await opening;
    look.on("pageerror", (error) => complaints.push(String(error)));
    await look.waitForFunction(() => globalThis.multumLook?.frameMs !== undefined);
    assert.equal(await look.evaluate(() => globalThis.origin), "null", "sandboxed");
    assert.match(await look.textContent("#facts"), /64 x 64, 4 lobes/);
    await look.selectOption("#left", "lobes"); // the address stores the view, also in the sandbox
    await look.waitForFunction(() => globalThis.location.hash === "#left=lobes");
    // The sandbox also allows the worker of the page.
    await look.setInputFiles("#open", [`${service.root}/look.ndf.exr`]);
    await look.waitForFunction(() => globalThis.multumLook.shown === "dropped");
    assert.equal(await look.locator("#problem").isVisible(), false);
    // If the map is removed, an existing page stays. For a bake that has no page, the service shows the reason.
    const other = await ask("POST", "/v1/jobs", { type: "bake", output: `${service.root}/look_two.ndf.exr`,
      parameters: { input: `${service.root}/look_normal.png`, no_measure: true, lobes: 2 } });
    await stateOf(other.id, "succeeded");
    const again = await openPage(`#job-${other.id}`);
    again.expectsRefusal = true;
    await again.locator("#detail figure img").nth(2).waitFor();
    await rm(`${service.root}/look_normal.png`);
    await again.locator("#detail a", { hasText: "its lobes" }).click();
    await again.getByText("there is no such file").waitFor();
    for (const one of [page, again]) await one.context().close();
  },

  async theTableOfPartsFollowsAMapThatIsInShares() {
    const farm = await drive("farm");
    if (farm.why) return console.log(`  skipped: ${farm.why}`);
    const { id } = await ask("POST", "/v1/jobs", { type: "bake", queue: "farm", output: `${farm.root}/map.ndf.exr`,
      parameters: { input: `${farm.root}/map_normal.png`, no_measure: true } }, farm);
    const page = await openPage(`#job-${id}`, { at: farm });
    const table = page.getByRole("region", { name: "Parts" });
    const cells = () => table.locator("tbody tr").evaluateAll((rows) =>
      rows.map((one) => [...one.cells].map((cell) => cell.innerText)));
    const rowOf = async (start, round) => (await cells()).find(([part, attempt]) =>
      part.startsWith(start) && attempt === round);
    // Share 0 runs first and the bands wait for it. Share 1 then runs until the test lets it continue, or cancels it.
    await until("share 1 runs", async () => ((await rowOf("1/", "1"))?.[2] ?? "").startsWith("running"),
      3 * PATIENCE); // kernels may need to be compiled
    const [share, , , node, slurmJob] = await rowOf("1/", "1");
    assert.match(node, /^bake[12]$/);
    assert.match(slurmJob, /^\d+$/);
    assert.equal((await rowOf("0/", "1"))[2], "succeeded");
    assert.equal(await table.getByRole("button", { name: "Cancel part 0/" }).count(), 0, "it has ended");
    await writeFile(farm.go, "");
    await table.getByRole("button", { name: `Cancel part ${share}`, exact: true }).click();
    await page.getByText(`Part ${share} of job ${id} is cancelled on Slurm`).waitFor();
    await until("it is done again", async () => (await rowOf("1/", "1, round 2"))?.[2] === "succeeded");
    await page.locator("#detail").getByText("succeeded", { exact: true }).first().waitFor();
    await until("the merge is done", async () => (await rowOf("merge", "1, round 2"))?.[2] === "succeeded");
    assert.equal((await rowOf("1/", "1"))[2], "lost");
    assert.equal(await table.getByRole("button").count(), 0, "nothing is left to cancel");
    await page.context().close();
  },

  async aMessageOfSeveralLinesHasOneInTheList() {
    const id = await drill(0, { then: "refuse", label: "talks much" });
    await stateOf(id, "dead");
    const message = "the first line\nthe second line";
    const page = await openPage();
    await page.route(/\/v1\/jobs(\?|\/\d+$)/, async (route) => {
      const response = await route.fetch();
      const answer = await response.json();
      for (const job of answer.jobs ?? [answer]) if (job.id === id) job.message = message;
      await route.fulfill({ response, json: answer });
    });
    await page.reload();
    const note = row(page, id).locator(".note");
    await note.getByText("the first line ...", { exact: true }).waitFor();
    assert.equal(await note.getAttribute("title"), message);
    await row(page, id).click();
    const why = page.locator("#detail .why");
    await why.getByText("the second line").waitFor();
    const lines = await why.evaluate((one) => {
      const style = getComputedStyle(one);
      return (one.clientHeight - 2 * parseFloat(style.paddingTop)) / parseFloat(style.lineHeight);
    });
    assert.ok(lines > 1.5, `${lines} lines of two`);
    await page.unrouteAll({ behavior: "ignoreErrors" }); // the page still sends requests while it closes
    await page.context().close();
  },

  async theLogOfARunningJobGrows() {
    const id = await drill(0, { then: "fail", attempt_max: 100 });
    const page = await openPage(`#job-${id}`);
    const attempts = page.locator("#detail tbody tr");
    await until("attempts", async () => (await attempts.count()) > 2);
    await shows(page, id, "queued");
    await ask("POST", `/v1/jobs/${id}/cancel`);
    await page.locator("#detail .badge[data-state=cancelled]").waitFor();
    const good = await drill(2);
    await page.goto(`${service.url}/#job-${good}`);
    await page.getByText("The log is empty so far.").waitFor();
    await page.locator("#detail .log").getByText("drill: done").waitFor();
    await page.context().close();
  },

  async everythingByKeyboardAlone() {
    for (const then of ["succeed", "refuse"]) await drill(0, { then });
    const id = await drill(600, { label: "by keyboard" });
    await stateOf(id, "running");
    const page = await openPage();
    const key = (name) => page.keyboard.press(name);
    await shows(page, id, "running");
    const seen = [];
    for (let i = 0; i < 25 && (await focusedRow(page)) === 0; ++i) {
      await key("Tab");
      const [words, isVisible] = await page.evaluate(() => {
        const style = getComputedStyle(document.activeElement);
        return [document.activeElement.id || document.activeElement.textContent.trim(),
          style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2];
      });
      assert.ok(isVisible, `no visible focus on ${words}`);
      seen.push(words);
    }
    const places = ["new-job", "theme", "help", "filter-state", "filter-queue", "filter-text", "retry-dead"];
    assert.deepEqual(seen.filter((one) => places.includes(one)), places, "Tab goes through the page from the top");
    assert.equal(await focusedRow(page), id, "Tab leads to the newest job");
    await key("ArrowDown");
    const second = await focusedRow(page);
    assert.notEqual(second, id);
    await key("j");
    const third = await focusedRow(page);
    assert.notEqual(third, second);
    await key("k");
    await key("ArrowUp");
    await key("ArrowUp");
    assert.equal(await focusedRow(page), id, "the up key stops at the first job");

    await key("Enter");
    await page.locator("#detail-title").waitFor();
    await until("focus in the job", async () => (await focusedId(page)) === "detail-title");
    await key("Escape");
    assert.equal(await page.locator("#detail").isVisible(), false);
    assert.equal(await focusedRow(page), id, "Escape gives the focus back");

    await key("c");
    await page.locator("#confirm[open]").waitFor();
    await key("Escape");
    assert.equal((await jobOf(id)).state, "running", "not confirmed, not cancelled");
    assert.equal(await focusedRow(page), id);
    await key("c");
    await page.locator("#confirm[open]").waitFor();
    await key("Enter");
    await shows(page, id, "cancelled");
    assert.equal((await jobOf(id)).state, "cancelled");
    assert.equal(await focusedRow(page), id);
    await key("r");
    await shows(page, id, "running");
    await key("Enter");
    await until("focus in the job", async () => (await focusedId(page)) === "detail-title");
    await key("c");
    await page.locator("#confirm[open]").waitFor();
    await key("Enter");
    await page.locator("#detail .badge[data-state=cancelled]").waitFor();
    await until("the end is said", async () => (await page.locator("#announce").textContent()).includes("cancelled"));
    await key("Escape");

    await key("/");
    assert.equal(await focusedId(page), "filter-text");
    await page.keyboard.type("cj?");
    assert.equal(await page.locator("#filter-text").inputValue(), "cj?", "typed letters must have no other effect");
    await page.getByText("None of the newest").waitFor();
    await page.locator("#filter-text").fill("");
    await shows(page, id, "cancelled");
    await key("Escape");
    assert.notEqual(await focusedRow(page), 0);
    await key("?");
    await page.locator("#keys[open]").waitFor();
    await key("Escape");
    await key("n");
    await page.locator("#submit[open]").waitFor();
    await key("Escape");
    assert.equal(await page.locator("dialog[open]").count(), 0);

    // The focus is not trapped. Even if a job is open, Tab reaches the end of the page and starts again.
    await key("Enter");
    await until("focus in the job", async () => (await focusedId(page)) === "detail-title");
    const hasLog = () => page.locator("#detail .log").isVisible();
    const hadLog = await hasLog();
    const round = new Set();
    for (let i = 0; i < 60; ++i) {
      await key("Tab");
      round.add(await page.evaluate(() => document.activeElement.id || document.activeElement.tagName));
    }
    assert.ok(round.has("new-job"), [...round].join(" "));
    // The log may appear or be reloaded while Tab moves the focus around the page.
    if (hadLog === await hasLog()) assert.ok(round.has("PRE") || !hadLog, [...round].join(" "));
    await page.context().close();
  },

  async filtersAndPages() {
    for (let i = 0; i < ROWS_MAX; ++i) await drill(0, { label: `terrain tile ${i}`, queue: "night" });
    await until("all done", async () => (await ask("GET", "/v1/queues")).queues.find((q) => q.name === "night").jobs
      .succeeded === ROWS_MAX);
    const page = await openPage();
    await until("one page", async () => (await page.locator("#rows tr").count()) === ROWS_MAX);
    const [top] = await page.locator("#rows tr").evaluateAll((rows) => rows.map((one) => Number(one.dataset.id)));
    await page.getByRole("button", { name: "Older jobs" }).click();
    await page.getByRole("button", { name: "Newer jobs" }).waitFor();
    await until("the older page", async () => Number(await page.locator("#rows tr").first().getAttribute("data-id"))
      === top - ROWS_MAX);
    await page.getByRole("button", { name: "Newer jobs" }).click();
    await row(page, top).waitFor();
    await page.locator("#filter-state").selectOption("dead");
    await until("the dead alone", async () => (await page.locator("#rows .badge").allInnerTexts())
      .every((state) => state === "dead"));
    await page.locator("#filter-state").selectOption("");
    await page.locator("#filter-text").fill("TILE 7");
    await page.getByText("1 found among").waitFor();
    await page.locator("#filter-text").fill("");
    await page.locator("#filter-queue").selectOption("default");
    await until("one queue alone", async () => (await page.locator("#rows td.queue").allInnerTexts())
      .every((queue) => queue === "default"));
    await page.context().close();
  },

  async queuesArePausedAndTheDeadRetried() {
    const page = await openPage();
    await page.getByRole("button", { name: "Pause queue night" }).click();
    await page.getByRole("button", { name: "Resume queue night" }).waitFor();
    const id = await drill(0, { queue: "night" });
    await shows(page, id, "queued");
    await page.getByRole("button", { name: "Resume queue night" }).click();
    await shows(page, id, "succeeded");
    const dead = await drill(0, { then: "refuse" });
    await shows(page, dead, "dead");
    await page.locator("#retry-dead").click();
    await page.getByRole("button", { name: "No, leave it" }).click();
    assert.equal((await jobOf(dead)).attempt, 1);
    await page.locator("#retry-dead").click();
    await page.getByRole("button", { name: "Yes, retry them" }).click();
    await until("another attempt", async () => (await jobOf(dead)).attempt === 2);
    await page.context().close();
  },

  async theFormMakesJobs() {
    const page = await openPage();
    await page.locator("#new-job").click();
    await page.locator("#submit-type").selectOption("drill");
    await page.locator("#parameter-seconds").fill("0");
    await page.locator("#submit-label").fill("from the form");
    await page.locator("#submit-priority").fill("7");
    await page.getByRole("button", { name: "Submit", exact: true }).click();
    await page.waitForURL(/#job-\d+$/);
    const id = Number(/\d+$/.exec(page.url()));
    await stateOf(id, "succeeded");
    const job = await jobOf(id);
    assert.deepEqual([job.label, job.priority, job.parameters], ["from the form", 7, { seconds: 0 }]);

    await page.keyboard.press("Escape");
    await page.locator("#new-job").click();
    await page.locator("#submit-type").selectOption("bake");
    await page.locator("#submit input[type=file]").first().setInputFiles(`${service.root}/rock_normal.png`);
    await until("the path", async () => (await page.locator("#parameter-input").inputValue()).includes("/uploads/"));
    assert.match(await page.locator("#submit-output").inputValue(), /\/results\/rock_normal-[0-9a-f]{8}\.ndf\.exr$/);
    await page.getByText(/^Parameters/).click();
    await page.locator("#parameter-lobes").fill("2");
    await page.locator("#parameter-first_level").fill("15");
    page.expectsRefusal = true;
    await page.getByRole("button", { name: "Submit", exact: true }).click();
    await page.waitForURL((url) => url.hash !== "" && url.hash !== `#job-${id}`);
    await page.locator("#detail .badge[data-state=dead]").waitFor();
    assert.match(await page.locator("#detail .why").innerText(), /first-level/);
    await page.locator("#new-job").click();
    await page.locator("#submit-type").selectOption("bake");
    await page.locator("#parameter-input").fill("/nowhere/at/all.png");
    assert.equal(await page.locator("#submit-output").inputValue(), "/nowhere/at/all.ndf.exr");
    await page.getByRole("button", { name: "Submit", exact: true }).click();
    await page.locator("#submit [role=alert]").getByText("not below a folder").waitFor();
    await page.context().close();
  },

  async looksOfIt() {
    const baked = await rock(); // while a worker is free for the job
    const running = await drill(900, { label: "cliff, 16384 x 16384" });
    await drill(900, { label: "terrain tile 50", queue: "night" });
    await drill(0, { label: "cliff, its frames", needs: [running] });
    await stateOf(running, "running");
    for (const colorScheme of ["light", "dark"]) {
      const page = await openPage("", { width: 1360, height: 760, colorScheme });
      await until("time left", async () => /left/.test(await row(page, running).innerText()));
      await checkContrast(page, 40);
      await until("notices are gone", async () => (await page.locator(".notice").count()) === 0);
      await page.screenshot({ path: `${screenshots}/${colorScheme}.png` });
      await page.goto(`${service.url}/#job-${baked}`);
      await page.locator("#detail figure img").nth(2).waitFor();
      await checkContrast(page, 70);
      await page.setViewportSize({ width: 1500, height: 1000 });
      await page.screenshot({ path: `${screenshots}/detail_${colorScheme}.png` });
      await page.keyboard.press("Escape");
      for (const name of ["n", "?", "c"]) {
        if (name === "c") await row(page, running).locator("a").focus();
        await page.keyboard.press(name);
        await page.locator("dialog[open]").waitFor();
        await checkContrast(page, 4);
        if (name === "n") await page.screenshot({ path: `${screenshots}/form_${colorScheme}.png` });
        await page.keyboard.press("Escape");
      }
      await page.context().close();
    }
    // The button overrides the setting of the system.
    const page = await openPage("", { colorScheme: "light" });
    const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await back();
    await page.locator("#theme").click();
    assert.equal(await back(), light);
    await page.locator("#theme").click();
    assert.notEqual(await back(), light);
    await page.reload();
    assert.notEqual(await back(), light, "and is remembered");
    await page.context().close();
    for (const state of ["queued", "running"]) // the next steps need the workers
      for (const job of (await ask("GET", `/v1/jobs?state=${state}&limit=1000`)).jobs)
        await ask("POST", `/v1/jobs/${job.id}/cancel`);
  },

  async narrowScreens() {
    const baked = await rock();
    const page = await openPage("", { width: 360, height: 740 });
    await noSideways(page, "the list");
    await page.screenshot({ path: `${screenshots}/narrow.png` });
    await page.goto(`${service.url}/#job-${baked}`);
    await page.locator("#detail figure img").nth(2).waitFor();
    await noSideways(page, "a job");
    assert.ok(await page.locator("#detail").evaluate((one) => one.scrollWidth <= one.clientWidth), "a job is too wide");
    assert.equal(await page.locator("#main").evaluate((one) => one.inert), true, "covered parts must be inert");
    await page.screenshot({ path: `${screenshots}/narrow_detail.png` });
    await page.keyboard.press("Escape");
    await page.keyboard.press("n");
    await page.locator("#submit[open]").waitFor();
    await noSideways(page, "the form");
    assert.ok(await page.locator("#submit").evaluate((one) => one.scrollWidth <= one.clientWidth), "a form too wide");
    await page.context().close();
  },

  async nothingIsCutInNarrowWindows() {
    const id = await drill(0, { label: `A_label_${"without_an_end_".repeat(12)}` });
    for (const { viewport, deviceScaleFactor } of NARROW) {
      const page = await openPage("", { ...viewport, deviceScaleFactor });
      await shows(page, id, "succeeded");
      assert.deepEqual(await misplaced(page, "#main"), [], `the list, ${viewport.width} px`);
      await page.screenshot({ path: `${screenshots}/list_${viewport.width}.png` });
      await page.evaluate((number) => { location.hash = `job-${number}`; }, id);
      await page.locator("#detail:not([hidden])").waitFor();
      assert.deepEqual(await misplaced(page, "#detail"), [], `a job, ${viewport.width} px`);
      await page.screenshot({ path: `${screenshots}/detail_${viewport.width}.png` });
      await page.keyboard.press("Escape");
      await page.keyboard.press("n");
      await page.locator("#submit[open]").waitFor();
      assert.deepEqual(await misplaced(page, "#submit"), [], `the form, ${viewport.width} px`);
      await page.screenshot({ path: `${screenshots}/form_${viewport.width}.png` });
      await page.context().close();
    }
  },

  async errorsAreWords() {
    const page = await openPage();
    isStopped = true; // errors after this point are expected
    await page.evaluate(() => {
      globalThis.fetch = () => Promise.reject(undefined);
      document.getElementById("new-job").click();
      setTimeout(() => Promise.reject(undefined));
    });
    await page.getByText("The service does not answer (the browser gives no reason).").waitFor();
    await page.getByText("Something in this page failed: the browser gives no reason.").waitFor();
    assert.doesNotMatch(await page.locator("#notices").innerText(), /undefined/);
    complaints.length = 0;
    isStopped = false;
    await page.context().close();
  },

  async aTokenIsAskedFor() {
    const guarded = await drive("start", "guarded");
    const page = await openPage("", { at: guarded });
    page.expectsRefusal = true;
    await page.locator("#token[open]").waitFor();
    await page.keyboard.press("Escape");
    assert.equal(await page.locator("#token[open]").count(), 1, "there is nothing behind it");
    await page.locator("#token-text").fill("a wrong token of letters");
    await page.keyboard.press("Enter");
    await page.getByText("This token was refused.").waitFor();
    await page.locator("#token-text").fill(guarded.token);
    await page.keyboard.press("Enter");
    await page.locator("#line[data-state=live]").waitFor();
    const submitted = await fetch(`${guarded.url}/v1/jobs`, { method: "POST", body: JSON.stringify({ type: "drill" }),
      headers: { Authorization: `Bearer ${guarded.token}` } });
    const { id } = await submitted.json();
    await shows(page, id, "succeeded");
    await page.reload();
    await shows(page, id, "succeeded");
    assert.equal(await page.locator("#token[open]").count(), 0, "the tab remembers it");
    assert.doesNotMatch(page.url(), /token/);
    await page.context().close();
  },

  async aBrokenLineIsSeenAndMended() {
    const page = await openPage();
    const id = await drill(0);
    await shows(page, id, "succeeded");
    isStopped = true;
    await drive("stop", "open");
    await page.locator("#line[data-state=broken]").waitFor();
    assert.match(await page.locator("#line").innerText(), /not connected/);
    await page.screenshot({ path: `${screenshots}/broken.png` });
    await drive("start", "open");
    const meanwhile = await drill(0, { label: "meanwhile" });
    await page.locator("#line[data-state=live]").waitFor();
    await shows(page, meanwhile, "succeeded");
    isStopped = false;
    const after = await drill(0, { label: "after" });
    await shows(page, after, "succeeded");
    await page.context().close();
  },

  async thousandsOfJobsAreFewRows() {
    const page = await openPage();
    await page.evaluate(() => {
      window.most = 0;
      new MutationObserver(() => {
        window.most = Math.max(window.most, document.querySelectorAll("#rows tr").length);
      }).observe(document.getElementById("rows"), { childList: true });
    });
    let last = 0;
    for (let i = 0; i < 2000; i += 100)
      last = Math.max(last, ...await Promise.all(Array.from({ length: 100 }, () => drill(0))));
    await shows(page, last, "succeeded");
    const [most, nodes] = await page.evaluate(() => [window.most, document.querySelectorAll("*").length]);
    assert.ok(most > 0 && most <= ROWS_MAX + 1, `${most} rows at once`);
    assert.ok(nodes < 2500, `${nodes} elements`);
    await page.context().close();
  },
};

let failures = 0;
for (const [name, step] of Object.entries(steps)) {
  if (only && !name.includes(only)) continue;
  const begun = Date.now();
  try {
    await step();
    assert.deepEqual(complaints.splice(0), [], "consoles must be empty, and no other host may be asked");
    console.log(`ok      ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failures;
    console.log(`FAILED  ${name}: ${error.stack}`, complaints.splice(0));
    for (const context of browser.contexts()) {
      await context.pages()[0]?.screenshot({ path: `${screenshots}/failed_${name}.png` });
      await context.close();
    }
  }
}
await browser.close();
process.exit(failures > 0 ? 1 : 0);
