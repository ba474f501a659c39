// Which charts there are, made from what the run has.

const CM = 100;
const cmText = (v) => `${fixed(v, 1)}\u00a0cm`;
const degText = (v) => degrees(v, 2);
const scaled = (values, factor) => values.map((v) => v * factor);

function metresAxis(value) {
  return value >= 1 ? `${Math.round(value)} m` : value >= 0.01 ? `${Math.round(value * 100)} cm` : `${Math.round(value * 1000)} mm`;
}

// Signed error of the estimate with its own 2-sigma bounds.
function boundedError(id, title, note, t, error, sigma, unit) {
  return {
    id, title, note, unit,
    axis: axisNumber,
    symmetric: true,
    series: [
      { kind: "band", label: "2-sigma bounds", colour: "estimate", t, low: sigma.map((s) => -2 * s), high: sigma.map((s) => 2 * s) },
      { kind: "line", label: "Error", colour: "estimate", t, y: error },
    ],
  };
}

function distances(a, b) {
  return a.x.map((x, i) => Math.hypot(x - b.x[i], a.y[i] - b.y[i]));
}

function distanceChart(run) {
  const { t, truth } = run;
  const series = truth
    ? [
      { kind: "line", label: "Estimate", colour: "estimate", t, y: run.truth.error.x.map((x, i) => Math.hypot(x, truth.error.y[i])) },
      { kind: "line", label: "Dead reckoning", colour: "odometry", t, y: distances(run.odometry, truth) },
    ]
    : [{ kind: "line", label: "Estimate from dead reckoning", colour: "odometry", t, y: distances(run.estimateFromStart, run.odometry) }];
  return {
    id: "distance",
    title: truth ? "Distance from the truth" : "Distance from dead reckoning",
    note: truth
      ? "How far each path is from the true position, from a common start. Each line of the scale is ten times the one below."
      : "How far the map has moved the estimate from where the wheels alone would put it.",
    unit: length,
    axis: metresAxis,
    log: true,
    floor: 1e-3,
    series,
  };
}

function errorCharts(run) {
  const { t, truth, sigma } = run;
  const charts = [distanceChart(run)];
  if (truth) {
    charts.push(
      boundedError("heading", "Heading error", "In degrees. It should stay inside the band 95 % of the time.", t,
        scaled(truth.error.theta, DEG), scaled(sigma.theta, DEG), degText),
      boundedError("error-x", "Error along x", "In centimetres, x being straight ahead at the start.", t,
        scaled(truth.error.x, CM), scaled(sigma.x, CM), cmText),
      boundedError("error-y", "Error along y", "In centimetres, y being left at the start.", t,
        scaled(truth.error.y, CM), scaled(sigma.y, CM), cmText),
    );
  } else {
    charts.push({
      id: "sigma",
      title: "Uncertainty of the position",
      note: "The estimator's own 2 sigma along each axis, in centimetres.",
      unit: cmText,
      axis: axisNumber,
      fromZero: true,
      series: [
        { kind: "line", label: "Along x", colour: "one", t, y: scaled(sigma.x, 2 * CM) },
        { kind: "line", label: "Along y", colour: "two", t, y: scaled(sigma.y, 2 * CM), dash: true },
      ],
    });
  }
  return charts;
}

// Squared innovations in units of their variance: a dot for each reading with this outcome.
function nisDots(run, outcome) {
  const t = [];
  const y = [];
  for (let step = 0; step < run.count; step++) {
    for (const sensor of run.sensors) {
      if (sensor.code[step] !== outcome) continue;
      t.push(run.t[step]);
      y.push(sensor.sigmas[step] ** 2);
    }
  }
  return { t, y };
}

// 95 % of a chi-square distribution with three degrees of freedom lies between these.
const NEES_LOW = 0.216;
const NEES_HIGH = 9.348;

