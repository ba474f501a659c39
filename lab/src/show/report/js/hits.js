// Where beams ended, and which visit of its neighbourhood each end belongs to.

// Visits of one neighbourhood that lie further apart than this are different passes.
const PASS_GAP_S = 30;
// A neighbourhood is a cell and those beside it: a pass that drifted aside by half a metre is still one of the same place.
const PASS_CELL_M = 1;

// Every hit of the run in order of time; `upTo[step]` is the number of hits before the end of that step.
function collectHits(run) {
  const hits = { count: 0, upTo: new Uint32Array(run.count) };
  let total = 0;
  for (const sensor of run.sensors) for (const range of sensor.range) if (Number.isFinite(range)) total++;
  const places = () => ({ x: new Float32Array(total), y: new Float32Array(total) });
  hits.placed = { estimate: places(), odometry: places() };
  hits.step = new Uint32Array(total);
  hits.sensor = new Uint8Array(total);
  hits.code = new Uint8Array(total);
  for (let step = 0; step < run.count; step++) {
    run.sensors.forEach((sensor, index) => {
      const end = beam(run.estimate, sensor, step);
      if (!end || !Number.isFinite(end.x1)) return;
      const i = hits.count++;
      const drifted = beam(run.odometry, sensor, step);
      [hits.placed.estimate.x[i], hits.placed.estimate.y[i]] = [end.x1, end.y1];
      [hits.placed.odometry.x[i], hits.placed.odometry.y[i]] = [drifted.x1, drifted.y1];
      hits.step[i] = step;
      hits.sensor[i] = index;
      hits.code[i] = Math.min(sensor.code[step], REFUSED);
    });
    hits.upTo[step] = hits.count;
  }
  placeHits(hits, "estimate");
  hits.pass = numberPasses(run, hits);
  return hits;
}

// Places the hits with the poses of the "estimate", or of "odometry".
function placeHits(hits, path) {
  Object.assign(hits, hits.placed[path]);
}

// Start and end of a sensor's beam from a pose of a path; null without a range.
function beam(path, sensor, step) {
  const range = sensor.range[step];
  if (!Number.isFinite(range)) return null;
  const { x, y, theta } = path;
  const c = Math.cos(theta[step]);
  const s = Math.sin(theta[step]);
  const x0 = x[step] + c * sensor.x - s * sensor.y;
  const y0 = y[step] + s * sensor.x + c * sensor.y;
  const direction = theta[step] + sensor.bearing;
  return { x0, y0, x1: x0 + range * Math.cos(direction), y1: y0 + range * Math.sin(direction) };
}

// The pass of each hit, from 1; 0 for refused ones. A cell's next pass begins with the first hit in it or beside it after
// none was seen there for PASS_GAP_S.
function numberPasses(run, hits) {
  const pass = new Uint8Array(hits.count);
  const cells = new Map();
  const key = (i, j) => i * 100003 + j;
  for (let h = 0; h < hits.count; h++) {
    if (hits.code[h] >= REFUSED) continue;
    const i = Math.floor(hits.x[h] / PASS_CELL_M);
    const j = Math.floor(hits.y[h] / PASS_CELL_M);
    const t = run.t[hits.step[h]];
    for (let di = -1; di <= 1; di++) {
      for (let dj = -1; dj <= 1; dj++) {
        const at = key(i + di, j + dj);
        const cell = cells.get(at) ?? { t: -Infinity, pass: 0 };
        if (t - cell.t > PASS_GAP_S) cell.pass = Math.min(255, cell.pass + 1);
        cell.t = t;
        cells.set(at, cell);
      }
    }
    pass[h] = cells.get(key(i, j)).pass;
  }
  return pass;
}
