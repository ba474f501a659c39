// What a robot swept of the floor: the section Floor, with a picture that follows the clock.
//
// A floor, which `decodeFloor` makes of the report's data and the studio of its own:
//   corner, cell, columns, first, again   when each cell was swept first and again, seconds; Infinity: not, NaN: out of reach
//   origin      where true poses begin, in the frame of the cells
//   keep_out, clean   corners of the areas to stay out of and to clean, in the frame of the cells
//   isOver      whether what was not swept is missed
//   t, shares, sharesTwice, time          shares over time; pairs of what the robot did and for how many seconds
//   floor_m2, swept, twice, overlap, bumps, home_m, hole_m2, hole_m

// What a cell is at a moment, in the order in which they are painted.
const FLOOR_CLASSES = [
  { id: "once", label: "Swept once", colour: "swept" },
  { id: "twice", label: "Swept twice or more", colour: "twice" },
  { id: "to-come", label: "Still to come", colour: "to-come" },
  { id: "missed", label: "Missed", colour: "missed" },
];
const [ONCE, TWICE, TO_COME, MISSED_FLOOR] = FLOOR_CLASSES.keys();

// Colour of what a robot did; what has none of its own takes the next that is free.
const DOING_COLOURS = {
  lanes: "one", edges: "three", transit: "two", retries: "four", return: "five", planning: "eight", "backing off": "seven",
};

// Runs of [second or code, length] as a value for each cell.
function floorTimes(runs) {
  let count = 0;
  for (let i = 1; i < runs.length; i += 2) count += runs[i];
  const out = new Float32Array(count);
  let at = 0;
  for (let i = 0; i + 1 < runs.length; i += 2) {
    const value = runs[i] === -2 ? NaN : runs[i] === -1 ? Infinity : runs[i];
    out.fill(value, at, at + runs[i + 1]);
    at += runs[i + 1];
  }
  return out;
}

function decodeFloor(raw) {
  if (!raw?.columns) return null;
  const [x, y, theta] = raw.origin;
  return {
    ...raw, origin: { x, y, theta }, first: floorTimes(raw.first), again: floorTimes(raw.again), sharesTwice: raw.shares_twice,
    isOver: true,
  };
}

// Class of a cell at a moment; -1: out of reach.
function floorClass(floor, cell, seconds) {
  const first = floor.first[cell];
  if (Number.isNaN(first)) return -1;
  if (floor.again[cell] <= seconds) return TWICE;
  if (first <= seconds) return ONCE;
  return floor.isOver && first === Infinity ? MISSED_FLOOR : TO_COME;
}

const squareMetres = (value) => {
  if (!Number.isFinite(value)) return NONE;
  return value >= 0.1 ? `${fixed(value, value >= 10 ? 1 : 2)}\u00a0m\u00b2` : `${whole(value * 1e4)}\u00a0cm\u00b2`;
};
const percent = (share) => `${fixed(100 * share, 1)}\u00a0%`;

// The floor from above with the plan, the largest hole and the robot; `run` is in the map frame.
class FloorView extends Picture {
  constructor(canvas, floor, run, clock) {
    super();
    Object.assign(this, { canvas, floor, run, clock });
    this.image = document.createElement("canvas");
    this.image.width = floor.columns;
    this.image.height = Math.max(1, floor.first.length / floor.columns);
    // The plan's frame, turned by quarters as the map is; and where true poses are in it.
    const quarter = Math.PI / 2;
    this.turn = quarter * Math.round((uprightTurn(run) + run.start.theta - floor.origin.theta) / quarter);
    this.place = mover({ x: 0, y: 0, theta: this.turn });
    this.fromStart = mover(floor.origin);
    this.bounds = this.extent();
    const { x0, x1, y0, y1 } = this.bounds;
    canvas.style.aspectRatio = String(Math.min(2.4, Math.max(0.8, (x1 - x0) / Math.max(0.1, y1 - y0))));
    clock.onChange(() => this.draw());
  }

  // The box of what is drawn, metres on the map.
  extent() {
    const { corner, cell } = this.floor;
    const [width, height] = [this.image.width * cell, this.image.height * cell];
    const corners = [[0, 0], [width, 0], [0, height], [width, height]].map(([x, y]) => this.place(corner[0] + x, corner[1] + y));
    const [xs, ys] = [0, 1].map((axis) => corners.map((point) => point[axis]));
    return { x0: Math.min(...xs), x1: Math.max(...xs), y0: Math.min(...ys), y1: Math.max(...ys) };
  }

