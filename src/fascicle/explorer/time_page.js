// Plays a run in the browser: moves the cursors, the drawing and the numbers, and tells the server
// nothing of it. Arguments: frames (a row each; tags: what stays the same in all of them), slider,
// play, cursors, tubes, boxes, labels, valves, readout, scene (the drawing's figure), speed.
const quiet = {sync: false};  // not to the server
const still = {...quiet, check_eq: false};
const D = frames.data, count = D.time?.length ?? 0, fixed = frames.tags[0];
const player = frames.player ??= {shown: -1, start: null, request: 0, last: 0};

const nearest = (time) => {
  let low = 0, high = count - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (D.time[middle] <= time) low = middle; else high = middle;
  }
  return time - D.time[low] <= D.time[high] - time ? low : high;
};
const row = (column, i) => {  // Bokeh's arrays of two dimensions have no slices
  const width = column.length / count;
  return Array.from({length: width}, (_, k) => column[i * width + k]);
};
// outline of so many points, at an offset
const outline = (points, first, length, x0) => {
  const xs = new Array(length), ys = new Array(length);
  for (let k = 0; k < length; k++) {
    xs[k] = x0 + points[first + 2 * k];
    ys[k] = points[first + 2 * k + 1];
  }
  return [xs, ys];
};
const show = (time) => {
  if (!count) return;
  const i = nearest(time);
  if (i === player.shown) return;
  player.shown = i;
  for (const cursor of cursors) cursor.setv({location: D.time[i]}, quiet);
  const states = row(D.states, i), T = row(D.tubes, i), H = row(D.heights, i);
  const pressures = row(D.pressures, i), openings = row(D.openings, i);
  const tube = {xs: [], ys: [], fill: [], line: [], alpha: [], hatch: []};
  const points = T.length / 2 / states.length;
  for (const [unit, x0] of fixed.muscles) {
    const [xs, ys] = outline(T, 2 * points * unit, points, x0);
    tube.xs.push(xs); tube.ys.push(ys);
    tube.fill.push(fixed.colors[unit]); tube.line.push(fixed.colors[unit]);
    tube.alpha.push(fixed.alphas[states[unit]]); tube.hatch.push(fixed.hatches[states[unit]]);
  }
  tubes.setv({data: tube}, still);
  boxes.setv({data: {...fixed.boxes, bottom: H.filter((_, k) => k % 2 === 0),
    top: H.filter((_, k) => k % 2)}}, still);
  const text = {x: [], y: [], label: []}, valve = {x: [], y: [], marker: [], size: [], color: []};
  const words = [];
  fixed.labels.forEach(([x, width], unit) => {
    const state = fixed.states[states[unit]], P = pressures[unit].toFixed(fixed.digits).replace(/^-(?=[0.]*$)/, "").replace("-", "−");
    const name = fixed.narrow ? `${unit + 1}` : `unit ${unit + 1}\n${state}`;
    text.x.push(x); text.y.push(fixed.label_height); text.label.push(name);
    const open = openings[unit];
    valve.x.push(x); valve.y.push(fixed.valve_height);
    valve.marker.push(open > 0 ? "inverted_triangle" : open < 0 ? "triangle" : "dash");
    valve.size.push(open ? 7 + 7 * Math.min(1, Math.abs(open)) : 9);
    valve.color.push(open ? fixed.open : fixed.shut);
    const way = open > 0 ? "filling" : open < 0 ? "venting" : "shut";
    words.push(`unit ${unit + 1}: ${P} ${fixed.pressure_unit}, ${state}, ${way}`);
  });
  labels.setv({data: text}, still);
  valves.setv({data: valve}, still);
  const numbers = fixed.numbers.map(([name, column, unit]) =>
    `${name} ${D[column][i].toPrecision(4).replace("-", "−")} ${unit}`);
  readout.setv({text: `<b>t = ${D.time[i].toFixed(3)} s</b> · ${numbers.join(" · ")}<br>`
    + words.join(" · ")}, quiet);
};
const fit = () => {
  if (!fixed) return;
  const size = name => scene.properties[name].is_unset ? 1 : scene[name] || 1;
  const shape = size("inner_height") / size("inner_width");
  const [left, right, low, high] = fixed.extent;
  const half = Math.max((right - left) / 2, (high - low) / 2 / shape);
  const [x, y] = [(left + right) / 2, (low + high) / 2];
  scene.x_range.setv({start: x - half, end: x + half}, quiet);
  scene.y_range.setv({start: y - half * shape, end: y + half * shape}, quiet);
};
const set = (time) => { slider.setv({value: time}, quiet); show(time); };
const pause = () => {
  cancelAnimationFrame(player.request);
  player.start = null;
  play.setv({label: "▶ Play"}, quiet);
};
const advance = (now) => {
  if (player.start === null) return;
  const end = D.time[count - 1];
  // a chart takes some milliseconds to draw: thirty frames a second leave time for keys
  if (now - player.last > 30) {
    player.last = now;
    const [began, from] = player.start;
    const time = Math.min(end, from + Number(speed.value) * (now - began) / 1000);
    set(time);
    if (time >= end) { pause(); return; }
  }
  player.request = requestAnimationFrame(player.advance);
};
const begin = () => {
  if (!count) return;
  const end = D.time[count - 1];
  const from = slider.value >= end - 1e-9 ? 0 : slider.value;
  player.start = [performance.now(), from];
  play.setv({label: "❚❚ Pause"}, quiet);
  player.request = requestAnimationFrame(player.advance);
};
const toggle = () => { if (player.start === null) begin(); else pause(); };
player.advance = advance;
player.toggle = toggle;

if (!player.listens) {  // the space bar, unless a field or a button has it
  player.listens = true;
  const deepest = (node) =>
    node?.shadowRoot?.activeElement ? deepest(node.shadowRoot.activeElement) : node;
  addEventListener("keydown", (event) => {
    const here = deepest(document.activeElement);
    const shown = Bokeh.index.find_one(play)?.el.checkVisibility();
    if (event.key !== " " || !shown || event.repeat
        || here?.matches("input, textarea, select, button, summary, a, .bk-tab, .bk-btn")) return;
    event.preventDefault();
    player.toggle();
  });
}
switch (cb_obj.origin ?? cb_obj) {  // an event, or the model that changed
  case play: toggle(); break;
  case slider:  // by a visitor: playing goes on from there
    if (player.start !== null) player.start = [performance.now(), slider.value];
    show(slider.value);
    break;
  case speed:
    if (player.start !== null) player.start = [performance.now(), slider.value];
    break;
  case frames:  // another run
    pause(); player.shown = -1; fit(); set(0);
    break;
  case scene: fit(); break;
  default:  // a click in a chart
    if (player.start !== null) player.start = [performance.now(), cb_obj.x];
    if (count) set(Math.max(0, Math.min(D.time[count - 1], cb_obj.x)));
}
