// Measures the speed of the page, with SIMD and without.
//
//     node rate.mjs MODEL...    rays per second on the page and in the native library, one row per model; - means the
//                               built-in scene. Each figure is the best of several runs on one thread.
//     node rate.mjs             milliseconds per frame of the vertex view, for each method and pixel width, including
//                               exact, the method, and drawing. Each figure is the median of several frames.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const HERE = fileURLToPath(new URL(".", import.meta.url));
const NATIVE = process.env.INTERTRI_DEMO_NATIVE ?? join(HERE, "..", "target/native/release/native");
const profile = mkdtempSync(join(tmpdir(), "intertri-rate-"));
const context = await chromium.launchPersistentContext(profile, {
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", headless: true,
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync"],
});

async function pageWith(hash) {
  const page = await context.newPage();
  await page.goto(`file://${join(HERE, "..", "index.html")}${hash}`);
  await page.waitForFunction(() => window.intertri?.ready, null, { timeout: 60_000 });
  return page;
}
const measure = ([name, text]) => {
  const { engine } = window.intertri;
  const numbers = window.START ??= window.intertri.model.numbers();
  if (text === "") engine.builtIn();
  else engine.model(name, Uint8Array.from(atob(text), (c) => c.charCodeAt(0)));
  engine.look(numbers);
  let best = Infinity;
  for (let i = 0; i < 12; i++) {
    const start = performance.now();
    engine.trace(0, numbers[1]);
    best = Math.min(best, performance.now() - start);
  }
  return { rate: numbers[0] * numbers[1] / best / 1e3, numbers };
};
/** Measures the time that the page takes to draw a frame, in milliseconds, for each pixel width and method. */
const pictures = async (zooms) => {
  const { fan, engine } = window.intertri;
  const rows = [];
  for (const zoom of zooms) {
    const row = [];
    for (let method = 0; method < engine.methods.length; method++) {
      Object.assign(fan.state, { zoom, method, yaw: 9 });
      const times = [];
      for (let i = 0; i < 15; i++) {
        fan.state.yaw += 0.1;
        fan.change();
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        times.push(window.intertri.frame.time);
      }
      row.push(times.sort((a, b) => a - b)[7]);
    }
    rows.push(row);
  }
  return { rows, methods: engine.methods };
};

const [simd, plain] = [await pageWith(""), await pageWith("#plain")];
const models = process.argv.slice(2);
if (models.length) console.log("model                 native    simd128      plain   (millions of rays per second)");
for (const file of models) {
  const given = file === "-" ? ["", ""] : [basename(file), readFileSync(file).toString("base64")];
  const [a, b] = [await simd.evaluate(measure, given), await plain.evaluate(measure, given)];
  const native = Number(execFileSync(NATIVE, ["rate", file, ...a.numbers.map(String)], { encoding: "utf8" }));
  const columns = [native, a.rate, b.rate].map((x) => x.toFixed(2).padStart(9)).join("  ");
  console.log(`${basename(file).padEnd(18)}${columns}`);
}
const zooms = [18, 24, 25.5, 30];
for (const [name, of] of models.length ? [] : [["simd128", simd], ["plain", plain]]) {
  await of.bringToFront(); // browsers rarely draw pages in the background
  const { rows, methods } = await of.evaluate(pictures, zooms);
  console.log(`\n${`ms per frame, ${name}`.padEnd(24)}${zooms.map((zoom) => `2^-${zoom}`.padStart(9)).join("")}`);
  methods.forEach((method, i) => {
    console.log(method.padEnd(24) + rows.map((row) => row[i].toFixed(1).padStart(9)).join(""));
  });
}
await context.close();
rmSync(profile, { recursive: true, force: true });
