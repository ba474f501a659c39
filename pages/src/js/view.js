// The map's view: which metres are where on the screen, moved by pointer, wheel and keyboard.

class View {
  constructor(canvas, bounds, changed) {
    this.canvas = canvas;
    this.bounds = bounds;
    this.changed = changed;
    this.x = 0;
    this.y = 0;
    this.scale = 50;
    this.untouched = true;
    this.measure();
    this.bindPointers();
    this.bindWheel();
    this.bindKeys();
    this.fit(bounds);
  }

  // The canvas's size, kept because asking for it is slow.
  measure() {
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
  }

  // Screen position of a map point, CSS pixels.
  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toMap(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  fit(bounds) {
    const width = Math.max(bounds.x1 - bounds.x0, 0.5);
    const height = Math.max(bounds.y1 - bounds.y0, 0.5);
    this.x = (bounds.x0 + bounds.x1) / 2;
    this.y = (bounds.y0 + bounds.y1) / 2;
    const margin = 32;
    this.measure();
    this.scale = Math.max(2, Math.min((this.width - 2 * margin) / width, (this.height - 2 * margin) / height));
    this.changed();
  }

  fitAll() {
    this.untouched = true;
    this.fit(this.bounds);
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toMap(px, py);
    this.scale = Math.min(4000, Math.max(2, this.scale * factor));
    const [nx, ny] = this.toMap(px, py);
    this.x += x - nx;
    this.y += y - ny;
    this.untouched = false;
    this.changed();
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.untouched = false;
    this.onPan?.();
    this.changed();
  }

  bindPointers() {
    const down = new Map();
    const place = (event) => ({ x: event.offsetX, y: event.offsetY });
    this.canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.canvas.setPointerCapture(event.pointerId);
      down.set(event.pointerId, place(event));
      this.moved = 0;
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const before = down.get(event.pointerId);
      if (!before) return;
      const now = place(event);
      const other = [...down].find(([id]) => id !== event.pointerId)?.[1];
      down.set(event.pointerId, now);
      if (other) {
        const spread = (p) => Math.max(10, Math.hypot(p.x - other.x, p.y - other.y));
        this.zoom(spread(now) / spread(before), (now.x + other.x) / 2, (now.y + other.y) / 2);
      }
      const share = other ? 0.5 : 1;
      this.moved += Math.hypot(now.x - before.x, now.y - before.y);
      this.pan((now.x - before.x) * share, (now.y - before.y) * share);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      this.canvas.addEventListener(name, (event) => down.delete(event.pointerId));
    }
  }

  // The wheel scrolls the page until the map has the focus, so that nobody is caught in the map.
  bindWheel() {
    this.canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== this.canvas && !event.ctrlKey) return;
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0016)), event.offsetX, event.offsetY);
    }, { passive: false });
  }

  bindKeys() {
    const moves = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] };
    this.canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (moves[event.key]) this.pan(...moves[event.key]);
      else if (event.key === "+" || event.key === "=") this.zoom(1.25);
      else if (event.key === "-") this.zoom(0.8);
      else if (event.key === "0") this.fitAll();
      else return;
      event.preventDefault();
    });
  }
}

// The rectangle that holds everything worth seeing at first. Dead reckoning is left out: it may wander off for miles.
function mapBounds(run) {
  const b = { x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity };
  const add = (x, y) => {
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    b.x0 = Math.min(b.x0, x);
    b.x1 = Math.max(b.x1, x);
    b.y0 = Math.min(b.y0, y);
    b.y1 = Math.max(b.y1, y);
  };
  for (const path of [run.estimate, run.truth]) if (path) path.x.forEach((x, i) => add(x, path.y[i]));
  for (const [x0, y0, x1, y1] of run.plan) {
    add(x0, y0);
    add(x1, y1);
  }
  for (const wall of run.walls) {
    const ends = wallAt(wall, run.count - 1);
    if (!ends) continue;
    add(ends.x0, ends.y0);
    add(ends.x1, ends.y1);
  }
  return Number.isFinite(b.x0) ? b : { x0: -1, y0: -1, x1: 1, y1: 1 };
}
