// ---- The page ----

/** Exposed to the tests of the page. */
const page = window.intertri = { ready: false };

/** Computes the golden answers after the pictures are drawn. */
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
    $("scope-title").textContent = "This browser has no WebAssembly, or too old a one.";
    throw e;
  }
  page.module = engine.name;
  page.engine = engine;
  $("module-note").textContent = engine.name === "simd128"
    ? "Computed by WebAssembly with SIMD; add #plain to the address for the module without."
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
    page.fan.change(); // the first picture's time was that of code not yet compiled
    page.ready = true;
  }, 600);
}
start();
