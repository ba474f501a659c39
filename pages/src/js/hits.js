// Where beams ended, and which visit of its neighbourhood each end belongs to.

// Visits of one neighbourhood that lie further apart than this are different passes.
const PASS_GAP_S = 30;
// A neighbourhood is a cell and those beside it: a pass that drifted aside by half a metre is still one of the same place.
const PASS_CELL_M = 1;

// Every hit of a run in order of time; `upTo[step]` is the number of hits before the end of that step. Hits are added step by
// step, so that a run may grow.
class Hits {
  constructor(run) {
    this.run = run;
    this.placing = "estimate";
    this.reset();
  }

  reset() {
    this.count = 0;
    this.upTo = [];
    this.cells = new Map();
    this.room = 0;
    this.makeRoom(4096);
  }

  makeRoom(room) {
    const larger = (Type, before) => {
      const after = new Type(room);
      if (before) after.set(before.subarray(0, this.count));
      return after;
    };
    const places = (before) => ({ x: larger(Float32Array, before?.x), y: larger(Float32Array, before?.y) });
    const before = this.room ? this : {};
    this.placed = { estimate: places(before.placed?.estimate), odometry: places(before.placed?.odometry) };
    this.step = larger(Uint32Array, before.step);
    this.sensor = larger(Uint8Array, before.sensor);
    this.code = larger(Uint8Array, before.code);
    this.pass = larger(Uint8Array, before.pass);
    this.room = room;
    placeHits(this, this.placing);
  }

  // The hits of the next step.
  add(step) {
    const { run } = this;
    run.sensors.forEach((sensor, index) => {
      const end = beam(run.estimate, sensor, step);
      if (!end || !Number.isFinite(end.x1)) return;
      if (this.count === this.room) this.makeRoom(2 * this.room);
      const i = this.count++;
      const drifted = beam(run.odometry, sensor, step);
      const { estimate, odometry } = this.placed;
      [estimate.x[i], estimate.y[i]] = [end.x1, end.y1];
      [odometry.x[i], odometry.y[i]] = [drifted.x1, drifted.y1];
      this.step[i] = step;
      this.sensor[i] = index;
      this.code[i] = Math.min(sensor.code[step], REFUSED);
      this.pass[i] = this.code[i] >= REFUSED ? 0 : this.passAt(estimate.x[i], estimate.y[i], run.t[step]);
    });
    this.upTo[step] = this.count;
  }

  // The pass of a hit, from 1. A cell's next pass begins with the first hit in it or beside it after none was seen there for
  // PASS_GAP_S.
  passAt(x, y, t) {
    const key = (i, j) => i * 100003 + j;
    const i = Math.floor(x / PASS_CELL_M);
    const j = Math.floor(y / PASS_CELL_M);
    for (let di = -1; di <= 1; di++) {
      for (let dj = -1; dj <= 1; dj++) {
        const at = key(i + di, j + dj);
        const cell = this.cells.get(at) ?? { t: -Infinity, pass: 0 };
        if (t - cell.t > PASS_GAP_S) cell.pass = Math.min(255, cell.pass + 1);
        cell.t = t;
        this.cells.set(at, cell);
      }
    }
    return this.cells.get(key(i, j)).pass;
  }
}

// Every hit of a finished run.
function collectHits(run) {
  const hits = new Hits(run);
  for (let step = 0; step < run.count; step++) hits.add(step);
  return hits;
}

// Places the hits with the poses of the "estimate", or of "odometry".
function placeHits(hits, path) {
  hits.placing = path;
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
