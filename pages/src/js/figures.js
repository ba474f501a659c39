// The headline: a sentence, and figures with what they mean.

function verdict(run) {
  const { estimate, odometry, path_m: path } = run.figures;
  if (!run.count) return "The log held no samples.";
  const drive = `${length(path)} in ${duration(run.figures.duration_s)}`;
  const walls = `${whole(run.figures.walls)} ${run.figures.walls === 1 ? "wall" : "walls"}`;
  if (estimate && odometry && Number.isFinite(estimate.ate_m)) {
    const times = odometry.ate_m / estimate.ate_m;
    const versus = times >= 1.05
      ? `${times >= 10 ? fixed(times, 0) : fixed(times, 1)} times closer than dead reckoning`
      : times > 0.95 ? "about as far as dead reckoning" : "worse than dead reckoning";
    return `${drive}: the estimated path lies ${length(estimate.ate_m)} from the true one, ${versus}; ${walls} in the map.${placeWords(run.figures.lost)}`;
  }
  const consistency = run.figures.consistency;
  const apart = Number.isFinite(consistency?.apart_m ?? NaN)
    ? ` Different visits see one surface ${length(consistency.apart_m)} apart${Number.isFinite(consistency.odometry_apart_m ?? NaN) ? `, dead reckoning ${length(consistency.odometry_apart_m)}` : ""}.` : "";
  return `${drive}, ${walls} in the map. ${truthWords(run)}${apart}${placeWords(run.figures.lost)}`;
}

function truthWords({ figures, plan }) {
  return figures.lost === 1 && plan.length ? "There is no path in the map that it began in." : "The true path is not known.";
}

// Of the time in which the robot did not know its place; the studio does not count it.
function placeWords(lost) {
  if (!(lost > 0)) return "";
  if (lost === 1) return " The robot never found itself in the map that it began in.";
  return ` For ${percent(lost)} of the time it did not know its place; no error counts that.`;
}

// How the estimator was, and what it noticed of what befell the robot.
function conditionFigure({ at_end: atEnd, unwell, jolts, holds, restarts }) {
  const stretch = ({ what, begin_s: begin, end_s: end }) => `${what} from ${clockTime(begin)} to ${end === null ? "the end" : clockTime(end)}`;
  const most = 3;
  const more = unwell.length > most ? ` and ${unwell.length - most} times more` : "";
  const illness = unwell.length ? `Not well: ${unwell.slice(0, most).map(stretch).join(", ")}${more}.` : "It was well all the time.";
  const times = (count) => (count === 1 ? "once" : `${whole(count)} times`);
  return { id: "health", name: "Estimator", value: atEnd === "well" ? "Well" : "Not well",
    note: `${illness} Jolts that readings undid: ${whole(jolts)}; times that something held the robot: ${whole(holds)}. Its map was begun anew ${restarts ? times(restarts) : "never"}.` };
}

// A figure with its comparison, if there is one: the bar shows the estimate's share of dead reckoning's error.
function figureCard({ id, name, value, note, estimate, odometry, text }) {
  const card = element("div", { class: "card figure", "data-figure": id },
    element("h3", {}, name), element("p", { class: "value" }, value));
  if (Number.isFinite(odometry)) {
    const share = Math.min(1, Math.max(0.005, estimate / Math.max(estimate, odometry)));
    const other = Math.min(1, Math.max(0.005, odometry / Math.max(estimate, odometry)));
    card.append(element("div", { class: "bars", "aria-hidden": "true" },
      element("span", { class: "bar", style: `--w:${share * 100}%;--c:var(--estimate)` }),
      element("span", { class: "bar", style: `--w:${other * 100}%;--c:var(--odometry)` })),
    element("p", { class: "versus" }, `Dead reckoning: ${text(odometry)}`));
  }
  card.append(element("p", { class: "note" }, note));
  return card;
}

function honesty(nees) {
  if (nees < 1) return "More cautious than it needs to be.";
  if (nees <= 6) return "Its error bars can be believed.";
  if (nees <= 20) return "Somewhat surer than it should be.";
  return "Much surer than it should be.";
}