  setTheme(theme) {
    this.theme = theme;
    this.colours = FLOOR_CLASSES.map(({ colour }) => theme[colour].match(/\d+/g).slice(0, 3).map(Number));
    this.painted = undefined;
    this.draw();
  }

  paint() {
    const { context, width, height } = prepare(this.canvas);
    const { x0, x1, y0, y1 } = this.bounds;
    const margin = 20;
    const scale = Math.min((width - 2 * margin) / (x1 - x0), (height - 2 * margin) / (y1 - y0));
    this.toScreen = (x, y) => [width / 2 + (x - (x0 + x1) / 2) * scale, height / 2 - (y - (y0 + y1) / 2) * scale];
    this.scale = scale;
    context.clearRect(0, 0, width, height);
    this.paintCells(context);
    paintAreas(context, this.floor, (x, y) => this.toScreen(...this.place(x, y)), this.theme);
    this.paintPlan(context);
    if (this.floor.isOver) this.paintHole(context, width);
    this.paintRobot(context);
  }

  // The cells, a pixel each, laid on the map.
  paintCells(context) {
    const { floor, image, clock } = this;
    const seconds = Math.ceil(clock.run.count ? clock.run.t[clock.step] : 0);
    if (this.painted !== seconds) {
      this.painted = seconds;
      this.fillImage(seconds);
    }
    const [x, y] = this.toScreen(...this.place(...floor.corner));
    context.save();
    context.translate(x, y);
    context.rotate(-this.turn);
    context.scale(floor.cell * this.scale, -floor.cell * this.scale);
    context.drawImage(image, 0, 0);
    context.restore();
  }

  fillImage(seconds) {
    const { floor, image, colours } = this;
    const layer = image.getContext("2d");
    const pixels = layer.createImageData(image.width, image.height);
    for (let cell = 0; cell < floor.first.length; cell++) {
      const kind = floorClass(floor, cell, seconds);
      if (kind < 0) continue;
      pixels.data.set(colours[kind], 4 * cell);
      pixels.data[4 * cell + 3] = 255;
    }
    layer.putImageData(pixels, 0, 0);
  }

  paintPlan(context) {
    context.strokeStyle = this.theme.wall;
    context.lineWidth = 2;
    context.lineCap = "round";
    context.beginPath();
    for (const [x0, y0, x1, y1] of this.run.plan) {
      context.moveTo(...this.toScreen(...this.place(...this.fromStart(x0, y0))));
      context.lineTo(...this.toScreen(...this.place(...this.fromStart(x1, y1))));
    }
    context.stroke();
  }

  // A frame around the largest piece that was missed, and its size.
  paintHole(context, width) {
    const { hole_m: hole, hole_m2: area } = this.floor;
    if (!hole) return;
    const [ax, ay] = this.toScreen(...this.place(...hole[0]));
    const [bx, by] = this.toScreen(...this.place(...hole[1]));
    const air = 6;
    const [left, top] = [Math.min(ax, bx) - air, Math.min(ay, by) - air];
    const [right, bottom] = [Math.max(ax, bx) + air, Math.max(ay, by) + air];
    const text = `largest hole ${squareMetres(area)}`;
    context.font = `600 12px ${this.theme.font}`;
    const isLeft = right + 8 + context.measureText(text).width > width;
    context.textAlign = isLeft ? "right" : "left";
    const at = [isLeft ? left - 6 : right + 6, (top + bottom) / 2 + 4];
    context.lineJoin = "round";
    for (const [style, line] of [[this.theme.card, 5], [this.theme.ink, 2]]) {
      context.strokeStyle = style;
      context.lineWidth = line;
      context.strokeRect(left, top, right - left, bottom - top);
      if (style === this.theme.card) context.strokeText(text, ...at);
    }
    context.fillStyle = this.theme.ink;
    context.fillText(text, ...at);
  }

