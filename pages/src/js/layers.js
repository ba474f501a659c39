// What the map can show, and how hits are told apart.

const LAYERS = [
  { id: "plan", label: "True plan", swatch: "band", colour: "plan" },
  { id: "walls", label: "Estimated walls", swatch: "thick", colour: "wall" },
  { id: "apart", label: "Visits over 15 cm apart", swatch: "glow", colour: "apart" },
  { id: "hits", label: "Hits", swatch: "dot", colour: "used" },
  { id: "estimate", label: "Estimated path", swatch: "line", colour: "estimate" },
  { id: "truth", label: "True path", swatch: "dash", colour: "truth" },
  { id: "odometry", label: "Dead reckoning", swatch: "line", colour: "odometry" },
  { id: "robot", label: "Robot, beams, 2-sigma ellipse", swatch: "ring", colour: "estimate" },
];

const OUTCOMES = [
  { label: "Used for the map", colour: "used" },
  { label: "Outside the gate", colour: "gated" },
  { label: "Met no known wall", colour: "unexplained" },
  { label: "Refused", colour: "refused" },
];

// The classes of hits under a colouring: label and colour, in the order of `hitClass`.
function hitClasses(colouring, run, hits) {
  if (colouring === "outcome") return OUTCOMES;
  if (colouring === "sensor") return run.sensors.map((s, i) => ({ label: s.name, colour: SERIES[i % SERIES.length] }));
  if (colouring === "time") {
    const span = (k) => clockTime((run.end * k) / AGES.length).replace(/\.\d$/, "");
    return AGES.map((colour, k) => ({ label: `${span(k)} to ${span(k + 1)}`, colour }));
  }
  let most = 0;
  for (const pass of hits.pass) most = Math.max(most, pass);
  return SERIES.slice(0, most).map((colour, i) => ({
    label: i === SERIES.length - 1 ? `Pass ${i + 1} and later` : `Pass ${i + 1}`,
    colour,
  }));
}

// Class of hit `h`; -1: not shown under this colouring.
function hitClass(colouring, run, hits, h) {
  if (colouring === "outcome") return hits.code[h] - USED;
  if (hits.code[h] >= REFUSED) return -1;
  if (colouring === "sensor") return hits.sensor[h];
  if (colouring === "pass") return Math.min(hits.pass[h], SERIES.length) - 1;
  return Math.min(AGES.length - 1, Math.floor((AGES.length * run.t[hits.step[h]]) / (run.end || 1)));
}
