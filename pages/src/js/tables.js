// Tables: the readings of the moment, the walls of the finished map, the fate of all readings.

const OUTCOME_TEXT = ["No reading", "Used", "Outside the gate", "Met no known wall"];

function outcomeText(run, code) {
  return OUTCOME_TEXT[code] ?? `Refused: ${run.refusals[code - REFUSED] ?? "unknown"}`;
}

function outcomeColour(code) {
  return code === MISSING ? "line" : OUTCOMES[Math.min(code, REFUSED) - USED].colour;
}

// Rows are made once and filled at every moment.
class TraceTable {
  constructor(run) {
    this.run = run;
    this.pose = document.getElementById("pose");
    this.rows = run.sensors.map((sensor) => {
      const cells = {
        range: element("td", { class: "num" }),
        outcome: element("td", {}),
        wall: element("td", { class: "num" }),
        innovation: element("td", { class: "num" }),
        bar: element("span", {}),
      };
      cells.dot = element("span", { class: "dot" });
      cells.text = element("span", {});
      cells.outcome.append(cells.dot, cells.text);
      cells.row = element("tr", {}, element("th", { scope: "row" }, sensor.name), cells.range, cells.outcome, cells.wall,
        cells.innovation, element("td", {}, element("div", { class: "sigma-bar", "aria-hidden": "true" }, cells.bar)));
      return cells;
    });
    const body = document.querySelector("#trace tbody");
    body.replaceChildren(...this.rows.map((cells) => cells.row));
    if (!this.rows.length) body.append(element("tr", {}, element("td", { colspan: "6" }, "This robot has no range sensors.")));
  }

  show(step) {
    const { run } = this;
    if (!run.count) return;
    run.sensors.forEach((sensor, i) => {
      const cells = this.rows[i];
      const code = sensor.code[step];
      const sigmas = sensor.sigmas[step];
      cells.range.textContent = Number.isFinite(sensor.range[step]) ? `${fixed(sensor.range[step], 3)}\u00a0m` : NONE;
      cells.text.textContent = outcomeText(run, code);
      cells.dot.style.setProperty("--c", `var(--${outcomeColour(code)})`);
      cells.wall.textContent = sensor.wall[step] >= 0 ? sensor.wall[step] : NONE;
      cells.innovation.textContent = Number.isFinite(sigmas)
        ? `${sigmas > 0 ? "+" : ""}${fixed(sigmas, 2)}\u03c3 (${fixed(sigmas * sensor.sigma[step] * 1000, 0)}\u00a0mm)` : NONE;
      const share = Number.isFinite(sigmas) ? Math.max(-1, Math.min(1, sigmas / 3)) : 0;
      cells.bar.style.left = `${50 + Math.min(0, share) * 50}%`;
      cells.bar.style.width = `${Math.abs(share) * 50}%`;
      cells.bar.style.background = `var(--${outcomeColour(code)})`;
    });
    this.showPose(step);
  }

  showPose(step) {
    const { run } = this;
    const { x, y, theta } = run.estimate;
    const rows = [
      ["Position", `${fixed(x[step], 3)}, ${fixed(y[step], 3)} m`],
      ["2 sigma", `${length(2 * run.sigma.x[step])}, ${length(2 * run.sigma.y[step])}`],
      ["Heading", `${degrees(theta[step] * DEG, 1)} \u00b1 ${degrees(2 * run.sigma.theta[step] * DEG)}`],
      ["Grid", Number.isFinite(run.alpha[step]) ? degrees(run.alpha[step] * DEG) : "none yet"],
      ["Walls", whole(run.wallCount[step])],
    ];
    if (run.truth) {
      const { error } = run.truth;
      rows.push(["Position error", length(Math.hypot(error.x[step], error.y[step]))],
        ["Heading error", degrees(error.theta[step] * DEG)]);
    }
    this.pose.replaceChildren(...rows.map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value))));
  }
}

