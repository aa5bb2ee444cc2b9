"use strict";
/* The live page: the model in WebAssembly (`src/lib.rs`), controls, drawing, plots, records and links. The drawing of the belt is that of the reports.
   Values are in SI units but where they are shown. */

const $ = (id) => document.getElementById(id);
const KEPT = 20001, LONGEST = 120e3; // Milliseconds that plots can show; rows of a record.
const COLOURS = ["#1874dc", "#be840b", "#05a75d", "#830196"], INK = "#1d2733", GRID = "#e3e7ec";
const SCALE = ["#dbe5ee", "#8fbfe0", "#2f7fc1", "#5b2d91", "#2b0a3d"].map((one) => [1, 3, 5].map((k) => parseInt(one.slice(k, k + 2), 16)));
const ROUND = [1, 2, 5, 10, 20, 50, 100, 200, 500], TURNS = 0.35; // Magnifications to choose from; turns of the faster pulley in a second of the drawing.
const PULLEYS = ["secondary", "primary"];
/* Parameters of the page: shafts with engine and car, so that they change their speeds slowly, and cylinders. */
const OWN = { "primary.inertia": 0.15, "secondary.inertia": 1, "primary.cylinder.area": 0.014, "secondary.cylinder.area": 0.01 };
/* Road load per square of the speed, speed from which the engine's torque falls, its slope, speed below which a torque against the motion fades. */
const DRAG = 49 / 209.44 ** 2, GOVERNED = 628.3, GOVERNOR = 2, SLOW = 10;
const SLIDERS = [
  ["primary.torque", "Torque on P, the engine", -200, 250], ["primary.clampingForce", "Clamping of P", 0, 50e3],
  ["secondary.torque", "Torque on S: brake, slope", -250, 200], ["secondary.clampingForce", "Clamping of S", 0, 50e3],
];
const FIRST = { "primary.torque": 50, "primary.clampingForce": 13.6e3, "secondary.torque": 0, "secondary.clampingForce": 10e3 };
/* Parameters, inputs at the start, and changes of inputs: time and duration, s, name, value at the end. */
const MANOEUVRES = {
  Steady: [{}, {}, []],
  Launch: [{ "initial.ratio": 2.2, "initial.primarySpeed": 0 }, { "primary.torque": 20, "primary.clampingForce": 18e3, "secondary.clampingForce": 25e3 },
    [[0.3, 0.4, "primary.torque", 110], [1, 2, "primary.clampingForce", 34e3], [2.5, 1, "primary.torque", 60]]],
  "Kick-down": [{ "initial.ratio": 0.6, "initial.primarySpeed": 200 }, { "primary.torque": 110, "primary.clampingForce": 26e3, "secondary.clampingForce": 15e3 },
    [[0.5, 0.1, "primary.clampingForce", 14e3], [0.5, 0.1, "secondary.clampingForce", 27e3], [0.5, 0.2, "primary.torque", 160], [0.85, 0.15, "primary.clampingForce", 30e3]]],
  "Torque step": [{}, { "primary.clampingForce": 26e3, "secondary.clampingForce": 20e3 },
    [[0.5, 0, "primary.torque", 150], [1.5, 0, "primary.torque", -40], [2.5, 0, "primary.torque", 50]]],
  "Macro-slip": [{}, {}, [[0.5, 0.3, "primary.torque", 200], [1.5, 0.05, "secondary.clampingForce", 24e3], [1.5, 0.05, "primary.clampingForce", 31e3]]],
  Reverse: [{ "initial.ratio": 2.2, "initial.primarySpeed": -1e-6 }, { "primary.torque": -20, "primary.clampingForce": 18e3, "secondary.clampingForce": 25e3 },
    [[0.3, 0.4, "primary.torque", -80], [1.2, 0.5, "primary.torque", -45]]],
};
/* Title and lines: variable, label, colour, dash. A variable with a bracket is a field along the belt. */
const PLOTS = [
  ["Speeds", ["primary.speed", "P", 0], ["secondary.speed", "S", 1]],
  ["Ratio and thrust ratio", ["ratio.geometric", "ratio", 0], ["thrustRatio", "thrust ratio", 2]],
  ["External torques", ["primary.externalTorque", "P", 0], ["secondary.externalTorque", "S", 1]],
  ["Axial forces", ["primary.clampingForceTotal", "clamp P", 0, [5, 4]], ["primary.axialForce", "belt P", 0], ["secondary.clampingForceTotal", "clamp S", 1, [5, 4]], ["secondary.axialForce", "belt S", 1]],
  ["Slip", ["slip", "slip", 0]],
  ["Forces along the belt", ["profile.pushForce[1]", "push force up to", 3], ["profile.ringTension[1]", "ring tension up to", 2]],
];

