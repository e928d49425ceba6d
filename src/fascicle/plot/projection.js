// Patches of solids as a camera sees them: faces that look away are dropped, the others shaded, the
// far ones first; the braid's fibers are thin ribbons among them. There is no physics here.
//
// azimuth, elevation: of the camera [deg]. points: columns x, y, z [m]. faces: columns a, b, c, d of
// point numbers, counterclockwise on the screen where they look here, and red, green, blue. fibers:
// columns x, y, z and nx, ny, nz, of `along` points each, in `colors`; thin: half of a fiber's width
// [m], lift: by how many of it a fiber is nearer. Returns arrays of depth, abscissas, ordinates and color.
function projectSolids({azimuth, elevation, points: P, faces: Q, fibers: F, along, colors,
                        thin, lift}) {
  const [az, el] = [azimuth, elevation].map(d => d * Math.PI / 180);
  const [ca, sa, ce, se] = [Math.cos(az), Math.sin(az), Math.cos(el), Math.sin(el)];
  const n = P.x.length, u = new Float64Array(n), v = new Float64Array(n), w = new Float64Array(n);
  for (let i = 0; i < n; i++) {
    const a = P.x[i] * ca - P.z[i] * sa, b = P.x[i] * sa + P.z[i] * ca;
    u[i] = b; v[i] = P.y[i] * ce - a * se; w[i] = P.y[i] * se + a * ce;
  }
  const seen = [];
  for (let k = 0; k < Q.a.length; k++) {
    const at = [Q.a[k], Q.b[k], Q.c[k], Q.d[k]], [a, b, c, d] = at;
    const [e1, e2, e3] = [u[c] - u[a], v[c] - v[a], w[c] - w[a]];
    const [f1, f2, f3] = [u[d] - u[b], v[d] - v[b], w[d] - w[b]];
    const nz = e1 * f2 - e2 * f1;
    const area = Math.hypot(e2 * f3 - e3 * f2, e3 * f1 - e1 * f3, nz);
    if (area === 0 || nz <= 0) continue;
    const ny = (e3 * f1 - e1 * f3) / area;
    const light = 0.55 + 0.35 * nz / area + 0.18 * ny;
    const rgb = [Q.red[k], Q.green[k], Q.blue[k]].map(x => Math.round(Math.min(255, x * light)));
    seen.push([(w[a] + w[b] + w[c] + w[d]) / 4, at.map(i => u[i]), at.map(i => v[i]),
               `rgb(${rgb})`]);
  }
  for (let first = 0, thread = 0; first < F.x.length; first += along, thread++) {
    let last = null;
    for (let i = first; i < first + along; i++) {
      const a = F.x[i] * ca - F.z[i] * sa, na = F.nx[i] * ca - F.nz[i] * sa;
      const at = [F.x[i] * sa + F.z[i] * ca, F.y[i] * ce - a * se, F.y[i] * se + a * ce];
      const facing = F.ny[i] * se + na * ce >= 0;
      if (facing && last) {
        const [du, dv] = [at[0] - last[0], at[1] - last[1]], long = Math.hypot(du, dv) || 1;
        const [pu, pv] = [-thin * dv / long, thin * du / long];
        // nearer by a few of its widths: it lies on the face that it would vanish in
        seen.push([(last[2] + at[2]) / 2 + lift * thin,
                   [last[0] + pu, at[0] + pu, at[0] - pu, last[0] - pu],
                   [last[1] + pv, at[1] + pv, at[1] - pv, last[1] - pv], colors[thread]]);
      }
      last = facing ? at : null;
    }
  }
  return seen.sort((p, q) => p[0] - q[0]);
}
