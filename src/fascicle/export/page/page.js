// The page: one state, sliders and figures that show it. Quantities are in SI units; those shown
// are in kPa, mm and N.
const DATA = JSON.parse(document.getElementById("data").textContent);
const KPA = 1e3, MM = 1e-3;
const POINTS = 161;  // of a curve
const REVERSAL_POINTS = 97;
const JUMP = 1e-4;  // of strain: far more than a smooth curve rises in a pascal
const SLICE = 6;  // ms of a frame that a long curve may take
const $ = id => document.getElementById(id);
const dark = matchMedia("(prefers-color-scheme: dark)");

const tables = DATA.tables.map(table => new MuscleTable(table));
const view = {pressures: DATA.start, strain: DATA.strain, curves: DATA.curves};
const isBundle = DATA.units.length > 1 || DATA.units[0].count > 1;

const figures = value => !Number.isFinite(value) ? "never"
  : value === 0 ? "0" : String(Number(value.toPrecision(4)));
const theme = () => DATA.theme[dark.matches ? "dark" : "light"];

// ---- the muscles

const bundleAt = pressures => new PressurizedBundle(
  DATA.units, pressures, DATA.ratios, (table, pressure) => new PressurizedMuscle(tables[table], pressure));

// Largest strain that is drawn, well past the free strain at the highest pressure.
function strainLimit() {
  const free = bundleAt(view.pressures.map(() => DATA.highest));
  const most = Math.max(...free.units.map((unit, i) => free.plateStrain(i, unit.free)));
  return Math.min(free.largestStrain, Math.max(0.1, Math.ceil(1.5 * most * 20) / 20));
}

// All that is shown of the state, as numbers [SI].
function results() {
  const bundle = bundleAt(view.pressures), {strain} = view;
  return {
    bundle, strain,
    force: bundle.force(strain), blocked: bundle.force(0), free: bundle.freeStrain(),
    units: bundle.units.map((unit, i) => ({
      force: bundle.unitForce(i, strain), blocked: bundle.unitForce(i, 0),
      free: bundle.plateStrain(i, unit.free), collapse: bundle.plateStrain(i, unit.collapse),
      region: unit.region(bundle.muscleStrain(i, strain)),
      deflection: unit.deflection(bundle.muscleStrain(i, strain)),
    })),
  };
}

// ---- charts

function canvasContext(canvas) {
  const box = canvas.getBoundingClientRect(), scale = window.devicePixelRatio || 1;
  const [width, height] = [Math.round(box.width * scale), Math.round(box.height * scale)];
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width; canvas.height = height;
  }
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, box.width, box.height);
  return [context, box.width, box.height];
}

function ticks(low, high, most) {
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(x => x * power >= rough);
  const result = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
    result.push(Number((i * step).toPrecision(6)));
  }
  return result;
}

class Chart {
  constructor(canvas, xLabel, yLabel) { Object.assign(this, {canvas, xLabel, yLabel}); }

  begin(xRange, yRange) {
    const [context, width, height] = canvasContext(this.canvas), colors = theme();
    Object.assign(this, {context, xRange, yRange, labels: [], taken: [], drawn: []});
    context.font = `13px ${DATA.font}`;
    const yTicks = ticks(...yRange, 6), xTicks = ticks(...xRange, width < 500 ? 4 : 8);
    const wide = Math.max(...yTicks.map(tick => context.measureText(String(tick)).width));
    this.box = [wide + 32, 12, width - 12, height - 44];
    const [left, top, right, bottom] = this.box;
    context.lineWidth = 1;
    context.fillStyle = colors.soft;
    context.strokeStyle = colors.line;
    context.beginPath();
    context.textAlign = "center"; context.textBaseline = "top";
    for (const tick of xTicks) {
      context.moveTo(this.x(tick), top); context.lineTo(this.x(tick), bottom);
      context.fillText(String(tick), this.x(tick), bottom + 6);
    }
    context.textAlign = "right"; context.textBaseline = "middle";
    for (const tick of yTicks) {
      context.moveTo(left, this.y(tick)); context.lineTo(right, this.y(tick));
      context.fillText(String(tick), left - 6, this.y(tick));
    }
    context.stroke();
    context.fillStyle = colors.ink;
    context.textAlign = "center"; context.textBaseline = "bottom";
    context.fillText(this.xLabel, (left + right) / 2, height - 4);
    context.save();
    context.translate(4, (top + bottom) / 2); context.rotate(-Math.PI / 2);
    context.textBaseline = "top";
    context.fillText(this.yLabel, 0, 0);
    context.restore();
    context.strokeStyle = colors.edge;
    context.beginPath();
    if (yRange[0] < 0 && yRange[1] > 0) {
      context.moveTo(left, this.y(0)); context.lineTo(right, this.y(0));
    }
    context.moveTo(left, top); context.lineTo(left, bottom);
    context.stroke();
  }

