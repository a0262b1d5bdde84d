// Tests docs/demo/index.html in a real browser: npm test. The tests need Chromium, at the path in CHROMIUM or at
// /usr/bin/chromium, and the native program, which computes the same results. To build the native program, run this
// command in docs/demo: cargo build --release --bin native --target-dir target/native. If SHOTS=DIR is set, the tests
// save screenshots in DIR.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

import { BROKEN, MODELS, TRIANGLES } from "./models.mjs";

const HERE = fileURLToPath(new URL(".", import.meta.url));
const PAGE = join(HERE, "..", "index.html");
const URL_OF_PAGE = pathToFileURL(PAGE).href;
const NATIVE = process.env.INTERTRI_DEMO_NATIVE ?? join(HERE, "..", "target/native/release/native");
const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

let context, page, folder;
const faults = [], requests = [];

async function open(hash = "", options = {}) {
  const page = await context.newPage();
  if (options.width) await page.setViewportSize({ width: options.width, height: options.height });
  if (options.scheme) await page.emulateMedia({ colorScheme: options.scheme });
  page.on("console", (message) => { if (["error", "warning"].includes(message.type())) faults.push(message.text()); });
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("request", (request) => requests.push(request.url()));
  await page.goto(URL_OF_PAGE + hash);
  await page.waitForFunction(() => window.intertri?.ready, null, { timeout: 60_000 });
  await idle(page);
  return page;
}
/** Waits until nothing is left to compute. */
async function idle(page) {
  await page.waitForTimeout(400);
  await page.waitForFunction(() => window.intertri.compared, null, { timeout: 60_000 });
}
async function shot(page, name, options = {}) {
  if (process.env.SHOTS) await page.screenshot({ path: join(process.env.SHOTS, `${name}.png`), ...options });
}
function native(...args) {
  const lines = execFileSync(NATIVE, args.map(String), { encoding: "utf8" }).trim().split("\n");
  return lines.map((line) => line.split("\t").slice(0, 5).map(Number));
}
const shownCounts = (page) => page.$$eval("#methods tbody tr", (rows) =>
  rows.map((row) => [...row.querySelectorAll("td.n")].slice(0, 3).map((td) => Number(td.textContent.replaceAll(",", "")))));
/** Drops a file with the given name and content onto the model view. */
async function drop(page, name, bytes) {
  await page.evaluate(([name, text]) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const data = new DataTransfer();
    data.items.add(new File([bytes], name));
    window.intertri.compared = null;
    document.getElementById("drop").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, [name, bytes.toString("base64")]);
}

before(async () => {
  folder = mkdtempSync(join(tmpdir(), "intertri-demo-"));
  context = await chromium.launchPersistentContext(join(folder, "profile"), {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", headless: true, args: FLAGS,
    viewport: { width: 1280, height: 900 },
  });
  page = await open();
});
after(async () => {
  await context?.close();
  rmSync(folder, { recursive: true, force: true });
});

test("the page is one file of at most four mebibytes", () => {
  assert.ok(statSync(PAGE).size <= 4 << 20);
});

test("the page loads without errors and makes no network requests", () => {
  assert.deepEqual(faults, []);
  assert.deepEqual([...new Set(requests)].filter((url) => !url.startsWith("data:")), [URL_OF_PAGE]);
});

test("the golden hashes equal those of the native library", async () => {
  const golden = await page.evaluate(() => window.intertri.golden);
  const report = execFileSync(NATIVE, ["golden"], { encoding: "utf8" });
  const rows = report.split("\n").filter((line) => line.includes("0x")).map((line) => line.trim().split(/\s+/));
  const hashes = Object.fromEntries(rows.map(([section, , , here]) => [section, here]));
  assert.ok(golden.rows.length >= 2 && golden.same);
  assert.deepEqual(new Set(golden.rows.map(([section]) => section)), new Set(Object.keys(hashes)));
  for (const [section, level, , here] of golden.rows) assert.equal(here, hashes[section], `${section}, ${level}`);
  assert.match(await page.textContent("#bits-verdict"), /The same bits/);
});

test("after a corner is dragged, the counts equal those of the native library", async () => {
  const before = await shownCounts(page);
  const said = async () => native("fan", ...await page.evaluate(() => window.intertri.fan.numbers()))
    .map(([, , leaks, doubles, wrongs]) => [leaks, doubles, wrongs]);
  assert.deepEqual(before, await said());
  assert.ok(before[0].some((n) => n > 0), "at least one method has a leak, a double, or a wrong hit");
  assert.deepEqual(before.at(-1), [0, 0, 0]);

  for (const [corner, dx, dy] of [[0, -40, 25], [3, 30, 30]]) {
    const handle = page.locator("#overview g").nth(corner);
    await handle.scrollIntoViewIfNeeded();
    const box = await handle.locator(".handle").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + dx, box.y + dy, { steps: 6 });
    await page.mouse.up();
    await page.waitForTimeout(700);
  }
  const dragged = await shownCounts(page);
  assert.notDeepEqual(dragged, before);
  assert.deepEqual(dragged, await said());
});

