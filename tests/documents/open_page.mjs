// SPDX-License-Identifier: Apache-2.0
// Opens a page in headless Chromium, waits until its title is TITLE, and fails if the page reports an error.
//
//   node open_page.mjs URL TITLE
import { existsSync } from "node:fs";
import { chromium } from "../service/web/node_modules/playwright-core/index.mjs";

const [url, title] = process.argv.slice(2);
const executablePath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium",
  "/usr/local/bin/chromium"].find(existsSync);
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--headless=new",
  "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
const complaints = [];
try {
  const page = await browser.newPage();
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("console", (message) => {
    if (message.type() === "error" && !/favicon/.test(message.text() + message.location().url))
      complaints.push(message.text());
  });
  await page.goto(url);
  await page.waitForFunction((wanted) => document.title === wanted, title, { timeout: 120000 })
    .catch(async () => complaints.push(`the title is '${await page.title()}', expected '${title}'`));
} finally {
  await browser.close();
}
for (const complaint of complaints) console.log(complaint);
process.exit(complaints.length > 0 ? 1 : 0);
