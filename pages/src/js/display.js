// The run as the map shows it: turned so that the home's wall grid is upright on the screen.

// Radians, at most an eighth of a turn.
function uprightTurn(run) {
  let alpha = NaN;
  for (let i = run.count - 1; i >= 0 && !Number.isFinite(alpha); i--) alpha = run.alpha[i];
  if (!Number.isFinite(alpha)) return 0;
  const quarter = Math.PI / 2;
  return quarter * Math.round(alpha / quarter) - alpha;
}

// Moves of the plane: [x, y] -> R(theta) [x, y] + [tx, ty].
function mover({ x: tx, y: ty, theta }) {
  const c = Math.cos(theta);
  const s = Math.sin(theta);
  return (x, y) => [c * x - s * y + tx, s * x + c * y + ty];
}

function inverseMove({ x, y, theta }) {
  const c = Math.cos(theta);
  const s = Math.sin(theta);
  return { x: -(c * x + s * y), y: s * x - c * y, theta: -theta };
}

function movedPath(path, move) {
  if (!path) return null;
  const place = mover(move);
  const out = { x: path.x.slice(), y: path.y.slice(), theta: path.theta.map((t) => t + move.theta) };
  for (let i = 0; i < out.x.length; i++) [out.x[i], out.y[i]] = place(path.x[i], path.y[i]);
  return out;
}

function movedWall(wall, move) {
  const place = mover(move);
  const out = { ...wall, x0: wall.x0.slice(), y0: wall.y0.slice(), x1: wall.x1.slice(), y1: wall.y1.slice() };
  for (let i = 0; i < wall.at.length; i++) {
    [out.x0[i], out.y0[i]] = place(wall.x0[i], wall.y0[i]);
    [out.x1[i], out.y1[i]] = place(wall.x1[i], wall.y1[i]);
  }
  return out;
}

function movedPlan(plan, move) {
  const place = mover(move);
  return plan.map(([x0, y0, x1, y1]) => [...place(x0, y0), ...place(x1, y1)]);
}

// `truths` holds the true path and plan in both ways to compare: from the common start, and in the best rigid fit.
function displayRun(run) {
  const turn = { x: 0, y: 0, theta: uprightTurn(run) };
  const inStart = { truth: movedPath(run.truth, run.start), plan: movedPlan(run.plan, run.start) };
  const alignment = run.figures.estimate?.alignment;
  const fit = alignment && inverseMove(alignment);
  const inFit = fit && { truth: movedPath(run.truth, fit), plan: movedPlan(run.plan, fit) };
  const turned = ({ truth, plan }) => ({ truth: movedPath(truth, turn), plan: movedPlan(plan, turn) });
  return {
    ...run,
    turn: turn.theta,
    estimate: movedPath(run.estimate, turn),
    odometry: movedPath(movedPath(run.odometry, run.start), turn),
    walls: run.walls.map((wall) => movedWall(wall, turn)),
    truths: { start: turned(inStart), fit: inFit ? turned(inFit) : null },
    ...turned(inStart),
  };
}
