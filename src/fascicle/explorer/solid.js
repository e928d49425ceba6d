// Projects solids by `plot/projection.js`, which stands ahead of this; Bokeh draws flat patches.
// Arguments: camera, points (tags: half of what must be seen across and up, half a fiber's width),
// faces, fibers (tags: a color each), drawn, frame, along, lift.
const [reach, tall, thin] = points.tags;
const seen = projectSolids({
  azimuth: camera.data.azimuth[0], elevation: camera.data.elevation[0], points: points.data,
  faces: faces.data, fibers: fibers.data, along, colors: fibers.tags, thin, lift,
});
drawn.data = {xs: seen.map(s => s[1]), ys: seen.map(s => s[2]), color: seen.map(s => s[3])};
// undistorted in whatever room there is, and all of it to be seen
const size = name => frame.properties[name].is_unset ? 1 : frame[name] || 1;
const shape = size("inner_height") / size("inner_width");
const x = Math.max(reach, tall / shape), y = x * shape;
if (frame.x_range.end !== x || frame.y_range.end !== y) {
  frame.x_range.setv({start: -x, end: x}); frame.y_range.setv({start: -y, end: y});
}
