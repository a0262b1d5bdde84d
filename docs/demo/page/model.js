// ---- A model of your own ----

function modelView(engine) {
  const WIDTH = 512, HEIGHT = 384, DISTANCE = 4, FIELD = 2.3 / HEIGHT / 4;
  const canvas = $("view"), context = canvas.getContext("2d");
  const HOME = { yaw: 210, pitch: -18, close: 0, shift: [0, 0] };
  let home = HOME;
  const state = { ...HOME, away: 0, method: 0, name: "", triangles: 0 };
  let shades = [], marks = [], scale = 1, wrong = [], looked = 0;
  let traced = new Uint8Array(0);

  const away = () => (state.away === 0 ? 0 : 10 ** (state.away / 4));
  const pixel = () => FIELD * 2 ** -state.close;
  /** Returns the numbers that describe the view at 1/`by` of the resolution, for the module and for the tests' native program. */
  function numbers(by = 1) {
    const { right, up, forward } = axes(state.yaw, state.pitch);
    return [WIDTH / by, HEIGHT / by, pixel() * by, ...state.shift, ...[1, 0.7, 0.4].map((x) => x * away()),
      ...right, ...up, ...forward, DISTANCE];
  }

  function recolour() {
    const [low, high, sky] = ["--shade-0", "--shade-1", "--sky"].map(colour);
    shades = Uint32Array.from({ length: 256 }, (_, i) => packed(i === 0 ? sky : mixed(low, high, (i / 255) ** 0.8)));
    marks = ["--none", "--none", "--leak", "--double", "--wrong"].map((name) => packed(colour(name)));
  }

  function paint(by, pixels) {
    const small = document.createElement("canvas");
    [small.width, small.height] = [WIDTH / by, HEIGHT / by];
    const image = small.getContext("2d").createImageData(small.width, small.height);
    const words = new Uint32Array(image.data.buffer);
    for (let i = 0; i < words.length; i++) words[i] = shades[pixels[i]];
    small.getContext("2d").putImageData(image, 0, 0);
    context.drawImage(small, 0, 0, WIDTH, HEIGHT);
  }

  /** Traces the whole image and shows it. The rate excludes setting the view, which can rebuild the hierarchy. */
  function trace(by) {
    if (!engine.look(numbers(by))) return;
    looked = by;
    const start = performance.now();
    const pixels = engine.trace(0, HEIGHT / by);
    const seconds = (performance.now() - start) / 1e3;
    traced = pixels.slice();
    paint(by, traced);
    const rate = traced.length / seconds / 1e6;
    $("model-speed").textContent = `${rate.toFixed(1)} million rays per second on one thread`;
    page.rate = rate;
    scale = by;
  }

  function draw() {
    if (state.triangles === 0) return;
    guarded(() => trace(scale > 1 || page.rate === undefined || page.rate > 6 ? 1 : 2));
    $("model-title-out").textContent = `${state.name}, ${NUMBER.format(state.triangles)} triangles`;
    $("model-wrong").textContent = "";
    labels();
  }

  const inPieces = pieces();
  /** Traces the image at full resolution if needed, then compares the selected method with `exact`, a few rows of tiles at a time. */
  function rest() {
    if (state.triangles === 0) return;
    if (looked !== 1 || scale !== 1) guarded(() => trace(1));
    const method = state.method, counts = [0, 0, 0, 0, 0], jobs = [], found = [];
    page.compared = null;
    wrong = [];
    for (let first = 0; first < HEIGHT / 8; first += 2) {
      jobs.push(() => guarded(() => {
        const part = engine.compare(method, first, first + 2);
        part.counts.forEach((n, i) => { counts[i] += n; });
        part.pixels.forEach((mark, i) => {
          if (mark > 1) found.push({ x: i % WIDTH, y: 8 * first + Math.floor(i / WIDTH), mark });
        });
      }));
    }
    jobs.push(() => {
      wrong = found;
      light();
      verdict(method, counts);
      page.compared = { method, counts };
    });
    inPieces(jobs);
  }
  const change = scheduler(draw, rest);

  /** Highlights wrong pixels. If there are only a few, each gets a ring, so that even a single pixel is easy to see. */
  function light() {
    for (const { x, y, mark } of wrong) {
      const word = marks[mark];
      const style = `rgb(${word & 255} ${word >> 8 & 255} ${word >> 16 & 255})`;
      context.fillStyle = context.strokeStyle = style;
      context.fillRect(x - 1, y - 1, 3, 3);
      if (wrong.length < 400) {
        context.lineWidth = 1.5;
        context.beginPath();
        context.arc(x + 0.5, y + 0.5, 6, 0, 2 * Math.PI);
        context.stroke();
      }
    }
    $("next").disabled = wrong.length === 0;
  }

  function verdict(method, [, , leaks, falls, others]) {
    const bad = leaks + falls + others, name = engine.methods[method], all = NUMBER.format(WIDTH * HEIGHT);
    const parts = [[leaks, "hit nothing"], [falls, "hit a triangle where there is none"], [others, "hit the wrong triangle"]];
    $("model-wrong").replaceChildren();
    const strong = document.createElement("b");
    strong.textContent = bad === 0 ? `${name} gets every pixel right` : `${name} gets ${NUMBER.format(bad)} of ${all} pixels wrong`;
    const rest = bad === 0 ? " in this view. Move the model away from the origin, or zoom in."
      : `: ${parts.filter(([n]) => n > 0).map(([n, what]) => `${NUMBER.format(n)} ${what}`).join(", ")}.`;
    $("model-wrong").append(strong, rest);
  }

  function labels() {
    $("away-out").textContent = away() === 0 ? "0" : `${readable(away())} radii`;
    $("close-out").textContent = `${readable(2 ** state.close)}×`;
    for (const id of ["away", "close"]) $(id).value = state[id];
  }
  function complain(text) {
    $("model-error").hidden = text === "";
    $("model-error").textContent = text;
  }
  /** Runs `work`. After a trap, such as running out of memory, an instance is unusable, so the page continues with a new one. */
  function guarded(work) {
    try {
      return work();
    } catch (e) {
      if (!(e instanceof WebAssembly.RuntimeError || e instanceof RangeError)) throw e;
      state.triangles = 0;
      complain("The browser has run out of memory.");
      engine.restart();
    }
  }

  /** Loads a model with `load` and shows it under a name. */
  function take(name, load, from = {}) {
    complain("");
    try {
      const start = performance.now();
      const triangles = load();
      home = { ...HOME, ...from };
      Object.assign(state, { name, triangles, away: 0 }, home);
      page.built = performance.now() - start;
      scale = 1;
      change();
    } catch (e) {
      if (e instanceof WebAssembly.RuntimeError || e instanceof RangeError) {
        complain(`${name}: the browser has run out of memory.`);
        state.triangles = 0;
        engine.restart();
      } else {
        complain(e.message);
      }
    }
  }
  async function open(file) {
    if (!file) return;
    $("model-title-out").textContent = `Reading ${file.name}…`;
    let bytes;
    try {
      bytes = new Uint8Array(await file.arrayBuffer());
    } catch {
      complain(`${file.name} cannot be read.`);
      return;
    }
    await new Promise(requestAnimationFrame);
    take(file.name, () => engine.model(file.name, bytes));
    if (state.triangles) $("model-title-out").textContent = `${state.name}, ${NUMBER.format(state.triangles)} triangles`;
  }

  /** Shows the built-in scene from close up, because its floor is much wider than its objects. */
  const takeBuiltIn = () => take("Built-in scene", () => engine.builtIn(), { close: 2, shift: [0.004, 0.012] });

  const drop = $("drop");
  for (const name of ["dragenter", "dragover"]) {
    drop.addEventListener(name, (e) => { e.preventDefault(); drop.classList.add("over"); });
  }
  for (const name of ["dragleave", "drop"]) drop.addEventListener(name, () => drop.classList.remove("over"));
  drop.addEventListener("drop", (e) => { e.preventDefault(); open(e.dataTransfer.files[0]); });
  // The browser must not open a file that is dropped next to the image.
  for (const name of ["dragover", "drop"]) window.addEventListener(name, (e) => e.preventDefault());
  $("open").addEventListener("click", () => $("file").click());
  $("file").addEventListener("change", () => { open($("file").files[0]); $("file").value = ""; });
  $("built-in").addEventListener("click", takeBuiltIn);

  engine.methods.forEach((name, i) => $("method").add(new Option(name, i)));
  $("method").addEventListener("change", () => { state.method = Number($("method").value); change(); });
  for (const id of ["away", "close"]) {
    $(id).addEventListener("input", () => { state[id] = Number($(id).value); change(); });
  }
  navigate(canvas, {
    turn(dx, dy) {
      // The step of a shift is proportional to the width of the visible area.
      const by = 2 ** -state.close;
      if (state.close > 4) {
        state.shift = [state.shift[0] - dx * by * 0.003, state.shift[1] + dy * by * 0.003];
      } else {
        state.yaw = (state.yaw - dx + 360) % 360;
        state.pitch = clamp(state.pitch + dy, -89, 89);
      }
      change();
    },
    magnify(steps) { state.close = clamp(state.close + steps, 0, 20); change(); },
  });
  let visited = 0;
  $("next").addEventListener("click", () => {
    if (wrong.length === 0) return;
    const { x, y } = wrong[visited++ % wrong.length];
    state.shift = [state.shift[0] + (x + 0.5 - WIDTH / 2) * pixel(), state.shift[1] + (HEIGHT / 2 - 0.5 - y) * pixel()];
    state.close = clamp(state.close + 4, 0, 20);
    change();
  });
  $("home").addEventListener("click", () => { Object.assign(state, home); change(); });
  recolour();
  takeBuiltIn();
  page.model = { state, numbers, change };
  return { recolour() { recolour(); change(); } };
}
