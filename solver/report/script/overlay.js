// Over the picture: lines between the sides of joints, a mark at a place, the axes.

function drawOverlay(canvas, scene, states, camera, shown, mark, [left, , width, height]) {
  const pen = canvas.getContext('2d'), { ratio } = shown;
  const matrix = cameraMatrix(camera, width / height);
  inBox(pen, left, width, height);
  pen.clearRect(0, 0, width, height);
  pen.lineWidth = 1.5 * ratio;
  pen.strokeStyle = shade('--bad');
  // What a joint keeps together, the scale of the deformation parts; what slides is apart anyway.
  const joined = jointLines(scene, states, 1);
  jointLines(scene, states, shown.scale).forEach(({ ends, coil }, k) => {
    const [one, two] = joined[k].ends, apart = Math.hypot(...one.map((v, i) => v - two[i]));
    const [a, b] = ends.map((p) => projected(matrix, p, width, height));
    if (coil) return drawCoil(pen, a, b, ratio);
    if (apart > 0.002 * scene.size || Math.hypot(a[0] - b[0], a[1] - b[1]) < 2 * ratio) return;
    pen.beginPath();
    pen.moveTo(a[0], a[1]);
    pen.lineTo(b[0], b[1]);
    pen.stroke();
  });
  if (shown.paths) drawPaths(pen, scene, shown, matrix, width, height);
  if (shown.loads && scene.loads) drawLoads(pen, scene.loads, scene.size, shown, matrix, width, height);
  if (mark) {
    const at = pointAt(scene.bodies[mark.body], states[mark.body], mark.node, [0, 0, 0], shown.scale);
    const [x, y] = projected(matrix, at, width, height);
    pen.lineWidth = 2.5 * ratio;
    pen.beginPath();
    pen.arc(x, y, 14 * ratio, 0, 2 * Math.PI);
    pen.stroke();
  }
  if (!left) drawAxes(pen, camera, height, ratio);
  pen.restore();
}

const TURNS = 6, WIDTH_PX = 5; // of the coil of a spring

function drawCoil(pen, a, b, ratio) {
  const way = [b[0] - a[0], b[1] - a[1]], long = Math.hypot(...way) || 1, side = (WIDTH_PX * ratio) / long;
  const at = (s, up) => pen.lineTo(a[0] + s * way[0] - up * side * way[1], a[1] + s * way[1] + up * side * way[0]);
  pen.save();
  pen.strokeStyle = shade('--ink');
  pen.beginPath();
  at(0, 0);
  for (let k = 0; k <= 2 * TURNS; k++) at(0.15 + (0.7 * k) / (2 * TURNS), k % 2 ? 1 : k && k < 2 * TURNS ? -1 : 0);
  at(1, 0);
  pen.stroke();
  pen.restore();
}

function drawAxes(pen, camera, height, ratio) {
  const [right, above] = cameraAxes(camera), size = Math.min(26 * ratio, 0.06 * height), x = 1.5 * size, y = height - x;
  pen.font = `${12 * ratio}px system-ui, sans-serif`;
  pen.fillStyle = pen.strokeStyle = shade('--grey');
  pen.lineWidth = 1.5 * ratio;
  ['x', 'y', 'z'].forEach((name, i) => {
    const end = [x + size * right[i], y - size * above[i]];
    if (Math.hypot(right[i], above[i]) < 0.15) return;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(...end);
    pen.stroke();
    pen.fillText(name, x + 1.35 * size * right[i] - 3 * ratio, y - 1.35 * size * above[i] + 4 * ratio);
  });
}
