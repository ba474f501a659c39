// A run that grows: the columns that the program sends, as the view modules want them. The other end is `growing.rs`.

// A column of numbers that grows; `view` has those that are there.
class Column {
  constructor(Type = Float64Array) {
    this.store = new Type(2048);
    this.length = 0;
  }

  push(value) {
    if (this.length === this.store.length) {
      const larger = new this.store.constructor(2 * this.length);
      larger.set(this.store);
      this.store = larger;
    }
    this.store[this.length++] = value;
  }

  get view() {
    return this.store.subarray(0, this.length);
  }
}

// The numbers of a step, in the program's order.
const STEP_NAMES = [
  "t", "x", "y", "theta", "startX", "startY", "startTheta", "odometryX", "odometryY", "odometryTheta",
  "errorX", "errorY", "errorTheta", "sigmaX", "sigmaY", "sigmaTheta", "correlation", "alpha", "alphaSigma",
  "nees", "nisUsed", "nisAll", "wallCount", "searching",
];
// What follows from them: paths as the map shows them, and in the start frame.
const PLACED_NAMES = [
  "shownX", "shownY", "shownTheta", "shownOdometryX", "shownOdometryY", "shownOdometryTheta",
  "shownTruthX", "shownTruthY", "shownTruthTheta", "fromStartX", "fromStartY", "fromStartTheta", "truthX", "truthY", "truthTheta",
];
const READING_NAMES = ["code", "wall", "range", "sigmas", "sigma"];
// A wall's place is kept again when an end moved so far (metres) or its sigma changed by such a share.
const WALL_MOVED_M = 0.004;
const SIGMA_CHANGED = 0.1;

// `run` is in the map frame, as the charts want it, and `shown` is turned for the map; both stay the same objects.
class LiveRun {
  constructor() {
    this.run = {};
    this.shown = {};
    this.hits = new Hits(this.shown);
    this.reset(null, 0);
  }

  // Begins anew; `turn` is how the map frame is turned on the screen, radians.
  reset(head, turn) {
    this.turn = turn;
    this.plan = [];
    this.columns = Object.fromEntries([...STEP_NAMES, ...PLACED_NAMES].map((name) => [name, new Column()]));
    const sensors = head?.sensors ?? [];
    this.readings = sensors.map(() => Object.fromEntries(READING_NAMES.map((name) => [name, new Column(Float32Array)])));
    this.tracks = new Map();
    this.allTracks = [];
    // How the map frame lies on the first one: not at all elsewhere, but for a fresh map of a robot that is lost.
    this.frame = { x: 0, y: 0, theta: 0 };
    this.breaks = new Set();
    this.width = STEP_NAMES.length + READING_NAMES.length * sensors.length;
    if (head && (head.step_numbers !== STEP_NAMES.length || head.reading_numbers !== READING_NAMES.length)) {
      throw new Error("The page and its program are of different versions: reload the page without its cache.");
    }
    this.knowsTruth = false;
    this.counts = [];
    this.calibration = { t: new Column(), values: (head?.parameters ?? []).map(() => [new Column(), new Column()]) };
    const shared = {
      title: head?.title ?? "", seed: null, program: head?.program ?? "", refusals: head?.refusals ?? [], stride: 1,
      figures: {}, plan: [],
    };
    const info = sensors.map(({ name, x, y, bearing }) => ({ name, x, y, bearing }));
    Object.assign(this.run, shared, { sensors: info });
    Object.assign(this.shown, shared, { sensors: info, turn });
    this.parameters = (head?.parameters ?? []).map((name) => ({ name, truth: head.truth?.[name] ?? null }));
    this.hits.reset();
    this.publish();
  }

  // Takes the steps that came.
  take(numbers) {
    const from = this.run.count;
    for (let at = 0; at + this.width <= numbers.length; at += this.width) this.takeStep(numbers.subarray(at, at + this.width));
    this.publish();
    for (let step = from; step < this.run.count; step++) this.hits.add(step);
  }

  takeStep(numbers) {
    const { columns } = this;
    const now = {};
    STEP_NAMES.forEach((name, i) => {
      now[name] = numbers[i];
      columns[name].push(numbers[i]);
    });
    this.place(now);
    let at = STEP_NAMES.length;
    for (const reading of this.readings) {
      this.counts[numbers[at]] = (this.counts[numbers[at]] ?? 0) + 1;
      for (const name of READING_NAMES) reading[name].push(numbers[at++]);
    }
    this.knowsTruth ||= Number.isFinite(now.errorX);
  }

  // Where a step's poses lie on the screen, and in the start frame.
  place(now) {
    const put = (name, [x, y], theta) => {
      this.columns[`${name}X`].push(x);
      this.columns[`${name}Y`].push(y);
      this.columns[`${name}Theta`].push(theta);
    };
    const turn = mover({ x: 0, y: 0, theta: this.turn });
    const here = now.searching ? composed({ x: 0, y: 0, theta: this.turn }, this.frame) : { x: 0, y: 0, theta: this.turn };
    const start = { x: now.startX, y: now.startY, theta: now.startTheta };
    const toStart = mover(inverseMove(start));
    const truth = [now.x - now.errorX, now.y - now.errorY];
    const truthTheta = now.theta - now.errorTheta;
    // Where the frame changed, the path is broken.
    if (this.isBroken) this.breaks.add(this.columns.t.length - 1);
    this.isBroken = false;
    put("shown", mover(here)(now.x, now.y), now.theta + here.theta);
    put("shownOdometry", turn(...mover(start)(now.odometryX, now.odometryY)), now.odometryTheta + start.theta + this.turn);
    put("shownTruth", turn(...truth), truthTheta + this.turn);
    put("fromStart", toStart(now.x, now.y), now.theta - start.theta);
    put("truth", toStart(...truth), truthTheta - start.theta);
  }

