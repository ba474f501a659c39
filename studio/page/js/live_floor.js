// The floor that a robot sweeps: a raster in the plan's frame, each cell with the times of its first two passes.

LAYERS.splice(1, 0, { id: "floor", label: "Floor swept; twice is darker", swatch: "glow", colour: "used" });

// While the run grows, the floor is asked for and coloured so often, milliseconds.
const FLOOR_EVERY_MS = 150;
// Opacity of what was swept once, and of what was swept again.
const SWEPT_ALPHA = [0.22, 0.5];

class LiveFloor {
  // `read` gives the times, two a cell; `toShown` leads from the plan to the map on the screen.
  constructor(read, toShown) {
    Object.assign(this, { read, toShown });
    this.canvas = document.createElement("canvas");
  }

  // The raster lies here now: its lower corner, a cell's edge (metres), cells in a row.
  lie({ corner, cell, columns }) {
    Object.assign(this, { corner, cell, columns });
    this.forget();
  }

  // What was painted holds no more.
  forget() {
    this.key = null;
  }

  paint(map) {
    const { run, clock, theme } = map;
    const now = performance.now();
    const key = `${clock.step} ${run.count} ${theme.used}`;
    if (key !== this.key && !(clock.playing && this.key && now - this.colouredAt < FLOOR_EVERY_MS)) {
      if (run.count !== this.readCount || !this.key) this.times = this.read();
      this.readCount = run.count;
      this.colour(clock.seconds, theme.used);
      this.colouredAt = now;
      this.key = key;
    }
    this.draw(map);
  }

  // Colours each cell as it was at a time.
  colour(seconds, colour) {
    const { times, columns, canvas } = this;
    const cells = times.length / 2;
    [canvas.width, canvas.height] = [columns, cells / columns];
    const context = canvas.getContext("2d");
    const picture = context.createImageData(columns, cells / columns);
    const pixels = new Uint32Array(picture.data.buffer);
    const [once, twice] = SWEPT_ALPHA.map((alpha) => pixelOf(colour, alpha));
    for (let cell = 0; cell < cells; cell++) {
      if (times[2 * cell] <= seconds) pixels[cell] = times[2 * cell + 1] <= seconds ? twice : once;
    }
    context.putImageData(picture, 0, 0);
  }

  draw({ context, view }) {
    const { corner: [x, y], cell, toShown, canvas } = this;
    const place = (px, py) => view.toScreen(...toShown(px, py));
    const [origin, along, across] = [place(x, y), place(x + cell, y), place(x, y + cell)];
    context.save();
    context.imageSmoothingEnabled = false;
    context.transform(along[0] - origin[0], along[1] - origin[1], across[0] - origin[0], across[1] - origin[1], ...origin);
    context.drawImage(canvas, 0, 0);
    context.restore();
  }
}

// The pixel of a CSS colour, `rgb(r, g, b)`, as the bytes of an image hold it.
function pixelOf(colour, alpha) {
  const [r, g, b] = colour.match(/[\d.]+/g).map(Number);
  return new Uint32Array(new Uint8ClampedArray([r, g, b, 255 * alpha]).buffer)[0];
}
