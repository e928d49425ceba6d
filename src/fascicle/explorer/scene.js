// Projects solids by `plot/projection.js`, which stands ahead of this; Bokeh draws flat patches. A
// hand on an end of the muscle pulls it; elsewhere it turns the camera, as the slider does, and a
// double click turns it back. Arguments: camera (tags: azimuth and elevation at first), slider,
// points (tags: half of what must be seen across and up, half a fiber's width, rest length [m]),
// faces, fibers (tags: a color each), drawn, frame, along, lift, hand (the end's new strain; tags: the present one).
const [reach, tall, thin, rest] = points.tags;
const angle = () => [camera.data.azimuth[0], camera.data.elevation[0]];
const aim = (azimuth, elevation) => {
  camera.data = {azimuth: [azimuth], elevation: [elevation]};
  slider.value = Math.round(azimuth);
};
const draw = () => {
  const [azimuth, elevation] = angle();
  const seen = projectSolids({azimuth, elevation, points: points.data, faces: faces.data,
    fibers: fibers.data, along, colors: fibers.tags, thin, lift});
  drawn.data = {xs: seen.map(s => s[1]), ys: seen.map(s => s[2]), color: seen.map(s => s[3])};
  // undistorted in whatever room there is, and all of it to be seen
  const size = name => frame.properties[name].is_unset ? 1 : frame[name] || 1;
  const shape = size("inner_height") / size("inner_width");
  const x = Math.max(reach, tall / shape), y = x * shape;
  if (frame.x_range.end !== x || frame.y_range.end !== y) {
    frame.x_range.setv({start: -x, end: x}); frame.y_range.setv({start: -y, end: y});
  }
};
switch (cb_obj.event_name) {
  case "panstart": {
    camera.grip = {azimuth: camera.data.azimuth, elevation: camera.data.elevation, pulls: false};
    const [strain] = hand.tags, cosine = Math.abs(Math.cos(angle()[0] * Math.PI / 180));
    if (strain === undefined || cosine < 0.3) break;  // no muscle to pull, or seen from its end
    const ends = [Infinity, -Infinity];
    for (const xs of drawn.data.xs)
      for (const x of xs) { ends[0] = Math.min(ends[0], x); ends[1] = Math.max(ends[1], x); }
    const [low, high] = ends, x = cb_obj.x;
    const pulls = Math.min(Math.abs(x - low), Math.abs(x - high)) < 0.15 * (high - low);
    // both ends move from the middle: one follows the hand if the length changes twice as much
    const rate = 2 * Math.sign(x - (low + high) / 2) / (rest * cosine);
    Object.assign(camera.grip, {pulls, x, strain, rate});
    break;
  }
  case "pan": {
    const grip = camera.grip;
    if (grip.pulls) {
      const now = performance.now();
      if (now - (hand.last ?? 0) < 40) break;  // ms
      hand.last = now;
      hand.data = {strain: [grip.strain - grip.rate * (cb_obj.x - grip.x)]};
      break;
    }
    const turned = grip.azimuth[0] - 0.5 * cb_obj.delta_x;
    aim(((turned + 180) % 360 + 360) % 360 - 180,
        Math.max(-89, Math.min(89, grip.elevation[0] + 0.5 * cb_obj.delta_y)));
    break;
  }
  case "doubletap":
    aim(...camera.tags);
    break;
  default:
    if (cb_obj === slider) {
      if (Math.round(camera.data.azimuth[0]) !== slider.value) aim(slider.value, angle()[1]);
    } else draw();
}