  // Takes the map and the calibration of a step.
  takeMap({ step, walls, calibration }) {
    const here = new Set();
    const turn = mover(composed({ x: 0, y: 0, theta: this.turn }, this.frame));
    for (const { id, kind, ends, sigma, updates } of walls) {
      here.add(id);
      const track = this.tracks.get(id) ?? this.newTrack(id, step);
      Object.assign(track.run, { kind, updates });
      Object.assign(track.shown, { kind, updates });
      const last = track.last;
      const moved = !last || ends.some((value, i) => Math.abs(value - last.ends[i]) > WALL_MOVED_M)
        || Math.abs(sigma - last.sigma) > SIGMA_CHANGED * last.sigma;
      if (!moved) continue;
      track.last = { ends, sigma };
      for (const wall of [track.run, track.shown]) {
        wall.at.push(step);
        wall.sigma.push(sigma);
      }
      const shown = [...turn(ends[0], ends[1]), ...turn(ends[2], ends[3])];
      ["x0", "y0", "x1", "y1"].forEach((name, i) => {
        track.run[name].push(ends[i]);
        track.shown[name].push(shown[i]);
      });
    }
    for (const [id, { run, shown }] of this.tracks) {
      if (here.has(id) || run.gone !== Infinity) continue;
      run.gone = step;
      shown.gone = step;
    }
    this.calibration.t.push(this.run.t[step] ?? 0);
    calibration.forEach(([value, sigma], i) => {
      this.calibration.values[i][0].push(value);
      this.calibration.values[i][1].push(sigma);
    });
    this.publish();
  }

  newTrack(id, step) {
    const wall = () => ({
      id, kind: "free", updates: 0, visits: 0, thickness: NaN, gap: NaN, born: step, gone: Infinity,
      at: [], x0: [], y0: [], x1: [], y1: [], sigma: [],
    });
    const track = { run: wall(), shown: wall(), last: null };
    this.tracks.set(id, track);
    this.allTracks.push(track);
    return track;
  }

  // Poses and walls are in another frame from now on: the walls so far are of the old one.
  newFrame(frame) {
    this.frame = frame;
    this.isBroken = true;
    for (const { run, shown } of this.tracks.values()) {
      const gone = Math.min(run.gone, this.run.count);
      run.gone = gone;
      shown.gone = gone;
    }
    this.tracks = new Map();
  }

  // The walls in the map now, as the screen shows them.
  wallsNow() {
    const walls = this.shown.walls.map((wall) => wallAt(wall, Math.max(0, this.run.count - 1))).filter(Boolean);
    return walls.map(({ x0, y0, x1, y1 }) => [x0, y0, x1, y1]);
  }

  // The true plan: segments in the start frame, x0, y0, x1, y1.
  takePlan(segments) {
    this.plan = segments;
    this.publish();
  }

  // Puts what is there where the views look for it.
  publish() {
    const view = Object.fromEntries(Object.entries(this.columns).map(([name, column]) => [name, column.view]));
    const path = (name) => ({ x: view[`${name}X`], y: view[`${name}Y`], theta: view[`${name}Theta`] });
    const count = view.t.length;
    this.readings.forEach((reading, i) => {
      for (const name of READING_NAMES) this.run.sensors[i][name] = reading[name].view;
    });
    const common = {
      count,
      end: count ? view.t[count - 1] : 0,
      t: view.t,
      sigma: { x: view.sigmaX, y: view.sigmaY, theta: view.sigmaTheta },
      correlation: view.correlation,
      alpha: view.alpha, alphaSigma: view.alphaSigma,
      nees: this.knowsTruth ? view.nees : null,
      nisUsed: view.nisUsed, nisAll: view.nisAll,
      wallCount: view.wallCount,
      searching: view.searching,
      counts: this.counts.map((n, code) => [code, n]).filter((pair) => pair),
      calibration: {
        t: this.calibration.t.view,
        parameters: this.parameters.map((parameter, i) => ({
          ...parameter, value: this.calibration.values[i][0].view, sigma: this.calibration.values[i][1].view,
        })),
      },
    };
    const tracks = this.allTracks;
    const start = count
      ? { x: view.startX[count - 1], y: view.startY[count - 1], theta: view.startTheta[count - 1] } : { x: 0, y: 0, theta: 0 };
    Object.assign(this.run, common, {
      estimate: { x: view.x, y: view.y, theta: view.theta },
      estimateFromStart: path("fromStart"),
      odometry: path("odometry"),
      start,
      truth: this.knowsTruth ? { error: path("error"), ...path("truth") } : null,
      walls: tracks.map((track) => track.run),
      plan: this.plan ?? [],
    });
    const plan = movedPlan(movedPlan(this.plan ?? [], start), { x: 0, y: 0, theta: this.turn });
    const truth = this.knowsTruth ? path("shownTruth") : null;
    Object.assign(this.shown, common, {
      breaks: this.breaks,
      estimate: path("shown"),
      odometry: path("shownOdometry"),
      truth,
      walls: tracks.map((track) => track.shown),
      plan,
      start,
      truths: { start: { truth, plan }, fit: null },
    });
  }
}
