// SPDX-License-Identifier: MIT OR Apache-2.0
// Checks of a report's pages in a browser; ci/pages.sh says which, and sets NODE_PATH and CHROMIUM.
"use strict";
const fs = require("fs");
const os = require("os");
const path = require("path");
const { pathToFileURL } = require("url");
const puppeteer = require("puppeteer-core");
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

const WIDTHS = [1400, 800, 390];
const MAX_INDEX_BYTES = 300e3;
const MAX_LOAD_MS = 1000;
const MAX_PRINTED_PAGES = 12;
// As axe grades what keeps a reader out.
const GRAVE = ["serious", "critical"];

// What a reader may open is opened: what a page holds must be sound, folded or not.
const unfold = (page) => page.$$eval("details:not(.wipe)", (all) => { for (const details of all) details.open = true; });

// Opens a page and collects what it says on the console.
async function open(browser, url, width, scheme, problems) {
  const page = await browser.newPage();
  page.on("console", (said) => { if (["error", "warning"].includes(said.type())) problems.push(`console: ${said.text()}`); });
  page.on("pageerror", (error) => problems.push(`script: ${error.message}`));
  page.on("requestfailed", (request) => problems.push(`not loaded: ${request.url()}`));
  // A phone shows all of the widest line, so that what is too wide makes all else small.
  await page.setViewport({ width, height: 900, isMobile: width < 600 });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  await page.goto(url, { waitUntil: "load" });
  return page;
}

// What a reader meets at one width in one colour scheme.
async function look(browser, url, width, scheme) {
  const problems = [];
  const page = await open(browser, url, width, scheme, problems);
  await unfold(page);
  const needed = await page.evaluate(() => document.documentElement.scrollWidth);
  if (needed > width) problems.push(`scrolls sideways: ${needed} px wide`);
  const broken = await page.$$eval("img[src]", (all) => Promise.all(all.map((img) => {
    img.loading = "eager";
    return img.decode().then(() => "", () => img.alt || img.getAttribute("src").slice(0, 60));
  })));
  const names = broken.filter(Boolean);
  if (names.length) problems.push(`broken pictures: ${names.length}: ${names.slice(0, 3).join(", ")}`);
  await page.evaluate(axe);
  const found = await page.evaluate(() => axe.run(document, { resultTypes: ["violations"], preload: false }));
  for (const violation of found.violations.filter((v) => GRAVE.includes(v.impact))) {
    const places = violation.nodes.slice(0, 3).map((node) => node.target.join(" ")).join(", ");
    problems.push(`axe: ${violation.id} (${violation.impact}), ${violation.nodes.length} places: ${places}`);
  }
  await page.close();
  return problems.map((problem) => `${width} px, ${scheme}: ${problem}`);
}

