// Where the robot knew its place, what its searches found, and what look backs changed.
//
// Of a run: `handOvers` with the shown step after each, the one before, why it was `refused` (null: taken over), `moved_m` and
// `turned_rad`; `searches` with the shown step, the log odds of the best place, and walls of the fresh map and those matched;
// `lost`, pairs of shown steps between which the robot did not know its place; `condition`, how the estimator was, or null.

// Odds of a thousand to one, as a power of ten: from there on a place is claimed.
const CLAIMED = 3;
// Odds beyond this power of ten are drawn there.
const ODDS_SPAN = 9;

function decodeEvents(raw) {
  const lost = raw?.lost ?? [];
  // Where the frame changed, paths are broken.
  const condition = raw?.condition ?? null;
  return { handOvers: raw?.hand_overs ?? [], searches: raw?.searches ?? [], lost, condition, breaks: new Set(lost.flat()) };
}

// On the time line: bands where the estimator was not well and where the robot did not know its place, and a bar for each
// hand-over, hollow where it was refused.
function drawEvents({ context, width, height }, run, theme, xOf) {
  context.fillStyle = translucent(theme.gated, 0.6);
  for (const { begin_s: begin, end_s: end } of run.condition?.unwell ?? []) {
    const [from, to] = [stepAt(run, begin), stepAt(run, end ?? run.end)].map(xOf);
    context.fillRect(from, 0, Math.max(2, to - from), height);
  }
  context.fillStyle = translucent(theme.apart, 0.35);
  for (const [from, to] of run.lost ?? []) context.fillRect(xOf(from), 0, Math.max(2, xOf(to) - xOf(from)), height);
  for (const { step, refused } of run.handOvers ?? []) {
    context.fillStyle = context.strokeStyle = theme.estimate;
    context.lineWidth = 1;
    const x = Math.round(xOf(step));
    if (refused) context.strokeRect(x - 1.5, 0.5, 3, height - 1);
    else context.fillRect(x - 2, 0, 4, height);
  }
}

// What the marks on the time line are.
function showTimeLegend(run) {
  const marks = [
    ["soft", "A wall was born", run.walls.length],
    ["gated", "Estimator not well", run.condition?.unwell.length],
    ["apart", "Place not known", run.lost.length],
    ["estimate", "A look back was taken over, or refused (hollow)", run.handOvers.length],
  ];
  const entry = ([colour, label]) => element("li", {}, element("span", { class: "dot", style: `--c:var(--${colour})` }), label);
  document.getElementById("time-legend").replaceChildren(...marks.filter(([, , count]) => count > 0).map(entry));
}

// Odds of the best place over time.
function oddsChart(run) {
  const at = (step) => run.t[Math.min(step, run.count - 1)];
  const edges = run.lost.flatMap(([from, to]) => [[at(from), -ODDS_SPAN, ODDS_SPAN], [at(to), -ODDS_SPAN, ODDS_SPAN], [at(to), NaN, NaN]]);
  const powers = run.searches.map(({ log_odds: odds }) => Math.max(-ODDS_SPAN, Math.min(ODDS_SPAN, odds / Math.LN10)));
  const t = run.searches.map(({ step }) => at(step));
  const text = (power) => (Math.abs(power) >= ODDS_SPAN ? `beyond ${powerOfTen(fixed(power, 0))}` : powerOfTen(fixed(power, 1)));
  return {
    id: "odds",
    title: "Odds of the best place",
    note: "Against all other places and elsewhere, as found by each search. The robot claims a place at a thousand to one.",
    unit: text,
    axis: (power) => powerOfTen(axisNumber(power)),
    range: [-ODDS_SPAN, ODDS_SPAN],
    series: [
      { kind: "band", label: "Place not known", colour: "apart", t: edges.map(([s]) => s), low: edges.map(([, low]) => low), high: edges.map(([, , high]) => high), quiet: true },
      { kind: "level", label: "A thousand to one", colour: "soft", y: CLAIMED },
      { kind: "step", label: "Odds", colour: "estimate", t, y: powers },
    ],
  };
}

function placeNote(run) {
  const seconds = run.lost.reduce((sum, [from, to]) => sum + run.t[Math.min(to, run.count - 1)] - run.t[from], 0);
  const last = run.lost.at(-1);
  const found = last && last[1] < run.count ? `It knew its place again from ${clockTime(run.t[last[1]])} on.` : "At the end it did not know it.";
  const wholly = run.searches.length === 1 ? "one search" : `${whole(run.searches.length)} searches`;
  return `For ${duration(seconds)} the robot did not know where it was in the map that it keeps (shaded here and on the time line). Path and walls are of a fresh map then, drawn where it was found to lie; the kept map is dashed. ${found} It made ${wholly}.`;
}

// The section of a robot that looked for its place; gives its charts.
function showPlace(run, clock) {
  const isShown = run.lost.length > 0;
  document.getElementById("place-section").hidden = !isShown;
  if (!isShown) return [];
  document.getElementById("place-note").textContent = placeNote(run);
  const rows = run.searches.map(({ step, log_odds: odds, walls: [walls, matched] }) => element("tr", {},
    element("th", { scope: "row" }, momentButton(run, clock, step)),
    element("td", { class: "num" }, whole(walls)), element("td", { class: "num" }, whole(matched)),
    element("td", { class: "num" }, powerOfTen(fixed(odds / Math.LN10, 1)))));
  document.querySelector("#searches tbody").replaceChildren(...rows);
  document.getElementById("searches").hidden = !rows.length;
  return addCharts("place-charts", rows.length ? [oddsChart(run)] : [], clock);
}

// A time that the page goes to.
function momentButton(run, clock, step) {
  const button = element("button", { type: "button", class: "link" }, clockTime(run.t[step]));
  button.addEventListener("click", () => {
    clock.play(false);
    clock.seekStep(step);
  });
  return button;
}

// The table of hand-overs; a choice shows the map before or after one, with the other drawn dashed.
function showHandOvers(run, map, clock) {
  document.getElementById("hand-overs-section").hidden = !run.handOvers.length;
  const rows = run.handOvers.map(({ step, before, refused, moved_m: moved, turned_rad: turned }) => {
    const show = (name, now, beside) => {
      const button = element("button", { type: "button" }, name);
      button.addEventListener("click", () => {
        clock.play(false);
        map.beside = { step: now, at: beside };
        clock.seekStep(now);
        map.canvas.scrollIntoView({ block: "center" });
      });
      return button;
    };
    const moment = momentButton(run, clock, step);
    moment.addEventListener("click", () => (map.beside = null));
    return element("tr", { "data-hand-over": refused ?? "taken" },
      element("th", { scope: "row" }, moment),
      element("td", {}, refused ? `refused: ${refused.replace("_", " ")}` : "taken over"),
      element("td", { class: "num" }, refused ? NONE : length(moved)), element("td", { class: "num" }, refused ? NONE : degrees(turned * DEG)),
      element("td", { class: "choices" }, ...(refused ? [] : [show("Before", before, step), show("After", step, before)])));
  });
  document.querySelector("#hand-overs tbody").replaceChildren(...rows);
}