  x(value) {
    const [left, , right] = this.box, [low, high] = this.xRange;
    return left + (value - low) / (high - low) * (right - left);
  }

  y(value) {
    const [, top, , bottom] = this.box, [low, high] = this.yRange;
    return bottom - (value - low) / (high - low) * (bottom - top);
  }

  value(pixel) {
    const [left, , right] = this.box, [low, high] = this.xRange;
    return low + (high - low) * Math.min(Math.max((pixel - left) / (right - left), 0), 1);
  }

  line(curve, color, width, dash = []) {
    const {context} = this, [left, top, right, bottom] = this.box;
    context.save();
    context.beginPath();
    context.rect(left, top, right - left, bottom - top); context.clip();
    context.strokeStyle = color; context.lineWidth = width; context.setLineDash(dash);
    context.lineJoin = "round";
    context.beginPath();
    curve.x.forEach((x, i) => {  // with gaps where it has no value
      if (!Number.isFinite(curve.y[i])) return;
      const draw = Number.isFinite(curve.y[i - 1]) ? "lineTo" : "moveTo";
      const place = [this.x(x), this.y(curve.y[i])];
      context[draw](...place);
      this.drawn.push(place);
    });
    context.stroke();
    context.restore();
  }

  mark(x, y, color, text, radius = 4) {
    const {context} = this, [left, top, right, bottom] = this.box;
    const [a, b] = [this.x(x), this.y(y)];
    if (!(a >= left - 1 && a <= right + 1 && b >= top - 1 && b <= bottom + 1)) return;
    context.fillStyle = color; context.strokeStyle = theme().paper; context.lineWidth = 2;
    context.beginPath(); context.arc(a, b, radius, 0, 2 * Math.PI);
    context.fill(); context.stroke();
    this.taken.push([a - radius - 2, b - radius - 2, a + radius + 2, b + radius + 2]);
    if (!text) return;
    const wide = context.measureText(text).width;
    // above the mark or below, to its right or left
    this.labels.push([text, [14, -16, 30, -32, 46, -48, 62, 78, 94].flatMap(up =>
      [[a + 9, b - up], [a - 9 - wide, b - up]]), [a, b]]);
  }

  label(text, a, b) { this.labels.push([text, [[a, b]], null]); }

