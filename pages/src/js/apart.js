// Walls that different visits place apart: where the map contradicts itself.

// From here on the visits of a wall are apart, metres.
const APART_M = 0.15;

// This many walls carry their figure however small the map is drawn.
const APART_LABELS = 5;

// The finished map's walls whose visits are apart, the widest first.
function wallsApart(run) {
  return run.walls.filter((wall) => wall.gap > APART_M && wall.gone === Infinity).sort((a, b) => b.gap - a.gap);
}

// A band along each such wall, as wide as its visits are apart.
function paintApartBands(map) {
  const { context, view, theme, clock } = map;
  context.lineCap = "butt";
  context.strokeStyle = translucent(theme.apart, 0.3);
  for (const wall of wallsApart(map.run)) {
    const ends = wallAt(wall, clock.step);
    if (!ends) continue;
    context.lineWidth = Math.max(9, Math.min(40, wall.gap * view.scale));
    map.stroke(ends.x0, ends.y0, ends.x1, ends.y1);
  }
}

// How far the visits are apart: of every such wall where the map is drawn large, of the worst ones otherwise.
function paintApartLabels(map) {
  const { context, view, theme, clock } = map;
  context.font = `600 12px ${theme.font}`;
  context.textAlign = "center";
  context.lineJoin = "round";
  context.lineWidth = 4;
  context.strokeStyle = theme.card;
  context.fillStyle = theme.apart;
  const walls = wallsApart(map.run);
  for (const wall of view.scale < 60 ? walls.slice(0, APART_LABELS) : walls) {
    const ends = wallAt(wall, clock.step);
    if (!ends) continue;
    const [px, py] = view.toScreen((ends.x0 + ends.x1) / 2, (ends.y0 + ends.y1) / 2);
    context.strokeText(length(wall.gap), px, py + 4);
    context.fillText(length(wall.gap), px, py + 4);
  }
}
