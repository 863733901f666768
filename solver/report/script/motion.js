// Where the bodies are at a time, in double precision: for the fallback, labels and joints.

// Rows of stored times around t, and the part of the way from the first to the second.
function between(times, t) {
  let k = 0, high = times.length - 1;
  while (high - k > 1) {
    const middle = (k + high) >> 1;
    if (times[middle] <= t) k = middle;
    else high = middle;
  }
  const part = high > k ? Math.min(Math.max((t - times[k]) / (times[high] - times[k]), 0), 1) : 0;
  return [k, high, part];
}

// State of a body: r, A (by rows), q; between stored times by linear interpolation.
function bodyState(scene, body, t, solo) {
  const [k, high, part] = between(array(scene.t), t);
  const blend = (values, width, i) => (1 - part) * values[k * width + i] + part * values[high * width + i];
  const motion = array(body.motion), coordinates = array(body.q), m = body.modes;
  const r = [0, 1, 2].map((i) => blend(motion, 7, i));
  let p = [3, 4, 5, 6].map((i) => blend(motion, 7, i));
  const norm = Math.hypot(...p);
  p = p.map((v) => v / norm);
  const q = Float64Array.from({ length: m }, (_, i) => (solo >= 0 && solo !== i ? 0 : blend(coordinates, m, i)));
  return { r, A: rotation(p), q, t, solo };
}

// Strain energy or exposure of each site of a body, of all modes or of one.
function siteValues(scene, body, state, name) {
  if (name === 'ply') {
    const known = plyNames(scene), row = (body.sites.plies ?? []).map((ply) => known.indexOf(ply));
    return Float32Array.from(row.length ? array(body.sites.ply) : [0], (k) => row[k] ?? 0);
  }
  const field = body.sites[name];
  if (!field) return new Float32Array(1);
  const steps = array(field.steps), count = page.arrays[field.steps].shape[1], unit = field.top / 255;
  const [k, high, part] = between(array(scene.field_t), state.t);
  const blend = (s) => unit * ((1 - part) * steps[k * count + s] + part * steps[high * count + s]);
  if (state.solo < 0) return Float32Array.from({ length: count }, (_, s) => blend(s));
  const q = state.q[state.solo], alone = array(field.alone), linear = name !== 'energy';
  const row = linear && q < 0 ? state.solo + body.modes : state.solo, factor = linear ? Math.abs(q) : q * q;
  return Float32Array.from({ length: count }, (_, s) => factor * alone[row * count + s]);
}

// Rotation matrix by rows from Euler parameters, scalar first.
function rotation([e0, e1, e2, e3]) {
  return [
    1 - 2 * (e2 * e2 + e3 * e3), 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2),
    2 * (e1 * e2 + e0 * e3), 1 - 2 * (e1 * e1 + e3 * e3), 2 * (e2 * e3 - e0 * e1),
    2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), 1 - 2 * (e1 * e1 + e2 * e2),
  ];
}

const turned = (A, v) => [0, 3, 6].map((i) => A[i] * v[0] + A[i + 1] * v[1] + A[i + 2] * v[2]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// Position of a point with an offset from a node, in the axes of the scene.
function pointAt(body, state, node, offset, scale) {
  const shapes = array(body.shapes), nodes = array(body.nodes), m = body.modes;
  const moved = [0, 0, 0, 0, 0, 0];
  for (let i = 0; i < m; i++) {
    const first = (node * m + i) * 6;
    for (let a = 0; a < 6; a++) moved[a] += state.q[i] * shapes[first + a];
  }
  const swing = cross(moved.slice(3), offset);
  const local = [0, 1, 2].map((a) => nodes[3 * node + a] + offset[a] + scale * (moved[a] + swing[a]));
  return turned(state.A, local).map((v, a) => v + state.r[a]);
}

// All points of a body, flat.
function pointsAt(body, state, scale) {
  const node = array(body.node), offset = array(body.offset);
  const found = new Float64Array(3 * node.length);
  for (let i = 0; i < node.length; i++) {
    found.set(pointAt(body, state, node[i], offset.subarray(3 * i, 3 * i + 3), scale), 3 * i);
  }
  return found;
}

// Ends of the lines that join both sides of each joint; of a spring, which is a coil.
function jointLines(scene, states, scale) {
  return scene.joints.map(({ sides, coil }) => ({ coil, ends:
    sides.map((side) => {
      if (side.body < 0) return side.at.map((v, a) => v - scene.origin[a]);
      const body = scene.bodies[side.body];
      return body ? pointAt(body, states[side.body], side.node, [0, 0, 0], scale) : null;
    }) })).filter(({ ends }) => ends[0] && ends[1]);
}