// Filters, sorting, pointers and keys, where the page has them. Says what it tried.
async function use(browser, url, tried) {
  const problems = [];
  const page = await open(browser, url, 1400, "light", problems);
  const count = (what) => { tried[what] = (tried[what] || 0) + 1; };
  const expect = (ok, what) => { count(what); if (!ok) problems.push(`fails: ${what}`); };

  const folded = await page.$$eval("nav a[href^='#']", (links) => links
    .map((link) => link.getAttribute("href"))
    .find((href) => { const at = document.getElementById(href.slice(1)); return at && at.closest("details:not([open])"); }));
  if (folded) {
    const isOpen = () => page.$eval(folded, (at) => !at.closest("details:not([open])"));
    await page.click(`nav a[href='${folded}']`);
    expect(await isOpen(), "a link opens what is folded");
    await page.reload({ waitUntil: "load" });
    expect(page.url().endsWith(folded) && await isOpen(), "an address opens what is folded");
  }
  await unfold(page);
  if (await page.$(".tools input[type=search]")) {
    const rows = () => page.$eval(".tools input[type=search]", (input) => {
      const table = input.closest(".tools").nextElementSibling.querySelector("table");
      return [...table.tBodies[0].rows].filter((row) => row.getClientRects().length > 0).length;
    });
    const all = await rows();
    await page.type(".tools input[type=search]", "no-row-has-this");
    expect(await rows() === 0 && all > 0, "a filter hides rows");
    await page.setViewport({ width: 390, height: 900 });
    expect(await rows() === 0, "a filter hides rows that are cards");
    await page.setViewport({ width: 1400, height: 900 });
    const address = page.url();
    expect(address.includes("no-row-has-this"), "the address keeps the filter");
    const again = await open(browser, address, 1400, "light", problems);
    expect(await again.$eval(".tools input[type=search]", (input) => input.value) === "no-row-has-this", "a link carries the filter");
    await again.close();
    await page.$eval(".tools input[type=search]", (input) => { input.value = ""; input.dispatchEvent(new Event("input")); });
    expect(await rows() === all, "an empty filter shows all rows");
    const button = await page.$("th button");
    if (button) {
      await button.evaluate((b) => { b.focus(); });
      await page.keyboard.press("Enter");
      expect(await page.$("th[aria-sort=ascending]") !== null, "a heading sorts");
      await page.keyboard.press("Enter");
      expect(await page.$("th[aria-sort=descending]") !== null, "a heading sorts the other way");
    }
  }
  for (const [selector, what] of [[".spot", "a mark says its values on focus"], ["td[data-command], th[data-command]", "a cell says its command on focus"]]) {
    const found = await page.$$(selector);
    for (const mark of found) {
      if (!await mark.evaluate((m) => m.getClientRects().length > 0)) continue;
      // A pointer that rests where the mark comes to lie would not enter it again.
      await page.mouse.move(0, 0);
      await mark.evaluate((m) => { m.focus(); });
      expect(await page.$eval(".tip", (tip) => tip.textContent.trim().length > 0).catch(() => false), what);
      await page.keyboard.press("Escape");
      expect(await page.$(".tip") === null, "Escape closes it");
      await mark.hover();
      expect(await page.$(".tip") !== null, "so it does under a pointer");
      await page.keyboard.press("Escape");
      break;
    }
  }
  const wipe = await page.$(".wipe summary");
  if (wipe) {
    await wipe.click();
    const shows = () => [...document.querySelectorAll(".wipe[open] img")].length > 1 && [...document.querySelectorAll(".wipe[open] img")].every((img) => img.src !== "");
    const shown = await page.waitForFunction(shows, { timeout: 2000 }).then(() => true, () => false);
    expect(shown, "a picture lies over the reference");
    const edge = () => page.$eval(".wipe img + img", (img) => img.style.clipPath);
    const before = await edge();
    await page.focus(".wipe input");
    await page.keyboard.press("ArrowRight");
    expect(before !== await edge(), "the edge moves by keys");
  }
  await page.close();
  problems.push(...await tab(browser, url, count));
  return problems;
}

// Every stop of the Tab key is seen, from the top of the page on, and none holds the reader.
async function tab(browser, url, count) {
  const problems = [];
  const page = await open(browser, url, 1400, "light", []);
  const stops = new Set();
  for (let press = 0; press < 40; press += 1) {
    await page.keyboard.press("Tab");
    const stop = await page.evaluate(() => {
      const own = document.activeElement;
      if (own === document.body) return null;
      own.dataset.stop = own.dataset.stop || String(document.querySelectorAll("[data-stop]").length);
      return [own.dataset.stop, own.getClientRects().length > 0, getComputedStyle(own).outlineStyle !== "none" || own.matches(".spot, .pictures img, input[type=radio], input[type=range]")];
    });
    if (stop === null) break;
    if (!stop[1]) problems.push("a Tab stop is not seen");
    if (!stop[2]) problems.push("a Tab stop does not show its focus");
    stops.add(stop[0]);
  }
  const what = "the Tab key reaches what can be used";
  count(what);
  if (stops.size <= 5) problems.push(`fails: ${what}: ${stops.size} stops`);
  await page.close();
  return problems;
}

// Without scripts the page is as long, and its tables and drawings are there.
async function withoutScripts(browser, url) {
  const page = await browser.newPage();
  await page.setJavaScriptEnabled(false);
  await page.goto(url, { waitUntil: "load" });
  const parts = await page.$$eval("table, svg, dl, .lead", (all) => all.length);
  const hidden = await page.$$eval("table", (all) => all.filter((t) => t.getClientRects().length === 0 && !t.closest("details, .way")).length);
  await page.close();
  return parts === 0 ? ["without scripts: empty"] : hidden > 0 ? [`without scripts: ${hidden} tables are hidden`] : [];
}

