// Replay: a log and a rig file of the user's, which stay in this page.

// Rows that are asked for at once; a frame's time is looked at between.
const ROWS = 10;
// Largest file that is read, bytes: a log of a day has less.
const LARGEST = 512 * 1024 * 1024;
// What a run writes beside its log, which is no log.
const NO_LOGS = ["estimate.csv", "walls.csv", "calibration.csv", "readings.csv", "truth.csv"];

class ReplayMode {
  constructor(studio) {
    this.studio = studio;
    this.files = {};
    const byId = (id) => document.getElementById(id);
    for (const id of ["files", "folder"]) {
      byId(id).addEventListener("change", () => {
        this.take([...byId(id).files]);
        byId(id).value = "";
      });
    }
    byId("replay").addEventListener("submit", (event) => event.preventDefault());
    byId("save-estimate").addEventListener("click", () => this.program && save("estimate.csv", this.program.estimate()));
    byId("save-replay-map").addEventListener("click", () =>
      this.program && save("map.bin", this.program.kept_map(), "application/octet-stream"));
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", async (event) => {
      event.preventDefault();
      const files = await dropped(event.dataTransfer);
      if (!files.length) return;
      const isMap = files.length === 1 && files[0].name.endsWith(".bin");
      if (isMap && document.documentElement.dataset.mode === "simulate") return studio.modes.simulate.giveMap(files[0]);
      studio.choose("replay");
      await this.take(files);
    });
  }

  // Takes files by what they are called; begins when there are a log and a rig.
  async take(files) {
    const named = (test) => files.find((file) => test(file.name.toLowerCase()));
    const isLog = (name) => /\.(csv|log|clf|txt)(\.gz)?$/.test(name) && !NO_LOGS.includes(name);
    const chosen = {
      rig: named((name) => name === "rig.toml") ?? named((name) => name.endsWith(".toml")),
      log: named((name) => name === "log.csv") ?? named(isLog),
      truth: named((name) => name === "truth.csv"),
      // In the folder of a run the map is what it ended with, not what it began in.
      map: named((name) => name === "summary.json") ? undefined : named((name) => name.endsWith(".bin")),
    };
    const large = Object.values(chosen).find((file) => file && file.size > LARGEST);
    await this.studio.attemptLater(async () => {
      if (large) throw new Error(`${large.name}: is larger than ${LARGEST / 1024 / 1024} MiB; use lab replay`);
      if (!Object.values(chosen).some(Boolean)) {
        const names = files.map((file) => file.name).slice(0, 5).join(", ");
        throw new Error(`${names}: is no log and no rig; a log.csv or a CARMEN log, plain or gzipped, and a rig.toml are needed`);
      }
      // A new log is not to be held against an old one's truth, nor to begin in its map.
      if (chosen.log) this.files = { rig: this.files.rig };
      for (const [kind, file] of Object.entries(chosen)) {
        if (file) this.files[kind] = { name: file.name, content: new Uint8Array(await file.arrayBuffer()) };
      }
      this.showFiles();
      if (this.files.log && this.files.rig) this.begin();
    });
  }

  showFiles() {
    const { log, rig, truth, map } = this.files;
    const missing = !log ? "a log is missing" : !rig ? "a rig.toml is missing" : "";
    const there = [log, rig, truth, map].filter(Boolean).map((file) => file.name).join(", ");
    document.getElementById("files-said").textContent = [there, missing].filter(Boolean).join("; ");
  }

  begin() {
    const { log, rig, truth, map } = this.files;
    const part = (file) => [file?.name ?? "", file?.content ?? new Uint8Array(0)];
    // Files that cannot be replayed leave what is shown.
    const program = new Replay(...part(log), ...part(rig), ...part(truth), ...part(map));
    this.program?.free();
    this.program = program;
    this.enter();
  }

  // The mode is chosen, or a log: all of its run so far is shown.
  enter() {
    if (!this.program) return;
    this.program.tell_again();
    this.scored = false;
    this.studio.begin(this, JSON.parse(this.program.head()), 0, "Replayed log");
    this.studio.clock.speed = Infinity;
    this.studio.clock.play(true);
  }

  get ended() {
    return Boolean(this.program?.is_over());
  }

  // Feeds rows until a time or a deadline.
  reach(seconds, deadline) {
    const { program, studio } = this;
    if (!program) return;
    while (!program.is_over() && studio.live.run.end <= seconds && performance.now() < deadline) {
      program.advance(ROWS);
      if (!program.is_over()) this.deliver();
    }
    if (program.is_over() && !this.scored) this.showAll();
  }

  deliver() {
    const { live, map } = this.studio;
    live.take(this.program.steps());
    const latest = this.program.map();
    if (latest) live.takeMap(JSON.parse(latest));
    const now = performance.now();
    if (now - (this.framed ?? 0) > 500) {
      this.framed = now;
      map.setBounds(mapBounds(live.shown));
    }
  }

  // The log is over: everything once more, upright, with the truth where it is known.
  showAll() {
    const { studio, program } = this;
    this.scored = true;
    const upright = uprightTurn(studio.live.run);
    studio.live.reset(JSON.parse(program.head()), Number.isFinite(upright) ? upright : 0);
    studio.adopt(this);
    const state = JSON.parse(program.state());
    const maps = JSON.parse(program.maps());
    studio.live.take(program.steps());
    for (const map of maps) studio.live.takeMap(map);
    studio.map.setBounds(mapBounds(studio.live.shown));
    studio.clock.speed = 10;
    studio.clock.play(false);
    studio.clock.follow();
    studio.showSpeed();
    studio.finish();
    if (state.error) studio.say(state.error);
  }

  status() {
    if (!this.program) return "Drop a log and its rig.toml on this page, or the folder that a run has written; they stay on your computer.";
    const state = JSON.parse(this.program.state());
    const words = [`${whole(state.rows)} rows${state.over ? "" : " so far"}.`, ...state.notes.map((note) => `Note: ${note}.`)];
    if (state.searching) words.push("Searching its place in the kept map.");
    if (state.complaint && state.over) words.push(`${state.complaint}.`);
    return words.join(" ");
  }

  figures() {
    return JSON.parse(this.program.figures());
  }
}

// The files that were dropped, those of folders, too.
async function dropped(transfer) {
  const entries = [...(transfer?.items ?? [])].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return [...(transfer?.files ?? [])];
  const filesOf = async (entry) => {
    if (entry.isFile) return [await new Promise((done, failed) => entry.file(done, failed))];
    const inside = await new Promise((done, failed) => entry.createReader().readEntries(done, failed));
    return (await Promise.all(inside.filter((child) => child.isFile).map(filesOf))).flat();
  };
  return (await Promise.all(entries.map(filesOf))).flat();
}
