// Rays a second on the page, with SIMD and without, beside the native library: node rate.mjs [MODEL...].
// Prints a row a model; - is the built-in scene. The best of some runs of each, one thread.

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
  let frames = [];
  engine.fan(window.intertri.fan.numbers());
  for (let i = 0; i < 12; i++) {
    const start = performance.now();
    engine.fan(window.intertri.fan.numbers());
    engine.fanPicture(0);
    frames.push(performance.now() - start);
  }
  return { rate: numbers[0] * numbers[1] / best / 1e3, numbers, frame: Math.min(...frames) };
};

const [simd, plain] = [await pageWith(""), await pageWith("#plain")];
console.log("model                 native    simd128      plain   (million rays a second)   a picture of the vertex, ms");
for (const file of process.argv.length > 2 ? process.argv.slice(2) : ["-"]) {
  const given = file === "-" ? ["", ""] : [basename(file), readFileSync(file).toString("base64")];
  const [a, b] = [await simd.evaluate(measure, given), await plain.evaluate(measure, given)];
  const native = Number(execFileSync(NATIVE, ["rate", file, ...a.numbers.map(String)], { encoding: "utf8" }));
  const columns = [native, a.rate, b.rate].map((x) => x.toFixed(2).padStart(9)).join("  ");
  console.log(`${basename(file).padEnd(18)}${columns}   ${a.frame.toFixed(1)} simd128, ${b.frame.toFixed(1)} plain`);
}
await context.close();
rmSync(profile, { recursive: true, force: true });
