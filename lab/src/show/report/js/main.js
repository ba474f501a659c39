// Puts the page together.

function allCharts(run, clock) {
  document.getElementById("errors-note").textContent = run.truth
    ? "Against the true path, from a common start. The shaded bounds are the estimator's own 2 sigma."
    : "The true path is not known, so only the estimator's own view can be shown.";
  document.getElementById("calibration-section").hidden = !run.calibration.parameters.length || !run.calibration.t.length;
  return [
    ...addCharts("error-charts", errorCharts(run), clock),
    ...addCharts("consistency-charts", consistencyCharts(run), clock),
    ...addCharts("calibration-charts", calibrationCharts(run), clock),
  ];
}

// `#t=83.4&theme=dark&colour=pass&place=odometry` opens the page at a moment, in a theme, with a colouring and placing.
function openAtAddress(clock, chooseTheme, colouring) {
  const wish = new URLSearchParams(location.hash.slice(1));
  document.querySelector(`[data-placing="${CSS.escape(wish.get("place") ?? "")}"]`)?.click();
  if (["light", "dark"].includes(wish.get("theme"))) chooseTheme(wish.get("theme"));
  document.querySelector(`[data-colouring="${CSS.escape(wish.get("colour") ?? colouring)}"]`)?.click();
  const seconds = Number.parseFloat(wish.get("t"));
  if (Number.isFinite(seconds)) clock.seek(seconds);
}

function start() {
  const run = decode(JSON.parse(document.getElementById("data").textContent));
  const shown = displayRun(run);
  const hits = collectHits(shown);
  const clock = new Clock(run);
  const map = new MapView(document.getElementById("map"), shown, hits, clock);
  document.getElementById("map-empty").hidden = run.count > 0;
  showFigures(run);
  fillWallTable(shown, map);
  fillCounts(run);
  showTimeLegend(run);
  const charts = [...allCharts(run, clock), ...showFloor(run.floor, run, clock), ...showPlace(run, clock)];
  showHandOvers(run, map, clock);
  const trace = new TraceTable(run);
  const redraw = () => {
    const theme = readTheme();
    map.setTheme(theme);
    drawBirths(document.getElementById("births"), run, theme);
    for (const chart of charts) chart.draw(theme);
  };
  // Without a plan to hold it against, a map shows whether it is right by its passes, and less is more.
  const isReal = !run.plan.length;
  map.shown.odometry = !isReal;
  buildLayerToggles(map, run);
  bindMapControls(map);
  bindMapTip(map, run, hits, clock);
  bindTransport(clock);
  clock.onChange(() => map.draw());
  clock.onChange(() => trace.show(clock.step));
  const chooseTheme = bindTheme(redraw);
  showHitClasses(map);
  redraw();
  clock.announce();
  new ResizeObserver(() => {
    if (map.view.untouched) map.view.fitAll();
    redraw();
  }).observe(document.querySelector("main"));
  openAtAddress(clock, chooseTheme, isReal ? "pass" : "outcome");
  const stride = run.stride > 1 ? ` Every ${run.stride}th sample is shown.` : "";
  document.getElementById("eyebrow").textContent = run.seed === null ? "Replayed log" : `Simulated drive, seed ${run.seed}`;
  document.getElementById("foot").textContent = `Written by ${run.program}.${stride} This page needs no network.`;
  document.documentElement.dataset.ready = "true";
}

start();