  // Write the labels, in order, each at that of its free places that the fewest points of curves are
  // behind, else it is left out; a line leads from it to its mark, unless it is right above.
  writeLabels() {
    const {context} = this, [left, top, right, bottom] = this.box;
    context.textAlign = "left"; context.textBaseline = "middle";
    context.lineWidth = 4; context.strokeStyle = theme().paper; context.fillStyle = theme().ink;
    for (const [text, places, mark] of this.labels) {
      const wide = context.measureText(text).width;
      const boxes = places.map(([a, b]) => [a - 2, b - 7, a + wide + 2, b + 7]);
      const isFree = box => box[0] > left && box[1] > top - 8 && box[2] < right + 10 && box[3] <= bottom
        && !this.taken.some(x => x[0] < box[2] && box[0] < x[2] && x[1] < box[3] && box[1] < x[3]);
      const covered = boxes.map(box => isFree(box) ? this.drawn.filter(([x, y]) =>
        box[0] < x && x < box[2] && box[1] < y && y < box[3]).length : Infinity);
      const fewest = Math.min(...covered), free = covered.indexOf(fewest);
      if (fewest === Infinity) continue;
      this.taken.push(boxes[free]);
      if (mark && free > 0) {
        const [box0, box1, box2, box3] = boxes[free];
        context.save();
        context.lineWidth = 1; context.strokeStyle = theme().soft;
        context.beginPath(); context.moveTo(...mark);
        context.lineTo(mark[0] < box0 ? box0 : box2, mark[1] < box1 ? box1 : box3);
        context.stroke();
        context.restore();
      }
      context.strokeText(text, ...places[free]); context.fillText(text, ...places[free]);
    }
  }
}

const forceChart = new Chart($("force"), "Contraction ε [–]", "Force F [N]");
const reversalChart = isBundle && DATA.units.length > 1
  ? new Chart($("reversal"), "Pressure of unit 2 [kPa]", "Free strain [–]") : null;
const deflectionChart = new Chart($("deflection"), "Contraction ε [–]", "Deflection [mm]");

function curveOf(bundle, top, force = strain => bundle.force(strain)) {
  const x = bundle.grid(0, top, POINTS);
  return {x, y: x.map(force)};
}

let family = null;  // curves at the chosen pressures, until the list changes
function familyOf() {
  if (family) return family;
  const top = strainLimit();
  const curves = [...new Set(view.curves)].map(pressure => {
    const bundle = bundleAt(view.pressures.map(() => pressure));
    return {pressure, ...curveOf(bundle, top)};
  });
  // the axis holds the highest pressure, so that it stands still while a slider moves
  const limit = bundleAt(view.pressures.map(() => DATA.highest));
  const values = [0, ...curves.flatMap(curve => curve.y), ...curveOf(limit, top).y];
  const [low, high] = [Math.min(...values), Math.max(...values)], pad = 0.05 * (high - low) || 1;
  return family = {curves, top, range: [low - pad, high + pad]};
}

function drawForce(shown) {
  const {curves, top, range} = familyOf(), colors = theme(), chart = forceChart;
  chart.begin([0, top], range);
  curves.forEach((curve, i) => {
    const color = colors.family[Math.round(i / Math.max(curves.length - 1, 1) *
                                           (colors.family.length - 1))];
    chart.line(curve, color, 1.3);
  });
  const {bundle} = shown, total = isBundle ? colors.ink : colors.curves[0];
  if (isBundle) {
    bundle.units.forEach((_, i) => {
      chart.line(curveOf(bundle, top, strain => bundle.unitForce(i, strain)),
                 colors.curves[i % colors.curves.length], 1.6, [6, 4]);
    });
  }
  chart.line(curveOf(bundle, top), total, 2.6);
  chart.mark(shown.strain, shown.force, colors.ink, `${figures(shown.force)} N`, 7);
  chart.mark(0, shown.blocked, total);
  if (Number.isFinite(shown.free)) chart.mark(shown.free, 0, total,
                                             `free ${figures(shown.free)}`);
  shown.units.forEach((unit, i) => {
    if (unit.collapse > top) return;
    chart.mark(unit.collapse, bundle.force(unit.collapse), colors.bad,
               isBundle ? `collapse of ${i + 1}` : `collapse ${figures(unit.collapse)}`, 3);
  });
  for (const {pressure, y} of curves) {
    chart.label(`${figures(pressure / KPA)} kPa`, chart.x(0) + 7, chart.y(y[0]));
  }
  chart.writeLabels();
}

// ---- the reversal: a curve that is computed in slices, so that no frame waits for it

function reversalKey() {
  return JSON.stringify(view.pressures.filter((_, i) => i !== 1));
}

let reversal = DATA.reversal && {...DATA.reversal, key: reversalKey()};  // the library's, at first

