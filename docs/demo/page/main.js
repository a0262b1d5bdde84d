// ---- The golden results, and the start of the page ----

/** The state of the page, exposed for the tests. */
const page = window.intertri = { ready: false };

/** Computes the golden results and shows their hashes. */
function bits(engine) {
  const { text, rows } = engine.golden();
  const body = $("hashes").tBodies[0];
  let same = rows.length > 0;
  for (const [section, level, lines, here, committed, verdict] of rows) {
    const tr = body.insertRow();
    for (const [i, cell] of [section, level, NUMBER.format(lines), here, committed].entries()) {
      const td = tr.insertCell();
      td.textContent = cell;
      if (i === 2) td.className = "n";
    }
    tr.insertCell().textContent = verdict === "same" ? "✓ the same" : "✗ different";
    same &&= verdict === "same";
  }
  $("bits-verdict").replaceChildren();
  const strong = document.createElement("b");
  strong.textContent = same ? "The same bits, here too." : "Different bits: please report this.";
  $("bits-verdict").append(strong, ` ${navigator.userAgent}`);
  page.golden = { text, rows, same };
}

async function start() {
  let engine;
  try {
    engine = await Engine.load();
  } catch (e) {
    $("scope-title").textContent = "This browser does not support WebAssembly, or is too old.";
    throw e;
  }
  page.module = engine.name;
  page.engine = engine;
  $("module-note").textContent = engine.name === "simd128"
    ? "Computed by WebAssembly with SIMD. Add #plain to the URL to use the module without SIMD."
    : "Computed by WebAssembly without SIMD.";
  const pictures = [microscope(engine), modelView(engine)];
  const recolour = () => pictures.forEach((picture) => picture.recolour());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
  $("theme").addEventListener("click", () => {
    const root = document.documentElement;
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    recolour();
  });
  setTimeout(() => {
    bits(engine);
    page.fan.change(); // draws again, because the time of the first frame included compiling the module
    page.ready = true;
  }, 600);
}
start();
