// The map with what only a live page shows: how sure each wall is.

LAYERS.splice(LAYERS.length - 1, 0, { id: "places", label: "Places that it may be at", swatch: "ring", colour: "apart" });
LAYERS.splice(2, 0, { id: "sigma", label: "Walls, 2 sigma, drawn tenfold", swatch: "glow", colour: "estimate" });

class LiveMap extends MapView {
  // Walls of a kept map while the robot searches it, and what is being drawn; x0, y0, x1, y1.
  ghost = [];
  sketch = [];
  // Where a robot that searches may be: place, heading, share of the odds.
  places = [];
  // The floor of a robot that sweeps it.
  floor = null;
  // Areas to stay out of and to clean: their corners, and what leads from these to the map on the screen.
  areas = {};
  toShown = (x, y) => [x, y];
  // The look back.
  back = null;

  paintGrid(surface) {
    super.paintGrid(surface);
    if (this.floor && this.shown.floor) this.floor.paint(this);
    paintAreas(this.context, this.areas, (x, y) => this.view.toScreen(...this.toShown(x, y)), this.theme);
  }

  paint() {
    super.paint();
    this.back.paint(this);
    if (this.shown.places) this.places.forEach((place) => this.paintPlace(place));
    this.paintSegments(this.ghost, this.theme.estimate, 2.5);
    this.paintSegments(this.sketch, this.theme.estimate, 4);
  }

  paintSegments(segments, colour, width) {
    const { context } = this;
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash([7, 5]);
    for (const segment of segments) this.stroke(...segment);
    context.setLineDash([]);
  }

  // A ring with a heading, the likelier the bolder, with its share where that is worth words.
  paintPlace({ at, heading, share }) {
    const { context, theme, view } = this;
    const [px, py] = view.toScreen(...at);
    const radius = Math.max(9, 0.17 * view.scale);
    context.strokeStyle = context.fillStyle = theme.apart;
    context.globalAlpha = Math.max(0.35, share);
    context.lineWidth = 1.5 + 2.5 * share;
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.moveTo(px, py);
    context.lineTo(px + 1.6 * radius * Math.cos(heading), py - 1.6 * radius * Math.sin(heading));
    context.stroke();
    context.globalAlpha = 1;
    if (share < 0.01) return;
    context.font = `600 13px ${theme.font}`;
    context.textAlign = "left";
    const words = `${fixed(100 * share, 0)}\u00a0%`;
    context.strokeStyle = theme.card;
    context.lineWidth = 4;
    context.strokeText(words, px + radius + 4, py - radius);
    context.fillText(words, px + radius + 4, py - radius);
  }

  paintWalls() {
    if (this.shown.sigma) this.paintSigmas();
    super.paintWalls();
  }

  // A band ten times as wide as the wall's place is unsure: to scale it would be hidden by the wall's line.
  paintSigmas() {
    const { context, theme, view } = this;
    context.lineCap = "butt";
    context.strokeStyle = translucent(theme.estimate, 0.16);
    for (const wall of this.run.walls) {
      const ends = wallAt(wall, this.clock.step);
      if (!ends) continue;
      context.lineWidth = Math.min(0.5 * view.scale, 10 * 4 * ends.sigma * view.scale);
      this.stroke(ends.x0, ends.y0, ends.x1, ends.y1);
    }
  }

  // Shows a run of another extent.
  setBounds(bounds) {
    this.canvas.style.aspectRatio = String(Math.min(3, Math.max(0.9, (bounds.x1 - bounds.x0) / Math.max(0.1, bounds.y1 - bounds.y0))));
    this.view.bounds = bounds;
    if (this.view.untouched) this.view.fitAll();
  }
}
