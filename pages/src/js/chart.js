// One chart over time on a canvas. Its series share the run's time axis:
//   { kind: "line" | "step" | "dots", label, colour, t, y, unit(value) -> text, dash, quiet }
//   { kind: "band", label, colour, t, low, high }    drawn under the lines
//   { kind: "level", label, colour, y }              a constant
// `quiet` series are left out of the readout.

const MARGIN = { left: 52, right: 12, top: 10, bottom: 24 };

class Chart {
  constructor(spec, clock) {
    this.spec = spec;
    this.clock = clock;
    this.canvas = element("canvas", { role: "img", "aria-label": `${spec.title}. ${spec.note}` });
    this.cursor = element("div", { class: "cursor", "aria-hidden": "true" });
    this.hoverLine = element("div", { class: "cursor hover", "aria-hidden": "true", hidden: true });
    this.readout = element("p", { class: "readout" });
    const legend = spec.small ? "" : element("ul", { class: "legend" }, ...spec.series.map((series) => element("li", {},
      element("span", { class: `swatch ${series.kind} ${series.dash ? "dashed" : ""}`, style: `--c:var(--${series.colour})` }),
      series.label)));
    this.figure = element("figure", { class: "chart card", "data-chart": spec.id },
      element("figcaption", {}, element("h3", {}, spec.title), element("p", {}, spec.note)),
      legend,
      element("div", { class: "plot" }, this.canvas, this.cursor, this.hoverLine),
      this.readout);
    Object.assign(this, { width: 1, height: 1 });
    this.range = spec.range ?? valueRange(spec);
    this.bindPointer();
    clock.onChange(() => this.showMoment());
  }

  // Time at a horizontal position of the canvas, and back.
  timeAt(px) {
    const share = (px - MARGIN.left) / Math.max(1, this.width - MARGIN.left - MARGIN.right);
    return Math.min(1, Math.max(0, share)) * this.clock.run.end;
  }

  xOf(seconds) {
    const width = this.width - MARGIN.left - MARGIN.right;
    return MARGIN.left + (this.clock.run.end > 0 ? seconds / this.clock.run.end : 0) * width;
  }

  yOf(value) {
    const scale = this.spec.log ? Math.log10 : (v) => v;
    const [low, high] = this.range.map(scale);
    const height = this.height - MARGIN.top - MARGIN.bottom;
    const clamped = this.spec.log ? Math.max(value, this.range[0] / 10) : value;
    return MARGIN.top + (1 - (scale(clamped) - low) / (high - low)) * height;
  }

