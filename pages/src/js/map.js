// The map: plan, walls, hits, paths, the robot and its beams at the current moment.

class MapView extends Picture {
  constructor(canvas, run, hits, clock) {
    super();
    Object.assign(this, { canvas, run, hits, clock });
    this.shown = Object.fromEntries(LAYERS.map((layer) => [layer.id, true]));
    this.colouring = "outcome";
    this.placing = "estimate";
    this.hidden = new Set();
    this.hitLayer = document.createElement("canvas");
    this.hitsDrawn = 0;
    this.highlight = null;
    // At this step of the clock the walls of another one are drawn dashed: { step, at }.
    this.beside = null;
    this.follow = false;
    const bounds = mapBounds(run);
    canvas.style.aspectRatio = String(Math.min(3, Math.max(0.9, (bounds.x1 - bounds.x0) / Math.max(0.1, bounds.y1 - bounds.y0))));
    this.view = new View(canvas, bounds, () => this.redrawHits());
    this.view.onPan = () => this.setFollow(false);
  }

  setTheme(theme) {
    this.theme = theme;
    this.redrawHits();
  }

  // Compare with the truth from the common start ("start") or in the best rigid fit ("fit").
  compare(how) {
    Object.assign(this.run, this.run.truths[how]);
    this.draw();
  }

  // Place the hits by the "estimate", or by "odometry": what the map would be without the estimator.
  place(path) {
    this.placing = path;
    placeHits(this.hits, path);
    this.redrawHits();
  }

  // Walls lie on top of the hits that made them, but under hits that are to show whether passes or sensors agree.
  get wallsBeneath() {
    return this.shown.hits && this.colouring !== "outcome";
  }

  setFollow(on) {
    this.follow = on;
    document.getElementById("follow").setAttribute("aria-pressed", String(on));
    if (on && this.view.scale < 80) this.view.zoom(80 / this.view.scale);
    this.draw();
  }

  // Moves the view to a wall.
  showAround({ x0, y0, x1, y1 }) {
    const air = 0.5;
    this.setFollow(false);
    this.view.untouched = false;
    this.view.fit({
      x0: Math.min(x0, x1) - air, x1: Math.max(x0, x1) + air,
      y0: Math.min(y0, y1) - air, y1: Math.max(y0, y1) + air,
    });
  }

  classes() {
    return hitClasses(this.colouring, this.run, this.hits);
  }

  // Class of a hit; -1: not shown.
  shownClass(h) {
    const kind = hitClass(this.colouring, this.run, this.hits, h);
    return this.hidden.has(kind) ? -1 : kind;
  }

  redrawHits() {
    this.hitsDrawn = Infinity;
    this.draw();
  }

  paint() {
    const { run, clock, shown } = this;
    if (this.follow && run.count) this.centreOnRobot();
    const surface = prepare(this.canvas);
    this.view.measure();
    this.context = surface.context;
    this.context.clearRect(0, 0, surface.width, surface.height);
    this.paintGrid(surface);
    this.paintStart();
    if (shown.plan) this.paintPlan();
    const apart = shown.apart && this.placing === "estimate";
    if (apart) paintApartBands(this);
    if (shown.walls && this.wallsBeneath) this.paintWalls();
    if (shown.hits) this.paintHits(surface);
    if (shown.odometry) this.paintPath(run.odometry, this.theme.odometry, 1.5, []);
    if (shown.estimate) this.paintPath(run.estimate, this.theme.estimate, 2, []);
    if (shown.truth && run.truth) this.paintPath(run.truth, this.theme.truth, 1.25, [5, 4]);
    if (shown.walls && !this.wallsBeneath) this.paintWalls();
    if (shown.walls) this.paintWallsBeside();
    if (shown.robot && run.count) paintRobot(this, clock.step);
    if (apart) paintApartLabels(this);
    this.paintScaleBar(surface);
  }

  centreOnRobot() {
    const x = this.run.estimate.x[this.clock.step];
    const y = this.run.estimate.y[this.clock.step];
    if (!Number.isFinite(x) || !Number.isFinite(y) || (x === this.view.x && y === this.view.y)) return;
    this.view.x = x;
    this.view.y = y;
    this.hitsDrawn = Infinity;
  }

