// Computes the golden answers in WebAssembly: node run.mjs FILE.wasm. Prints the report, and fails
// if an answer differs.
import { readFileSync } from "node:fs";

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]));
const { memory, golden_report, golden_text, golden_text_len } = instance.exports;
const same = golden_report();
const text = new Uint8Array(memory.buffer, golden_text(), golden_text_len());
process.stdout.write(new TextDecoder().decode(text));
process.exit(same ? 0 : 1);
