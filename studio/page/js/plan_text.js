// A plan file's text as things that can be moved, added and taken away; what is not touched stays as it was written.

const THING_KEYS = {
  box: ["min_m", "max_m"], wall: ["from_m", "to_m"], round: ["centre_m"], person: ["path_m"], door: ["from_m", "to_m"],
  rug: ["min_m", "max_m"], cliff: ["min_m", "max_m"], keep_out: ["points_m"], clean: ["points_m"],
};

// Metres to the nearest five centimetres.
const snapped = (metres) => Math.round(metres * 20) / 20;
const shortNumber = (value) => String(Number(value.toFixed(3)));
const pointText = (point) => `[${point.map(shortNumber).join(", ")}]`;

// The things in a text: kind, place of its block, points of its keys. What cannot be read is left alone.
function thingsIn(text) {
  const headers = [...text.matchAll(/^[ \t]*\[\[?([a-z_]+)\]?\]/gm)];
  return headers.flatMap((header, i) => {
    const kind = header[1];
    const [from, to] = [header.index, headers[i + 1]?.index ?? text.length];
    if (!THING_KEYS[kind]) return [];
    const values = THING_KEYS[kind].map((key) => valueIn(text, key, from, to));
    return values.every(Boolean) ? [{ kind, from, to, values, points: values.flatMap((value) => value.points) }] : [];
  });
}

// A key's list of points: where its text stands, and the points.
function valueIn(text, key, from, to) {
  const found = text.slice(from, to).match(new RegExp(`^[ \\t]*${key}[ \\t]*=[ \\t]*`, "m"));
  if (!found) return null;
  const begin = from + found.index + found[0].length;
  let depth = 0;
  let end = begin;
  for (; end < to; end++) {
    if (text[end] === "[") depth++;
    else if (text[end] === "]" && --depth === 0) break;
  }
  try {
    const list = JSON.parse(text.slice(begin, end + 1));
    const isFlat = typeof list[0] === "number";
    const points = isFlat ? [list] : list;
    return points.every((point) => point.length === 2 && point.every(Number.isFinite)) ? { begin, end: end + 1, points, isFlat } : null;
  } catch {
    return null;
  }
}

// The text with a thing moved, metres.
function movedThing(text, thing, dx, dy) {
  let out = text;
  for (const value of [...thing.values].reverse()) {
    const points = value.points.map(([x, y]) => [x + dx, y + dy]);
    const written = value.isFlat ? pointText(points[0]) : `[${points.map(pointText).join(", ")}]`;
    out = out.slice(0, value.begin) + written + out.slice(value.end);
  }
  return out;
}

function withoutThing(text, thing) {
  return text.slice(0, thing.from) + text.slice(thing.to);
}

// The text with a thing drawn from one place to another.
function withThing(text, kind, a, b) {
  const [low, high] = [[Math.min(a[0], b[0]), Math.min(a[1], b[1])], [Math.max(a[0], b[0]), Math.max(a[1], b[1])]];
  const radius = Math.hypot(b[0] - a[0], b[1] - a[1]);
  const lines = {
    wall: [`from_m = ${pointText(a)}`, `to_m = ${pointText(b)}`],
    box: [`min_m = ${pointText(low)}`, `max_m = ${pointText(high)}`],
    round: [`centre_m = ${pointText(a)}`, `radius_m = ${shortNumber(Math.min(1, Math.max(0.03, radius)))}`],
    person: [`path_m = [${pointText(a)}, ${pointText(b)}]`],
    door: [`from_m = ${pointText(a)}`, `to_m = ${pointText(b)}`],
    rug: [`min_m = ${pointText(low)}`, `max_m = ${pointText(high)}`, "turn_deg = 9.0"],
    keep_out: areaLines(low, high),
    clean: areaLines(low, high),
  }[kind];
  return `${text.trimEnd()}\n\n[[${kind}]]\n${lines.join("\n")}\n`;
}

// A rectangle as an area's corners.
function areaLines([x0, y0], [x1, y1]) {
  return [`points_m = [${[[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(pointText).join(", ")}]`];
}

// The thing nearest to a place, within `reach` metres; null: none.
function thingNear(text, [x, y], reach) {
  let best = null;
  let nearest = reach;
  for (const thing of thingsIn(text)) {
    const d = thingDistance(thing, x, y);
    if (d >= nearest) continue;
    nearest = d;
    best = thing;
  }
  return best;
}

// An area is taken hold of by its edge: what stands in it can be, too.
const isArea = (kind) => kind === "keep_out" || kind === "clean";

function thingDistance({ kind, points }, x, y) {
  if (points.length === 1) return Math.hypot(points[0][0] - x, points[0][1] - y) - 0.1;
  if (["box", "rug", "cliff"].includes(kind)) {
    const [[x0, y0], [x1, y1]] = points;
    return Math.hypot(Math.max(x0 - x, 0, x - x1), Math.max(y0 - y, 0, y - y1));
  }
  let least = Infinity;
  if (isArea(kind)) points = [...points, points[0]];
  for (let i = 1; i < points.length; i++) least = Math.min(least, segmentDistance(x, y, points[i - 1], points[i]));
  return least;
}