  paintGrid({ context, width, height }) {
    const { view } = this;
    const spacing = [1, 5, 10, 50, 100].find((m) => m * view.scale >= 12) ?? 500;
    const [x0, y1] = view.toMap(0, 0);
    const [x1, y0] = view.toMap(width, height);
    context.strokeStyle = this.theme.grid;
    context.lineWidth = 1;
    context.beginPath();
    for (let x = Math.ceil(x0 / spacing) * spacing; x <= x1; x += spacing) {
      const px = Math.round(view.toScreen(x, 0)[0]) + 0.5;
      context.moveTo(px, 0);
      context.lineTo(px, height);
    }
    for (let y = Math.ceil(y0 / spacing) * spacing; y <= y1; y += spacing) {
      const py = Math.round(view.toScreen(0, y)[1]) + 0.5;
      context.moveTo(0, py);
      context.lineTo(width, py);
    }
    context.stroke();
  }

  // The map frame's origin: where the robot started, and which way it looked.
  paintStart() {
    const { context, view, theme } = this;
    const [px, py] = view.toScreen(0, 0);
    const c = Math.cos(this.run.turn);
    const s = Math.sin(this.run.turn);
    context.strokeStyle = theme.soft;
    context.fillStyle = theme.soft;
    context.lineWidth = 1.5;
    context.beginPath();
    context.arc(px, py, 3, 0, 2 * Math.PI);
    context.moveTo(px, py);
    context.lineTo(px + 22 * c, py - 22 * s);
    context.stroke();
    context.font = `12px ${theme.font}`;
    context.textAlign = "center";
    context.fillText("start", px, py + 18);
  }

  stroke(x0, y0, x1, y1) {
    this.context.beginPath();
    this.context.moveTo(...this.view.toScreen(x0, y0));
    this.context.lineTo(...this.view.toScreen(x1, y1));
    this.context.stroke();
  }

  paintPlan() {
    this.context.strokeStyle = this.theme.plan;
    this.context.lineWidth = Math.min(14, Math.max(5, 0.08 * this.view.scale));
    this.context.lineCap = "square";
    for (const segment of this.run.plan) this.stroke(...segment);
  }

  paintWalls() {
    const { context, theme } = this;
    context.lineCap = "butt";
    for (const wall of this.run.walls) {
      const ends = wallAt(wall, this.clock.step);
      if (!ends) continue;
      const free = wall.kind === "free";
      if (wall.id === this.highlight) {
        context.strokeStyle = translucent(theme.estimate, 0.35);
        context.lineWidth = 14;
        this.stroke(ends.x0, ends.y0, ends.x1, ends.y1);
      }
      context.strokeStyle = translucent(free ? theme.free : theme.wall, this.wallsBeneath ? 0.45 : 1);
      context.lineWidth = this.wallsBeneath ? 2 : 3;
      context.setLineDash(wall.kind === "snapped" ? [9, 3] : []);
      this.stroke(ends.x0, ends.y0, ends.x1, ends.y1);
      context.setLineDash([]);
      if (free) this.paintEndCaps(ends);
    }
  }

  // The walls of another moment: one that was asked for, or while the robot looks for its place those that it found itself in.
  paintWallsBeside() {
    const { context, theme, clock } = this;
    const [, found] = this.run.lost?.find(([from, to]) => from <= clock.step && clock.step < to && to < this.run.count) ?? [];
    const at = this.beside?.step === clock.step ? this.beside.at : found;
    if (at === undefined) return;
    context.strokeStyle = theme.odometry;
    context.lineWidth = 2;
    context.lineCap = "butt";
    context.setLineDash([6, 4]);
    for (const wall of this.run.walls) {
      const ends = wallAt(wall, at);
      if (ends) this.stroke(ends.x0, ends.y0, ends.x1, ends.y1);
    }
    context.setLineDash([]);
  }