  bindPointer() {
    let held = false;
    const go = (event) => {
      this.clock.play(false);
      this.clock.seek(this.timeAt(event.offsetX));
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      held = true;
      this.canvas.setPointerCapture(event.pointerId);
      go(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (held) go(event);
      this.hover = this.timeAt(event.offsetX);
      this.showMoment();
    });
    for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, () => (held = false));
    this.canvas.addEventListener("pointerleave", () => {
      this.hover = undefined;
      this.showMoment();
    });
  }

  // Moves the cursor and writes the values at the hovered time, or at the clock's.
  showMoment() {
    const { clock } = this;
    const at = clock.run.count ? clock.run.t[clock.step] : 0;
    this.cursor.style.transform = `translateX(${this.xOf(at)}px)`;
    this.hoverLine.hidden = this.hover === undefined;
    if (this.hover !== undefined) this.hoverLine.style.transform = `translateX(${this.xOf(this.hover)}px)`;
    const seconds = this.hover ?? at;
    const values = this.spec.series.filter((s) => !s.quiet && s.kind !== "level").map((series) => {
      const i = lastKnown(series, seconds + 1e-9);
      const text = i < 0 ? NONE : series.kind === "band" ? this.bandText(series, i) : this.spec.unit(series.y[i]);
      return `${series.label} ${text}`;
    });
    this.readout.textContent = [clockTime(seconds), ...values].join(" \u00b7 ");
  }

  bandText(series, i) {
    return `${this.spec.unit(series.low[i])} to ${this.spec.unit(series.high[i])}`;
  }

  draw(theme) {
    const surface = prepare(this.canvas);
    const { context, width, height } = surface;
    // Kept because asking for it is slow.
    Object.assign(this, { width, height });
    context.clearRect(0, 0, width, height);
    context.font = `12px ${theme.font}`;
    this.drawAxes(surface, theme);
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, MARGIN.top - 2, width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom + 4);
    context.clip();
    const order = { band: 0, level: 1, dots: 2, step: 3, line: 3 };
    for (const series of [...this.spec.series].sort((a, b) => order[a.kind] - order[b.kind])) {
      this.drawSeries(context, series, theme[series.colour]);
    }
    context.restore();
    this.showMoment();
  }

  drawAxes({ context, width, height }, theme) {
    const { end } = this.clock.run;
    context.strokeStyle = theme.line;
    context.fillStyle = theme.soft;
    context.lineWidth = 1;
    context.textBaseline = "middle";
    context.textAlign = "right";
    const marks = this.spec.log ? decades(...this.range) : ticks(...this.range, Math.max(2.2, height / 60));
    for (const value of marks) {
      const y = Math.round(this.yOf(value)) + 0.5;
      context.beginPath();
      context.moveTo(MARGIN.left, y);
      context.lineTo(width - MARGIN.right, y);
      context.stroke();
      context.fillText(this.spec.axis(value), MARGIN.left - 8, y);
    }
    context.textBaseline = "alphabetic";
    const times = timeTicks(end, (width - MARGIN.left - MARGIN.right) / 80);
    for (const seconds of times) {
      context.textAlign = seconds === 0 ? "left" : this.xOf(seconds) > width - 30 ? "right" : "center";
      context.fillText(clockTime(seconds).replace(/\.0$/, ""), this.xOf(seconds), height - 6);
    }
  }

  drawSeries(context, series, colour) {
    if (series.kind === "band") return this.drawBand(context, series, colour);
    context.strokeStyle = colour;
    // Many dots are fainter, so that their density shows.
    context.fillStyle = translucent(colour, Math.min(0.6, Math.max(0.08, 2500 / (series.t?.length || 1))));
    context.lineWidth = series.kind === "level" ? 1 : 1.6;
    context.setLineDash(series.dash ? [4, 4] : []);
    context.lineJoin = "round";
    context.beginPath();
    if (series.kind === "level") {
      context.moveTo(MARGIN.left, this.yOf(series.y));
      context.lineTo(this.width - MARGIN.right, this.yOf(series.y));
    } else if (series.kind === "dots") {
      this.drawDots(context, series);
    } else {
      this.pathOf(context, series);
    }
    context.stroke();
    context.setLineDash([]);
  }

  // One vertical stroke per pixel column from the lowest to the highest value in it, joined: no peak is lost. Values may
  // be sparse: only a long gap breaks the line.
  pathOf(context, { t, y, kind }) {
    let i = 0;
    let open = false;
    let lastY = 0;
    let lastT = 0;
    while (i < t.length) {
      if (!Number.isFinite(y[i])) {
        i++;
        continue;
      }
      if (t[i] - lastT > GAP_S) open = false;
      const px = Math.round(this.xOf(t[i]) * 2) / 2;
      let low = Infinity;
      let high = -Infinity;
      const first = y[i];
      let last = first;
      for (; i < t.length && Math.round(this.xOf(t[i]) * 2) / 2 === px && Number.isFinite(y[i]); i++) {
        low = Math.min(low, y[i]);
        high = Math.max(high, y[i]);
        last = y[i];
        lastT = t[i];
      }
      if (open && kind === "step") context.lineTo(px, lastY);
      if (open) context.lineTo(px, this.yOf(first));
      else context.moveTo(px, this.yOf(first));
      if (low < high) for (const value of [low, high, last]) context.lineTo(px, this.yOf(value));
      lastY = this.yOf(last);
      open = true;
    }
    if (open && kind === "step") context.lineTo(this.xOf(this.clock.run.end), lastY);
  }

  drawDots(context, { t, y }) {
    for (let i = 0; i < t.length; i++) {
      if (y[i] >= this.range[0]) context.fillRect(this.xOf(t[i]) - 1, this.yOf(Math.min(y[i], this.range[1])) - 1, 2, 2);
    }
  }

  drawBand(context, { t, low, high }, colour) {
    context.fillStyle = translucent(colour, 0.2);
    const skip = Math.max(1, Math.floor(t.length / (2 * this.width)));
    let from = 0;
    while (from < t.length) {
      if (!Number.isFinite(low[from]) || !Number.isFinite(high[from])) {
        from++;
        continue;
      }
      let to = from;
      while (to < t.length && Number.isFinite(low[to]) && Number.isFinite(high[to])) to++;
      context.beginPath();
      for (let i = from; i < to; i += skip) context.lineTo(this.xOf(t[i]), this.yOf(high[i]));
      context.lineTo(this.xOf(t[to - 1]), this.yOf(high[to - 1]));
      context.lineTo(this.xOf(t[to - 1]), this.yOf(low[to - 1]));
      for (let i = to - 1; i >= from; i -= skip) context.lineTo(this.xOf(t[i]), this.yOf(low[i]));
      context.closePath();
      context.fill();
      from = to;
    }
  }
}

