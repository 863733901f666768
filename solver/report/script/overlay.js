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
  jointLines(scene, states, shown.scale).forEach((ends, k) => {
    const apart = Math.hypot(...joined[k][0].map((v, a) => v - joined[k][1][a]));
    const [a, b] = ends.map((p) => projected(matrix, p, width, height));
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

function drawAxes(pen, camera, height, ratio) {
  const [right, above] = cameraAxes(camera), size = 26 * ratio, x = 40 * ratio, y = height - 40 * ratio;
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