// The finished map's walls, the ones whose visits disagree most first.
function fillWallTable(run, map) {
  const walls = run.walls.map((wall) => ({ wall, ends: wallAt(wall, run.count - 1) })).filter(({ ends }) => ends);
  for (const entry of walls) entry.size = Math.hypot(entry.ends.x1 - entry.ends.x0, entry.ends.y1 - entry.ends.y0);
  walls.sort((a, b) => (b.wall.gap || 0) - (a.wall.gap || 0) || b.size - a.size);
  document.getElementById("walls-note").textContent = walls.length
    ? `Thickness is the root mean square distance of the hits from the wall's line; visits apart is how far the means of visits more than ${PASS_GAP_S} s apart lie from each other. Both are small where the map is right. Choose a wall to see it on the map.`
    : "The finished map has no walls.";
  document.querySelector("#walls tbody").replaceChildren(...walls.map((entry) => wallRow(entry, map)));
  document.querySelector("#walls").hidden = !walls.length;
}

function wallRow({ wall, ends, size }, map) {
  const button = element("button", { type: "button", class: "link" }, `Wall ${wall.id}`);
  const number = (text) => element("td", { class: "num" }, text);
  const row = element("tr", {}, element("th", { scope: "row" }, button), element("td", {}, wall.kind), number(length(size)),
    number(length(ends.sigma)), number(whole(wall.updates)), number(whole(wall.visits)), number(length(wall.thickness)), number(length(wall.gap)));
  const mark = (id) => {
    map.highlight = id;
    map.draw();
  };
  row.addEventListener("pointerenter", () => mark(wall.id));
  row.addEventListener("pointerleave", () => mark(null));
  button.addEventListener("click", () => {
    mark(wall.id);
    map.showAround(ends);
    map.canvas.scrollIntoView({ block: "center" });
  });
  return row;
}

// One bar per fate, widest first.
function fillCounts(run) {
  const total = run.counts.reduce((sum, [, n]) => sum + n, 0);
  const rows = run.counts.filter(([, n]) => n > 0).sort((a, b) => b[1] - a[1]).map(([code, n]) => {
    const share = (100 * n) / total;
    return element("div", { class: "count-row" },
      element("span", {}, outcomeText(run, code)),
      element("span", { class: "track", "aria-hidden": "true" },
        element("span", { class: "bar", style: `--w:${Math.max(0.3, share)}%;--c:var(--${outcomeColour(code)})` })),
      element("span", { class: "num" }, `${whole(n)}\u2002(${fixed(share, 1)} %)`));
  });
  document.getElementById("counts").replaceChildren(...(rows.length ? rows : [element("p", { class: "note" }, "There were none.")]));
  fillSensorCounts(run);
}

// What became of each sensor's readings; the studio counts them together alone.
function fillSensorCounts(run) {
  const table = document.getElementById("sensor-counts");
  table.hidden = !run.sensorCounts?.length;
  if (table.hidden) return;
  const cell = (text) => element("td", { class: "num" }, text);
  const row = (counts, i) => {
    const of = (wanted) => counts.filter(([code]) => wanted(code)).reduce((sum, [, n]) => sum + n, 0);
    const all = of((code) => code !== MISSING);
    const share = (n) => (all ? percent(n / all) : NONE);
    const [code, most] = counts.filter(([one]) => one >= REFUSED).sort((a, b) => b[1] - a[1])[0] ?? [];
    const why = most ? `${run.refusals[code - REFUSED]} ${share(most)}` : NONE;
    const used = of((one) => one === USED);
    return element("tr", { class: used ? "" : "unused", "data-sensor": run.sensors[i].name },
      element("th", { scope: "row" }, run.sensors[i].name), cell(whole(all)), cell(share(used)), cell(share(of((one) => one === GATED))),
      cell(share(of((one) => one === UNEXPLAINED))), cell(share(of((one) => one >= REFUSED))), element("td", {}, why),
      cell(whole(of((one) => one === MISSING))));
  };
  table.querySelector("tbody").replaceChildren(...run.sensorCounts.map(row));
}