// Index of the last value of a series at or before a time, sparse values being bridged like the line is; -1: none.
function lastKnown(series, seconds) {
  const values = series.y ?? series.low;
  let i = lastAtOrBefore(series.t, seconds);
  while (i >= 0 && !Number.isFinite(values[i]) && seconds - series.t[i] <= GAP_S) i--;
  return i;
}

// Lowest and highest value of a chart, with a little air; a symmetric chart keeps zero in the middle.
function valueRange(spec) {
  let low = Infinity;
  let high = -Infinity;
  for (const series of spec.series) {
    const columns = series.kind === "band" ? [series.low, series.high] : series.kind === "level" ? [[series.y]] : [series.y];
    for (const values of columns) {
      for (const value of values) {
        if (!Number.isFinite(value) || (spec.log && value <= 0)) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
  }
  if (low > high) return spec.log ? [0.1, 10] : [-1, 1];
  if (spec.log) {
    const bottom = Math.max(10 ** Math.floor(Math.log10(low)), spec.floor ?? 0);
    return [bottom, Math.max(10 ** Math.ceil(Math.log10(high)), bottom * 10)];
  }
  if (spec.symmetric) {
    high = Math.max(-low, high, spec.least ?? 0);
    low = -high;
  }
  if (spec.fromZero) low = 0;
  const air = (high - low || spec.least || 1) * 0.06;
  return [spec.fromZero ? 0 : low - air, high + air];
}

// Round values between two limits, at least `wanted` of them.
function ticks(low, high, wanted) {
  const most = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(most));
  const spacing = power * [5, 2, 1].find((m) => m * power <= most);
  const out = [];
  for (let k = Math.ceil(low / spacing - 1e-9); k * spacing <= high + 1e-9 * spacing; k++) out.push(k * spacing);
  return out;
}

function decades(low, high) {
  const out = [];
  for (let e = Math.ceil(Math.log10(low) - 1e-9); e <= Math.log10(high) + 1e-9; e++) out.push(10 ** e);
  return out;
}

function timeTicks(end, wanted) {
  const spacings = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600];
  const spacing = spacings.find((s) => end / s <= Math.max(2, wanted)) ?? 7200;
  const out = [];
  for (let seconds = 0; seconds <= end; seconds += spacing) out.push(seconds);
  return out;
}
