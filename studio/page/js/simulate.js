// Simulate: a home, a robot, and what one does to them.

// Samples that are asked for at once; a frame's time is looked at between.
const CHUNK = 4;
const KNOBS = ["sensors", "reach", "noise", "gain_sigma", "wheel_sigma"];

class Simulate {
  constructor(studio) {
    this.studio = studio;
    this.program = null;
    this.plans = JSON.parse(built_in_plans());
    this.tools = new Tools(studio.map, this);
    const byId = (id) => document.getElementById(id);
    byId("plan").replaceChildren(...Object.keys(this.plans).map((name) => element("option", { value: name }, name)),
      element("option", { value: "" }, "as drawn"));
    this.choosePlan("flat");
    byId("simulate").addEventListener("submit", (event) => {
      event.preventDefault();
      this.restart();
    });
    byId("plan").addEventListener("change", () => {
      if (byId("plan").value) this.choosePlan(byId("plan").value);
      this.restart();
    });
    for (const id of ["robot", "job"]) byId(id).addEventListener("change", () => this.restart());
    byId("apply-plan").addEventListener("click", () => this.rebuild(byId("plan-text").value));
    for (const knob of KNOBS) byId(`knob-${knob}`).addEventListener("change", () => this.restart());
    for (const knob of KNOBS) byId(`knob-${knob}`).addEventListener("input", () => this.showKnobs());
    byId("reset-knobs").addEventListener("click", () => {
      for (const knob of KNOBS) byId(`knob-${knob}`).value = byId(`knob-${knob}`).defaultValue;
      this.restart();
    });
    this.bindDeeds(byId);
  }

  // What one does to the robot.
  bindDeeds(byId) {
    const on = (id, act) => byId(id).addEventListener("click", () => {
      this.studio.attempt(act);
      this.studio.clock.play(true);
    });
    on("carry", () => this.program.carry());
    on("kick", () => this.program.kick());
    on("hold", () => this.program.hold());
    on("cut-power", () => this.beginAnew(null));
    byId("give-map").addEventListener("change", () => {
      const [file] = byId("give-map").files;
      byId("give-map").value = "";
      if (file) this.giveMap(file);
    });
    byId("cover").addEventListener("change", () => {
      const chosen = byId("cover").value;
      this.studio.live.run.sensors.forEach((_, i) => this.program.cover(i, chosen === "all" || chosen === String(i)));
    });
    byId("save-log").addEventListener("click", () => save("log.csv", this.program.log()));
    byId("save-rig").addEventListener("click", () => save("rig.toml", this.program.rig()));
    byId("save-map").addEventListener("click", () => save("map.bin", this.program.kept_map(), "application/octet-stream"));
    byId("share").addEventListener("click", () => this.share());
  }

  choosePlan(name) {
    this.name = name;
    this.text = this.plans[name];
    document.getElementById("plan").value = name;
    document.getElementById("plan-text").value = this.text;
  }

  // The sliders: what of the robot is changed.
  knobs() {
    return Object.fromEntries(KNOBS.map((knob) => [knob, Number(document.getElementById(`knob-${knob}`).value)]));
  }

  showKnobs() {
    const { sensors, reach, noise, gain_sigma: gain, wheel_sigma: wheel } = this.knobs();
    const words = {
      sensors: `${sensors}`, reach: `${fixed(100 * reach, 0)} %`, noise: `${fixed(noise, 1)}\u00d7`,
      gain_sigma: `${fixed(100 * gain, 1)} %`, wheel_sigma: `${fixed(100 * wheel, 1)} %`,
    };
    for (const knob of KNOBS) document.getElementById(`knob-${knob}-value`).textContent = words[knob];
  }

  get isTuned() {
    return KNOBS.some((knob) => document.getElementById(`knob-${knob}`).value !== document.getElementById(`knob-${knob}`).defaultValue);
  }

  // Begins a drive; what is wrong with it is said, and the old one goes on.
  restart() {
    this.showKnobs();
    const seed = Number(document.getElementById("seed").value) >>> 0;
    const begun = this.studio.attempt(() => {
      const robot = document.getElementById("robot").value;
      const rig = this.isTuned ? tuned_rig(robot, JSON.stringify(this.knobs())) : robot;
      return new Simulation(this.name || this.text, rig, document.getElementById("job").value, seed);
    });
    if (!begun) return;
    this.program?.free();
    this.program = begun;
    this.eyebrow = `Simulated drive, seed ${seed}`;
    this.begun(this.eyebrow);
    document.getElementById("cover").replaceChildren(element("option", { value: "none" }, "no sensor"),
      ...this.studio.live.run.sensors.map((sensor, i) => element("option", { value: i }, sensor.name)),
      element("option", { value: "all" }, "all sensors"));
    this.studio.map.setBounds(mapBounds(this.studio.live.shown));
  }

