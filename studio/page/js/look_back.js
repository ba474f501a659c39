// The look back as a layer: path and walls of all that was driven, placed once more, a few milliseconds a frame.

LAYERS.splice(LAYERS.length - 1, 0, { id: "back", label: "Look back: path, walls", swatch: "line", colour: "back" });
COLOUR_NAMES.push("back");

// Time of a frame that a look back may take, milliseconds.
const LOOK_BACK_MS = 4;
// Small pieces of work that are asked for at once; a frame's time is looked at between.
const PIECES = 4;
// A look back that is done goes on when the run has grown by so many steps, and by this share.
const GROWN_STEPS = 250;
const GROWN_SHARE = 0.1;

class LookBackLayer {
  constructor(studio) {
    this.studio = studio;
    this.button = document.getElementById("look-back");
    this.saveButton = document.getElementById("save-look-back");
    this.button.addEventListener("click", () => this.turn(!this.isOn));
    this.saveButton.addEventListener("click", () => this.save());
    this.reset();
  }

  get program() {
    return this.studio.source?.program;
  }

  // A new run: nothing of it is placed.
  reset() {
    Object.assign(this, { isWorking: false, isWanted: false, found: null, refusal: "" });
    this.showButtons();
  }

  turn(on) {
    this.isOn = on;
    this.refusal = "";
    this.showButtons();
    this.studio.map.draw();
  }

  showButtons() {
    this.button.setAttribute("aria-pressed", String(Boolean(this.isOn)));
    this.saveButton.disabled = !this.found && !this.isWanted;
  }

  // Whether there is enough new to look back on.
  get isDue() {
    const { run } = this.studio.live;
    const placed = this.found?.steps ?? 0;
    const grown = run.count - placed;
    if (this.isWanted || !this.studio.clock.playing) return grown > 0;
    return grown >= Math.max(GROWN_STEPS, GROWN_SHARE * placed);
  }

  // Does a frame's share of the work.
  work() {
    if (!(this.isOn || this.isWanted) || this.refusal || !this.program || !this.studio.live.run.count) return;
    if (!this.isWorking && !this.isDue) return;
    const deadline = performance.now() + LOOK_BACK_MS;
    try {
      do this.isWorking = this.program.look_back(PIECES);
      while (this.isWorking && performance.now() < deadline);
      if (!this.isWorking) this.take();
    } catch (error) {
      Object.assign(this, { isWorking: false, isWanted: false, refusal: `No look back: ${error}.` });
      this.showButtons();
    }
  }

  // Takes what was found; turned as the map is shown.
  take() {
    const { live, map } = this.studio;
    const turn = mover({ x: 0, y: 0, theta: live.turn });
    const { steps, walls } = JSON.parse(this.program.looked_back());
    const numbers = this.program.looked_back_path();
    const path = { x: new Float64Array(steps), y: new Float64Array(steps) };
    for (let step = 0; step < steps; step++) [path.x[step], path.y[step]] = turn(numbers[2 * step], numbers[2 * step + 1]);
    this.found = { steps, path, walls: walls.map(([x0, y0, x1, y1]) => [...turn(x0, y0), ...turn(x1, y1)]) };
    this.showButtons();
    map.draw();
    if (this.isWanted && steps === live.run.count) this.savePage();
  }

  // Saves the page of the whole drive: what has come since the last look back is placed first, and the drive waits.
  save() {
    this.studio.clock.play(false);
    this.isWanted = true;
    this.refusal = "";
    if (this.found?.steps === this.studio.live.run.count) this.savePage();
  }

  savePage() {
    this.isWanted = false;
    const page = this.program.look_back_page();
    if (page) save("looking-back.html", page, "text/html");
  }

  // What the page says of it.
  status() {
    if (!(this.isOn || this.isWanted)) return "";
    if (this.refusal) return this.refusal;
    if (this.found) return `The look back placed the first ${whole(this.found.steps)} of ${whole(this.studio.live.run.count)} samples once more.`;
    return "Looking back.";
  }

  paint(map) {
    const { found } = this;
    if (!this.isOn || !found || !map.shown.back) return;
    map.paintPath(found.path, map.theme.back, 2, []);
    map.context.strokeStyle = map.theme.back;
    map.context.lineWidth = 2;
    for (const wall of found.walls) map.stroke(...wall);
  }
}
