// The moment that everything on the page shows, and its playback.

class Clock {
  constructor(run) {
    this.run = run;
    this.step = Math.max(0, run.count - 1);
    this.seconds = run.end;
    this.speed = 10;
    this.playing = false;
    this.listeners = [];
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  announce() {
    for (const listener of this.listeners) listener(this);
  }

  // Go to a time in seconds.
  seek(seconds) {
    this.seconds = Math.min(Math.max(seconds, 0), this.run.end);
    this.step = stepAt(this.run, this.seconds);
    this.announce();
  }

  // Go to a step.
  seekStep(step) {
    if (!this.run.count) return;
    this.step = Math.min(Math.max(step, 0), this.run.count - 1);
    this.seconds = this.run.t[this.step];
    this.announce();
  }

  play(on) {
    if (on === this.playing || (on && this.run.count < 2)) return;
    this.playing = on;
    if (on && this.seconds >= this.run.end) this.seconds = 0;
    if (on) this.tick(null);
    this.announce();
  }

  tick(before) {
    requestAnimationFrame((now) => {
      if (!this.playing) return;
      if (before !== null) this.seek(this.seconds + ((now - before) / 1000) * this.speed);
      if (this.seconds >= this.run.end) this.play(false);
      else this.tick(now);
    });
  }
}

// The play button, speeds, slider and steppers.
function bindTransport(clock) {
  const { run } = clock;
  const byId = (id) => document.getElementById(id);
  const slider = byId("time");
  slider.max = String(Math.max(0, run.count - 1));
  slider.disabled = run.count < 2;
  for (const id of ["play", "step-back", "step-on"]) byId(id).disabled = run.count < 2;
  slider.addEventListener("input", () => {
    clock.play(false);
    clock.seekStep(Number(slider.value));
  });
  byId("play").addEventListener("click", () => clock.play(!clock.playing));
  const nudge = (by) => {
    clock.play(false);
    clock.seekStep(clock.step + by);
  };
  byId("step-back").addEventListener("click", () => nudge(-1));
  byId("step-on").addEventListener("click", () => nudge(1));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === ",") nudge(-1);
    else if (event.key === ".") nudge(1);
    else if (event.key === " " && event.target.id === "map") clock.play(!clock.playing);
    else return;
    event.preventDefault();
  });
  chooseOne(byId("speeds"), (button) => {
    clock.speed = Number(button.dataset.speed);
  });
  clock.onChange(() => {
    slider.value = String(clock.step);
    const time = run.count ? clockTime(run.t[clock.step]) : NONE;
    byId("clock").textContent = `${time} / ${clockTime(run.end)}`;
    slider.setAttribute("aria-valuetext", time);
    byId("play").textContent = clock.playing ? "Pause" : "Play";
    byId("play").setAttribute("aria-pressed", String(clock.playing));
  });
}

// Buttons of a group of which one is pressed.
function chooseOne(group, chosen) {
  const buttons = [...group.querySelectorAll("button")];
  for (const button of buttons) {
    button.addEventListener("click", () => {
      for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
      chosen(button);
    });
  }
}

// Marks on the time line: where walls were born, and what else happened.
function drawBirths(canvas, run, theme) {
  const surface = prepare(canvas);
  const { context, width, height } = surface;
  context.clearRect(0, 0, width, height);
  if (run.count < 2) return;
  // The thumb of the slider is half its width away from either end.
  const inset = 8;
  const xOf = (step) => inset + (step / (run.count - 1)) * (width - 2 * inset);
  context.fillStyle = theme.soft;
  for (const wall of run.walls) context.fillRect(Math.round(xOf(wall.born)), 2, 1, height - 2);
  drawEvents(surface, run, theme, xOf);
}
