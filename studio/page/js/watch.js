// Robot: a robot at a serial port, or at the WebSocket of `lab monitor --serve`.

const BAUD = 115200;
// Most bytes that wait for the next frame: more than 20 seconds of the line. What comes beyond is dropped and counted.
const MOST_WAITING = 256 * 1024;
// Bytes that one frame takes in: at 60 frames a second forty times what the line carries.
const MOST_A_FRAME = 8 * 1024;
// Without a whole frame for so long something is wrong, milliseconds.
const PATIENCE_MS = 3000;
// A key that is held drives on; each command lasts a short time on the robot. Share of the supply.
const KEY_EVERY_MS = 150;
const DRIVE = 0.45;
const TURN = 0.3;
const KEYS = {
  w: [DRIVE, DRIVE], s: [-DRIVE, -DRIVE], a: [-TURN, TURN], d: [TURN, -TURN],
};

// Buttons, and what they tell the robot.
const COMMANDS = [
  ["robot-start", "start"], ["robot-clean", "clean"], ["robot-clean-anew", "clean-anew"], ["robot-stop", "stop"], ["robot-reset", "reset"],
];

class RobotMode {
  constructor(studio) {
    this.studio = studio;
    this.waiting = [];
    this.waitingBytes = 0;
    this.dropped = 0;
    this.line = null;
    this.lineSays = "";
    this.errands = new Errands(this);
    const byId = (id) => document.getElementById(id);
    const serial = byId("connect-serial");
    serial.disabled = !("serial" in navigator);
    if (serial.disabled) serial.title = "This browser has no WebSerial; Chromium and Edge have, or use lab monitor --serve";
    byId("robot-form").addEventListener("submit", (event) => event.preventDefault());
    serial.addEventListener("click", () => this.connect(() => this.openSerial()));
    byId("connect-socket").addEventListener("click", () => this.connect(() => this.openSocket(byId("socket").value)));
    byId("disconnect").addEventListener("click", () => this.disconnect("Disconnected."));
    for (const [id, command] of COMMANDS) {
      byId(id).addEventListener("click", () => this.send(robot_command(command, 0, 0)));
    }
    byId("save-robot-log").addEventListener("click", () => this.program && save("log.csv", this.program.log()));
    byId("save-robot-rig").addEventListener("click", () => this.program && save("rig.toml", this.program.rig()));
    this.bindKeys(byId("drive-pad"));
  }

  bindKeys(pad) {
    const held = new Set();
    const drive = () => {
      const wheels = [...held].reduce(([l, r], key) => [l + KEYS[key][0], r + KEYS[key][1]], [0, 0]);
      this.send(robot_command("spin", ...wheels));
    };
    pad.addEventListener("keydown", (event) => {
      const key = event.key.toLowerCase();
      if (key === " ") this.send(robot_command("stop", 0, 0));
      else if (KEYS[key]) {
        held.add(key);
        drive();
        this.driving ??= setInterval(drive, KEY_EVERY_MS);
      } else return;
      event.preventDefault();
    });
    const release = (key) => {
      if (key) held.delete(key);
      else held.clear();
      if (held.size || !this.driving) return;
      clearInterval(this.driving);
      this.driving = null;
      this.send(robot_command("stop", 0, 0));
    };
    pad.addEventListener("keyup", (event) => release(event.key.toLowerCase()));
    pad.addEventListener("blur", () => release(null));
  }

  async connect(open) {
    this.disconnect("");
    await this.studio.attemptLater(async () => {
      this.program?.free();
      this.program = null;
      const rig = document.getElementById("robot-rig").value;
      this.program = new Robot(rig);
      this.starts = 0;
      this.waiting = [];
      [this.waitingBytes, this.dropped] = [0, 0];
      this.line = await open();
      this.heardAt = performance.now();
      this.enter();
    });
    this.showLine();
  }

  // The mode is chosen, or a line is open.
  enter() {
    if (!this.program) return;
    this.program.tell_again();
    const head = JSON.parse(this.program.head());
    this.longest = head.longest_s;
    this.studio.begin(this, head, 0, "Your robot");
    this.studio.clock.speed = Infinity;
    this.studio.clock.play(true);
  }

  showLine() {
    const open = Boolean(this.line);
    for (const id of [...COMMANDS.map(([id]) => id), "disconnect", "drive-pad"]) document.getElementById(id).disabled = !open;
    for (const id of ["connect-socket"]) document.getElementById(id).disabled = open;
    this.errands.enable(open);
    document.getElementById("connect-serial").disabled = open || !("serial" in navigator);
  }

