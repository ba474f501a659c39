// Where beams ended, which visit each end belongs to, and how thick that makes the walls.

// Visits of one neighbourhood that lie further apart than this are different passes.
const PASS_GAP_S = 30;
const PASS_CELL_M = 0.5;

// Every hit of the run in order of time; `upTo[step]` is the number of hits before the end of that step.
function collectHits(run) {
  const hits = { count: 0, upTo: new Uint32Array(run.count) };
  let total = 0;
  for (const sensor of run.sensors) for (const range of sensor.range) if (Number.isFinite(range)) total++;
  hits.x = new Float32Array(total);
  hits.y = new Float32Array(total);
  hits.step = new Uint32Array(total);
  hits.sensor = new Uint8Array(total);
  hits.code = new Uint8Array(total);
  for (let step = 0; step < run.count; step++) {
    run.sensors.forEach((sensor, index) => {
      const end = beam(run, sensor, step);
      if (!end || !Number.isFinite(end.x1)) return;
      const i = hits.count++;
      hits.x[i] = end.x1;
      hits.y[i] = end.y1;
      hits.step[i] = step;
      hits.sensor[i] = index;
      hits.code[i] = Math.min(sensor.code[step], REFUSED);
    });
    hits.upTo[step] = hits.count;
  }
  hits.pass = numberPasses(run, hits);
  return hits;
}

// Start and end of a sensor's beam in the map frame; null without a range.
function beam(run, sensor, step) {
  const range = sensor.range[step];
  if (!Number.isFinite(range)) return null;
  const { x, y, theta } = run.estimate;
  const c = Math.cos(theta[step]);
  const s = Math.sin(theta[step]);
  const x0 = x[step] + c * sensor.x - s * sensor.y;
  const y0 = y[step] + s * sensor.x + c * sensor.y;
  const direction = theta[step] + sensor.bearing;
  return { x0, y0, x1: x0 + range * Math.cos(direction), y1: y0 + range * Math.sin(direction) };
}

// The pass of each hit, from 1; 0 for refused ones. A pass ends when nothing was seen near for PASS_GAP_S.
function numberPasses(run, hits) {
  const pass = new Uint8Array(hits.count);
  const cells = new Map();
  const key = (i, j) => i * 100003 + j;
  for (let h = 0; h < hits.count; h++) {
    if (hits.code[h] >= REFUSED) continue;
    const i = Math.floor(hits.x[h] / PASS_CELL_M);
    const j = Math.floor(hits.y[h] / PASS_CELL_M);
    let latest = null;
    for (let di = -1; di <= 1; di++) {
      for (let dj = -1; dj <= 1; dj++) {
        const near = cells.get(key(i + di, j + dj));
        if (near && (!latest || near.t > latest.t)) latest = near;
      }
    }
    const t = run.t[hits.step[h]];
    const fresh = latest && t - latest.t > PASS_GAP_S;
    pass[h] = latest ? Math.min(255, latest.pass + (fresh ? 1 : 0)) : 1;
    cells.set(key(i, j), { t, pass: pass[h] });
  }
  return pass;
}

const NEAR_WALL_M = 0.25;
const FEWEST_HITS_OF_A_PASS = 12;
// This near to a wall's end, a hit that met no known wall may belong to the next wall.
const CORNER_M = 0.15;

// Directions of the walls of the finished map by their id, radians.
function wallDirections(run) {
  const directions = new Map();
  for (const wall of run.walls) {
    const ends = wallAt(wall, run.count - 1);
    if (ends) directions.set(wall.id, Math.atan2(ends.y1 - ends.y0, ends.x1 - ends.x0));
  }
  return directions;
}

// A wall that is not in the finished map has no direction and is as good as none.
function nearlyParallel(a, b) {
  return a === undefined || b === undefined || Math.abs(Math.sin(a - b)) < 0.25;
}

// How the hits lie about one wall of the final map: RMS distance, and how far the means of its passes are apart.
// Hits count that were seen from the side that most of its updates came from, so that the two faces of one partition do
// not mix, and that belong to no wall of another direction, so that corners do not count.
function wallThickness(run, hits, wall, directions) {
  const ends = wallAt(wall, run.count - 1);
  const size = ends ? Math.hypot(ends.x1 - ends.x0, ends.y1 - ends.y0) : 0;
  const result = { length: size, passes: 0, rms: NaN, apart: NaN };
  if (!(size > 0)) return result;
  const ux = (ends.x1 - ends.x0) / size;
  const uy = (ends.y1 - ends.y0) / size;
  const offset = (x, y) => (x - ends.x0) * -uy + (y - ends.y0) * ux;
  const sideOf = (h) => Math.sign(offset(run.estimate.x[hits.step[h]], run.estimate.y[hits.step[h]]));
  const near = [];
  let balance = 0;
  for (let h = 0; h < hits.count; h++) {
    if (hits.code[h] >= REFUSED) continue;
    const along = (hits.x[h] - ends.x0) * ux + (hits.y[h] - ends.y0) * uy;
    if (along < 0 || along > size || Math.abs(offset(hits.x[h], hits.y[h])) > NEAR_WALL_M) continue;
    const met = run.sensors[hits.sensor[h]].wall[hits.step[h]];
    if (met === wall.id) balance += sideOf(h);
    else if (met < 0 && Math.min(along, size - along) < CORNER_M) continue;
    else if (!nearlyParallel(directions.get(met), directions.get(wall.id))) continue;
    near.push(h);
  }
  const byPass = new Map();
  let sum = 0;
  let count = 0;
  for (const h of near) {
    if (balance !== 0 && sideOf(h) !== Math.sign(balance)) continue;
    const d = offset(hits.x[h], hits.y[h]);
    sum += d * d;
    count++;
    const group = byPass.get(hits.pass[h]) ?? { sum: 0, count: 0 };
    group.sum += d;
    group.count++;
    byPass.set(hits.pass[h], group);
  }
  const means = [...byPass.values()].filter((g) => g.count >= FEWEST_HITS_OF_A_PASS).map((g) => g.sum / g.count);
  result.passes = means.length;
  if (count) result.rms = Math.sqrt(sum / count);
  if (means.length > 1) result.apart = Math.max(...means) - Math.min(...means);
  return result;
}
