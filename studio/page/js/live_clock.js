// The moment that the page shows, and the run's growth: playing past what is there asks the run's source for more.

// Time that one frame may spend on growing the run, milliseconds: at 60 frames a second there are 16.7 for everything.
const FRAME_WORK_MS = 9;

class LiveClock extends Clock {
  // `source` is what the run grows from: `reach(seconds, deadline)` grows it up to a time, for as long as it may.
  constructor(run) {
    super(run);
    this.source = null;
  }

  get atEnd() {
    // A source may be a few samples ahead of the clock.
    return this.run.end - this.seconds < 1;
  }

  play(on) {
    if (on === this.playing) return;
    this.playing = on;
    if (on) this.tick(null);
    this.announce();
  }

  tick(before) {
    requestAnimationFrame((now) => {
      if (!this.playing) return;
      // A page in the background gets no frames: what it missed is not caught up with.
      const elapsed = before === null ? 0 : Math.min(0.25, (now - before) / 1000);
      this.advance(elapsed);
      if (this.playing) this.tick(now);
    });
  }

  advance(elapsed) {
    // Without a limit, as fast as there is time for.
    const wanted = this.speed === Infinity ? Infinity : this.seconds + elapsed * this.speed;
    if (wanted > this.run.end || !this.run.count) this.source?.reach(wanted, performance.now() + FRAME_WORK_MS);
    this.seek(wanted);
    if (this.source?.ended && this.seconds >= this.run.end) this.play(false);
  }

  // Goes to the newest moment.
  follow() {
    this.seek(Infinity);
  }
}