test("sliders and keys change the image, and the counts still equal those of the native library", async () => {
  await page.locator("#offset").fill("12");
  await page.locator("#scope").focus();
  const yaw = await page.inputValue("#yaw");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("+");
  await page.locator("#overview g").nth(1).focus();
  await page.keyboard.press("Shift+ArrowUp");
  await page.keyboard.press("ArrowLeft");
  await page.waitForTimeout(700);
  assert.notEqual(await page.inputValue("#yaw"), yaw);
  const wanted = native("fan", ...await page.evaluate(() => window.intertri.fan.numbers()));
  assert.deepEqual(await shownCounts(page), wanted.map(([, , a, b, c]) => [a, b, c]));
  await page.locator("#methods tbody tr").nth(1).click();
  await page.waitForTimeout(300);
  assert.match(await page.textContent("#scope-title"), /Baldwin/);
  await page.click("#fan-reset");
});

test("dropped files of every format are drawn, with the same wrong pixels as in the native library", async () => {
  for (const [name, bytes] of Object.entries(MODELS)) {
    await drop(page, name, bytes);
    await page.waitForFunction((name) => document.getElementById("model-title-out").textContent.startsWith(`${name},`), name);
    await idle(page);
    assert.match(await page.textContent("#model-title-out"), new RegExp(`${TRIANGLES} triangles`));
    const path = join(folder, name);
    writeFileSync(path, bytes);
    // Far from the origin, the f32 methods make errors.
    for (const away of ["0", "18"]) {
      await page.evaluate(() => { window.intertri.compared = null; });
      await page.locator("#away").fill(away);
      await idle(page);
      const [numbers, { method, counts }] = await page.evaluate(() => [window.intertri.model.numbers(), window.intertri.compared]);
      assert.deepEqual(counts, native("model", path, ...numbers)[method], `${name} moved by ${away}`);
      assert.ok(counts[0] > 1000 && counts[1] > 1000, "the torus and the background are both visible");
    }
  }
  assert.equal(await page.isHidden("#model-error"), true);
  const colours = await page.$eval("#view", (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
  assert.ok(colours > 20, `${colours} colours`);
});

test("an invalid file leads to a clear message, and the page keeps working", async () => {
  for (const [name, [bytes, words]] of Object.entries(BROKEN)) {
    await drop(page, name, bytes);
    await page.waitForFunction((name) => document.getElementById("model-error").textContent.includes(name), name);
    const message = await page.textContent("#model-error");
    assert.match(message, words);
    assert.ok(!message.includes("\n") && message.length < 300, message);
  }
  await page.click("#built-in");
  await idle(page);
  assert.equal(await page.isHidden("#model-error"), true);
  assert.deepEqual(faults, []);
});

test("the vertex view is drawn fast enough", async () => {
  const times = await page.evaluate(async () => {
    const times = [], { fan } = window.intertri;
    for (let method = 0; method < 8; method++) {
      fan.state.method = method;
      for (let i = 0; i < 12; i++) {
        fan.state.yaw += 0.1;
        fan.change();
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        times.push([method, window.intertri.frame.time]);
      }
    }
    return times;
  });
  const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
  for (let method = 0; method < 8; method++) {
    const time = median(times.filter(([m]) => m === method).map(([, t]) => t));
    console.log(`method ${method}: ${time.toFixed(1)} ms per frame`);
  }
  // The limit is generous, because other processes can slow the page down.
  assert.ok(median(times.map(([, t]) => t)) < 50);
});

test("the module without SIMD computes the same bits", async () => {
  const plain = await open("#plain");
  assert.equal(await plain.evaluate(() => window.intertri.module), "plain");
  assert.equal(await page.evaluate(() => window.intertri.module), "simd128");
  const golden = await plain.evaluate(() => window.intertri.golden);
  assert.ok(golden.same && golden.rows.every(([, level]) => level === "portable"));
  await plain.close();
});

test("the page fits wide and narrow screens, in light and dark mode", async () => {
  for (const [name, width, height] of [["wide", 1280, 900], ["narrow", 390, 844]]) {
    for (const scheme of ["light", "dark"]) {
      const other = await open("", { width, height, scheme });
      const overflow = await other.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(overflow <= 0, `${name}: ${overflow} pixels too wide`);
      await shot(other, `${name}-${scheme}`, { fullPage: true });
      await other.close();
    }
  }
  assert.deepEqual(faults, []);
});
