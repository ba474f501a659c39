// What pictures of a home have in common.

// A picture that has its colours in `theme` and paints itself in `paint`: once a frame, however often it is asked to.
class Picture {
  draw() {
    if (!this.theme || this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.paint();
    });
  }
}

// Distance between the lines that hatch an area, pixels.
const HATCH_PX = 10;

// Areas to stay out of are hatched, areas to clean outlined; `keep_out` and `clean` have their corners, `toScreen` places these.
function paintAreas(context, { keep_out: keepOut = [], clean = [] }, toScreen, theme) {
  const outline = (corners) => {
    context.beginPath();
    for (const [x, y] of corners) context.lineTo(...toScreen(x, y));
    context.closePath();
  };
  context.lineWidth = 1.5;
  context.strokeStyle = theme.soft;
  for (const corners of keepOut) {
    outline(corners);
    context.stroke();
    context.save();
    context.clip();
    context.beginPath();
    const { width, height } = context.canvas;
    for (let x = -height; x < width; x += HATCH_PX) {
      context.moveTo(x, 0);
      context.lineTo(x + height, height);
    }
    context.stroke();
    context.restore();
  }
  context.setLineDash([6, 4]);
  for (const corners of clean) {
    outline(corners);
    context.stroke();
  }
  context.setLineDash([]);
}
