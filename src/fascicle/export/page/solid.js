// A muscle as a solid of rings, drawn as in the library's `plot.shapes` and the explorer: axes are z
// along the muscle, y the way it bows, x across [m].
const HINGE_POINTS = 41, CREASE = 0.8;  // points around a hinge; radii over which the tube folds in
const FITTING = [1.3, 1.1];  // radius and depth, over the bladder's radius

// Outline around a centerline, with the tube's radius: its height above and below the line.
function outline({z, y}, radius, wall, collapsed) {
  const count = z.length, middle = (count - 1) / 2;
  const along = [0], slope = [];
  for (let i = 1; i < count; i++) {
    along.push(along[i - 1] + Math.hypot(z[i] - z[i - 1], y[i] - y[i - 1]));
  }
  for (let i = 0; i < count; i++) {
    const a = Math.max(i - 1, 0), b = Math.min(i + 1, count - 1);
    slope.push(Math.atan2(y[b] - y[a], z[b] - z[a]));
  }
  const points = Array.from({length: count}, (_, i) =>
    ({z: z[i], y: y[i], along: along[i], slope: slope[i], above: radius, below: radius}));
  if (!collapsed) return points;
  // the hinge is repeated, so that the outer wall goes around it
  const [from, to] = [slope[middle - 2], slope[middle + 2]];
  const hinge = Array.from({length: HINGE_POINTS}, (_, i) => ({
    ...points[middle], slope: from + (to - from) * i / (HINGE_POINTS - 1),
  }));
  points.splice(middle, 1, ...hinge);
  const crease = 2 * wall - radius, half = along[count - 1] / 2;
  for (const point of points) {
    const distance = Math.min(Math.abs(point.along - half) / (CREASE * radius), 1);
    point.above = crease + (radius - crease) * Math.sin(Math.PI / 2 * distance);
  }
  return points;
}

// Function of arc length s and angle from the upper side [rad]: a point of the tube.
function tube(points, radius) {
  const length = points[points.length - 1].along, last = points.length - 1;
  // repeated points of a hinge have one arc length: spread by a hair
  const at = points.map((point, i) => point.along + 1e-9 * length * i / last);
  return s => {
    let low = 0, high = last;
    while (high - low > 1) {
      const half = (low + high) >> 1;
      if (at[half] <= s) low = half; else high = half;
    }
    const a = points[low], b = points[high];
    const t = Math.min(Math.max((s - at[low]) / (at[high] - at[low]), 0), 1);
    const mix = name => a[name] + (b[name] - a[name]) * t;
    const [z, y, slope, above, below] = ["z", "y", "slope", "above", "below"].map(mix);
    return angle => {
      const up = (above - below) / 2 + (above + below) / 2 * Math.cos(angle);
      return [radius * Math.sin(angle), y + up * Math.cos(slope), z - up * Math.sin(slope)];
    };
  };
}

// Rings and fibers of a muscle: `radius` [m] and `angle` [rad] are those of its braid at the strain.
function solidOf(line, {radius, angle, restRadius, wall, collapsed, rings, around, fibers, along}) {
  const points = outline(line, radius, wall, collapsed), place = tube(points, radius);
  const length = points[points.length - 1].along, rows = [];
  const ring = at => Array.from({length: around}, (_, j) => at(2 * Math.PI * j / around));
  for (let i = 0; i < rings; i++) {  // they crowd at the middle, where a hinge turns
    const t = 2 * i / (rings - 1) - 1;
    rows.push(ring(place(length * (1 + Math.sign(t) * Math.abs(t) ** 1.6) / 2)));
  }
  const [wide, deep] = FITTING.map(ratio => ratio * restRadius), closed = 1e-9 * wide;
  for (const [end, out] of [[line.z[0], -deep], [line.z[line.z.length - 1], deep]]) {
    const profile = [[end, closed], [end, wide], [end + out, wide], [end + out, closed]];
    if (out < 0) profile.reverse();  // faces look outward if rings run toward larger z
    for (const [z, r] of profile) rows.push(ring(a => [r * Math.sin(a), r * Math.cos(a), z]));
  }
  const stations = Array.from({length: along}, (_, i) => {
    const s = length * i / (along - 1), at = place(s), [top, bottom] = [at(0), at(Math.PI)];
    return {at, turn: s * Math.tan(angle) / radius, middle: top.map((x, k) => (x + bottom[k]) / 2)};
  });
  const threads = [];
  for (let k = 0; k < 2 * fibers; k++) {
    const start = 2 * Math.PI * (k % fibers) / fibers, way = k < fibers ? 1 : -1;
    for (const {at, turn, middle} of stations) {
      const point = at(start + way * turn);
      threads.push([point, point.map((x, axis) => x - middle[axis])]);
    }
  }
  return {rows, threads, rings};
}

// Positions (angle [rad], x, y [m]) of muscles in rings that bow outward.
function musclePositions(count, spacing) {
  const polar = count === 2 ? [] : [[0, Math.PI / 2]];
  for (let ring = 1; polar.length < count; ring++) {
    const number = Math.min(6 * ring, count - polar.length);
    const radius = spacing * (count === 2 ? 0.5 : ring);  // two stand beside the axis
    for (let k = 0; k < number; k++) polar.push([radius, Math.PI / 2 + 2 * Math.PI * k / number]);
  }
  return polar.map(([radius, theta]) => [
    Math.atan2(-Math.cos(theta), -Math.sin(theta)), radius * Math.cos(theta),
    radius * Math.sin(theta),
  ]);
}

// Columns of points, faces and fibers of solids at their positions, for `projectSolids`.
function scene(solids, positions, tubes, fitting) {
  const points = {x: [], y: [], z: []};
  const faces = {a: [], b: [], c: [], d: [], red: [], green: [], blue: []};
  const fibers = {x: [], y: [], z: [], nx: [], ny: [], nz: []};
  const {rows, rings} = solids[0], middle = (rows[0][0][2] + rows[rings - 1][0][2]) / 2;
  solids.forEach((solid, k) => {
    const [angle, dx, dy] = positions[k], [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const turn = ([x, y, z]) => [x * cos + y * sin, y * cos - x * sin, z];
    const around = solid.rows[0].length, first = points.x.length;
    for (const row of solid.rows) {
      for (const point of row) {
        const [x, y, z] = turn(point);
        points.x.push(x + dx); points.y.push(y + dy); points.z.push(z - middle);
      }
    }
    solid.rows.forEach((_, i) => {
      const isTube = i < solid.rings, part = isTube ? i : (i - solid.rings) % 4;
      if (part === (isTube ? solid.rings - 1 : 3)) return;
      const [red, green, blue] = isTube ? tubes[k] : fitting;
      for (let j = 0; j < around; j++) {
        const next = (j + 1) % around, a = first + i * around, b = a + around;
        faces.a.push(a + j); faces.b.push(a + next); faces.c.push(b + next); faces.d.push(b + j);
        faces.red.push(red); faces.green.push(green); faces.blue.push(blue);
      }
    });
    for (const [point, normal] of solid.threads) {
      const [x, y, z] = turn(point), [nx, ny, nz] = turn(normal);
      fibers.x.push(x + dx); fibers.y.push(y + dy); fibers.z.push(z - middle);
      fibers.nx.push(nx); fibers.ny.push(ny); fibers.nz.push(nz);
    }
  });
  return {points, faces, fibers};
}
