// Simulate: a home, a robot, and what one does to them.

// Samples that are asked for at once; a frame's time is looked at between.
const CHUNK = 4;

class Simulate {
  constructor(studio) {
    this.studio = studio;
    this.program = null;
    const form = document.getElementById("simulate");
    const plans = JSON.parse(built_in_plans());
    const select = document.getElementById("plan");
    select.replaceChildren(...Object.keys(plans).map((name) => element("option", { value: name, selected: name === "flat" }, name)));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.restart();
    });
    for (const id of ["plan", "robot"]) document.getElementById(id).addEventListener("change", () => this.restart());
    document.getElementById("save-log").addEventListener("click", () => save("log.csv", this.program.log()));
    document.getElementById("save-rig").addEventListener("click", () => save("rig.toml", this.program.rig()));
  }

  // Begins a drive; what is wrong with it is said, and the old one goes on.
  restart() {
    const seed = Number(document.getElementById("seed").value) >>> 0;
    const begun = this.studio.attempt(() =>
      new Simulation(document.getElementById("plan").value, document.getElementById("robot").value, seed));
    if (!begun) return;
    this.program?.free();
    this.program = begun;
    const head = JSON.parse(begun.head());
    this.longest = head.longest_s;
    this.start = { x: head.start[0], y: head.start[1], theta: head.start[2] };
    this.studio.begin(this, head, this.start.theta, `Simulated drive, seed ${seed}`);
    this.showHome();
    begun.advance(0, 1);
    this.deliver();
    this.studio.clock.play(true);
  }

  // The true plan in the start frame, which is what the map is held against.
  showHome() {
    const { faces, rounds } = JSON.parse(this.program.home());
    const toStart = mover(inverseMove(this.start));
    const segments = [...faces, ...rounds.flatMap(([x, y, radius]) => circle(x, y, radius))];
    this.studio.live.takePlan(segments.map(([x0, y0, x1, y1]) => [...toStart(x0, y0), ...toStart(x1, y1)]));
    this.studio.map.setBounds(mapBounds(this.studio.live.shown));
  }

  get ended() {
    return this.studio.live.run.end >= this.longest;
  }

  // Drives on until a time or a deadline.
  reach(seconds, deadline) {
    const { program } = this;
    do program.advance(seconds, CHUNK);
    while ((program.time() ?? 0) < Math.min(seconds, this.longest) && performance.now() < deadline);
    this.deliver();
  }

  deliver() {
    const { live } = this.studio;
    live.take(this.program.steps());
    const map = this.program.map();
    if (map) live.takeMap(JSON.parse(map));
  }

  figures() {
    return JSON.parse(this.program.figures());
  }
}

// A round thing as segments.
function circle(x, y, radius) {
  const corners = 16;
  const at = (i) => [x + radius * Math.cos((2 * Math.PI * i) / corners), y + radius * Math.sin((2 * Math.PI * i) / corners)];
  return Array.from({ length: corners }, (_, i) => [...at(i), ...at(i + 1)]);
}