function* reversalSteps(key) {
  const curve = {key, x: [], y: [], done: false};
  const freeAt = pressure =>
    bundleAt(view.pressures.map((p, i) => i === 1 ? pressure : p)).freeStrain();
  for (let i = 0; i < REVERSAL_POINTS; i++) {
    // dense at low pressure, where it turns
    const pressure = DATA.highest * (i / (REVERSAL_POINTS - 1)) ** 2;
    curve.x.push(pressure / KPA); curve.y.push(freeAt(pressure));
    yield curve;
  }
  let least = curve.y.indexOf(Math.min(...curve.y));
  let [low, high] = [Math.max(least - 1, 0), Math.min(least + 1, REVERSAL_POINTS - 1)]
    .map(i => curve.x[i] * KPA);
  for (let zoom = 0; zoom < 5; zoom++) {
    const at = Array.from({length: 17}, (_, i) => low + (high - low) * i / 16), values = [];
    for (const pressure of at) { values.push(freeAt(pressure)); yield curve; }
    least = values.indexOf(Math.min(...values));
    curve.turn = [at[least], values[least]];
    [low, high] = [at[Math.max(least - 1, 0)], at[Math.min(least + 1, 16)]];
  }
  // the steepest step, halved until it is less than a pascal wide, is a jump if it is one still
  const points = curve.x.map((x, i) => [x * KPA, curve.y[i]]);
  const fall = i => Math.abs(curve.y[i + 1] - curve.y[i]) || 0;
  const steepest = curve.x.reduce((best, _, i) => fall(i) > fall(best) ? i : best, 0);
  let [before, after] = points.slice(steepest, steepest + 2);
  for (let halving = 0; halving < 15; halving++) {
    const pressure = (before[0] + after[0]) / 2, middle = [pressure, freeAt(pressure)];
    if (Math.abs(middle[1] - before[1]) > Math.abs(after[1] - middle[1])) after = middle;
    else before = middle;
    yield curve;
  }
  const jump = Math.abs(after[1] - before[1]) > JUMP ? [before, after] : [];
  if (jump.length) points.push(before, [before[0], NaN], after);
  const [turn] = curve.turn;
  if (!jump.length || turn < before[0] || turn > after[0]) points.push(curve.turn);
  points.sort(([a], [b]) => a - b);
  const line = part => ({x: part.map(([x]) => x / KPA), y: part.map(([, free]) => free)});
  Object.assign(curve, line(points), {jump: line(jump)});
  curve.done = true;
  yield curve;
}

let job = null;
function drawReversal(shown) {
  if (!reversalChart) return;
  const key = reversalKey();
  if (job?.key !== key) job = {key, steps: reversalSteps(key)};
  if (!reversal || reversal.key !== key) {
    const end = performance.now() + SLICE;
    let step;
    do step = job.steps.next(); while (!step.value.done && performance.now() < end);
    if (step.value.done) reversal = step.value; else schedule();
  }
  if (!reversal) return;
  const colors = theme(), values = reversal.y.filter(Number.isFinite);
  const [low, high] = [Math.min(...values), Math.max(...values)], pad = 0.08 * (high - low) || 0.01;
  reversalChart.begin([0, DATA.highest / KPA], [Math.max(low - pad, 0), high + pad]);
  const color = reversal.key === key ? colors.ink : colors.edge;
  reversalChart.line(reversal, color, 2.6);
  reversalChart.line(reversal.jump, color, 2, [2, 3]);
  const [turn, free] = reversal.turn, depth = reversal.y[0] - free;
  const turns = depth > 1e-12;  // as in the library: rounding of two roots
  $("turn").textContent = turns
    ? `The free strain falls by ${figures(depth)} up to ${figures(turn / KPA)} kPa of unit 2, then`
      + " rises: the reversal."
    : "The free strain never falls: there is no reversal.";
  if (turns) reversalChart.mark(turn / KPA, free, colors.bad, "reversal");
  if (Number.isFinite(shown.free)) {
    reversalChart.mark(view.pressures[1] / KPA, shown.free, colors.ink, "", 7);
  }
  reversalChart.writeLabels();
}

