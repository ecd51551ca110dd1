// SPDX-License-Identifier: MIT OR Apache-2.0
// Serves a page with CesiumJS on localhost, opens it in headless Chromium and calls its functions.
//
// Environment: TERRAFILL_DRIVER, JSON: { cesium: folder of the release build, chromium, flags, env, size, page }.
// Standard input: a JSON line for each call, { call, given: [...] }. Standard output: a JSON line for each
// answer, { value } or { error }; the first one, without a call, is the browser's process id and version.
// Ends, and the browser with it, when standard input ends. Protocol: Chrome DevTools over a pipe, messages
// that end in NUL.
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";
import { createInterface } from "node:readline";

const LIMIT_MS = 300_000; // a call that takes longer hangs
const TYPES = { ".css": "text/css", ".html": "text/html", ".js": "text/javascript", ".json": "application/json", ".wasm": "application/wasm" };
const told = JSON.parse(process.env.TERRAFILL_DRIVER);
const profile = mkdtempSync(join(tmpdir(), "terrafill-peer-"));
const say = (line) => process.stdout.write(JSON.stringify(line) + "\n");

const [width, height] = told.size;
const pages = {
  "/": `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><style>body{margin:0}#globe,#globe *{width:${width}px;height:${height}px}</style>
    <div id="globe"></div><script>window.CESIUM_BASE_URL = "/cesium/";</script><script src="/page.js"></script><script src="/cesium/Cesium.js"></script>`,
  "/page.js": told.page,
};
const server = createServer((request, response) => {
  const path = normalize(new URL(request.url, "http://localhost").pathname);
  try {
    const body = pages[path] ?? readFileSync(join(told.cesium, path.replace(/^\/cesium\//, "")));
    // Cross-origin isolation gives performance.now() its finer steps.
    response.writeHead(200, { "content-type": TYPES[extname(path)] ?? (path === "/" ? "text/html" : "application/octet-stream"),
      "cross-origin-opener-policy": "same-origin", "cross-origin-embedder-policy": "require-corp" });
    response.end(body);
  } catch {
    response.writeHead(404);
    response.end();
  }
});
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));

const browser = spawn(told.chromium, ["--headless=new", "--remote-debugging-pipe", `--user-data-dir=${profile}`, "--no-sandbox", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-extensions", "--disable-sync", "--disable-gpu-watchdog",
  "--disable-renderer-backgrounding", "--disable-background-timer-throttling", `--window-size=${width},${height}`, ...told.flags, "about:blank"],
{ stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"], env: { ...process.env, ...told.env } });
const finish = (code) => {
  browser.kill("SIGKILL");
  server.closeAllConnections();
  try { rmSync(profile, { recursive: true, force: true, maxRetries: 5 }); } catch { /* what is left is in the temporary folder */ }
  process.exit(code);
};
const fail = (why) => { say({ error: why }); finish(1); };
browser.on("error", (error) => fail(`Chromium does not start: ${error.message}`));
browser.on("exit", (code) => fail(`Chromium ended (${code})`));

// One message out, one answer back.
const waiting = new Map();
const events = new Map();
let last = 0;
let rest = "";
browser.stdio[4].setEncoding("utf8").on("data", (text) => {
  const messages = (rest + text).split("\0");
  rest = messages.pop();
  for (const message of messages.map((message) => JSON.parse(message))) {
    if (message.id === undefined) events.get(message.method)?.();
    else waiting.get(message.id)?.(message);
  }
});
const send = (method, params = {}, sessionId = undefined) => new Promise((resolve, reject) => {
  const id = ++last;
  const late = setTimeout(() => fail(`${method}: no answer in ${LIMIT_MS / 1000} s`), LIMIT_MS);
  waiting.set(id, (message) => {
    clearTimeout(late);
    waiting.delete(id);
    if (message.error) reject(new Error(`${method}: ${message.error.message}`)); else resolve(message.result);
  });
  browser.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + "\0");
});

try {
  const { product } = await send("Browser.getVersion");
  const { targetId } = await send("Target.createTarget", { url: "about:blank" });
  const { sessionId } = await send("Target.attachToTarget", { targetId, flatten: true });
  await send("Page.enable", {}, sessionId);
  const loaded = new Promise((ready) => events.set("Page.loadEventFired", ready));
  await send("Page.navigate", { url: `http://127.0.0.1:${server.address().port}/` }, sessionId);
  await loaded;
  say({ value: { pid: browser.pid, product } });
  for await (const line of createInterface({ input: process.stdin })) {
    const { call, given } = JSON.parse(line);
    const expression = `terrafillPeer.${call}(...${JSON.stringify(given)})`;
    const { result, exceptionDetails } = await send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true }, sessionId);
    if (exceptionDetails) say({ error: `${call}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}` });
    else say({ value: result.value ?? null });
  }
  finish(0);
} catch (error) {
  fail(error.message);
}
