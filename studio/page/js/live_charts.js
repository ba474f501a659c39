// The report's charts over a run that grows: one piece of work a frame, and only what is on the screen.

class LiveCharts {
  constructor(run, clock) {
    this.run = run;
    this.main = clock;
    this.groups = [
      { id: "error-charts", specs: errorCharts, charts: [] },
      { id: "consistency-charts", specs: consistencyCharts, charts: [] },
      { id: "calibration-charts", specs: calibrationCharts, charts: [] },
    ];
    this.queue = [];
    clock.onChange(() => this.announce());
  }

  // What the charts of a group take for the clock; made anew with them, so that old ones are forgotten.
  clockFor(group) {
    const { main } = this;
    group.listeners = [];
    return {
      get run() { return main.run; },
      get step() { return main.step; },
      onChange: (listener) => group.listeners.push(listener),
      play: (on) => main.play(on),
      seek: (seconds) => main.seek(seconds),
    };
  }

  announce() {
    const now = performance.now();
    // Words that change faster than they can be read only cost.
    if (this.main.playing && now - (this.said ?? 0) < 120) return;
    this.said = now;
    for (const group of this.groups) {
      if (onScreen(document.getElementById(group.id))) group.listeners?.forEach((listener) => listener());
    }
  }

  setTheme(theme) {
    this.theme = theme;
    this.queue = [];
    for (const group of this.groups) group.charts.forEach((chart) => chart.draw(theme));
  }

  // One piece of work: new series for a group, or one chart drawn.
  work() {
    if (!this.theme) return;
    if (!this.queue.length) this.queue = this.groups.map((group) => () => this.refresh(group));
    this.queue.shift()();
  }

  // Everything at once, for a run that has stopped.
  finish() {
    for (const group of this.groups) this.refresh(group, true);
    const rest = this.queue;
    this.queue = [];
    rest.forEach((job) => job());
  }

  refresh(group, always = false) {
    const box = document.getElementById(group.id);
    if (!this.run.count || (!always && group.charts.length && !onScreen(box))) return;
    const specs = group.specs(this.run);
    const same = specs.length === group.charts.length && specs.every((spec, i) => spec.id === group.charts[i].spec.id);
    if (!same) {
      const clock = this.clockFor(group);
      group.charts = specs.map((spec) => new Chart(spec, clock));
      box.replaceChildren(...group.charts.map((chart) => chart.figure));
    }
    group.charts.forEach((chart, i) => {
      chart.spec = specs[i];
      chart.range = specs[i].range ?? valueRange(specs[i]);
      chart.figure.querySelector("figcaption p").textContent = specs[i].note;
      if (always || onScreen(chart.figure)) this.queue.push(() => chart.draw(this.theme));
    });
  }
}

function onScreen(node) {
  const box = node.getBoundingClientRect();
  return box.bottom > -100 && box.top < innerHeight + 100;
}
