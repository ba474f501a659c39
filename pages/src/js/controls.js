// The controls of map and layers, and what lies under the pointer.

function buildLayerToggles(map, run) {
  const absent = { truth: !run.truth, plan: !run.plan.length, apart: !wallsApart(run).length, floor: !map.floor, back: !map.back?.isOn, places: !map.places?.length };
  const boxes = LAYERS.filter((layer) => !absent[layer.id]).map((layer) => {
    const box = element("input", { type: "checkbox", checked: map.shown[layer.id], "data-layer": layer.id });
    box.addEventListener("change", () => {
      map.shown[layer.id] = box.checked;
      map.redrawHits();
    });
    return element("label", {}, box, element("span", { class: `swatch ${layer.swatch}`, style: `--c:var(--${layer.colour})` }), layer.label);
  });
  const list = document.getElementById("layers");
  list.replaceChildren(...boxes);
  if (run.walls.some((wall) => wall.kind === "free")) {
    const at = boxes.findIndex((label) => label.querySelector("[data-layer=walls]"));
    boxes[at].after(element("p", { class: "key" }, element("span", { class: "swatch capped", style: "--c:var(--free)" }), "off the grid"));
  }
}

const COLOURING_NOTES = {
  outcome: "Readings outside the gate or without a wall wait in a buffer, where new walls are born from.",
  pass: `A new pass starts when a place was not seen for ${PASS_GAP_S} s. Where the map is right, the passes lie on top of each other.`,
  time: "Where late colours lie beside early ones instead of on top of them, the map has drifted apart.",
  sensor: "A sensor whose hits lie in front of or behind the others' is mounted or calibrated differently than the rig file says.",
};

function showHitClasses(map) {
  map.hidden.clear();
  const boxes = map.classes().map(({ label, colour }, kind) => {
    const box = element("input", { type: "checkbox", checked: true, "data-class": kind });
    box.addEventListener("change", () => {
      if (box.checked) map.hidden.delete(kind);
      else map.hidden.add(kind);
      map.redrawHits();
    });
    return element("label", {}, box, element("span", { class: "swatch dot", style: `--c:var(--${colour})` }), label);
  });
  document.getElementById("hit-classes").replaceChildren(...boxes);
  document.getElementById("colouring-note").textContent = COLOURING_NOTES[map.colouring];
  map.redrawHits();
}

function bindMapControls(map) {
  const byId = (id) => document.getElementById(id);
  byId("zoom-in").addEventListener("click", () => map.view.zoom(1.4));
  byId("zoom-out").addEventListener("click", () => map.view.zoom(1 / 1.4));
  byId("zoom-fit").addEventListener("click", () => {
    map.setFollow(false);
    map.view.fitAll();
  });
  byId("follow").addEventListener("click", () => map.setFollow(!map.follow));
  byId("comparison").hidden = !map.run.truths.fit;
  chooseOne(byId("comparison"), (button) => map.compare(button.dataset.comparison));
  chooseOne(byId("placing"), (button) => map.place(button.dataset.placing));
  chooseOne(byId("colouring"), (button) => {
    map.colouring = button.dataset.colouring;
    showHitClasses(map);
  });
}

// What lies under the pointer, in words; a click on a hit goes to its moment.
function bindMapTip(map, run, hits, clock) {
  const tip = document.getElementById("map-tip");
  const { canvas } = map;
  canvas.addEventListener("pointermove", (event) => {
    const text = event.buttons ? "" : tipText(map, run, hits, event.offsetX, event.offsetY);
    tip.hidden = !text;
    if (!text) return;
    tip.textContent = text;
    tip.style.left = `${Math.min(event.offsetX + 14, canvas.clientWidth - 230)}px`;
    tip.style.top = `${Math.min(event.offsetY + 14, canvas.clientHeight - 64)}px`;
  });
  canvas.addEventListener("pointerleave", () => (tip.hidden = true));
  canvas.addEventListener("click", (event) => {
    if (map.view.moved > 4) return;
    const h = map.hitNear(event.offsetX, event.offsetY);
    if (h < 0) return;
    clock.play(false);
    clock.seekStep(hits.step[h]);
  });
}

function tipText(map, run, hits, px, py) {
  const lines = [];
  const near = map.wallNear(px, py);
  if (near) {
    const { wall, ends } = near;
    lines.push(`Wall ${wall.id}, ${wall.kind}: ${length(Math.hypot(ends.x1 - ends.x0, ends.y1 - ends.y0))} long, sigma ${length(ends.sigma)}`);
  }
  if (near?.wall.visits > 1 && Number.isFinite(near.wall.gap)) {
    lines.push(`seen on ${near.wall.visits} visits, ${length(near.wall.gap)} apart`);
  }
  const h = map.hitNear(px, py);
  if (h >= 0) {
    const step = hits.step[h];
    const sensor = run.sensors[hits.sensor[h]];
    const wall = sensor.wall[step] >= 0 ? `, wall ${sensor.wall[step]}` : "";
    const sigmas = Number.isFinite(sensor.sigmas[step]) ? `, ${fixed(sensor.sigmas[step], 1)}\u03c3` : "";
    const pass = hits.pass[h] ? `, pass ${hits.pass[h]}` : "";
    lines.push(`Hit by ${sensor.name} at ${clockTime(run.t[step])}: ${outcomeText(run, sensor.code[step]).toLowerCase()}${wall}${sigmas}${pass}`);
  }
  return lines.join("\n");
}

function addCharts(id, specs, clock) {
  const charts = specs.map((spec) => new Chart(spec, clock));
  document.getElementById(id).replaceChildren(...charts.map((chart) => chart.figure));
  return charts;
}
