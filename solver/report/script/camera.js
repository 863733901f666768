// The eye goes round a target. Matrices by columns, as WebGL takes them.

function homeCamera(scene, shown) {
  const [x, y, z] = scene.extent;
  const flat = Math.min(x, y, z) < 0.25 * Math.max(x, y, z);
  // What is flat along its shortest side. Gravity says whether y or z is up, unless one looks along it.
  const along = flat ? [x, y, z].indexOf(Math.min(x, y, z)) : -1;
  const up = along === 2 ? 1 : along === 1 ? 2 : scene.up || (flat ? 2 : 1);
  const aside = along === 1 || (!flat && up === 2) ? -Math.PI / 2 : 0; // seen from -y
  const camera = { target: [0, 0, 0], up, yaw: aside + (flat ? 0.2 : 0.6), pitch: flat ? 0.2 : 0.45, distance: scene.size };
  return fitCamera(camera, scene, shown);
}

const FIT_TIMES = 25, FIT_POINTS = 4000, FILLED = 0.86; // of the picture

// Move the eye so that some points of all bodies are in the picture at some times of the run.
function fitCamera(camera, scene, { scale, aspect }) {
  const axes = cameraAxes(camera), f = 1 / Math.tan(0.27), times = array(scene.t), points = [];
  const most = Math.max(8, Math.floor(FIT_POINTS / FIT_TIMES / scene.bodies.length));
  for (let k = 0; k < FIT_TIMES; k++) {
    const t = times[Math.round((k * (times.length - 1)) / (FIT_TIMES - 1))];
    for (const body of scene.bodies) {
      const state = bodyState(scene, body, t, -1), node = array(body.node), offset = array(body.offset);
      for (let i = 0; i < node.length; i += Math.ceil(node.length / most)) {
        const at = pointAt(body, state, node[i], offset.subarray(3 * i, 3 * i + 3), scale);
        points.push(axes.map((axis) => axis[0] * at[0] + axis[1] * at[1] + axis[2] * at[2]));
      }
    }
  }
  const middle = [0, 1, 2].map((a) => points.reduce(([low, high], p) => [Math.min(low, p[a]), Math.max(high, p[a])], [Infinity, -Infinity]));
  const centre = middle.map(([low, high]) => (low + high) / 2);
  const wide = [(f * Math.min(aspect, 1)) / aspect / FILLED, (f * Math.min(aspect, 1)) / FILLED];
  const needed = (p) => p[2] - centre[2] + Math.max(...wide.map((each, a) => each * Math.abs(p[a] - centre[a])));
  camera.distance = Math.max(0.05 * scene.size, points.reduce((most, p) => Math.max(most, needed(p)), 0));
  camera.target = [0, 1, 2].map((a) => axes.reduce((sum, axis, i) => sum + axis[a] * centre[i], 0));
  return camera;
}

// Axes of the eye: right, above, back (towards the eye).
function cameraAxes(camera) {
  const { yaw, pitch, up } = camera;
  const c = Math.cos(pitch), s = Math.sin(pitch);
  const back = up === 1 ? [c * Math.sin(yaw), s, c * Math.cos(yaw)] : [c * Math.cos(yaw), c * Math.sin(yaw), s];
  const pole = up === 1 ? [0, 1, 0] : [0, 0, 1];
  const right = cross(pole, back), size = Math.hypot(...right);
  const side = right.map((v) => v / size);
  return [side, cross(back, side), back];
}

const eyeOf = (camera) => cameraAxes(camera)[2].map((v, i) => camera.target[i] + camera.distance * v);

function cameraMatrix(camera, aspect) {
  const axes = cameraAxes(camera), eye = eyeOf(camera);
  const f = 1 / Math.tan(0.27), near = 0.01 * camera.distance, far = 100 * camera.distance;
  const view = [0, 1, 2].map((i) => [...axes[i], -axes[i].reduce((sum, v, a) => sum + v * eye[a], 0)]);
  const rows = [
    view[0].map((v) => (v * f) / Math.max(aspect, 1e-3) * Math.min(aspect, 1)),
    view[1].map((v) => v * f * Math.min(aspect, 1)),
    view[2].map((v, i) => ((near + far) / (near - far)) * v + (i === 3 ? (2 * near * far) / (near - far) : 0)),
    view[2].map((v) => -v),
  ];
  return Float32Array.from({ length: 16 }, (_, k) => rows[k % 4][k >> 2]);
}

// Pixel (x, y, depth) of a position.
function projected(matrix, p, width, height) {
  const at = [0, 1, 2, 3].map((i) => matrix[i] * p[0] + matrix[4 + i] * p[1] + matrix[8 + i] * p[2] + matrix[12 + i]);
  return [(0.5 + (0.5 * at[0]) / at[3]) * width, (0.5 - (0.5 * at[1]) / at[3]) * height, at[3]];
}

function setUpCamera(canvas, camera, draw) {
  let last = null;
  canvas.addEventListener('pointerdown', (event) => {
    last = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointerup', () => (last = null));
  canvas.addEventListener('pointermove', (event) => {
    if (!last) return;
    const x = (event.clientX - last[0]) / canvas.clientHeight, y = (event.clientY - last[1]) / canvas.clientHeight;
    last = [event.clientX, event.clientY];
    if (event.shiftKey || event.buttons === 2) shift(camera(), x, y);
    else turn(camera(), -3 * x, 3 * y);
    draw();
  });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoom(camera(), Math.exp(0.001 * event.deltaY));
    draw();
  }, { passive: false });
}

function turn(camera, yaw, pitch) {
  camera.yaw += yaw;
  camera.pitch = Math.min(Math.max(camera.pitch + pitch, -1.55), 1.55);
}

function shift(camera, x, y) {
  const [right, above] = cameraAxes(camera);
  camera.target = camera.target.map((v, i) => v - 0.55 * camera.distance * (x * right[i] - y * above[i]));
}

const zoom = (camera, factor) => (camera.distance *= factor);
