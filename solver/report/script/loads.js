// Over the picture: arrows of forces and moments, paths of points.

const LONGEST = 0.25; // of an arrow, over the size of the scene

// Vectors (n, 3) of an array of the loads at a time.
function vectorsAt(loads, name, t) {
  const { top, steps } = loads[name], values = array(steps), n = loads.names.length;
  const [k, high, part] = between(array(loads.t), t);
  const blend = (i) => (((1 - part) * values[3 * n * k + i] + part * values[3 * n * high + i] - 32767) / 32767) * top;
  return Array.from({ length: n }, (_, i) => [0, 1, 2].map((a) => blend(3 * i + a)));
}

// Forces end with one head, moments with two.
function drawLoads(pen, loads, size, shown, matrix, width, height) {
  const scale = (LONGEST * size) / (loads[shown.loads].longest || 1), places = vectorsAt(loads, 'place', clock.t);
  pen.strokeStyle = pen.fillStyle = shade('--ink');
  pen.lineWidth = 2 * shown.ratio;
  vectorsAt(loads, shown.loads, clock.t).forEach((vector, i) => {
    const [from, to] = [0, scale].map((s) => projected(matrix, places[i].map((v, a) => v + s * vector[a]), width, height));
    const long = Math.hypot(to[0] - from[0], to[1] - from[1]), head = Math.min(9 * shown.ratio, long);
    if (long < 3 * shown.ratio) return;
    const [x, y] = [0, 1].map((a) => (to[a] - from[a]) / long);
    pen.beginPath();
    pen.moveTo(from[0], from[1]);
    pen.lineTo(to[0] - head * x, to[1] - head * y);
    pen.stroke();
    for (let k = 0; k < (shown.loads === 'moment' ? 2 : 1); k++) {
      const tip = [to[0] - k * head * x, to[1] - k * head * y];
      pen.beginPath();
      pen.moveTo(...tip);
      pen.lineTo(tip[0] - head * x - 0.4 * head * y, tip[1] - head * y + 0.4 * head * x);
      pen.lineTo(tip[0] - head * x + 0.4 * head * y, tip[1] - head * y - 0.4 * head * x);
      pen.fill();
    }
  });
}

const paths = new Map(); // of the bodies of a scene, by scene and scale

// Of each body the path of the node that comes farthest from the ground.
function pathsOf(scene, scale) {
  const key = scene.t + ' ' + scene.bodies.map((body) => body.motion) + ' ' + scale;
  if (!paths.has(key)) {
    const times = array(scene.t), foot = scene.joints.flatMap(({ sides }) => sides).find((side) => side.body < 0);
    const fixed = foot ? foot.at.map((v, a) => v - scene.origin[a]) : [0, 0, 0];
    const place = (body, node, t) => pointAt(body, bodyState(scene, body, t, -1), node, [0, 0, 0], scale);
    const away = (p) => Math.hypot(...p.map((v, a) => v - fixed[a]));
    paths.set(key, scene.bodies.filter((body) => body.name !== 'ground').map((body) => {
      const nodes = page.arrays[body.nodes].shape[0], step = Math.ceil(nodes / 60);
      let best = 0, farthest = -1;
      for (let node = nodes - 1; node >= 0; node -= step) {
        for (let k = 0; k < 12; k++) {
          const far = away(place(body, node, times[Math.round((k * (times.length - 1)) / 11)]));
          if (far > 1.000001 * farthest) [best, farthest] = [node, far];
        }
      }
      return Array.from(times, (t) => place(body, best, t));
    }));
  }
  return paths.get(key);
}

function drawPaths(pen, scene, shown, matrix, width, height) {
  pen.lineWidth = 1.5 * shown.ratio;
  pathsOf(scene, shown.scale).forEach((path, i) => {
    pen.strokeStyle = shade(COLOURS[i % COLOURS.length]);
    pen.beginPath();
    path.forEach((p) => pen.lineTo(...projected(matrix, p, width, height).slice(0, 2)));
    pen.stroke();
  });
}
