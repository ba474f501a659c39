// What is done with a robot beside watching it: its kept map, an examination part by part, calibration by driving.

// No file of a map is longer, bytes: it may have two, of which the newer one counts.
const LONGEST_MAP = 1024 * 1024;
// A factor is known when its sigma is this share of what it was.
const KNOWN_SHARE = 1 / 3;

class Errands {
  constructor(robot) {
    this.robot = robot;
    this.byId = (id) => document.getElementById(id);
    const { byId } = this;
    byId("fetch-map").addEventListener("click", () => this.mapErrand("get", new Uint8Array(0)));
    byId("forget-map").addEventListener("click", () => this.mapErrand("forget", new Uint8Array(0)));
    byId("store-map").addEventListener("change", () => {
      const [file] = byId("store-map").files;
      byId("store-map").value = "";
      if (file) this.storeMap(file);
    });
    byId("doctor-begin").addEventListener("click", () => {
      this.program?.examine();
      this.robot.studio.clock.play(true);
    });
    byId("doctor-done").addEventListener("click", () => this.program?.answer());
    byId("doctor-end").addEventListener("click", () => {
      this.program?.end_examination();
      this.robot.send(robot_command("stop", 0, 0));
    });
  }

  get program() {
    return this.robot.program;
  }

  // A line is open, or not.
  enable(open) {
    for (const id of ["fetch-map", "store-map", "forget-map", "doctor-begin"]) this.byId(id).disabled = !open;
  }

  mapErrand(name, bytes) {
    this.robot.studio.attempt(() => this.program?.begin_map(name, bytes));
    // What comes is taken in while the run grows.
    this.robot.studio.clock.play(true);
  }

  async storeMap(file) {
    await this.robot.studio.attemptLater(async () => {
      if (file.size > LONGEST_MAP) throw new Error(`${file.name}: is longer than any map that a robot keeps; it must be a map.bin`);
      try {
        this.program?.begin_map("put", new Uint8Array(await file.arrayBuffer()));
      } catch (error) {
        throw new Error(`${file.name}: ${error.message ?? error}`);
      }
      this.robot.studio.clock.play(true);
    });
  }

  // Sends what is due, and shows how far things are.
  work(state) {
    const due = this.program.due(performance.now());
    if (due.length) this.robot.send(due);
    const { map, doctor } = state.errands;
    this.showMap(map, state.place);
    this.showDoctor(doctor);
    this.showCalibration(state);
    const fetched = this.program.fetched();
    if (fetched.length) save("map.bin", fetched, "application/octet-stream");
  }

  // Changes a text only where it is another one: what is read aloud must not be repeated.
  tell(id, words) {
    const node = this.byId(id);
    if (node.textContent !== words) node.textContent = words;
  }

  showMap({ under_way: share, said, failed }, place) {
    const now = share === null ? [said, place].filter(Boolean).join(" ") : `${fixed(100 * Math.min(1, share), 0)} % of the map.`;
    this.tell("map-said", failed ? `Not done: ${said}.` : now);
    this.byId("map-said").classList.toggle("problem", failed);
  }

  showDoctor(doctor) {
    const { byId } = this;
    byId("doctor-begin").hidden = Boolean(doctor) && !doctor.over;
    for (const id of ["doctor-end", "doctor-share"]) byId(id).hidden = !doctor || doctor.over;
    byId("doctor-done").hidden = !doctor?.ask;
    if (!doctor) return this.tell("doctor-now", "");
    byId("doctor-share").value = doctor.share;
    const wrong = doctor.found.filter((part) => part.wrong).length;
    const over = wrong ? `${wrong} ${wrong === 1 ? "thing" : "things"} to put right.` : "Everything is as it should be.";
    this.tell("doctor-now", doctor.over ? over : doctor.ask ?? "Listening to the robot.");
    const list = byId("doctor-found");
    if (list.childElementCount === doctor.found.length) return;
    list.replaceChildren(...doctor.found.map(({ part, said, wrong: isWrong }) =>
      element("li", { class: isWrong ? "wrong" : "fine" }, element("strong", {}, isWrong ? "Wrong" : "Fine"), ` ${part}: ${said}`)));
  }

  showCalibration({ calibration }) {
    const known = ([, , sigma, prior]) => sigma <= KNOWN_SHARE * prior;
    const left = calibration.filter((factor) => !known(factor));
    const words = () => {
      if (!calibration.length) return "Nothing is heard of the robot's calibration yet; connect it and wait a second.";
      if (!left.length) return "Every factor is known. The robot goes on refining them.";
      const wheels = left.some(([name]) => /^(scale|track)/.test(name));
      const next = wheels
        ? "For wheels and track it has to go along walls and turn before them, in several rooms or corners."
        : "For the sensors' gains each has to see walls that others see, too: let it go round once more.";
      return `${left.length} of ${calibration.length} factors are not known yet: put the robot into a room with straight walls and press Start. ${next}`;
    };
    this.tell("calibrate-now", words());
    const list = this.byId("calibrate-factors");
    const lines = calibration.map((factor) => {
      const [name, value, sigma, prior] = factor;
      return `${name}: ${fixed(100 * (value - 1), 2)} % \u00b1 ${fixed(200 * sigma, 2)} (2 sigma), ${known(factor) ? "known" : `${fixed(100 * Math.max(0, 1 - sigma / prior), 0)} % of its uncertainty is gone`}`;
    });
    const text = lines.join("\n");
    if (this.shownFactors === text) return;
    this.shownFactors = text;
    list.replaceChildren(...lines.map((line, i) => element("li", { class: known(calibration[i]) ? "fine" : "" }, line)));
  }
}