  // The program began a new life of the robot.
  begun(eyebrow) {
    const head = JSON.parse(this.program.head());
    this.longest = head.longest_s;
    this.start = { x: head.start[0], y: head.start[1], theta: head.start[2] };
    this.wasSearching = false;
    this.state = null;
    this.studio.begin(this, head, this.start.theta, eyebrow);
    this.takeHome();
    this.program.advance(0, 1);
    this.deliver();
    this.studio.clock.play(true);
  }

  // Takes the home as it is now, and where its floor lies if that is swept.
  takeHome() {
    const { map } = this.studio;
    this.home = JSON.parse(this.program.home());
    this.showHome([], []);
    map.areas = this.home.areas;
    map.toShown = (x, y) => this.toShown(x, y);
    if (!this.home.floor) return;
    map.floor ??= new LiveFloor(() => this.program.floor(), map.toShown);
    map.floor.lie(this.home.floor);
  }

  // The true plan in the start frame, which is what the map is held against, with what moves.
  showHome(people, doors) {
    const { faces, rounds } = this.home;
    const toStart = mover(inverseMove(this.start));
    const segments = [...faces, ...doors, ...[...rounds, ...people].flatMap(([x, y, radius]) => circle(x, y, radius))];
    this.studio.live.takePlan(segments.map(([x0, y0, x1, y1]) => [...toStart(x0, y0), ...toStart(x1, y1)]));
  }

  // From a place on the screen's map to one in the plan, and back.
  toPlan(x, y) {
    const { start, turn } = this.studio.live.shown;
    const inMap = mover({ x: 0, y: 0, theta: -turn })(x, y);
    return mover(this.start)(...mover(inverseMove(start ?? { x: 0, y: 0, theta: 0 }))(...inMap));
  }

  toShown(x, y) {
    const { start, turn } = this.studio.live.shown;
    const inMap = mover(start ?? { x: 0, y: 0, theta: 0 })(...mover(inverseMove(this.start))(x, y));
    return mover({ x: 0, y: 0, theta: turn })(...inMap);
  }

  // Rebuilds the home after a text while the robot drives.
  rebuild(text) {
    const done = this.studio.attempt(() => {
      this.program.rebuild(text);
      return true;
    });
    if (!done) return;
    this.text = text;
    this.name = Object.keys(this.plans).find((name) => this.plans[name] === text) ?? "";
    document.getElementById("plan").value = this.name;
    document.getElementById("plan-text").value = text;
    const before = this.homeReaches();
    this.takeHome();
    // What was drawn stays under the pointer: the view moves only for a home that reaches elsewhere.
    if (this.homeReaches() !== before) this.studio.map.setBounds(mapBounds(this.studio.live.shown));
    this.studio.map.draw();
  }

  // How far the home reaches, as text that can be compared: in the plan, for on the screen it moves with what the robot makes of its start.
  homeReaches() {
    return JSON.stringify(mapBounds({ plan: this.home.faces, walls: [] }));
  }

  carryTo([x, y]) {
    this.studio.attempt(() => this.program.carry_to(x, y));
    this.studio.clock.play(true);
  }

  // The mode is chosen: the drive begins anew, for its run was another mode's meanwhile.
  enter() {
    this.restart();
  }

  get ended() {
    return this.state?.over || this.studio.live.run.end >= this.longest;
  }

  // Drives on until a time or a deadline.
  reach(seconds, deadline) {
    const { program } = this;
    do {
      program.advance(seconds, CHUNK);
      // Of a robot that is lost each piece is placed by itself.
      if (this.wasSearching) this.deliver();
    } while (!this.ended && (program.time() ?? 0) < Math.min(seconds, this.longest) && performance.now() < deadline);
    this.deliver();
  }

  deliver() {
    const { live, map } = this.studio;
    const steps = this.program.steps();
    if (!steps.length) return;
    const state = JSON.parse(this.program.state());
    if (state.searching && (state.lifted || !this.wasSearching)) {
      if (!this.wasSearching) map.ghost = this.soughtWalls();
      // A fresh map lies anywhere: it is drawn where the robot truly is.
      const at = steps.length - live.width;
      const [x, y, theta] = [steps[at + 1], steps[at + 2], steps[at + 3]];
      live.newFrame(composed({ x: state.truth[0], y: state.truth[1], theta: state.truth[2] }, inverseMove({ x, y, theta })));
    } else if (!state.searching && this.wasSearching) {
      live.newFrame({ x: 0, y: 0, theta: 0 });
      map.ghost = [];
    }
    map.places = this.placesShown(state.places);
    this.wasSearching = state.searching;
    live.take(steps);
    const latest = this.program.map();
    if (latest) live.takeMap(JSON.parse(latest));
    const moving = state.people.length + state.doors.length;
    if (moving || this.moving) {
      this.moving = moving;
      this.showHome(state.people, state.doors);
    }
    this.state = state;
  }

  // The kept map's walls on the screen's map, while the robot looks for itself in them.
  soughtWalls() {
    const turn = mover({ x: 0, y: 0, theta: this.studio.live.turn });
    return JSON.parse(this.program.sought() ?? "[]").map(([x0, y0, x1, y1]) => [...turn(x0, y0), ...turn(x1, y1)]);
  }

