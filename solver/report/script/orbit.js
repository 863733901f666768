// A figure of one signal against another: a curve for each run, and a dot at the time that is shown.

const ORBIT = { high: 400, left: 80, right: 20, top: 16, bottom: 50 }; // [pixels]

function drawn(tag, properties, ...children) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(properties)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function range(arrays) {
  let low = Infinity, high = -Infinity;
  for (const values of arrays) for (const v of values) if (Number.isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); }
  return { low, high, middle: 0.5 * (low + high), span: high - low || 1 };
}

function addOrbit(list, figure) {
  const runs = figure.runs.map(runOf), { high, left, right, top, bottom } = ORBIT, wide = Math.min(widthFor(list), 460);
  const [across, up] = [figure.against, figure.signal].map((name) => runs.map((run) => run.signals.find((signal) => signal.name === name)));
  const [x, y] = [across, up].map((series) => series.map((each) => array(each.values)));
  const [ax, ay] = [range(x), range(y)], room = [wide - left - right, high - top - bottom];
  let scale = [room[0] / ax.span, room[1] / ay.span].map((each) => 0.94 * each);
  if (across[0].unit === up[0].unit) scale = scale.fill(Math.min(...scale)); // circles are round
  const px = (v) => left + 0.5 * room[0] + scale[0] * (v - ax.middle), py = (v) => top + 0.5 * room[1] - scale[1] * (v - ay.middle);
  const at = (i, k) => [px(x[i][k]), py(y[i][k])];
  const place = (i, k) => at(i, k).map((v) => v.toFixed(1)).join(' ');
  const picture = drawn('svg', { viewBox: `0 0 ${wide} ${high}`, class: 'orbit', role: 'img', 'aria-label': `${figure.title}: one signal against another` });
  picture.append(drawn('rect', { x: left, y: top, width: room[0], height: room[1] }));
  const words = (text, x, y, anchor, turn = '') => picture.append(drawn('text', { x, y, 'text-anchor': anchor, transform: turn }, text));
  const rule = (x1, y1, x2, y2) => picture.append(drawn('line', { x1, y1, x2, y2 }));
  const mark = (low, high, draw) => { const splits = ticks(low, high); short(null, splits).forEach((text, k) => draw(text, splits[k])); };
  const [halfWide, halfHigh] = [0, 1].map((a) => 0.5 * room[a] / scale[a]);
  mark(ax.middle - halfWide, ax.middle + halfWide, (text, v) => { rule(px(v), top, px(v), high - bottom); words(text, px(v), high - bottom + 16, 'middle'); });
  mark(ay.middle - halfHigh, ay.middle + halfHigh, (text, v) => { rule(left, py(v), wide - right, py(v)); words(text, left - 6, py(v) + 4, 'end'); });
  words(unitOf(across[0]), left + 0.5 * room[0], high - 10, 'middle');
  words(unitOf(up[0]), 14, top + 0.5 * room[1], 'middle', `rotate(-90 14 ${top + 0.5 * room[1]})`);
  const dots = runs.map((run, i) => {
    const colour = `var(${COLOURS[i % COLOURS.length]})`;
    const points = Array.from(x[i], (_, k) => k).filter((k) => Number.isFinite(x[i][k]) && Number.isFinite(y[i][k]));
    const curve = picture.appendChild(drawn('polyline', { points: points.map((k) => place(i, k)).join(' ') }, drawn('title', {}, run.title)));
    const dot = picture.appendChild(drawn('circle', { r: 4 }));
    curve.style.stroke = colour;
    dot.style.fill = colour;
    return dot;
  });
  const move = () => dots.forEach((dot, i) => {
    const [k, high, part] = between(array(runs[i].t), clock.t), [cx, cy] = at(i, part > 0 ? high : k);
    if (Number.isFinite(cx + cy)) { dot.setAttribute('cx', cx); dot.setAttribute('cy', cy); }
  });
  clock.onChange(move);
  move();
  list.append(element('figure', {}, element('figcaption', {}, element('h3', {}, figure.title)), picture));
}
