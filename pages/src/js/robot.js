// The robot at one moment: outline, heading, 2-sigma ellipse of its position, beams.

const ROBOT_RADIUS_M = 0.16;

function paintRobot(map, step) {
  const { context, run, theme } = map;
  if (run.truth && map.shown.truth) paintOutline(map, run.truth, step, theme.truth, [3, 3]);
  if (map.shown.odometry) paintOutline(map, run.odometry, step, theme.odometry, []);
  paintBeams(map, step);
  const { x, y } = run.estimate;
  if (!Number.isFinite(x[step]) || !Number.isFinite(y[step])) return;
  paintEllipse(map, step);
  context.fillStyle = translucent(theme.card, 0.7);
  context.beginPath();
  context.arc(...map.view.toScreen(x[step], y[step]), robotRadius(map), 0, 2 * Math.PI);
  context.fill();
  paintOutline(map, run.estimate, step, theme.estimate, []);
}

// Pixels; never so small that it cannot be found.
function robotRadius(map) {
  return Math.max(6, ROBOT_RADIUS_M * map.view.scale);
}

function paintOutline(map, path, step, colour, dash) {
  const { context } = map;
  if (!Number.isFinite(path.x[step]) || !Number.isFinite(path.theta[step])) return;
  const [px, py] = map.view.toScreen(path.x[step], path.y[step]);
  const radius = robotRadius(map);
  const c = Math.cos(path.theta[step]);
  const s = Math.sin(path.theta[step]);
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.setLineDash(dash);
  context.beginPath();
  context.arc(px, py, radius, 0, 2 * Math.PI);
  context.moveTo(px, py);
  context.lineTo(px + c * radius, py - s * radius);
  context.stroke();
  context.setLineDash([]);
}

function paintBeams(map, step) {
  const { context, run, theme } = map;
  for (const sensor of run.sensors) {
    const ray = beam(run.estimate, sensor, step);
    if (!ray || !Number.isFinite(ray.x1)) continue;
    const colour = theme[OUTCOMES[Math.min(sensor.code[step], REFUSED) - USED]?.colour ?? "soft"];
    context.strokeStyle = translucent(colour, 0.8);
    context.lineWidth = 1.5;
    map.stroke(ray.x0, ray.y0, ray.x1, ray.y1);
    context.fillStyle = colour;
    context.beginPath();
    context.arc(...map.view.toScreen(ray.x1, ray.y1), 4, 0, 2 * Math.PI);
    context.fill();
  }
}

// The 2-sigma contour of the position's covariance, from its eigenvectors.
function paintEllipse(map, step) {
  const { context, run, theme, view } = map;
  const sx = run.sigma.x[step];
  const sy = run.sigma.y[step];
  const cross = run.correlation[step] * sx * sy;
  const mean = (sx * sx + sy * sy) / 2;
  const difference = (sx * sx - sy * sy) / 2;
  const root = Math.hypot(difference, cross);
  const major = 2 * Math.sqrt(Math.max(0, mean + root));
  const minor = 2 * Math.sqrt(Math.max(0, mean - root));
  if (!Number.isFinite(major)) return;
  const [px, py] = view.toScreen(run.estimate.x[step], run.estimate.y[step]);
  const angle = 0.5 * Math.atan2(cross, difference) + run.turn;
  context.beginPath();
  // The screen's y axis points down, so a counter-clockwise angle is negative there.
  context.ellipse(px, py, major * view.scale, minor * view.scale, -angle, 0, 2 * Math.PI);
  context.fillStyle = translucent(theme.estimate, 0.2);
  context.strokeStyle = translucent(theme.estimate, 0.8);
  context.lineWidth = 1;
  context.fill();
  context.stroke();
}