  async openSerial() {
    const port = await navigator.serial.requestPort();
    await port.open({ baudRate: BAUD, bufferSize: 16384 });
    const reader = port.readable.getReader();
    const writer = port.writable.getWriter();
    const read = async () => {
      try {
        for (let part = await reader.read(); !part.done; part = await reader.read()) this.heard(part.value);
        this.lineEnded("The line has ended.");
      } catch (error) {
        this.lineEnded(`The line broke: ${error.message ?? error}`);
      }
    };
    read();
    return {
      send: (bytes) => writer.write(bytes).catch((error) => this.lineEnded(`The line broke: ${error.message ?? error}`)),
      close: async () => {
        await reader.cancel().catch(() => {});
        reader.releaseLock();
        writer.releaseLock();
        await port.close().catch(() => {});
      },
    };
  }

  openSocket(address) {
    return new Promise((done, failed) => {
      const socket = new WebSocket(address);
      socket.binaryType = "arraybuffer";
      const line = { send: (bytes) => socket.send(bytes), close: () => socket.close() };
      socket.onopen = () => done(line);
      socket.onerror = () => failed(new Error(`${address}: nobody answers; is lab monitor --serve running?`));
      socket.onclose = () => this.line === line && this.lineEnded("The line has ended.");
      socket.onmessage = ({ data }) => data instanceof ArrayBuffer && this.heard(new Uint8Array(data));
    });
  }

  lineEnded(words) {
    this.lineSays = words;
    this.line = null;
    this.showLine();
  }

  disconnect(words) {
    const { line } = this;
    this.lineEnded(words);
    line?.close();
  }

  send(bytes) {
    this.line?.send(bytes);
  }

  // Keeps bytes for the next frame.
  heard(bytes) {
    if (this.waitingBytes + bytes.length > MOST_WAITING) {
      this.dropped += bytes.length;
      return;
    }
    this.waiting.push(bytes);
    this.waitingBytes += bytes.length;
  }

  // Takes in what was heard, at most so much a frame.
  reach() {
    const { program, studio } = this;
    if (!program) return;
    let room = MOST_A_FRAME;
    while (this.waiting.length && room > 0) {
      const part = this.waiting.shift();
      const now = part.subarray(0, room);
      if (now.length < part.length) this.waiting.unshift(part.subarray(now.length));
      room -= now.length;
      this.waitingBytes -= now.length;
      program.take(now);
    }
    const state = JSON.parse(program.state());
    if (state.starts !== this.starts) {
      this.starts = state.starts;
      this.enter();
    }
    const { live, map } = studio;
    this.errands.work(state);
    const steps = program.steps();
    if (steps.length) {
      live.take(steps);
      this.heardAt = performance.now();
    }
    const latest = program.map();
    if (latest) live.takeMap(JSON.parse(latest));
    if (performance.now() - (this.framed ?? 0) > 500) {
      this.framed = performance.now();
      map.setBounds(mapBounds(live.shown));
    }
    this.state = state;
  }

  status() {
    const { state } = this;
    if (!this.line && !this.program) {
      return "Connect a robot that runs the firmware: by USB in Chromium or Edge, elsewhere through lab monitor --serve.";
    }
    const words = [this.line ? "Connected." : this.lineSays];
    if (!state) return words.join(" ");
    words.push(`${whole(state.frames)} frames, ${whole(state.damaged)} damaged, ${whole(state.bytes)} bytes.`);
    if (this.dropped) words.push(`${whole(this.dropped)} bytes came too fast and were dropped.`);
    if (state.other_version !== null) words.push(`The robot speaks version ${state.other_version} of the protocol, this page ${state.version}.`);
    if (this.line && performance.now() - this.heardAt > PATIENCE_MS) {
      words.push(state.strange_bytes
        ? `${whole(state.strange_bytes)} bytes arrive and no whole frame: the line must run at ${BAUD} baud, and the robot must run the firmware of this version.`
        : "Nothing arrives: is the robot switched on, and is it at this port?");
    }
    const told = state.same + state.other;
    if (told) words.push(state.other ? `This page's own estimator agrees with ${whole(state.same)} of ${whole(told)} estimates.` : "This page's own estimator says the same, bit for bit.");
    if (state.health && state.health !== "well") words.push(`The estimator is unwell: ${state.health}.`);
    if (state.floor) words.push(state.floor);
    if (state.touched.length) words.push(`Touched: ${state.touched.join(", ")}.`);
    const faults = Object.entries(state.faults ?? {}).filter(([, count]) => count > 0);
    words.push(faults.length ? `Faults: ${faults.map(([name, count]) => `${name} ${count}`).join(", ")}.` : state.faults ? "No faults." : "");
    if (state.full) words.push("An hour is recorded; what comes now is shown and not kept.");
    return words.filter(Boolean).join(" ");
  }

  figures() {
    return JSON.parse(this.program.figures());
  }
}
