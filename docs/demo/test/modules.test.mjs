// Tests both WebAssembly modules in docs/demo/index.html without a browser: node --test modules.test.mjs.
// The modules are called through the page's own engine.js.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { runInThisContext } from "node:vm";
import { gunzipSync } from "node:zlib";

import { BROKEN, MODELS, TRIANGLES } from "./models.mjs";

const read = (name) => readFileSync(new URL(`../${name}`, import.meta.url), "utf8");
const script = (name, value) => runInThisContext(`${read(`page/${name}`)}; ${value}`);
const Engine = script("engine.js", "Engine");
const axes = script("common.js", "axes");

const [, modules] = read("index.html").match(/<script type="application\/json" id="modules">(.*?)<\/script>/s);
const engines = {};
for (const [name, packed] of Object.entries(JSON.parse(modules))) {
  const engine = engines[name] = new Engine();
  engine.module = new WebAssembly.Module(gunzipSync(Buffer.from(packed, "base64")));
  await engine.restart();
}
const both = Object.entries(engines);

/** Returns a view of six triangles around a vertex far from the origin: 64×64 pixels of the given width. */
function fan(width) {
  const { right, up, forward } = axes(25, 20);
  const corners = [0, 1, 2, 3, 4, 5].map((i) => [Math.cos(i), Math.sin(i), 0.1 * i]);
  return [64, width, 0, 0, 1000, 700, 400, ...right, ...up, ...forward, 4, corners.length, 0.1, 0.2, 0.3, ...corners.flat()];
}
/** Returns a view of a model moved away from the origin: 128×96 pixels of the given width, seen from a distance of 4. */
function look(away, pixel = 0.008, [yaw, pitch] = [30, 35]) {
  const { right, up, forward } = axes(yaw, pitch);
  return [128, 96, pixel, 0, 0, away, 0.7 * away, 0.4 * away, ...right, ...up, ...forward, 4];
}

test("both modules have the same methods", () => {
  assert.deepEqual(both.map(([name]) => name), ["simd", "plain"]);
  assert.deepEqual(engines.simd.methods, engines.plain.methods);
  assert.match(engines.simd.methods.at(-1), /exact/);
});

test("both modules compute the committed golden results", () => {
  const [simd, plain] = both.map(([, engine]) => engine.golden().rows);
  assert.ok(simd.some(([, level]) => level === "simd128") && plain.every(([, level]) => level === "portable"));
  for (const [section, level, , here, committed, verdict] of [...simd, ...plain]) {
    assert.deepEqual([here, verdict], [committed, "same"], `${section}, ${level}`);
  }
});

test("around a vertex, exact is right and other methods are not, in both modules", () => {
  for (const width of [2 ** -14, 2 ** -24]) {
    const counts = both.map(([, engine]) => {
      assert.ok(engine.fan(fan(width)));
      return engine.methods.map((_, method) => engine.fanPicture(method).counts);
    });
    assert.deepEqual(counts[0], counts[1]);
    const wrong = counts[0].map(([, , leaks, doubles, wrongs]) => leaks + doubles + wrongs);
    assert.ok(wrong.at(-1) === 0 && wrong.some((n) => n > 0), `${wrong}`);
  }
  assert.equal(engines.simd.fan([64]), false);
});

test("a model gives the same results in every format", () => {
  const seen = new Set();
  for (const [, engine] of both) {
    for (const [name, bytes] of Object.entries(MODELS)) {
      assert.equal(engine.model(name, bytes), TRIANGLES);
      for (const away of [0, 2 ** 18]) {
        assert.ok(engine.look(look(away)));
        const pixels = engine.trace(0, 96).slice();
        assert.ok(pixels.some((shade) => shade > 0) && pixels.some((shade) => shade === 0));
        const wrong = engine.methods.map((_, method) => engine.compare(method, 0, 12).counts.slice(2));
        assert.deepEqual(wrong.at(-1), [0, 0, 0]);
        seen.add(JSON.stringify([away, [...pixels], wrong]));
      }
    }
  }
  assert.equal(seen.size, 2);
});

test("the per-tile triangle lists lose no hit, at several zoom levels and distances from the origin", () => {
  const engine = engines.simd;
  const wrong = engine.methods.map(() => 0);
  engine.builtIn();
  for (const away of [0, 1e4]) {
    for (const pixel of [2e-2, 3e-3, 2e-6]) {
      for (const way of [[37, 0], [0, -37], [50, -40]]) {
        assert.ok(engine.look(look(away, pixel, way)));
        engine.trace(0, 96);
        for (const method of engine.methods.keys()) {
          const { counts, pixels } = engine.compare(method, 0, 12);
          assert.equal(pixels.length, 128 * 96);
          wrong[method] += counts[2] + counts[3] + counts[4];
        }
      }
    }
  }
  assert.ok(wrong.at(-1) === 0 && wrong[0] > 0, `${wrong}`);
  for (const [i, bad] of [[0, 0], [0, 1e9], [1, 2.5], [2, 0], [2, NaN], [17, Infinity]]) {
    assert.equal(engine.look(Object.assign(look(0), { [i]: bad })), false, `${i} ${bad}`);
  }
});

test("an invalid file leads to a clear message, and the next file is still read", () => {
  for (const [, engine] of both) {
    for (const [name, [bytes, words]] of Object.entries(BROKEN)) {
      assert.throws(() => engine.model(name, bytes), (e) => words.test(e.message) && !e.message.includes("\n"), name);
    }
    assert.ok(engine.builtIn() > 1000);
  }
});