  // Where the robot may be in the kept map, on the screen's map.
  placesShown(places) {
    const { turn: theta } = this.studio.live;
    const turn = mover({ x: 0, y: 0, theta });
    return places.map(([x, y, heading, share]) => ({ at: turn(x, y), heading: heading + theta, share }));
  }

  // Cuts the robot's power; it begins anew with this map, or where there is none with the one that it kept.
  beginAnew(map) {
    const done = this.studio.attempt(() => {
      if (map) this.program.begin_in(map.content);
      else this.program.cut_power();
      return true;
    });
    if (done) this.begun(`${this.eyebrow}, ${map ? `begun anew with ${map.name}` : "after its power was cut"}`);
  }

  async giveMap(file) {
    await this.studio.attemptLater(async () => {
      if (file.size > LONGEST_MAP) throw new Error(`${file.name}: is larger than any map of a robot; it must be a map.bin`);
      this.beginAnew({ name: file.name, content: new Uint8Array(await file.arrayBuffer()) });
    });
  }

  // What the page says beside the map.
  status() {
    const { state } = this;
    if (!state) return "";
    const words = [];
    if (state.lifted) words.push("Off the floor: the wheel-drop switches tell, and nothing is seen.");
    else if (state.searching) {
      const found = state.searched;
      if (state.places.length) words.push(placesWords(state.places));
      words.push(found
        ? `Searching its place in the kept map: of ${found.walls} walls of a fresh map ${found.matched} stand where kept ones do, odds 10^${fixed(found.log_odds / Math.LN10, 1)}; it claims a place at 10^3.`
        : "Searching its place in the kept map (dashed) with a fresh one, which is drawn where the robot truly is.");
    } else words.push("Located.");
    if (state.health && state.health !== "well") words.push(`The estimator is unwell: ${state.health}.`);
    if (state.bumped) words.push("It has bumped into something.");
    if (state.swept) words.push(cleaningWords(state));
    if (this.ended && !state.over) words.push("An hour is driven: start again.");
    return words.join(" ");
  }

  figures() {
    return JSON.parse(this.program.figures());
  }

  // A link with everything that the scene is made of, behind the address's #: servers never see it.
  async share() {
    const byId = (id) => document.getElementById(id);
    const scene = { plan: this.name || this.text, robot: byId("robot").value, job: byId("job").value, seed: Number(byId("seed").value) };
    if (this.isTuned) scene.knobs = this.knobs();
    location.hash = `scene=${await packed(JSON.stringify(scene))}`;
    const said = document.getElementById("shared");
    try {
      await navigator.clipboard.writeText(location.href);
      said.textContent = "The link is copied.";
    } catch {
      said.textContent = "The link is in the address bar.";
    }
  }

  // Takes the scene of a link; what cannot be read is said.
  async open(text) {
    const scene = JSON.parse(await unpacked(text));
    const byId = (id) => document.getElementById(id);
    byId("robot").value = String(scene.robot ?? "sharp");
    if (!byId("robot").value) byId("robot").value = "sharp";
    byId("job").value = scene.job === "clean" ? "clean" : "explore";
    byId("seed").value = String(Number(scene.seed) >>> 0);
    for (const knob of KNOBS) if (Number.isFinite(scene.knobs?.[knob])) byId(`knob-${knob}`).value = String(scene.knobs[knob]);
    const plan = String(scene.plan ?? "flat");
    if (this.plans[plan]) return this.choosePlan(plan);
    [this.name, this.text] = ["", plan];
    byId("plan").value = "";
    byId("plan-text").value = plan;
  }
}

// How likely the places that a search found are.
function placesWords(places) {
  const elsewhere = 1 - places.reduce((sum, [, , , share]) => sum + share, 0);
  const shares = places.filter(([, , , share]) => share >= 0.01).slice(0, 4).map(([, , , share]) => `${fixed(100 * share, 0)} %`);
  return `It may be at ${shares.length === 1 ? "one place" : `${shares.length} places`} (ringed: ${shares.join(", ")}), or elsewhere (${fixed(100 * elsewhere, 0)} %).`;
}

// What a robot that sweeps the floor does, and how far it is.
function cleaningWords({ doing, swept: [once, twice] }) {
  const now = {
    done: "The floor is swept, and it is back where it started",
    away: "The floor is swept; the way back is blocked",
    flat: "Its battery is empty; it stands",
  };
  return `${now[doing] ?? `Sweeping: ${doing}`}. ${fixed(100 * once, 1)} % of the floor that it can reach is swept, ${fixed(100 * twice, 1)} % twice or more.`;
}

// A round thing as segments.
function circle(x, y, radius) {
  const corners = 16;
  const at = (i) => [x + radius * Math.cos((2 * Math.PI * i) / corners), y + radius * Math.sin((2 * Math.PI * i) / corners)];
  return Array.from({ length: corners }, (_, i) => [...at(i), ...at(i + 1)]);
}

// The move that does `second` and then `first`.
function composed(first, second) {
  const [x, y] = mover(first)(second.x, second.y);
  return { x, y, theta: first.theta + second.theta };
}
