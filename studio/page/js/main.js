// Puts the studio together: one run that grows, the views of it, and the modes that it comes from.

// How often the figures are counted anew, milliseconds.
const FIGURES_EVERY_MS = 1000;

class Studio {
  constructor() {
    this.live = new LiveRun();
    const { run, shown, hits } = this.live;
    this.clock = new LiveClock(run);
    this.map = new LiveMap(document.getElementById("map"), shown, hits, this.clock);
    this.map.shown.apart = false;
    this.charts = new LiveCharts(run, this.clock);
    this.source = null;
    this.lookBack = new LookBackLayer(this);
    this.map.back = this.lookBack;
    this.bind();
  }

  bind() {
    const { live, map, clock } = this;
    bindMapControls(map);
    bindMapTip(map, live.run, live.hits, clock);
    document.getElementById("speeds").replaceChildren(...[1, 3, 10, 30, 100].map((speed) =>
      element("button", { type: "button", "data-speed": speed, "aria-pressed": String(speed === clock.speed) }, `${speed}\u00d7`)));
    document.getElementById("step-on").after(element("button", { type: "button", id: "follow-now", hidden: true }, "To the newest"));
    bindTransport(clock);
    document.getElementById("follow-now").addEventListener("click", () => clock.follow());
    clock.onChange(() => this.showMoment());
    this.chooseTheme = bindTheme(() => this.redraw());
    // In the next frame, for drawing may change sizes again.
    new ResizeObserver(() => requestAnimationFrame(() => {
      if (map.view.untouched) map.view.fitAll();
      this.redraw();
    })).observe(document.querySelector("main"));
    const frame = () => {
      this.everyFrame();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  // Says what is wrong with what a user gave; nothing where all is well.
  say(words) {
    const problem = document.getElementById("problem");
    problem.textContent = words;
    problem.hidden = !words;
  }

  // Runs what may fail on what a user gave; says why it failed.
  attempt(what) {
    this.say("");
    try {
      return what();
    } catch (error) {
      this.say(String(error?.message ?? error));
      return null;
    }
  }

  async attemptLater(what) {
    this.say("");
    try {
      await what();
    } catch (error) {
      this.say(String(error?.message ?? error));
    }
  }

  // A new run, from a source that grows it.
  begin(source, head, turn, eyebrow) {
    this.source = source;
    this.clock.play(false);
    this.clock.source = source;
    this.live.reset(head, turn);
    this.clock.seek(0);
    this.map.ghost = [];
    this.map.places = [];
    this.map.floor = null;
    this.map.areas = {};
    this.lookBack.reset();
    document.getElementById("eyebrow").textContent = eyebrow;
    document.getElementById("title").textContent = head.title;
    document.getElementById("foot").textContent = `${head.program}. Everything is computed in this page; it sends nothing anywhere.`;
    this.adopt();
    if (this.clock.speed === Infinity) this.clock.speed = 10;
    this.showSpeed();
  }

  // The views take the run's new sensors and colours.
  adopt() {
    this.trace = new TraceTable(this.live.run);
    document.getElementById("map-empty").hidden = true;
    for (const id of ["play", "step-back", "step-on", "time"]) document.getElementById(id).disabled = false;
    this.kinds = "";
    this.countedSteps = -1;
    // With the first sample, so that what lies below the layers does not move under a pointer later.
    this.counted = -Infinity;
    this.map.redrawHits();
  }

  showSpeed() {
    for (const button of document.querySelectorAll("#speeds button")) {
      button.setAttribute("aria-pressed", String(Number(button.dataset.speed) === this.clock.speed));
    }
  }

  // A mode: its controls are shown, and its run goes on.
  choose(mode) {
    if (document.documentElement.dataset.mode === mode) return;
    document.documentElement.dataset.mode = mode;
    for (const button of document.querySelectorAll("[data-mode-choice]")) {
      button.setAttribute("aria-pressed", String(button.dataset.modeChoice === mode));
    }
    this.say("");
    this.clock.play(false);
    // What is drawn with a tool is drawn into the simulated home.
    this.modes.simulate.tools.view();
    this.modes[mode].enter();
  }

  // Everything is there: figures and charts at once.
  finish() {
    this.showFigures();
    this.charts.finish();
  }

  showMoment() {
    const { live, clock, map } = this;
    const slider = document.getElementById("time");
    slider.max = String(Math.max(0, live.run.count - 1));
    slider.value = String(clock.step);
    document.getElementById("follow-now").hidden = clock.atEnd;
    map.draw();
  }

  // What need not happen with every sample.
  everyFrame() {
    const now = performance.now();
    const { live, clock, trace } = this;
    if (now - (this.toldAt ?? 0) > 250) {
      this.toldAt = now;
      const mode = this.modes?.[document.documentElement.dataset.mode];
      const words = [mode?.status(), this.lookBack.status()].filter(Boolean).join(" ");
      const status = document.getElementById("status");
      if (status.textContent !== words) status.textContent = words;
    }
    if (!trace || !live.run.count) return;
    this.lookBack.work();
    if (now - (this.traced ?? 0) > 100 && this.tracedStep !== clock.step) {
      this.traced = now;
      this.tracedStep = clock.step;
      trace.show(clock.step);
    }
    if (now - this.counted > FIGURES_EVERY_MS && this.countedSteps !== live.run.count) {
      this.counted = now;
      this.countedSteps = live.run.count;
      this.showFigures();
    } else if (clock.playing || this.charts.queue.length) this.charts.work();
  }

  showFigures() {
    const { live, map } = this;
    live.run.figures = live.shown.figures = this.source.figures();
    showFigures(live.run);
    fillCounts(live.run);
    if (!document.querySelector("#walls:hover")) fillWallTable(live.shown, map);
    drawBirths(document.getElementById("births"), live.run, map.theme);
    const kinds = [!map.floor, !map.places.length, !this.lookBack.isOn, !live.run.truth, !live.run.plan.length, live.run.walls.some((wall) => wall.kind === "free")].join();
    if (kinds !== this.kinds) {
      this.kinds = kinds;
      buildLayerToggles(map, live.shown);
      showHitClasses(map);
    }
    document.getElementById("errors-note").textContent = live.run.truth
      ? "Against the true path, from a common start. The shaded bounds are the estimator's own 2 sigma."
      : "The true path is not known, so only the estimator's own view can be shown.";
  }

  redraw() {
    const theme = readTheme();
    this.map.setTheme(theme);
    this.charts.setTheme(theme);
    drawBirths(document.getElementById("births"), this.live.run, theme);
  }

  // The page that the workbench writes of a run, of what was run here.
  saveReport() {
    this.attempt(() => {
      const page = this.source?.program?.report();
      if (!page) throw new Error("There is no run to report on.");
      save("report.html", page, "text/html");
    });
  }
}

async function start() {
  await init();
  const studio = new Studio();
  studio.redraw();
  const simulate = new Simulate(studio);
  studio.modes = { simulate, replay: new ReplayMode(studio), robot: new RobotMode(studio) };
  for (const button of document.querySelectorAll("[data-mode-choice]")) {
    button.addEventListener("click", () => studio.choose(button.dataset.modeChoice));
  }
  document.getElementById("save-report").addEventListener("click", () => studio.saveReport());
  const scene = new URLSearchParams(location.hash.slice(1)).get("scene");
  if (scene) {
    try {
      await simulate.open(scene);
    } catch {
      studio.linkFault = "The link's scene cannot be read; this is the built-in one.";
    }
  }
  simulate.restart();
  if (studio.linkFault) studio.say(studio.linkFault);
  document.documentElement.dataset.ready = "true";
}

start();
