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

  // Runs what may fail on what a user gave; says why it failed.
  attempt(what) {
    const problem = document.getElementById("problem");
    problem.hidden = true;
    try {
      return what();
    } catch (error) {
      problem.textContent = String(error?.message ?? error);
      problem.hidden = false;
      return null;
    }
  }

  // A new run, from a source that grows it.
  begin(source, head, turn, eyebrow) {
    this.source = source;
    this.clock.play(false);
    this.clock.source = source;
    this.live.reset(head, turn);
    this.clock.seek(0);
    this.trace = new TraceTable(this.live.run);
    document.getElementById("eyebrow").textContent = eyebrow;
    document.getElementById("title").textContent = head.title;
    document.getElementById("foot").textContent = `${head.program}. Everything is computed in this page; it sends nothing anywhere.`;
    document.getElementById("map-empty").hidden = true;
    for (const id of ["play", "step-back", "step-on", "time"]) document.getElementById(id).disabled = false;
    this.kinds = "";
    this.map.redrawHits();
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
    if (!trace || !live.run.count) return;
    if (now - (this.traced ?? 0) > 100 && this.tracedStep !== clock.step) {
      this.traced = now;
      this.tracedStep = clock.step;
      trace.show(clock.step);
    }
    if (now - (this.counted ?? 0) > FIGURES_EVERY_MS && this.countedSteps !== live.run.count) {
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
    const kinds = [!live.run.truth, !live.run.plan.length, live.run.walls.some((wall) => wall.kind === "free")].join();
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
}

async function start() {
  await init();
  const studio = new Studio();
  const simulate = new Simulate(studio);
  studio.redraw();
  simulate.restart();
  document.documentElement.dataset.ready = "true";
}

start();