  // Free walls carry rings at their ends, so that they differ by more than colour.
  paintEndCaps(ends) {
    const { context, view, theme } = this;
    context.lineWidth = 2;
    context.fillStyle = theme.card;
    for (const [x, y] of [[ends.x0, ends.y0], [ends.x1, ends.y1]]) {
      context.beginPath();
      context.arc(...view.toScreen(x, y), 3.5, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
  }

  // The whole path faintly, the part up to now in full.
  paintPath(path, colour, width, dash) {
    const { context, clock } = this;
    context.lineWidth = width;
    context.lineJoin = "round";
    context.setLineDash(dash);
    for (const [to, alpha] of [[this.run.count - 1, 0.22], [clock.step, 1]]) {
      context.strokeStyle = translucent(colour, alpha);
      this.trace(path, to);
    }
    context.setLineDash([]);
  }

  trace(path, to) {
    const { context, view } = this;
    const { scale } = view;
    const [originX, originY] = view.toScreen(0, 0);
    let open = false;
    let lastX = NaN;
    let lastY = NaN;
    let lastT = 0;
    context.beginPath();
    for (let i = 0; i <= to; i++) {
      const px = originX + path.x[i] * scale;
      const py = originY - path.y[i] * scale;
      if (!Number.isFinite(px) || !Number.isFinite(py)) continue;
      if (this.run.t[i] - lastT > GAP_S || this.run.breaks?.has(i)) open = false;
      lastT = this.run.t[i];
      if (open && i < to && Math.abs(px - lastX) < 1.5 && Math.abs(py - lastY) < 1.5) continue;
      if (open) context.lineTo(px, py);
      else context.moveTo(px, py);
      open = true;
      lastX = px;
      lastY = py;
    }
    context.stroke();
  }

  // Hits live on a canvas of their own: playing forward only adds the new ones.
  paintHits(surface) {
    const { hitLayer, hits } = this;
    if (!hits.count) return;
    const until = hits.upTo[this.clock.step];
    const resized = hitLayer.width !== this.canvas.width || hitLayer.height !== this.canvas.height;
    if (resized) {
      hitLayer.width = this.canvas.width;
      hitLayer.height = this.canvas.height;
    }
    const layer = hitLayer.getContext("2d");
    layer.setTransform(surface.ratio, 0, 0, surface.ratio, 0, 0);
    if (resized || until < this.hitsDrawn) {
      layer.clearRect(0, 0, surface.width, surface.height);
      this.hitsDrawn = 0;
    }
    this.paintHitsFrom(layer, this.hitsDrawn, until, surface);
    this.hitsDrawn = until;
    this.context.drawImage(hitLayer, 0, 0, surface.width, surface.height);
  }

  paintHitsFrom(layer, from, until, { width, height }) {
    const { hits, view } = this;
    const colours = this.classes().map((c) => translucent(this.theme[c.colour], 0.75));
    const size = Math.min(4, Math.max(2, view.scale * 0.012));
    const sx = width / 2 - view.x * view.scale - size / 2;
    const sy = height / 2 + view.y * view.scale - size / 2;
    // Refused readings first, used ones on top of them.
    for (const refused of [true, false]) {
      let current = -1;
      for (let h = from; h < until; h++) {
        if (hits.code[h] >= REFUSED !== refused) continue;
        const kind = this.shownClass(h);
        if (kind < 0) continue;
        if (kind !== current) layer.fillStyle = colours[kind];
        current = kind;
        layer.fillRect(sx + hits.x[h] * view.scale, sy - hits.y[h] * view.scale, size, size);
      }
    }
  }

  paintScaleBar({ context, height }) {
    const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((m) => m * this.view.scale >= 56) ?? 100;
    const width = metres * this.view.scale;
    const y = height - 16.5;
    context.strokeStyle = this.theme.ink;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(16.5, y - 5);
    context.lineTo(16.5, y);
    context.lineTo(16.5 + width, y);
    context.lineTo(16.5 + width, y - 5);
    context.stroke();
    context.fillStyle = this.theme.ink;
    context.font = `12px ${this.theme.font}`;
    context.textAlign = "left";
    context.fillText(length(metres), 22, y - 6);
  }

  // The shown hit nearest to a screen position, within a few pixels; -1: none.
  hitNear(px, py) {
    const { hits, view } = this;
    if (!this.shown.hits || !hits.count) return -1;
    const [x, y] = view.toMap(px, py);
    const until = hits.upTo[this.clock.step];
    let best = -1;
    let nearest = (7 / view.scale) ** 2;
    for (let h = 0; h < until; h++) {
      const d = (hits.x[h] - x) ** 2 + (hits.y[h] - y) ** 2;
      if (d >= nearest || this.shownClass(h) < 0) continue;
      nearest = d;
      best = h;
    }
    return best;
  }

  // The wall in the map now that is nearest to a screen position, within a few pixels; null: none.
  wallNear(px, py) {
    let best = null;
    let nearest = 7;
    for (const wall of this.run.walls) {
      const ends = this.shown.walls ? wallAt(wall, this.clock.step) : null;
      if (!ends) continue;
      const d = segmentDistance(px, py, this.view.toScreen(ends.x0, ends.y0), this.view.toScreen(ends.x1, ends.y1));
      if (d >= nearest) continue;
      nearest = d;
      best = { wall, ends };
    }
    return best;
  }
}

function segmentDistance(px, py, [ax, ay], [bx, by]) {
  const size = (bx - ax) ** 2 + (by - ay) ** 2;
  const along = size > 0 ? Math.min(1, Math.max(0, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / size)) : 0;
  return Math.hypot(px - ax - along * (bx - ax), py - ay - along * (by - ay));
}
