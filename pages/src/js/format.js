// Numbers as people read them. Absent or non-finite values become an en dash.

const NONE = "\u2013";
const DEG = 180 / Math.PI;

function fixed(value, digits) {
  if (!Number.isFinite(value)) return NONE;
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
}

// Metres as centimetres below one metre.
function length(metres) {
  if (!Number.isFinite(metres)) return NONE;
  const size = Math.abs(metres);
  if (size >= 100) return `${fixed(metres, 0)}\u00a0m`;
  if (size >= 0.995) return `${fixed(metres, 2)}\u00a0m`;
  return `${fixed(metres * 100, size < 0.0995 ? 1 : 0)}\u00a0cm`;
}

function degrees(value, digits = 2) {
  return Number.isFinite(value) ? `${fixed(value, digits)}\u00b0` : NONE;
}

function plain(value) {
  if (!Number.isFinite(value)) return NONE;
  const size = Math.abs(value);
  return fixed(value, size >= 100 ? 0 : size >= 10 ? 1 : 2);
}

function whole(value) {
  return Number.isFinite(value) ? Math.round(value).toLocaleString("en").replaceAll(",", "\u202f") : NONE;
}

// A round number on an axis.
function axisNumber(value) {
  return String(Number(value.toPrecision(4))).replace("-", "\u2212");
}

const RAISED = { "-": "\u207b", "\u2212": "\u207b", ".": "\u00b7", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3" };

// A power of ten, its exponent raised.
function powerOfTen(exponent) {
  const raised = [...exponent].map((digit) => RAISED[digit] ?? String.fromCodePoint(0x2070 + Number(digit)));
  return `10${raised.join("")}`;
}

// Seconds as m:ss.s
function clockTime(seconds) {
  if (!Number.isFinite(seconds)) return NONE;
  const tenths = Math.round(seconds * 10);
  const rest = tenths % 600;
  return `${Math.floor(tenths / 600)}:${String(Math.floor(rest / 10)).padStart(2, "0")}.${rest % 10}`;
}

function duration(seconds) {
  if (!Number.isFinite(seconds)) return NONE;
  if (seconds < 60) return `${fixed(seconds, 1)}\u00a0s`;
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}\u00a0min ${whole % 60}\u00a0s`;
}

function wrapAngle(angle) {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

// An element with attributes and children; text is set as text, never as markup.
function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== null && value !== false) node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children);
  return node;
}