const model = {
  async load() {
    const packed = Uint8Array.from(atob($("module").textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    this.module = await WebAssembly.compile(await new Response(stream).arrayBuffer());
    await this.renew();
    const description = new DOMParser().parseFromString(this.text(), "text/xml");
    const items = (type) => [...description.querySelectorAll(`SimpleType[name="${type}"] Item`)].map((one) => [one.getAttribute("value"), one.getAttribute("name")]);
    this.variables = [...description.querySelectorAll("ScalarVariable")].map((one) => {
      const of = (name) => one.getAttribute(name) ?? one.firstElementChild.getAttribute(name), start = of("start"), unit = of("unit") ?? "";
      const shown = description.querySelector(`Unit[name="${unit}"] DisplayUnit[name="${of("displayUnit")}"]`);
      const isTruth = one.firstElementChild.tagName === "Boolean", type = of("declaredType");
      return {
        name: of("name"), about: of("description"), causality: of("causality"), isTunable: of("variability") === "tunable", unit, min: of("min"), max: of("max"),
        start: start && (isTruth ? Number(start === "true") : Number(start)), items: isTruth ? [[0, "false"], [1, "true"]] : type && items(type),
        factor: Number(shown?.getAttribute("factor") ?? 1), shown: shown?.getAttribute("name") ?? (unit === "1" ? "" : unit.replace(".", "·")),
      };
    });
    this.index = Object.fromEntries(this.variables.map(({ name }, k) => [name, k]));
    this.scalars = this.variables.findIndex(({ name }) => name.endsWith("]"));
    this.places = this.variables.filter(({ name }) => name.startsWith("profile.gap")).length;
  },
  async renew() {
    this.w = (await WebAssembly.instantiate(this.module, {})).exports;
    this.isBroken = false;
    this.w.describe();
  },
  text() { return new TextDecoder().decode(new Uint8Array(this.w.memory.buffer, this.w.text(), this.w.text_length())); },
  /* After a panic the module can't go on, and its text is that of the panic. */
  call(name, ...words) {
    let done = false;
    try { done = this.w[name](...words); } catch { this.isBroken = true; }
    if (!done) throw new Error(this.text());
  },
  set(name, value) {
    if (!(name in this.index)) throw new Error(`There is no variable ${name}.`);
    this.call("set", this.index[name], value);
  },
  read(elements) { this.values = new Float64Array(this.w.memory.buffer, this.w.values(elements), this.variables.length); },
  value(name) { return this.values[this.index[name]]; },
  field(name) { return Array.from(this.values.subarray(this.index[name], this.index[name] + this.places)); },
};

const variators = JSON.parse($("variators").textContent);
const fresh = () => ({ variator: "bench168", manoeuvre: "Steady", set: {}, inputs: { ...FIRST }, engine: true, road: true, clamp: "force", pace: 1, span: 5000, plots: [] });
let settings = fresh(), parameters = {}, step = 0, begun = [], isRunning = true, isStarting = false, record = null, cursor = null, plots = [], drawing, rows;
const drawn = { angles: [0, 0], way: 0, slow: 1 }, pace = { owed: 0, asked: 0, done: 0, shown: 0, period: 16 };
const stats = { frames: 0, computing: 0, drawing: 0, milliseconds: 0 };

const isChain = () => parameters["belt.kind"] === 2;
const changed = () => ({ ...OWN, ...MANOEUVRES[settings.manoeuvre]?.[0], ...settings.set });
const digits = (value, count = 4) => Number(value.toPrecision(count)).toLocaleString("en").replaceAll(",", "\u202f").replace("-", "\u2212");
const say = (text) => { $("said").textContent = text; };
const fail = (error) => {
  [isRunning, $("fault").hidden, $("fault").textContent] = [false, false, error.message ?? `${error}`];
  $("pause").textContent = "Run";
};
const attempt = (action) => { try { action(); } catch (error) { fail(error); } };

/* A start with the settings, of the manoeuvre if there is one. */
async function start() {
  if (isStarting) return;
  [isStarting, drawing, $("fault").hidden, $("log").textContent] = [true, undefined, true, ""];
  try {
    if (model.isBroken) await model.renew();
    const manoeuvre = MANOEUVRES[settings.manoeuvre];
    if (manoeuvre) settings.inputs = { ...FIRST, ...manoeuvre[1] };
    parameters = Object.fromEntries(model.variables.filter(({ start }) => start !== null).map(({ name, start }) => [name, start]));
    Object.assign(parameters, variators[settings.variator].parameters, changed());
    [step, begun, record, drawn.angles, drawn.way, pace.owed] = [0, [], null, [0, 0], 0, 0];
    refresh();
    for (const [name, value] of Object.entries(parameters)) model.set(name, value);
    const speed = parameters["initial.primarySpeed"];
    load(speed, speed / parameters["initial.ratio"]);
    rows = new Float32Array(KEPT * model.scalars);
    model.call("start");
    keep(1);
    const [distance, length, pitchOffset] = ["geometry.centerDistance", "geometry.beltLength", "belt.pitchOffset"].map((name) => 1e3 * parameters[name]);
    drawing = new BeltDrawing(document.querySelector(".belt svg"), {
      distance, length, pitchOffset, reach: 1e3 * Math.max(parameters["primary.maxRadius"], parameters["secondary.maxRadius"]) + 9, chain: isChain(), colours: SCALE,
      count: Math.round(length / ((isChain() ? 1e3 : 3e3) * parameters["belt.elementThickness"])), magnification: 0, gapScale: 0, most: 0,
    });
  } catch (error) { fail(error); }
  isStarting = false;
}

/* Notes the messages and values of now. */
function keep(elements) {
  if (model.text()) $("log").textContent += `${(step / 1000).toFixed(3)} s: ${model.text()}\n`;
  model.read(elements);
  rows.set(model.values.subarray(0, model.scalars), (step % KEPT) * model.scalars);
}

/* Inputs of the next millisecond: the sliders, which a manoeuvre moves, the limits of the engine, and the road load. */
function load(p, s) {
  const { inputs, engine, road, clamp } = settings;
  for (const [k, [begin, duration, name, value]] of (MANOEUVRES[settings.manoeuvre]?.[2] ?? []).entries()) {
    const passed = step / 1000 - begin;
    if (passed < 0 || passed > duration + 1e-9) continue;
    begun[k] ??= inputs[name];
    inputs[name] = begun[k] + (duration ? Math.min(passed / duration, 1) : 1) * (value - begun[k]);
  }
  const fading = (torque, speed) => torque * (torque * speed < 0 ? Math.min(Math.abs(speed) / SLOW, 1) : 1);
  const [driving, load] = [inputs["primary.torque"], inputs["secondary.torque"]];
  model.set("primary.torque", engine ? fading(driving, p) - GOVERNOR * Math.max(Math.abs(p) - GOVERNED, 0) * Math.sign(p) : driving);
  model.set("secondary.torque", road ? fading(load, s) - DRAG * s * Math.abs(s) : load);
  for (const pulley of PULLEYS) {
    const force = inputs[`${pulley}.clampingForce`], isForce = clamp === "force";
    model.set(`${pulley}.clampingForce`, isForce ? force : 0);
    model.set(`${pulley}.pressure`, isForce ? 0 : force / parameters[`${pulley}.cylinder.area`]);
  }
}

function advance() {
  load(model.value("primary.speed"), model.value("secondary.speed"));
  model.call("advance", (step + 1) / 1000);
  step++;
  keep(0);
  PULLEYS.forEach((pulley, n) => { drawn.angles[n] += (1e-3 * model.value(`${pulley}.speed`)) / drawn.slow; });
  drawn.way += model.value("belt.speed") / drawn.slow;
  if (record?.push(model.values.slice(0, model.scalars)) >= LONGEST) save();
}

/* Radii of the reference curve on S and P, m, by Newton's method. */
function radii(theta) {
  const [d, length] = [parameters["geometry.centerDistance"], parameters["geometry.beltLength"]], ratio = (1 - theta) / (1 + theta);
  let p = (length - 2 * d) / (Math.PI * (1 + ratio));
  for (let k = 0; k < 20; k++) {
    const difference = (1 - ratio) * p, phi = Math.acos(difference / d), slope = 2 * (Math.PI - phi) + 2 * ratio * phi;
    p -= (2 * Math.sqrt(d * d - difference ** 2) + slope * p - length) / slope;
  }
  return [ratio * p, p];
}

function drawBelt(now) {
  const [s, p] = radii(model.value("reference.theta")), [d, length, pitch] = [drawing.distance, drawing.length, drawing.pitchOffset].map((one) => 1e-3 * one);
  const phi = Math.acos((p - s) / d), thickness = parameters["belt.elementThickness"];
  const push = model.field(isChain() ? "profile.ringTension[1]" : "profile.pushForce[1]"), gap = model.field("profile.gap[1]");
  const offset = model.field("profile.radialDeviation[1]").map((deviation, n) => {
    const place = (n / model.places) * length, fromS = Math.min(place, length - place);
    if (fromS < s * phi) return deviation + model.value("secondary.radius") + pitch - s;
    return length / 2 - fromS < p * (Math.PI - phi) ? deviation + model.value("primary.radius") + pitch - p : deviation;
  });
  // Magnifications and the scale of colours stay for a second, unless the drawing would leave them.
  const almostMost = (values) => values.map(Math.abs).sort((a, b) => a - b)[Math.floor(0.99 * (values.length - 1))];
  const round = (bound) => Math.max(...ROUND.filter((one) => one <= Math.max(bound, 1)));
  const magnification = round((0.3 * Math.min(s, p)) / almostMost(offset)), gapScale = round((0.75 * thickness) / Math.max(almostMost(gap), 1e-9));
  const force = Math.max(...push, 1), power = 10 ** Math.floor(Math.log10(force)), most = [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((one) => one * power >= force) * power;
  if (!drawing.most || magnification < drawing.magnification || force > drawing.most || now - drawing.since > 1000) {
    Object.assign(drawing, { magnification, gapScale: gapScale / thickness, most, since: now });
    const turns = (Math.max(...PULLEYS.map((one) => Math.abs(model.value(`${one}.speed`)))) * settings.pace) / (2 * Math.PI * TURNS);
    drawn.slow = Math.max(Number(turns.toPrecision(1)), 1);
    $("most").textContent = `${digits(1e-3 * most)} kN ${isChain() ? "tension" : "push force"}`;
    $("drawn").textContent = `The distance from the reference curve is magnified ${magnification} times. ` +
      (isChain() ? "The pins of the chain are drawn." : `Gaps between elements are magnified ${gapScale} times, one drawn element represents 3 elements.`) +
      (drawn.slow > 1 ? ` One turn in the drawing represents ${drawn.slow} turns.` : "");
  }
  drawing.draw({ radii: [1e3 * s, 1e3 * p], angles: drawn.angles, way: drawn.way, places: model.places, push: (n) => push[n], offset: (n) => 1e3 * offset[n], gap: (n) => gap[n] });
}

/* A step of 1, 2 or 5 times a power of ten, of which about `count` fill a size. */
const tickOf = (size, count) => { const power = 10 ** Math.floor(Math.log10(size / count)); return [1, 2, 5, 10].find((one) => one * power * count >= size) * power; };

/* Variables over time, or fields along the belt. */
class Plot {
  constructor([title, ...lines], close) {
    const { factor, shown } = model.variables[model.index[lines[0][0]]];
    Object.assign(this, { lines, factor, isField: lines[0][0].endsWith("]"), section: document.createElement("section") });
    this.section.innerHTML = '<h4><span></span></h4><div class="keys"></div><canvas role="img"></canvas>';
    [this.heading, this.keys, this.canvas] = this.section.children;
    this.heading.firstChild.textContent = shown ? `${title}, ${shown}` : title;
    this.canvas.setAttribute("aria-label", this.heading.textContent);
    for (const [, , colour] of lines) this.keys.append(Object.assign(document.createElement("span"), { style: `color: ${COLOURS[colour]}` }));
    if (close) this.heading.append(Object.assign(document.createElement("button"), { type: "button", textContent: "×", title: "Remove this plot", onclick: close }));
    if (!this.isField) this.canvas.onpointermove = ({ offsetX }) => { cursor = (offsetX - 48) / (this.canvas.clientWidth - 56); };
    this.canvas.onpointerleave = () => { cursor = null; };
    $("plots").append(this.section);
  }

  draw() {
    const { canvas, factor, lines, isField } = this, ratio = devicePixelRatio || 1, [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio)) [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const g = canvas.getContext("2d"), [left, right, top, bottom] = [48, width - 8, 6, height - 22];
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, height);
    const span = isField ? model.places : settings.span, last = isField ? span - 1 : step, first = isField ? 0 : Math.max(0, last - span);
    const values = lines.map(([name]) => {
      const field = isField && model.field(name), at = model.index[name];
      return (k) => factor * (field ? field[k] : rows[(k % KEPT) * model.scalars + at]);
    });
    // Least and largest value in each pixel.
    const every = Math.max(1, Math.ceil((last - first) / (right - left)));
    let [low, high] = [Infinity, -Infinity];
    const points = values.map((value) => {
      const found = [];
      for (let k = first; k <= last; k += every) {
        let [a, b] = [Infinity, -Infinity];
        for (let j = k; j < Math.min(k + every, last + 1); j++) { const one = value(j); if (one < a) a = one; if (one > b) b = one; }
        found.push(k, a, b);
        [low, high] = [Math.min(low, a), Math.max(high, b)];
      }
      return found;
    });
    const least = Math.max(0.02 * Math.max(Math.abs(low), Math.abs(high)), 1e-9), wider = 0.5 * Math.max(least - (high - low), 0);
    [low, high] = [low - wider, high + wider];
    const tick = tickOf(high - low, 4);
    [low, high] = [tick * Math.floor(low / tick + 0.05), tick * Math.ceil(high / tick - 0.05)];
    const x = (k) => left + ((k - first) / span) * (right - left), y = (value) => top + ((high - value) / (high - low)) * (bottom - top);
    Object.assign(g, { font: "11.5px system-ui, sans-serif", fillStyle: INK, strokeStyle: GRID, lineWidth: 1, lineJoin: "round", textAlign: "right", textBaseline: "middle" });
    const line = (x0, y0, x1, y1) => { g.beginPath(); g.moveTo(x0, y0); g.lineTo(x1, y1); g.stroke(); };
    for (let k = Math.round(low / tick); k <= Math.round(high / tick); k++) { line(left, y(k * tick), right, y(k * tick)); g.fillText(digits(k * tick), left - 6, y(k * tick)); }
    const [scale, unit] = isField ? [drawing.length / span, "mm"] : span < 1000 ? [1, "ms"] : [1e-3, "s"], across = tickOf(span * scale, 4);
    Object.assign(g, { textAlign: "center", textBaseline: "top" });
    for (let k = Math.ceil((first * scale) / across); k * across <= (first + span) * scale; k++) {
      const isLast = (k + 1) * across > (first + span) * scale, text = digits(k * across, 6) + (isLast ? ` ${unit}` : "");
      line(x((k * across) / scale), top, x((k * across) / scale), bottom);
      g.fillText(text, Math.min(x((k * across) / scale), right + 8 - 0.5 * g.measureText(text).width), bottom + 5);
    }
    g.lineWidth = 1.5;
    lines.forEach(([, , colour, dash], n) => {
      g.strokeStyle = COLOURS[colour];
      g.setLineDash(dash ?? []);
      g.beginPath();
      for (let k = 0; k < points[n].length; k += 3) { const [place, a, b] = [x(points[n][k]), points[n][k + 1], points[n][k + 2]]; g.lineTo(place, y(a)); if (b > a) g.lineTo(place, y(b)); }
      g.stroke();
    });
    const at = cursor === null || isField ? last : Math.round(Math.min(Math.max(first + cursor * span, first), last));
    Object.assign(g, { strokeStyle: INK }).setLineDash([]);
    if (at < last) line(x(at), top, x(at), bottom);
    lines.forEach(([, label], n) => {
      const value = isField ? Math.max(...points[n].filter((_, k) => k % 3 === 2)) : values[n](at);
      this.keys.children[n].textContent = `${label} ${digits(value, isField ? 3 : 4)}`;
    });
  }
}

function showFacts() {
  const isSlipping = model.value("macroSlip") === 1;
  const facts = [["ratio.geometric", "ratio"], ["primary.speed", "speed of P"], ["secondary.speed", "speed of S"], ["thrustRatio", "thrust ratio", 3], ["slip", isSlipping ? "macro-slip" : "slip", 3],
    ["torqueUtilisation", "of the torque of full slip", 3], ["pushForce.max", "largest push force", 3], ["loss.total", "losses", 3]];
  $("facts").innerHTML = facts.map(([name, label, count]) => {
    const { factor, shown } = model.variables[model.index[name]];
    return `<div${name === "slip" && isSlipping ? ' class="alarm"' : ""}><b>${digits(factor * model.value(name), count)} ${shown}</b><span>${label}</span></div>`;
  }).join("");
  const reached = pace.asked > 20 ? pace.done / pace.asked : 1;
  const slow = reached < 0.85 ? `: slow motion, this machine reaches ${digits(settings.pace * reached, 2)} × real time` : "";
  $("clock").textContent = `${(step / 1000).toFixed(3)} s${isRunning ? slow : ", paused"}`;
  [pace.asked, pace.done] = [0.8 * pace.asked, 0.8 * pace.done];
  for (const [name] of SLIDERS) showSlider(name);
}

function frame(now) {
  const passed = Math.min(now - (pace.last ?? now), 100), began = performance.now(), enough = Math.max(12, 0.7 * pace.period);
  pace.last = now;
  pace.period += 0.1 * (passed - pace.period);
  attempt(() => {
    if (!drawing || model.isBroken) return;
    pace.owed += isRunning ? passed * settings.pace : 0;
    const due = Math.floor(pace.owed);
    let done = 0;
    // Not more than fits a frame: a slow machine shows slow motion.
    for (; done < due && performance.now() - began < enough; done++) advance();
    [pace.owed, pace.asked, pace.done, stats.milliseconds] = [pace.owed - due, pace.asked + due, pace.done + done, stats.milliseconds + done];
    stats.computing += performance.now() - began;
    model.read(1);
    drawBelt(now);
    plots.forEach((plot, k) => { if ((k + stats.frames) % 2 || !isRunning) plot.draw(); });
    if (now - pace.shown > 150) { showFacts(); pace.shown = now; }
    [stats.first, stats.drawing, stats.frames] = [stats.first ?? performance.now(), stats.drawing + performance.now() - began, stats.frames + 1];
  });
  requestAnimationFrame(frame);
}

/* The address has what differs from the beginning. */
function address() {
  const words = new URLSearchParams(), usual = fresh();
  for (const name of ["variator", "manoeuvre", "engine", "road", "clamp", "pace", "span", "plots"]) if (`${settings[name]}` !== `${usual[name]}`) words.set(name, settings[name]);
  if (!settings.manoeuvre) for (const name in FIRST) if (settings.inputs[name] !== FIRST[name]) words.set(name, settings.inputs[name]);
  for (const [name, value] of Object.entries(settings.set)) words.set(name, value);
  return `${words}`;
}

function follow(hash) {
  settings = fresh();
  for (const [name, text] of new URLSearchParams(hash)) {
    if (name === "engine" || name === "road") settings[name] = text === "true";
    else if (name === "pace" || name === "span") settings[name] = Number(text) || settings[name];
    else if (name === "plots") settings.plots = text.split(",").filter((one) => one in model.index);
    else if (name === "manoeuvre" || name === "clamp" || (name === "variator" && text in variators)) settings[name] = text;
    else if (Number.isFinite(Number(text))) (name in FIRST ? settings.inputs : settings.set)[name] = Number(text);
  }
}

/* Factor and unit in which a slider shows its input. */
const scaleOf = (name) =>
  name.endsWith("torque") ? [1, "N·m"] : settings.clamp === "force" ? [1e-3, "kN"] : [1e-5 / parameters[name.replace("clampingForce", "cylinder.area")], "bar"];
const showSlider = (name) => {
  const shown = Number((scaleOf(name)[0] * settings.inputs[name]).toFixed(2));
  for (const one of $(name).querySelectorAll("input")) if (one !== document.activeElement || settings.manoeuvre) one.value = shown;
};

/* Shows the settings in controls, plots and address. */
function refresh() {
  for (const [name, , min, max] of SLIDERS) {
    const [factor, unit] = scaleOf(name);
    for (const one of $(name).querySelectorAll("input")) Object.assign(one, { min: Math.round(factor * min), max: Math.round(factor * max), step: 0.1 });
    $(name).querySelector("span").textContent = unit;
    showSlider(name);
  }
  for (const name of ["engine", "road"]) $(name).checked = settings[name];
  for (const name of ["clamp", "variator", "pace", "span"]) $(name).value = settings[name];
  $("ring").value = parameters["ring.model"];
  $("pause").textContent = isRunning ? "Pause" : "Run";
  $("record").setAttribute("aria-pressed", record !== null);
  for (const one of $("manoeuvres").children) one.setAttribute("aria-pressed", one.textContent === settings.manoeuvre);
  $("set").replaceChildren(...Object.entries(changed()).map(([name, value]) => {
    const { unit, items, about, min, max } = model.variables[model.index[name]] ?? { about: "There is no such variable." }, row = document.createElement("tr");
    const field = items ? `<select>${items.map(([number, text]) => `<option value="${number}">${text}</option>`).join("")}</select>` : '<input inputmode="decimal" size="10">';
    row.innerHTML = `<td><code></code><td>${field} ${unit === "1" ? "" : unit ?? ""}<td>`;
    row.querySelector("code").textContent = name;
    row.lastChild.textContent = about + (min || max ? ` (${min ?? "−∞"} to ${max ?? "∞"})` : "");
    const input = Object.assign(row.querySelector("input, select"), { value, ariaLabel: name });
    input.onchange = () => change(name, input.value === "" ? undefined : Number(input.value));
    return row;
  }));
  $("plots").replaceChildren();
  const own = settings.plots.map((name) => [name, [name, "now", 0]]), last = PLOTS.length - 1;
  plots = [...PLOTS.slice(0, last), isChain() ? [PLOTS[last][0], PLOTS[last][2]] : PLOTS[last]].map((one) => new Plot(one));
  for (const one of own) plots.push(new Plot(one, () => { settings.plots = settings.plots.filter((name) => name !== one[0]); refresh(); }));
  history.replaceState(null, "", `#${address()}`);
  $("settings").textContent = [...new URLSearchParams(address())].map((one) => one.join(" ")).join(", ") || "all settings as at the beginning";
}

/* Sets a parameter, or with no value takes the variator's. */
function change(name, value) {
  if (value === undefined) delete settings.set[name]; else settings.set[name] = value;
  if (value === undefined || !model.variables[model.index[name]]?.isTunable) return void start();
  attempt(() => { model.set(name, value); parameters[name] = value; refresh(); });
}

/* A hand on a slider ends the manoeuvre. */
function slide(name, text) {
  const [min, max] = SLIDERS.find(([one]) => one === name).slice(2);
  if (settings.manoeuvre) Object.assign(settings, { set: { ...MANOEUVRES[settings.manoeuvre]?.[0], ...settings.set }, manoeuvre: "" });
  settings.inputs[name] = Math.min(Math.max(Number(text) / scaleOf(name)[0] || 0, min), max);
  showSlider(name);
}

function save() {
  const shown = model.variables.slice(0, model.scalars).map((one, k) => [one, k]).filter(([{ causality }]) => causality !== "parameter"), first = step - record.length + 1;
  const head = ["time [s]", ...shown.map(([{ name, unit }]) => `${name} [${unit || 1}]`)];
  const lines = record.map((values, k) => [(first + k) / 1000, ...shown.map(([, at]) => Number(values[at].toPrecision(9)))]);
  Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([[head, ...lines, ""].join("\n")], { type: "text/csv" })), download: "pushbelt-live.csv" }).click();
  say(`pushbelt-live.csv has ${record.length} rows.`);
  record = null;
  refresh();
}

