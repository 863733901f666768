// The view: which run, colour, scale and mode are shown, from where, at which time.

const view = { renderer: null, camera: null, mark: null, waiting: false };
const field = (id) => document.getElementById(id);

const runShown = () => runOf(field('view-run').value);
const runOver = () => (field('view-over').value ? runOf(field('view-over').value) : null);

function statesOf(scene, solo) {
  const [own, mode] = solo || [-1, -1];
  return scene.bodies.map((body, i) => bodyState(scene, body, clock.t, i === own ? mode : -1));
}

const soloShown = () => (field('solo').value === '-1' ? null : field('solo').value.split(',').map(Number));

// Parts of the canvas [left, bottom, width, height]: one, or two for runs side by side.
function boxes() {
  const { width, height } = view.renderer.canvas, half = Math.floor(width / 2);
  return runOver() && field('beside').value ? [[0, 0, half, height], [half, 0, width - half, height]] : [[0, 0, width, height]];
}

function shownNow(scene) {
  const name = field('colour').value;
  return {
    name,
    field: FIELDS[name].number,
    ranges: fieldRanges(name, scene),
    scale: Number(field('scale').value),
    edges: field('edges').checked,
    paths: field('paths').checked,
    loads: field('loads').value,
    aspect: boxes()[0][2] / boxes()[0][3],
    ratio: view.renderer.canvas.width / Math.max(view.renderer.canvas.clientWidth, 1) || 1,
  };
}

function drawView(camera = view.camera) {
  const { scene } = runShown(), shown = shownNow(scene), states = statesOf(scene, soloShown());
  const layers = [{ scene, states, alpha: 1 }], over = runOver(), [box, beside] = boxes();
  if (beside) {
    const theirs = statesOf(over.scene, null);
    view.renderer.draw([{ scene: over.scene, states: theirs, alpha: 1 }], camera, shown, beside);
    drawOverlay(field('overlay'), over.scene, theirs, camera, shown, null, beside);
  } else if (over) layers.push({ scene: over.scene, states: statesOf(over.scene, null), alpha: 0.35, plain: true });
  view.renderer.draw(layers, camera, shown, box);
  drawOverlay(field('overlay'), scene, states, camera, shown, view.mark, box);
}

// One picture for all that changes before the next one.
function drawSoon() {
  if (view.waiting) return;
  view.waiting = true;
  requestAnimationFrame(() => {
    view.waiting = false;
    drawView();
  });
}

function tellView() {
  const run = runShown(), shown = shownNow(run.scene), over = runOver();
  const t = Math.min(clock.t, array(run.scene.t).at(-1));
  const scale = shown.scale === 1 ? 'true to scale' : `deformation ${shown.scale} times`;
  field('caption').textContent = [`${run.title}`, `t = ${digits(t, 4)} s`, scale, over ? `${field('beside').value ? 'right' : 'grey'}: ${over.title}` : '', shown.loads && run.scene.loads ? `longest ${shown.loads} ${digits(run.scene.loads[shown.loads].longest, 3)} ${shown.loads === 'force' ? 'N' : 'N m'}` : '', soloShown() ? `only ${field('solo').selectedOptions[0].textContent}` : '', view.mark ? view.mark.text : '']
    .filter(Boolean).join(' · ');
  const legend = field('legend');
  legend.hidden = shown.name === 'body';
  if (!legend.hidden) legend.replaceChildren(...fieldLegend(shown, run.scene));
}

function tellTime() {
  field('slider').value = clock.t / (clock.end || 1);
  field('clock').textContent = `${digits(clock.t, 4)} s`;
  field('play').textContent = clock.playing ? 'pause' : 'play';
}

