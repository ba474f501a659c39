// The embedded data: columns of whole numbers in small units, each stored as its difference from the one before.

// A delta-coded column as numbers in `unit`; null is NaN.
function column(deltas, unit) {
  const values = new Float64Array(deltas.length);
  let sum = 0;
  for (let i = 0; i < deltas.length; i++) {
    if (deltas[i] === null) {
      values[i] = NaN;
    } else {
      sum += deltas[i];
      values[i] = sum * unit;
    }
  }
  return values;
}

const MM = 1e-3;
const TENTH_MM = 1e-4;
const TENTH_MRAD = 1e-4;
const TEN_URAD = 1e-5;

function poses(raw) {
  return { x: column(raw.x, MM), y: column(raw.y, MM), theta: column(raw.theta, TENTH_MRAD) };
}

// The estimate in the frame of the start pose, which walls may have moved in the map.
function fromStart(estimate, start) {
  if (!start) return estimate;
  const out = { x: estimate.x.slice(), y: estimate.y.slice(), theta: estimate.theta.map((t, i) => t - start.theta[i]) };
  for (let i = 0; i < out.x.length; i++) {
    const [c, s] = [Math.cos(start.theta[i]), Math.sin(start.theta[i])];
    const [dx, dy] = [estimate.x[i] - start.x[i], estimate.y[i] - start.y[i]];
    [out.x[i], out.y[i]] = [c * dx + s * dy, c * dy - s * dx];
  }
  return out;
}

// True poses are stored as the estimate's error from the start pose, which is small and stays precise.
function truthFrom(raw, estimate) {
  if (!raw) return null;
  const error = { x: column(raw.x, TENTH_MM), y: column(raw.y, TENTH_MM), theta: column(raw.theta, TEN_URAD) };
  const minus = (a, b) => a.map((value, i) => value - b[i]);
  return {
    error,
    x: minus(estimate.x, error.x),
    y: minus(estimate.y, error.y),
    theta: minus(estimate.theta, error.theta),
  };
}

// Outcome codes of the data: these, then 4 + the index into `refusals`.
const MISSING = 0;
const USED = 1;
const GATED = 2;
const UNEXPLAINED = 3;
const REFUSED = 4;

// One sensor's readings, a value per step: outcome code, wall id (-1: none), range, innovation in sigmas, its sigma.
function readings(raw, count) {
  const out = {
    name: raw.name,
    x: raw.x,
    y: raw.y,
    bearing: raw.bearing,
    code: new Uint8Array(count),
    wall: new Int32Array(count).fill(-1),
    range: new Float32Array(count).fill(NaN),
    sigmas: new Float32Array(count).fill(NaN),
    sigma: new Float32Array(count).fill(NaN),
  };
  const ranges = column(raw.ranges, MM);
  const sigma = column(raw.sigma, TENTH_MM);
  let step = 0;
  let nextRange = 0;
  let nextInnovation = 0;
  // Runs of [code, wall or -1, whether there is a hit, length].
  for (let i = 0; i + 3 < raw.runs.length; i += 4) {
    const [code, wall, hasHit, length] = raw.runs.slice(i, i + 4);
    for (let k = 0; k < length; k++, step++) {
      out.code[step] = code;
      out.wall[step] = wall;
      if (hasHit) out.range[step] = ranges[nextRange++];
      if (code === USED || code === GATED) {
        out.sigmas[step] = raw.sigmas[nextInnovation] === null ? NaN : raw.sigmas[nextInnovation] / 100;
        out.sigma[step] = sigma[nextInnovation++];
      }
    }
  }
  return out;
}

function wallTracks(raw) {
  return raw.map((wall) => ({
    id: wall.id,
    kind: wall.kind,
    updates: wall.updates,
    visits: wall.visits,
    thickness: wall.thickness ?? NaN,
    gap: wall.gap ?? NaN,
    born: wall.born,
    gone: wall.gone ?? Infinity,
    at: column(wall.at, 1),
    x0: column(wall.x0, MM),
    y0: column(wall.y0, MM),
    x1: column(wall.x1, MM),
    y1: column(wall.y1, MM),
    sigma: column(wall.sigma, TENTH_MM),
  }));
}

function decode(raw) {
  const s = raw.steps;
  const estimate = poses(s.estimate);
  const start = s.start ? poses(s.start) : null;
  const estimateFromStart = fromStart(estimate, start);
  const last = s.t.length - 1;
  const run = {
    title: raw.title,
    seed: raw.seed,
    program: raw.program,
    figures: raw.figures,
    counts: raw.counts,
    sensorCounts: raw.sensor_counts,
    refusals: raw.refusals,
    stride: raw.stride,
    count: s.t.length,
    t: column(s.t, 1e-3),
    estimate,
    estimateFromStart,
    odometry: poses(s.odometry),
    truth: truthFrom(s.error, estimateFromStart),
    start: start ? { x: start.x[last], y: start.y[last], theta: start.theta[last] } : { x: 0, y: 0, theta: 0 },
    sigma: { x: column(s.sigma_x, TENTH_MM), y: column(s.sigma_y, TENTH_MM), theta: column(s.sigma_theta, TEN_URAD) },
    correlation: column(s.correlation, 0.01),
    alpha: column(s.alpha, TENTH_MRAD),
    alphaSigma: column(s.alpha_sigma, TEN_URAD),
    nees: s.nees ? column(s.nees, 0.01) : null,
    nisUsed: column(s.nis_used, 0.01),
    nisAll: column(s.nis_all, 0.01),
    wallCount: column(s.walls, 1),
    walls: wallTracks(raw.walls),
    plan: raw.plan,
    floor: decodeFloor(raw.floor),
    ...decodeEvents(raw.events),
    calibration: {
      t: column(raw.calibration.t, 1e-3),
      parameters: raw.calibration.parameters.map((p) => ({
        name: p.name,
        truth: p.truth,
        value: column(p.value, 1e-5),
        sigma: column(p.sigma, 1e-5),
      })),
    },
  };
  run.sensors = raw.sensors.map((sensor) => readings(sensor, run.count));
  run.end = run.count ? run.t[run.count - 1] : 0;
  return run;
}

// A gap in time that a line over sparse values does not bridge, seconds.
const GAP_S = 5;

// Index of the last step at or before `seconds`.
function stepAt(run, seconds) {
  return Math.max(0, lastAtOrBefore(run.t, seconds));
}

// Index of the last of the sorted `values` that is at or below `limit`; -1 where there is none.
function lastAtOrBefore(values, limit) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= limit) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

// A wall's ends at one step, or null while it is not in the map.
function wallAt(wall, step) {
  if (step < wall.born || step >= wall.gone) return null;
  const i = Math.max(0, lastAtOrBefore(wall.at, step));
  return { x0: wall.x0[i], y0: wall.y0[i], x1: wall.x1[i], y1: wall.y1[i], sigma: wall.sigma[i] };
}
