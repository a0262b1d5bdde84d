// ---- The vertex, magnified ----

const SIZE = 256;
const DISTANCE = 2.75;
const START = {
  vertex: [0.0713, 0.0519, 0.1937],
  corners: [[0.913, 0.127, 0.311], [0.417, 0.829, 0.253], [-0.457, 0.761, 0.157],
    [-0.871, -0.071, 0.283], [-0.389, -0.823, 0.331], [0.503, -0.751, 0.227]],
  zoom: 25.5, offset: 0, yaw: 9, pitch: -7, method: 0,
};

function microscope(engine) {
  const state = structuredClone(START);
  const canvas = $("scope");
  const thumbs = [];
  let colours = [];

  const width = () => 2 ** -state.zoom;
  const away = () => (state.offset === 0 ? 0 : 10 ** (state.offset / 4));
  const offset = () => [1, 0.7, 0.4].map((x) => x * away());
  const view = () => axes(state.yaw, state.pitch);

  /** Returns the numbers that describe the view, for the module and for the tests' native program. */
  function numbers(size = SIZE) {
    const { right, up, forward } = view();
    return [size, width(), 0, 0, ...offset(), ...right, ...up, ...forward, DISTANCE,
      state.corners.length, ...state.vertex, ...state.corners.flat()];
  }

  function recolour() {
    const rights = ["--right-a", "--right-b", "--right-c"].map(colour);
    const [none, leak, double, wrong] = ["--none", "--leak", "--double", "--wrong"].map(colour);
    colours = new Uint32Array(128);
    for (let i = 0; i < 128; i++) {
      const right = rights[(i >> 4) % 3];
      colours[i] = packed([none, right, leak, double, wrong][i & 15] ?? none);
    }
  }

  function paint(target, pixels) {
    const context = target.getContext("2d");
    const image = context.createImageData(SIZE, SIZE);
    const words = new Uint32Array(image.data.buffer);
    for (let i = 0; i < words.length; i++) words[i] = colours[pixels[i] & 127];
    context.putImageData(image, 0, 0);
  }

  function row(method, { counts }) {
    const [, , leaks, doubles, wrongs] = counts;
    const cells = $("methods").tBodies[0].rows[method].querySelectorAll("td.n");
    [leaks, doubles, wrongs, leaks + doubles + wrongs].forEach((n, i) => {
      cells[i].textContent = NUMBER.format(n);
      cells[i].className = `n ${n === 0 ? "zero" : "bad"}`;
    });
  }

  function draw() {
    const start = performance.now();
    engine.fan(numbers());
    const picture = engine.fanPicture(state.method);
    paint(canvas, picture.pixels);
    const time = performance.now() - start;
    row(state.method, picture);
    const [, , leaks, doubles, wrongs] = picture.counts;
    const bad = leaks + doubles + wrongs;
    $("scope-title").textContent = `${engine.methods[state.method]}: ` +
      (bad === 0 ? "every ray is right" : `${NUMBER.format(bad)} of ${NUMBER.format(SIZE * SIZE)} rays are wrong`);
    $("scope-speed").textContent = `${time.toFixed(1)} ms, including exact`;
    labels();
    overview();
    page.frame = { time, counts: picture.counts };
  }

  const inPieces = pieces();
  function rest() {
    inPieces(engine.methods.map((_, method) => () => {
      const picture = engine.fanPicture(method);
      row(method, picture);
      paint(thumbs[method], picture.pixels);
    }));
  }
  const change = scheduler(draw, rest);

  function labels() {
    $("zoom-out").textContent = readable(width());
    $("offset-out").textContent = readable(away());
    $("yaw-out").textContent = `${state.yaw.toFixed(1)}°`;
    $("pitch-out").textContent = `${state.pitch.toFixed(1)}°`;
    for (const id of ["zoom", "offset", "yaw", "pitch"]) $(id).value = state[id];
  }

  // The overview of the triangles, with their coordinates rounded to f32.
  const svg = $("overview");
  const make = (name, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    svg.append(element);
    return element;
  };
  const faces = state.corners.map(() => make("path", { class: "face" }));
  const frame = make("rect", { class: "window" });
  const handles = state.corners.map((_, i) => make("g", { tabindex: 0, role: "button", "aria-label": `Corner ${i + 1}` }));
  const NAMES = ["--right-a", "--right-b", "--right-c"];
  handles.forEach((handle, i) => {
    const grip = make("circle", { class: "grip", r: 0.16 }), dotted = make("circle", { class: "handle", r: 0.06 });
    handle.append(grip, dotted);
    handle.addEventListener("pointerdown", (e) => { handle.setPointerCapture(e.pointerId); handle.focus(); e.preventDefault(); });
    handle.addEventListener("pointermove", (e) => {
      if (!handle.hasPointerCapture(e.pointerId)) return;
      const box = svg.getBoundingClientRect();
      const x = ((e.clientX - box.left) / box.width - 0.5) * 2.6, y = (0.5 - (e.clientY - box.top) / box.height) * 2.6;
      place(i, clamp(x, -1.2, 1.2), clamp(y, -1.2, 1.2));
    });
    handle.addEventListener("keydown", (e) => {
      const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      if (!moves[e.key]) return;
      e.preventDefault();
      const [dx, dy] = moves[e.key];
      if (e.shiftKey) state.corners[i] = nudge(state.corners[i], dx, dy);
      else {
        const [x, y] = seen(state.corners[i]);
        return place(i, clamp(x + 0.02 * dx, -1.2, 1.2), clamp(y + 0.02 * dy, -1.2, 1.2));
      }
      change();
    });
  });
  /** Returns the position of a corner in the overview, relative to the vertex. */
  function seen(corner) {
    const { right, up } = view();
    const from = corner.map((x, k) => x - state.vertex[k]);
    return [dot(from, right), dot(from, up)];
  }
  /** Moves a corner to a position in the overview. */
  function place(i, x, y) {
    const { right, up } = view();
    const [oldX, oldY] = seen(state.corners[i]);
    state.corners[i] = state.corners[i].map((c, k) => c + (x - oldX) * right[k] + (y - oldY) * up[k]);
    change();
  }
  /** Moves a corner to the next f32 number along x or y. */
  function nudge(corner, dx, dy) {
    return corner.map((x, k) => {
      const by = [dx, dy, 0][k], at = offset()[k];
      if (by === 0) return x;
      const float = new Float32Array([x + at]), word = new Int32Array(float.buffer);
      if (float[0] === 0) word[0] = by > 0 ? 1 : 0x80000001 | 0;
      else word[0] += (float[0] > 0) === (by > 0) ? 1 : -1;
      return float[0] - at;
    });
  }
  function overview() {
    const at = offset();
    const rounded = (p) => p.map((x, k) => Math.fround(x + at[k]) - at[k]);
    const middle = seen(rounded(state.vertex));
    const corners = state.corners.map((corner) => seen(rounded(corner)));
    const text = ([x, y]) => `${x.toFixed(4)} ${(-y).toFixed(4)}`;
    faces.forEach((face, i) => {
      const next = corners[(i + 1) % corners.length];
      face.setAttribute("d", `M${text(middle)}L${text(corners[i])}L${text(next)}Z`);
      face.style.fill = `var(${NAMES[i % 3]})`;
    });
    const side = Math.max(width() * SIZE, 0.05);
    for (const [key, value] of Object.entries({ x: middle[0] - side / 2, y: -middle[1] - side / 2, width: side, height: side })) {
      frame.setAttribute(key, value);
    }
    handles.forEach((handle, i) => handle.setAttribute("transform", `translate(${text(corners[i]).replace(" ", ",")})`));
  }

  // The table of methods, one per row.
  engine.methods.forEach((name, method) => {
    const tr = $("methods").tBodies[0].insertRow();
    const picture = document.createElement("canvas");
    picture.width = picture.height = SIZE;
    picture.setAttribute("aria-hidden", "true");
    thumbs.push(picture);
    const pic = tr.insertCell();
    pic.className = "pic";
    pic.append(picture);
    const label = document.createElement("label"), input = document.createElement("input");
    Object.assign(input, { type: "radio", name: "shown", value: method, checked: method === state.method });
    label.append(input, name);
    tr.insertCell().append(label);
    for (let i = 0; i < 4; i++) tr.insertCell().className = "n";
    tr.addEventListener("click", () => choose(method));
    input.addEventListener("change", () => choose(method));
  });
  function choose(method) {
    state.method = method;
    [...$("methods").tBodies[0].rows].forEach((tr, i) => {
      tr.classList.toggle("chosen", i === method);
      tr.querySelector("input").checked = i === method;
    });
    change();
  }

  for (const id of ["zoom", "offset", "yaw", "pitch"]) {
    $(id).addEventListener("input", () => { state[id] = Number($(id).value); change(); });
  }
  navigate(canvas, {
    turn(dx, dy) {
      state.yaw = clamp(state.yaw - dx, -80, 80);
      state.pitch = clamp(state.pitch + dy, -80, 80);
      change();
    },
    magnify(steps) { state.zoom = clamp(state.zoom + steps, 7, 32); change(); },
  });
  $("fan-reset").addEventListener("click", () => { Object.assign(state, structuredClone(START), { method: state.method }); change(); });
  $("fan-random").addEventListener("click", () => {
    const turn = Math.random() * Math.PI;
    state.corners = state.corners.map((_, i) => {
      const angle = turn + (i + 0.7 * (Math.random() - 0.5)) * Math.PI / 3, r = 0.6 + 0.5 * Math.random();
      return [r * Math.cos(angle), r * Math.sin(angle), 0.2 + 0.3 * (Math.random() - 0.5)];
    });
    change();
  });
  recolour();
  choose(state.method);
  page.fan = { state, numbers, change, counts: (method) => { engine.fan(numbers()); return engine.fanPicture(method).counts; } };
  return { recolour() { recolour(); change(); } };
}
