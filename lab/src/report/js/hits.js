// Where beams ended, and which visit of its neighbourhood each end belongs to.

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