function consistencyCharts(run) {
  const { t } = run;
  const charts = [];
  if (run.nees) {
    charts.push({
      id: "nees",
      title: "NEES: pose error against its covariance",
      note: "3 on average for an honest estimator; 95 % of moments inside the band. Above: surer than it should be.",
      unit: plain,
      axis: axisNumber,
      log: true,
      floor: 0.01,
      series: [
        { kind: "band", label: "95 % band", colour: "soft", t: [0, run.end], low: [NEES_LOW, NEES_LOW], high: [NEES_HIGH, NEES_HIGH], quiet: true },
        { kind: "level", label: "Ideal, 3", colour: "soft", y: 3 },
        { kind: "line", label: "NEES", colour: "estimate", t, y: run.nees },
      ],
    });
  }
  charts.push({
    id: "nis",
    title: "NIS: surprise of each reading",
    note: "Innovation squared over its variance: 1 on average for honest error bars. Dots are readings, lines are means of 30 s.",
    unit: plain,
    axis: axisNumber,
    log: true,
    range: [0.01, 100],
    series: [
      { kind: "dots", label: "Reading used", colour: "soft", ...nisDots(run, USED), quiet: true },
      { kind: "dots", label: "Outside the gate", colour: "gated", ...nisDots(run, GATED), quiet: true },
      { kind: "level", label: "Ideal, 1", colour: "soft", y: 1 },
      { kind: "line", label: "Mean of those used", colour: "estimate", t, y: run.nisUsed },
      { kind: "line", label: "Mean with those outside the gate", colour: "estimate", dash: true, t, y: run.nisAll },
    ],
  });
  charts.push({
    id: "walls",
    title: "Walls in the map",
    note: "Rises when a wall is born, falls when two are merged or one is removed.",
    unit: whole,
    axis: (v) => (Number.isInteger(v) ? String(v) : ""),
    fromZero: true,
    least: 1,
    series: [{ kind: "step", label: "Walls", colour: "estimate", t, y: run.wallCount }],
  });
  if (run.alpha.some(Number.isFinite)) charts.push(alphaChart(run));
  return charts;
}

function alphaChart(run) {
  const { t } = run;
  const y = scaled(run.alpha, DEG);
  const s = scaled(run.alphaSigma, 2 * DEG);
  return {
    id: "alpha",
    title: "Direction of the wall grid",
    note: "In degrees from the robot's first heading: the one direction that all grid walls share.",
    unit: degText,
    axis: axisNumber,
    least: 0.5,
    series: [
      { kind: "band", label: "2 sigma", colour: "estimate", t, low: y.map((v, i) => v - s[i]), high: y.map((v, i) => v + s[i]), quiet: true },
      { kind: "line", label: "Alpha", colour: "estimate", t, y },
    ],
  };
}

const PARAMETER_NAMES = {
  scale_left: "Left wheel", scale_right: "Right wheel", track: "Track",
  scale_distance: "Travelled distance", scale_turn: "Turned angle",
};

function parameterName(name) {
  return PARAMETER_NAMES[name] ?? name.replace(/^gain_(.*)$/, "Gain, $1");
}

// Largest deviation from 1 that a group of parameters and their bands show, percent. The wide bands of the first
// moments may leave the chart.
function widestDeviation(parameters) {
  let most = 0.2;
  for (const p of parameters) {
    const settled = Math.floor(p.value.length * 0.1);
    p.value.forEach((v, i) => {
      const size = 100 * (Math.abs(v - 1) + (i < settled ? 0 : 2 * p.sigma[i]));
      if (Number.isFinite(size)) most = Math.max(most, size);
    });
    if (Number.isFinite(p.truth)) most = Math.max(most, 100 * Math.abs(p.truth - 1));
  }
  return most;
}

// Small multiples: gains on one common scale and motion on another, so that they can be compared.
function calibrationCharts(run) {
  // A parameter without uncertainty is not estimated; the veer is no factor.
  const estimated = run.calibration.parameters.filter((p) => p.name !== "veer" && p.sigma.some((s) => s > 0));
  const groups = [(p) => p.name.startsWith("gain_"), (p) => !p.name.startsWith("gain_")].map((f) => estimated.filter(f));
  return groups.flatMap((group) => group.map((p) => calibrationChart(run, p, 1.05 * widestDeviation(group))));
}

function calibrationChart(run, p, most) {
  const { t } = run.calibration;
  const y = p.value.map((v) => 100 * (v - 1));
  const band = (sign) => y.map((v, i) => v + sign * 200 * p.sigma[i]);
  const series = [
    { kind: "band", label: "2 sigma", colour: "estimate", t, low: band(-1), high: band(1), quiet: true },
    { kind: "line", label: "Estimate", colour: "estimate", t, y },
  ];
  const known = Number.isFinite(p.truth);
  if (known) series.push({ kind: "level", label: "True", colour: "ink", y: 100 * (p.truth - 1), dash: true });
  const last = p.value.length - 1;
  return {
    id: `calibration-${p.name}`,
    title: parameterName(p.name),
    note: `${signedPercent(p.value[last])} \u00b1 ${fixed(200 * p.sigma[last], 2)} %${known ? `, true ${signedPercent(p.truth)}` : ""}`,
    unit: (v) => `${fixed(v, 2)} %`,
    axis: axisNumber,
    range: [-most, most],
    small: true,
    series,
  };
}

function signedPercent(factor) {
  const value = 100 * (factor - 1);
  return `${value > 0 ? "+" : ""}${fixed(value, 2)} %`;
}