  paintRobot(context) {
    const { run, clock, theme } = this;
    const path = run.truth ?? run.estimateFromStart;
    const [x, y] = [path.x[clock.step], path.y[clock.step]];
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    const [px, py] = this.toScreen(...this.place(...this.fromStart(x, y)));
    const theta = path.theta[clock.step] + this.floor.origin.theta + this.turn;
    const radius = Math.max(4, 0.17 * this.scale);
    context.fillStyle = theme.card;
    context.strokeStyle = theme.ink;
    context.lineWidth = 2;
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.fill();
    context.moveTo(px, py);
    context.lineTo(px + radius * Math.cos(theta), py - radius * Math.sin(theta));
    context.stroke();
  }
}

// Shares of the floor over time.
function floorChart(floor) {
  return {
    id: "floor-swept",
    title: "Swept over time",
    note: "Share of the floor that the brush can reach, in percent.",
    unit: (value) => percent(value / 100),
    axis: axisNumber,
    range: [0, 104],
    series: [
      { kind: "line", label: "Swept", colour: "swept-line", t: floor.t, y: scaled(floor.shares, 100) },
      { kind: "line", label: "Swept twice or more", colour: "twice-line", dash: true, t: floor.t, y: scaled(floor.sharesTwice, 100) },
    ],
  };
}

function floorFigures(floor) {
  const took = floor.time.reduce((sum, [, seconds]) => sum + seconds, 0);
  return [
    { id: "swept", name: "Floor swept", value: percent(floor.swept),
      note: `Of ${squareMetres(floor.floor_m2)} that the brush can reach; ${percent(floor.twice)} twice or more.` },
    { id: "overlap", name: "Overlap", value: plain(floor.overlap), note: "The path's area, as wide as the brush, over the area swept." },
    { id: "hole", name: "Largest hole", value: squareMetres(floor.hole_m2), note: "The largest piece in one that was missed; it is framed below." },
    { id: "bumps", name: "Bumps per m\u00b2", value: fixed(floor.bumps / floor.floor_m2, 2), note: `${whole(floor.bumps)} in all.` },
    { id: "took", name: "Time", value: duration(took), note: `It ended ${length(floor.home_m)} from where it started.` },
  ];
}

// What the robot did and for how long, the longest first, with a colour each.
function floorTime(floor) {
  const parts = floor.time.filter(([, seconds]) => seconds >= 0.5).sort((a, b) => b[1] - a[1]);
  const free = SERIES.filter((colour) => !parts.some(([name]) => DOING_COLOURS[name] === colour));
  return parts.map(([name, seconds]) => ({ name, seconds, colour: DOING_COLOURS[name] ?? free.shift() ?? "refused" }));
}

// One bar of the whole time, and below it how long each thing took.
function fillFloorTime(floor) {
  const parts = floorTime(floor);
  const total = parts.reduce((sum, { seconds }) => sum + seconds, 0);
  const share = (seconds) => (100 * seconds) / total;
  const bar = element("div", { class: "time-bar", "aria-hidden": "true" }, ...parts.map(({ seconds, colour }) =>
    element("span", { style: `--w:${share(seconds)}%;--c:var(--${colour})` })));
  const list = element("ul", { class: "legend time" }, ...parts.map(({ name, seconds, colour }) => element("li", { "data-doing": name },
    element("span", { class: "swatch dot", style: `--c:var(--${colour})` }),
    `${name} ${duration(seconds)} (${fixed(share(seconds), 0)} %)`)));
  document.getElementById("floor-time").replaceChildren(bar, list);
}

// The section. Gives what is to be drawn with a theme.
function showFloor(floor, run, clock) {
  document.getElementById("floor-section").hidden = !floor;
  if (!floor) return [];
  document.getElementById("floor-figures").replaceChildren(...floorFigures(floor).map(figureCard));
  document.getElementById("floor-legend").replaceChildren(...FLOOR_CLASSES.map(({ label, colour }) =>
    element("li", {}, element("span", { class: "swatch square", style: `--c:var(--${colour})` }), label)));
  if (floor.keep_out?.length) {
    document.getElementById("floor-legend").append(element("li", {}, element("span", { class: "swatch square hatched" }), "Out of bounds"));
  }
  fillFloorTime(floor);
  const view = new FloorView(document.getElementById("floor"), floor, run, clock);
  const charts = addCharts("floor-charts", [floorChart(floor)], clock);
  return [{ draw: (theme) => view.setTheme(theme) }, ...charts];
}