// ---- the deflection

function drawDeflection(shown) {
  const {bundle} = shown, colors = theme(), {top} = familyOf();
  const curves = bundle.units.map((unit, i) => {
    const x = bundle.grid(0, top, POINTS);
    return {x, y: x.map(strain => unit.deflection(bundle.muscleStrain(i, strain)) / MM)};
  });
  const most = Math.max(...curves.flatMap(curve => curve.y), 1);
  deflectionChart.begin([0, top], [0, 1.1 * most]);
  curves.forEach((curve, i) => {
    const color = colors.curves[i % colors.curves.length];
    deflectionChart.line(curve, color, 2.6, isBundle ? [6, 4] : []);
    const depth = `${figures(shown.units[i].deflection / MM)} mm`;
    const label = isBundle ? `unit ${i + 1}: ${depth}` : depth;
    deflectionChart.mark(shown.strain, shown.units[i].deflection / MM, colors.ink, label, 7);
  });
  deflectionChart.writeLabels();
}

// ---- controls and readings

function setText(id, text) { const node = $(id); if (node.textContent !== text) node.textContent = text; }

function showReadings(shown) {
  setText("force-value", `${figures(shown.force)} N`);
  setText("blocked-value", `${figures(shown.blocked)} N`);
  setText("free-value", figures(shown.free));
  if (!isBundle) {
    setText("collapse-value", figures(shown.units[0].collapse));
    setText("region-value", shown.units[0].region);
    setText("deflection-value", `${figures(shown.units[0].deflection / MM)} mm`);
  }
  shown.units.forEach((unit, i) => {
    const values = {force: `${figures(unit.force)} N`, free: figures(unit.free),
                    collapse: figures(unit.collapse), region: unit.region};
    if (isBundle) for (const [name, text] of Object.entries(values)) setText(`${name}-${i}`, text);
  });
  const [strain, force] = [figures(shown.strain), `${figures(shown.force)} N`];
  $("strain").setAttribute("aria-valuetext", `${strain}, force ${force}`);
  view.pressures.forEach((pressure, i) => {
    $(`pressure-${i}`).setAttribute("aria-valuetext", `${figures(pressure / KPA)} kPa, force ${force}`);
  });
}

function showControls() {
  view.pressures.forEach((pressure, i) => {
    for (const id of [`pressure-${i}`, `pressure-number-${i}`]) {
      if (document.activeElement !== $(id) || $(id).type === "range") {
        $(id).value = Number((pressure / KPA).toPrecision(6));
      }
    }
  });
  for (const id of ["strain", "strain-number"]) {
    if (document.activeElement !== $(id) || $(id).type === "range") {
      $(id).value = Number(view.strain.toPrecision(6));
    }
  }
}

let waiting = false;
function schedule() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; render(); });
}

function render() {
  const shown = results();
  drawForce(shown); drawDeflection(shown); drawReversal(shown);
  showReadings(shown); showControls();
}

// Show why a field is wrong right below it, or nothing.
function showError(input, text) {
  const id = `${input.id}-error`;
  let note = $(id);
  if (!note) {
    note = document.createElement("p");
    Object.assign(note, {id, className: "error", role: "status"});
    input.closest(".row").append(note);
    input.setAttribute("aria-describedby", id);
  }
  input.setAttribute("aria-invalid", text ? "true" : "false");
  setText(id, text);
}

// A number that someone types: shown as wrong, with the reason, until it is right.
function onNumber(input, low, high, unit, set) {
  input.addEventListener("input", () => {
    const value = input.valueAsNumber;
    let message = "";
    if (!(value >= low && value <= high)) {
      const [from, to] = [low, high].map(figures);
      message = `${input.dataset.name} must lie in ${from} to ${to} ${unit}`.trim() + ".";
    } else message = set(value) ?? "";
    showError(input, message);
  });
}