const actions = {
  pause() { isRunning = !isRunning; refresh(); },
  step() { if (isRunning) actions.pause(); if (drawing) attempt(() => { advance(); showFacts(); }); },
  again() { isRunning = true; start(); },
  record() {
    if (record?.length) return save();
    record = [];
    say("Each millisecond is recorded until the button is pressed again.");
    refresh();
  },
  link() { navigator.clipboard.writeText(location.href).then(() => say("The link is in the clipboard."), () => say("The address of this page is the link.")); },
};

function build() {
  const make = (tag, properties) => Object.assign(document.createElement(tag), properties), names = Object.keys(MANOEUVRES), manoeuvre = (name) => { Object.assign(settings, { manoeuvre: name, set: {} }); actions.again(); };
  $("manoeuvres").replaceChildren(...names.map((name, k) => make("button", { type: "button", textContent: name, title: `Key ${k + 1}`, onclick: () => manoeuvre(name) })));
  $("sliders").replaceChildren(...SLIDERS.map(([name, label]) => {
    const row = make("div", { className: "slider", id: name });
    row.innerHTML = `<label for="${name}-range">${label}</label><label><input type="number" aria-label="${label}"> <span></span></label><input type="range" id="${name}-range">`;
    row.oninput = ({ target }) => slide(name, target.value);
    row.onchange = refresh;
    return row;
  }));
  $("variator").replaceChildren(...Object.entries(variators).map(([id, { about }]) => make("option", { value: id, textContent: id, title: about })));
  $("names").replaceChildren(...model.variables.filter(({ causality }) => causality === "parameter").map(({ name }) => make("option", { value: name })));
  $("more").append(...model.variables.slice(0, model.scalars).filter(({ causality }) => causality === "output" || causality === "local").map(({ name }) => make("option", { textContent: name })));
  document.querySelector(".scale i").style.background = `linear-gradient(90deg, ${SCALE.map((one) => `rgb(${one})`)})`;
  for (const name in actions) $(name).onclick = actions[name];
  $("more").onchange = ({ target }) => { settings.plots = [...new Set([...settings.plots, target.value])]; target.value = ""; refresh(); };
  $("name").onchange = ({ target: { value } }) => {
    if (model.variables[model.index[value]]?.causality !== "parameter") return;
    [settings.set[value], $("name").value] = [parameters[value], ""];
    refresh();
  };
  for (const name of ["engine", "road", "clamp"]) $(name).onchange = ({ target }) => { settings[name] = name === "clamp" ? target.value : target.checked; refresh(); };
  for (const name of ["pace", "span"]) $(name).onchange = ({ target }) => { settings[name] = Number(target.value); pace.asked = pace.done = 0; if (drawing) drawing.most = 0; refresh(); };
  $("variator").onchange = ({ target }) => { settings.variator = target.value; start(); };
  $("ring").onchange = ({ target }) => change("ring.model", target.value === "2" ? undefined : Number(target.value));
  addEventListener("hashchange", () => { if (location.hash.slice(1) !== address()) { follow(location.hash.slice(1)); start(); } });
  addEventListener("keydown", (event) => {
    const { key, target } = event, isTyping = target.matches("input:not([type=range], [type=checkbox]), select") || (key === " " && target.matches("button, summary, [type=checkbox]"));
    const action = { " ": actions.pause, ".": actions.step, r: actions.again, c: actions.record }[key] ?? (names[key - 1] && (() => manoeuvre(names[key - 1])));
    if (!action || isTyping || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  });
}

model.load().then(async () => {
  build();
  follow(location.hash.slice(1));
  await start();
  requestAnimationFrame(frame);
}).catch(fail);
