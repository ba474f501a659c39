// What the pointer does on the map of a simulated home: move the view, draw things, move them, put the robot elsewhere.

const TOOLS = [
  { id: "view", label: "Move view", note: "Drag to move the view." },
  { id: "robot", label: "Put robot", note: "Click where the robot is to be put down." },
  { id: "wall", label: "Wall", note: "Drag a wall from end to end." },
  { id: "box", label: "Box", note: "Drag a piece of furniture from corner to corner." },
  { id: "round", label: "Leg", note: "Click for a chair's leg; drag for something thicker." },
  { id: "door", label: "Door", note: "Drag a door leaf across its frame; it stays closed." },
  { id: "person", label: "Person", note: "Drag the path that somebody walks to and fro." },
  { id: "rug", label: "Rug", note: "Drag a rug: its edge turns the robot, and no encoder tells." },
  { id: "keep_out", label: "Keep out", note: "Drag an area that a robot which cleans stays out of." },
  { id: "clean", label: "Clean here", note: "Drag an area to clean; nothing outside such areas is cleaned then." },
  { id: "move", label: "Move thing", note: "Drag a wall, box, leg, door or person, or the edge of an area." },
  { id: "erase", label: "Erase", note: "Click what is to go." },
];

// Things that are drawn from corner to corner.
const RECTANGLES = ["box", "rug", "keep_out", "clean"];

// A press is on what lies within so many pixels.
const GRIP_PX = 12;

class Tools {
  constructor(map, simulate) {
    Object.assign(this, { map, simulate, tool: "view", begun: null });
    this.hint = document.querySelector(".map-hint").textContent;
    const group = document.getElementById("tools");
    group.replaceChildren(...TOOLS.map(({ id, label, note }) =>
      element("button", { type: "button", "data-tool": id, "aria-pressed": String(id === "view"), title: note }, label)));
    chooseOne(group, (button) => this.choose(button.dataset.tool));
    const frame = map.canvas.parentElement;
    const on = (name, act) => frame.addEventListener(name, (event) => {
      if (this.tool === "view" || event.target !== map.canvas) return;
      event.stopPropagation();
      act([event.offsetX, event.offsetY], event);
    }, { capture: true });
    on("pointerdown", (place, event) => {
      if (event.button !== 0) return;
      map.canvas.setPointerCapture(event.pointerId);
      this.press(this.toPlan(place));
    });
    on("pointermove", (place) => this.begun && this.drag(this.toPlan(place)));
    on("pointerup", (place) => this.begun && this.release(this.toPlan(place)));
    on("pointercancel", () => this.cancel());
    document.addEventListener("keydown", (event) => event.key === "Escape" && this.cancel());
  }

  // No tool: the map is moved.
  view() {
    for (const button of document.querySelectorAll("[data-tool]")) {
      button.setAttribute("aria-pressed", String(button.dataset.tool === "view"));
    }
    this.choose("view");
  }

  choose(tool) {
    this.tool = tool;
    this.cancel();
    document.querySelector(".map-hint").textContent = tool === "view" ? this.hint : TOOLS.find(({ id }) => id === tool).note;
    this.map.canvas.style.cursor = tool === "view" ? "" : "crosshair";
    this.map.canvas.style.touchAction = tool === "view" ? "" : "none";
  }

  cancel() {
    this.begun = null;
    this.map.sketch = [];
    this.map.draw();
  }

  toPlan([px, py]) {
    return this.simulate.toPlan(...this.map.view.toMap(px, py));
  }

  press(at) {
    const reach = GRIP_PX / this.map.view.scale;
    const { text } = this.simulate;
    if (this.tool === "robot") this.simulate.carryTo(at);
    else if (this.tool === "erase") {
      const thing = thingNear(text, at, reach);
      if (thing) this.simulate.rebuild(withoutThing(text, thing));
    } else if (this.tool === "move") {
      const thing = thingNear(text, at, reach);
      if (thing) this.begun = { at, thing, text };
    } else this.begun = { at: at.map(snapped) };
  }

  // Where a line to this place ends: on the grid, and along the axes where it nearly is.
  end(at) {
    const [x0, y0] = this.begun.at;
    const [x1, y1] = at.map(snapped);
    if (RECTANGLES.includes(this.tool)) return [x1, y1];
    if (Math.abs(y1 - y0) < 0.1 * Math.abs(x1 - x0)) return [x1, y0];
    if (Math.abs(x1 - x0) < 0.1 * Math.abs(y1 - y0)) return [x0, y1];
    return [x1, y1];
  }

  drag(at) {
    if (this.tool === "move") return this.moveTo(at);
    const [x0, y0] = this.begun.at;
    const [x1, y1] = this.end(at);
    const corners = RECTANGLES.includes(this.tool) ? [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]] : [[x0, y0], [x1, y1]];
    const shown = corners.map(([x, y]) => this.simulate.toShown(x, y));
    this.map.sketch = shown.slice(1).map((end, i) => [...shown[i], ...end]);
    this.map.draw();
  }

  moveTo(at) {
    const { at: from, thing, text } = this.begun;
    this.simulate.rebuild(movedThing(text, thing, snapped(at[0] - from[0]), snapped(at[1] - from[1])));
  }

  release(at) {
    const { begun, tool } = this;
    if (tool === "move") this.moveTo(at);
    else {
      const end = this.end(at);
      const long = Math.hypot(end[0] - begun.at[0], end[1] - begun.at[1]) >= 0.1;
      if (long || tool === "round") this.simulate.rebuild(withThing(this.simulate.text, tool, begun.at, end));
    }
    this.cancel();
  }
}
