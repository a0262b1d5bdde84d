// ---- Functions shared by both views: colours, directions, input ----

const $ = (id) => document.getElementById(id);
const NUMBER = new Intl.NumberFormat("en");

/** Returns a colour from the style sheet as [r, g, b]. */
function colour(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16));
}
/** Packs a colour into the 32-bit word that a canvas stores. */
const packed = ([r, g, b]) => (255 << 24 | b << 16 | g << 8 | r) >>> 0;
const mixed = (a, b, x) => a.map((c, i) => Math.round(c + (b[i] - c) * x));

/** Returns the right, up, and forward directions of a view with the given angles, in degrees. */
function axes(yaw, pitch) {
  const [y, p] = [yaw, pitch].map((angle) => angle * Math.PI / 180);
  const forward = [Math.sin(y) * Math.cos(p), Math.sin(p), Math.cos(y) * Math.cos(p)];
  const right = [Math.cos(y), 0, -Math.sin(y)];
  const up = [
    forward[1] * right[2] - forward[2] * right[1],
    forward[2] * right[0] - forward[0] * right[2],
    forward[0] * right[1] - forward[1] * right[0],
  ];
  return { right, up, forward };
}
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

/** Formats a number for display, such as 3,000 or 2.4e-7. */
function readable(x) {
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e-3 && size < 1e6) return NUMBER.format(Number(x.toPrecision(3)));
  return x.toExponential(1).replace("e+", "e");
}

/** Makes a canvas navigable: dragging and the arrow keys turn the view; the wheel, pinching, + and - zoom. */
function navigate(canvas, { turn, magnify }) {
  const pointers = new Map();
  let apart = 0;
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener("pointerdown", (e) => {
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    canvas.setPointerCapture(e.pointerId);
    if (pointers.size === 2) apart = spread();
  });
  canvas.addEventListener("pointermove", (e) => {
    const last = pointers.get(e.pointerId);
    if (!last) return;
    const [dx, dy] = [e.clientX - last.x, e.clientY - last.y];
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    if (pointers.size === 2) {
      const now = spread();
      magnify(Math.log2(now / apart));
      apart = now;
    } else {
      turn(dx * 0.35, dy * 0.35);
    }
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (e) => pointers.delete(e.pointerId));
  }
  canvas.addEventListener("wheel", (e) => {
    if (document.activeElement !== canvas && !e.ctrlKey) return; // the wheel scrolls the page unless the canvas has the focus
    e.preventDefault();
    magnify(-e.deltaY / 240);
  }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    const step = e.shiftKey ? 0.1 : 2;
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    if (moves[e.key]) turn(...moves[e.key]);
    else if (e.key === "+" || e.key === "=") magnify(0.25);
    else if (e.key === "-") magnify(-0.25);
    else return;
    e.preventDefault();
  });
}

/** Returns a function that requests a redraw: `draw` runs at most once per frame, `rest` after a pause in requests. */
function scheduler(draw, rest) {
  let asked = false, timer = 0;
  return () => {
    clearTimeout(timer);
    if (!asked) {
      asked = true;
      requestAnimationFrame(() => {
        asked = false;
        draw();
        clearTimeout(timer);
        timer = setTimeout(rest, 120);
      });
    }
  };
}

/** Returns a function that runs a list of jobs, a few in each frame. Calling it again drops the old list. */
function pieces() {
  let current = 0;
  return (jobs) => {
    const mine = ++current;
    const step = () => {
      if (mine !== current) return;
      const until = performance.now() + 12;
      while (jobs.length && performance.now() < until) jobs.shift()();
      if (jobs.length) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  };
}