async function firstPage(browser, file) {
  const problems = [];
  const url = pathToFileURL(file).href;
  const bytes = fs.statSync(file).size;
  const isSingle = !fs.existsSync(path.join(path.dirname(file), "pages"));
  if (bytes > MAX_INDEX_BYTES && !isSingle) problems.push(`${bytes} bytes, allowed ${MAX_INDEX_BYTES}`);
  // The best of three: the first one starts the browser's own processes too.
  let load = Infinity;
  for (let time = 0; time < 3; time += 1) {
    const page = await open(browser, url, 1400, "light", problems);
    load = Math.min(load, await page.evaluate(() => performance.getEntriesByType("navigation")[0].loadEventStart));
    await page.close();
  }
  if (load > MAX_LOAD_MS) problems.push(`loads in ${load.toFixed(0)} ms, allowed ${MAX_LOAD_MS}`);
  const page = await open(browser, url, 1400, "light", problems);
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  const pdf = Buffer.from(await page.pdf({ preferCSSPageSize: true })).toString("latin1");
  await page.close();
  const printed = (pdf.match(/\/Type\s*\/Page\b/g) || []).length;
  if (printed === 0 || printed > MAX_PRINTED_PAGES) problems.push(`prints on ${printed} pages, allowed ${MAX_PRINTED_PAGES}`);
  return [problems, `${bytes} bytes, ${height} px high, loads in ${load.toFixed(0)} ms, prints on ${printed} pages`];
}

// A page with every fault that is looked for; what is not found in it could not be found in a report.
async function twin(browser) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "pages-"));
  const file = path.join(folder, "index.html");
  fs.writeFileSync(file, `<!DOCTYPE html><html lang="en"><title>t</title><body style="background:#fff"><main><h1>t</h1>
    <nav><a href="#folded" onclick="return false">link</a></nav><p style="color:#ccc">too light</p><img src="none.png"><div style="width:3000px">wide</div>
    <details><summary>part</summary><p id="folded">folded</p></details>
    <div class="tools"><input type="search" aria-label="f"></div><div><table><tbody><tr><td>a</td></tr></tbody></table></div>
    <script>console.error("said"); throw new Error("thrown");</script></main></body></html>`);
  const url = pathToFileURL(file).href;
  const found = [...await look(browser, url, 390, "light"), ...await use(browser, url, {})].join("\n");
  fs.rmSync(folder, { recursive: true });
  const wanted = ["color-contrast", "image-alt", "scrolls sideways: 30", "broken pictures: 1: none.png", "console: said", "script: thrown", "not loaded", "fails: a link opens what is folded", "fails: an address opens what is folded", "fails: a filter hides rows", "fails: the Tab key"];
  return wanted.filter((fault) => !found.includes(fault));
}

(async () => {
  const browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM, args: ["--no-sandbox", "--disable-gpu"] });
  let faults = 0;
  const say = (name, problems, after = "") => {
    faults += problems.length;
    process.stdout.write(`${problems.length ? "FAIL" : "ok  "} ${name}${after && ": " + after}\n`);
    for (const problem of problems) process.stdout.write(`     ${problem}\n`);
  };
  const missed = await twin(browser);
  say("a page with faults is reported", missed.map((fault) => `not found: ${fault}`));
  const tried = {};
  for (const folder of process.argv.slice(2)) {
    const index = path.join(folder, "index.html");
    if (!fs.existsSync(index)) { say(folder, ["no index.html"]); continue; }
    const beside = path.join(folder, "pages");
    const others = fs.existsSync(beside) ? fs.readdirSync(beside).filter((name) => name.endsWith(".html")).sort() : [];
    const [problems, figures] = await firstPage(browser, index);
    say(index, problems, figures);
    for (const file of [index, ...others.map((name) => path.join(beside, name))]) {
      const url = pathToFileURL(file).href;
      const all = [];
      for (const width of WIDTHS) all.push(...await look(browser, url, width, "light"));
      all.push(...await look(browser, url, WIDTHS[0], "dark"));
      all.push(...await use(browser, url, tried), ...await withoutScripts(browser, url));
      say(file, all);
    }
  }
  for (const [what, times] of Object.entries(tried)) process.stdout.write(`tried ${times} ×: ${what}\n`);
  await browser.close();
  process.stdout.write(`${faults} faults\n`);
  process.exitCode = faults ? 1 : 0;
})().catch((error) => { process.stderr.write(`pages: ${error.stack}\n`); process.exitCode = 2; });
