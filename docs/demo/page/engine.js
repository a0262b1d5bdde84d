// ---- A JavaScript interface to the WebAssembly module ----

const CLASSES = 5; // background, right, leak, double, wrong

/** Unpacks an embedded module, which is compressed with gzip and encoded in base64. */
async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Compiles the module with SIMD, or the one without if the browser lacks SIMD or the URL ends in `#plain`. */
async function chooseModule() {
  const modules = JSON.parse(document.getElementById("modules").textContent);
  if (!location.hash.includes("plain")) {
    const bytes = await unpack(modules.simd);
    if (WebAssembly.validate(bytes)) return { name: "simd128", module: await WebAssembly.compile(bytes) };
  }
  return { name: "plain", module: await WebAssembly.compile(await unpack(modules.plain)) };
}

class Engine {
  static async load() {
    const { name, module } = await chooseModule();
    const engine = new Engine();
    engine.name = name;
    engine.module = module;
    await engine.restart();
    return engine;
  }

  /** Creates an instance of the module, at the start and whenever a trap has made the previous one unusable. */
  async restart() {
    this.wasm = (await WebAssembly.instantiate(this.module)).exports;
    this.wasm.method_names();
    this.methods = this.text().split("\n");
  }

  bytes() {
    return new Uint8Array(this.wasm.memory.buffer, this.wasm.output(), this.wasm.output_len());
  }
  text() {
    return new TextDecoder().decode(this.bytes());
  }
  send(numbers) {
    const at = this.wasm.buffer(8 * numbers.length);
    const view = new DataView(this.wasm.memory.buffer, at, 8 * numbers.length);
    numbers.forEach((x, i) => view.setFloat64(8 * i, x, true));
  }
  /** Decodes the last output: the number of pixels in each class, then one byte for each pixel. */
  counted() {
    const bytes = this.bytes();
    const view = new DataView(bytes.buffer, bytes.byteOffset, 4 * CLASSES);
    const counts = Array.from({ length: CLASSES }, (_, i) => view.getUint32(4 * i, true));
    return { counts, pixels: bytes.subarray(4 * CLASSES) };
  }

  fan(numbers) {
    this.send(numbers);
    return this.wasm.fan_set() === 1;
  }
  fanPicture(method) {
    this.wasm.fan_picture(method);
    return this.counted();
  }

  /** Loads a model. Throws an Error with the library's message if the file is not a valid model. */
  model(name, bytes) {
    const label = new TextEncoder().encode(name);
    const at = this.wasm.buffer(label.length + bytes.length);
    const memory = new Uint8Array(this.wasm.memory.buffer, at, label.length + bytes.length);
    memory.set(label);
    memory.set(bytes, label.length);
    const triangles = this.wasm.model_load(label.length);
    if (triangles === 0) throw new Error(this.text());
    return triangles;
  }
  builtIn() {
    return this.wasm.model_built_in();
  }
  look(numbers) {
    this.send(numbers);
    return this.wasm.model_look() === 1;
  }
  trace(first, end) {
    this.wasm.model_trace(first, end);
    return this.bytes();
  }
  compare(method, first, end) {
    this.wasm.model_compare(method, first, end);
    return this.counted();
  }

  /** Computes the golden report. Each row has the section, SIMD level, line count, hash, committed hash, and verdict. */
  golden() {
    this.wasm.golden();
    const text = this.text();
    const rows = text.split("\n").filter((line) => /0x[0-9a-f]{16}/.test(line) && !/^ /.test(line));
    return { text, rows: rows.map((line) => line.trim().split(/\s+/)) };
  }
}
