// Colours for canvases, read from the style sheet, and the light/dark choice.

const COLOUR_NAMES = [
  "paper", "card", "ink", "soft", "line", "grid", "estimate", "odometry", "truth", "plan", "wall", "free",
  "used", "gated", "unexplained", "refused", "apart", "one", "two", "three", "four", "five", "six", "seven", "eight",
  "swept", "twice", "to-come", "missed", "swept-line", "twice-line",
  "time-1", "time-2", "time-3", "time-4", "time-5", "time-6",
];

// Colours of categories that have no meaning of their own (passes, sensors), distinguishable with colour blindness.
const SERIES = ["one", "two", "three", "four", "five", "six", "seven", "eight"];

// Colours of times, early to late.
const AGES = ["time-1", "time-2", "time-3", "time-4", "time-5", "time-6"];

function readTheme() {
  const probe = element("span", { hidden: true });
  document.body.append(probe);
  const theme = {};
  for (const name of COLOUR_NAMES) {
    probe.style.color = `var(--${name})`;
    theme[name] = getComputedStyle(probe).color;
  }
  probe.remove();
  theme.font = getComputedStyle(document.body).fontFamily;
  return theme;
}

function bindTheme(changed) {
  const root = document.documentElement;
  const buttons = [...document.querySelectorAll("[data-theme-choice]")];
  const choose = (choice) => {
    root.dataset.theme = choice;
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.themeChoice === choice));
    changed();
  };
  for (const button of buttons) button.addEventListener("click", () => choose(button.dataset.themeChoice));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  return choose;
}

// A canvas at the screen's resolution; drawing is in CSS pixels.
function prepare(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(1, canvas.clientWidth);
  const height = Math.max(1, canvas.clientHeight);
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height, ratio };
}

function translucent(colour, alpha) {
  return colour.replace(/^rgba?\(([^,]+),([^,]+),([^,)]+).*$/, `rgba($1,$2,$3,${alpha})`);
}