function prepareControls() {
  view.pressures.forEach((_, i) => {
    const set = value => { view.pressures[i] = value * KPA; schedule(); };
    // four digits, but at the end, which may have more
    $(`pressure-${i}`).addEventListener("input", ({target: {valueAsNumber: value, max}}) =>
      set(value < max ? Number(figures(value)) : value));
    onNumber($(`pressure-number-${i}`), 0, DATA.highest / KPA, "kPa", set);
  });
  const setStrain = value => { view.strain = value; schedule(); };
  const {largestStrain} = bundleAt(view.pressures);
  $("strain").addEventListener("input", event => setStrain(event.target.valueAsNumber));
  onNumber($("strain-number"), 0, largestStrain, "", setStrain);
  $("curves").addEventListener("input", event => {
    const values = event.target.value.split(/[\s,;]+/).filter(Boolean).map(Number);
    const good = values.length <= 12 && values.every(x => x >= 0 && x <= DATA.highest / KPA);
    showError(event.target, good ? "" : `Curves must be up to 12 pressures in 0 to ${
      figures(DATA.highest / KPA)} kPa, such as 100, 200.`);
    if (good) { view.curves = values.map(x => x * KPA); family = null; schedule(); }
  });
  prepareDragging($("force"), forceChart);
  prepareDragging($("deflection"), deflectionChart);
  $("save").addEventListener("click", savePicture);
}

// The pointer on the curves sets the strain; a finger that moves up or down scrolls instead.
function prepareDragging(canvas, chart) {
  let start = null;  // of a drag, which a finger begins by moving to the side
  const set = event => {
    const strain = chart.value(event.clientX - canvas.getBoundingClientRect().left);
    view.strain = Number(strain.toFixed(4));
    schedule();
  };
  canvas.addEventListener("pointerdown", event => {
    start = {x: event.clientX, y: event.clientY, moves: event.pointerType !== "touch"};
    canvas.setPointerCapture(event.pointerId);
    if (start.moves) set(event);
  });
  canvas.addEventListener("pointermove", event => {
    if (!start) return;
    const [dx, dy] = [event.clientX - start.x, event.clientY - start.y].map(Math.abs);
    start.moves ||= dx > 4 && dx > dy;
    if (start.moves) set(event);
  });
  canvas.addEventListener("pointerup", event => { if (start) set(event); start = null; });
  canvas.addEventListener("pointercancel", () => { start = null; });
}

// All figures, one below the other, with the title and the readings.
function savePicture() {
  const pictures = [$("force"), $("deflection"), ...(reversalChart ? [$("reversal")] : [])];
  const scale = window.devicePixelRatio || 1, head = 60 * scale;
  const picture = document.createElement("canvas");
  picture.width = Math.max(...pictures.map(canvas => canvas.width));
  picture.height = pictures.reduce((sum, canvas) => sum + canvas.height, head);
  const context = picture.getContext("2d"), colors = theme();
  context.fillStyle = colors.paper;
  context.fillRect(0, 0, picture.width, picture.height);
  context.fillStyle = colors.ink;
  context.font = `bold ${18 * scale}px ${DATA.font}`;
  context.fillText(DATA.title, 12 * scale, 24 * scale);
  context.font = `${13 * scale}px ${DATA.font}`;
  const pressures = view.pressures.map(pressure => `${figures(pressure / KPA)} kPa`).join(", ");
  context.fillText(`${pressures}; ε = ${figures(view.strain)}; F = ${$("force-value").textContent}`,
                   12 * scale, 48 * scale);
  let top = head;
  for (const canvas of pictures) { context.drawImage(canvas, 0, top); top += canvas.height; }
  picture.toBlob(blob => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${DATA.title.replace(/[^\w.-]+/g, "_")}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
  }, "image/png");
}

prepareControls();
dark.addEventListener("change", schedule);
new ResizeObserver(schedule).observe($("force"));
render();
document.body.dataset.state = "ready";