function truthFigures({ estimate, odometry }) {
  const compare = (key, text) => ({ estimate: estimate[key], odometry: odometry?.[key], value: text(estimate[key] ?? NaN), text });
  const cards = [
    { id: "ate", name: "Path error", ...compare("ate_m", length),
      note: "ATE: root mean square distance from the true path after the best rigid alignment. The shape of the path." },
    { id: "start", name: "Error from the start", ...compare("start_m", length),
      note: "The same without alignment: both paths start at one pose, so an early turn of the whole map counts." },
    { id: "heading", name: "Heading error", ...compare("heading_deg", degrees),
      note: "Root mean square, the alignment's rotation removed." },
  ];
  return cards.filter(({ estimate: known }) => Number.isFinite(known));
}

function visitsNote({ revisited, widest_gap_m: widest, closure_m: closure }) {
  const typical = `How far visits more than ${PASS_GAP_S} s apart see one surface apart: the median over all places.`;
  if (!revisited) return typical;
  const last = Number.isFinite(closure ?? NaN) ? `; from first visit to last ${length(closure)}` : "";
  return `${typical} Of ${revisited} walls seen again at most ${length(widest)}${last}.`;
}

// Scores of the map against itself, which need no truth.
function consistencyFigures(consistency) {
  const cards = [];
  if (!consistency) return cards;
  const gain = (consistency.odometry_entropy_nats ?? NaN) - (consistency.entropy_nats ?? NaN);
  if (Number.isFinite(gain)) {
    const sharper = gain >= 0.005 ? "sharper than" : gain > -0.005 ? "as sharp as" : "more blurred than";
    cards.push({ id: "sharpness", name: "Sharpness", value: `${gain > 0 ? "+" : ""}${fixed(gain, 2)}`,
      note: `Mean map entropy of the hits in nats, dead reckoning's minus the estimate's: the map is ${sharper} without SLAM.` });
  }
  if (Number.isFinite(consistency.apart_m ?? NaN)) {
    cards.push({ id: "visits", name: "Visits apart", value: length(consistency.apart_m), text: length,
      estimate: consistency.apart_m, odometry: consistency.odometry_apart_m ?? NaN, note: visitsNote(consistency) });
  }
  return cards;
}

function showFigures(run) {
  const f = run.figures;
  document.getElementById("verdict").textContent = verdict(run);
  const cards = run.condition ? [conditionFigure(run.condition)] : [];
  if (f.lost > 0) {
    cards.push({ id: "place", name: "Place known", value: percent(1 - f.lost),
      note: "Share of the time in which the robot claimed to know where it is. Errors are of that time alone." });
  }
  if (Number.isFinite(f.estimate?.nees)) {
    cards.push({ id: "nees", name: "NEES", value: plain(f.estimate.nees),
      note: `Squared pose error in units of the estimator's own covariance; 3 is ideal. ${honesty(f.estimate.nees)}` });
  }
  cards.push({ id: "nis", name: "NIS", value: plain(f.mean_nis ?? NaN),
    note: "Mean squared surprise of the readings used, in units of its expected size; 1 is ideal, more means sensors worse than the rig file says." });
  cards.push(...consistencyFigures(f.consistency));
  const offset = Number.isFinite(f.map?.offset_m) ? ` within ${length(f.map.offset_m)} (RMS)` : "";
  const against = f.map
    ? `${f.map.matched} match the true plan${offset}; ${f.map.missed} missed, ${f.map.invented} invented.`
    : "Straight pieces in the finished map.";
  cards.push(
    { id: "walls", name: "Walls", value: whole(f.walls), note: against },
    { id: "path", name: "Drive", value: length(f.path_m), note: driveNote(f) },
  );
  document.getElementById("accuracy").replaceChildren(...(f.estimate ? truthFigures(f) : []).map(figureCard));
  document.getElementById("figures").replaceChildren(...cards.map(figureCard));
}

function driveNote({ duration_s: driven, estimator_s: computed }) {
  const time = `Length by the motion sensors alone, in ${duration(driven)}.`;
  if (!(computed > 0) || !(driven > 0)) return time;
  const took = computed < 1 ? `${fixed(1000 * computed, 0)}\u00a0ms` : `${fixed(computed, 1)}\u00a0s`;
  return `${time} The estimator took ${took}: ${whole(driven / computed)} times faster.`;
}
