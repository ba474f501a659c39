// The map with what only a live page shows: how sure each wall is.

LAYERS.splice(2, 0, { id: "sigma", label: "Walls, 2 sigma either way", swatch: "glow", colour: "estimate" });

class LiveMap extends MapView {
  paintWalls() {
    if (this.shown.sigma) this.paintSigmas();
    super.paintWalls();
  }

  // A band as wide as the wall's place is unsure.
  paintSigmas() {
    const { context, theme, view } = this;
    context.lineCap = "butt";
    context.strokeStyle = translucent(theme.estimate, 0.25);
    for (const wall of this.run.walls) {
      const ends = wallAt(wall, this.clock.step);
      if (!ends) continue;
      context.lineWidth = Math.max(3, 4 * ends.sigma * view.scale);
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