function fitCanvas() {
  const stage = field('stage'), ratio = Math.min(devicePixelRatio || 1, 2);
  const width = Math.max(stage.clientWidth, 200), height = Math.round(Math.min(Math.max(0.6 * width, 300), 560));
  for (const canvas of [field('canvas'), field('overlay')]) {
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
}

// Go to a place at a time: a ply, a finding.
function showPlace({ run, time, body, node, text }) {
  const chosen = run ? runOf(run) : view.renderer ? runShown() : page.runs[0];
  if (view.renderer && chosen.scene) {
    field('view-run').value = chosen.name;
    changeRun();
    const index = chosen.scene.bodies.findIndex((each) => each.name === body);
    view.mark = index >= 0 && node !== undefined ? { body: index, node: Number(node), text } : null;
    if (view.mark && !field('colour').querySelector('[value=exposure]').disabled) field('colour').value = 'exposure';
  }
  clock.playing = false;
  clock.set(Number(time));
  if (view.renderer) tellTime();
  if (view.renderer) field('stage').scrollIntoView({ block: 'nearest' });
}

function changeRun() {
  const { scene } = runShown();
  view.mark = null;
  const options = scene.bodies.flatMap((body, i) => body.labels.map((label, k) => element('option', { value: `${i},${k}` }, `${body.name}: ${label}`)));
  field('solo').replaceChildren(element('option', { value: '-1' }, 'all'), ...options);
  const coloured = view.renderer.name === 'webgl2', usable = { body: true, displacement: coloured, energy: coloured && scene.bodies.some((b) => b.sites) };
  for (const option of field('colour').options) option.disabled = !(usable[option.value] ?? (coloured && hasStrength(scene)));
  field('loads').disabled = !scene.loads;
  if (field('colour').selectedOptions[0].disabled) field('colour').value = 'body';
  field('worst').disabled = !runShown().worst.length;
  view.camera = homeCamera(scene, shownNow(scene));
  tellView();
  drawSoon();
}

function makeRenderer() {
  try {
    return glRenderer(field('canvas'));
  } catch (error) {
    // A canvas keeps its first kind of context: the fallback needs a new one.
    const fresh = field('canvas').cloneNode(true);
    field('canvas').replaceWith(fresh);
    field('stage').append(element('p', { class: 'note' }, `Simple drawing without colours of results: ${error.message}.`));
    return flatRenderer(fresh);
  }
}

function setUpView() {
  const runs = page.runs.filter((run) => run.scene);
  if (!runs.length) return;
  const listed = () => runs.map((run) => element('option', { value: run.name }, run.title));
  field('view-run').append(...listed());
  field('view-over').append(...listed());
  field('stage').insertBefore(element('canvas', { id: 'overlay', 'aria-hidden': 'true' }), field('caption'));
  view.renderer = makeRenderer();
  document.documentElement.dataset.renderer = view.renderer.name;
  fitCanvas();
  changeRun();
  const redraw = () => { tellView(); drawSoon(); };
  const fit = () => { fitCamera(view.camera, runShown().scene, shownNow(runShown().scene)); redraw(); };
  for (const id of ['colour', 'solo', 'edges', 'paths', 'loads']) field(id).addEventListener('change', redraw);
  for (const id of ['view-over', 'beside', 'scale']) field(id).addEventListener('change', fit);
  field('view-run').addEventListener('change', changeRun);
  field('play').addEventListener('click', () => clock.toggle());
  field('slider').addEventListener('input', () => { clock.playing = false; clock.set(nearestTime(field('slider').value * clock.end)); });
  clock.fitSpeed([...field('speed').options].map((each) => Number(each.value)));
  field('speed').value = String(clock.speed);
  field('speed').addEventListener('change', () => (clock.speed = Number(field('speed').value)));
  field('home').addEventListener('click', () => { view.camera = homeCamera(runShown().scene, shownNow(runShown().scene)); view.mark = null; redraw(); });
  field('worst').addEventListener('click', () => { const [worst] = runShown().worst; showPlace({ ...worst, run: runShown().name }); });
  setUpCamera(field('canvas'), () => view.camera, drawSoon);
  let told = 0;
  clock.onChange(() => {
    drawSoon();
    if (clock.playing && performance.now() - told < 200) return; // text at 5 Hz
    told = performance.now();
    tellTime();
    tellView();
  });
  addEventListener('resize', () => { fitCanvas(); drawSoon(); });
  themeListeners.push(drawSoon);
  setUpPrint();
  setUpFilm();
  tellTime();
}

function nearestTime(t) {
  const times = array(runShown().scene.t);
  let best = 0;
  for (let i = 1; i < times.length; i++) if (Math.abs(times[i] - t) < Math.abs(times[best] - t)) best = i;
  return t > times.at(-1) ? t : times[best];
}

function setUpPlaces() {
  for (const press of document.querySelectorAll('button[data-solo]')) {
    press.disabled = !view.renderer || !runOf(press.dataset.run).scene;
    press.addEventListener('click', () => {
      field('view-run').value = press.dataset.run;
      changeRun();
      field('solo').value = press.dataset.solo;
      tellView();
      field('stage').scrollIntoView({ block: 'nearest' });
    });
  }
  for (const press of document.querySelectorAll('button[data-time]')) {
    press.addEventListener('click', () => showPlace(press.dataset));
  }
}
