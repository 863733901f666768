// One chart: lines over a common axis, its legend, and the mark of the time that is shown.

const COLOURS = ['--c0', '--c1', '--c2', '--c3', '--c4', '--c5', '--c6'];
const charts = [];

// place: element; lines: [{ label, x, y, stopped }]
// options: { height, xLabel, yLabel, log, least, timed }; least: exponent below which nothing is told apart
function drawChart(place, lines, options) {
  const joined = lines.length > 1 ? uPlot.join(lines.map((line) => [line.x, line.y])) : [lines[0].x, lines[0].y];
  const axis = {
    stroke: () => shade('--grey'),
    grid: { stroke: () => shade('--line'), width: 1 },
    ticks: { stroke: () => shade('--line'), width: 1 },
    font: '12px system-ui, sans-serif',
    labelFont: '12px system-ui, sans-serif',
    labelSize: 18,
  };
  // Decades on a linear axis: the logarithmic axes of uPlot do not end below 1e-16.
  const show = options.log ? (v) => digits(v === null ? v : 10 ** v, 5) : (v) => digits(v, 5);
  const known = (v) => (v === undefined || Number.isFinite(v) ? v : null);
  const shown = joined.map((values, i) => (i ? Array.from(values, (v) => (options.log ? decade(known(v), options.least) : known(v))) : values));
  const settings = {
    width: widthFor(place),
    height: options.height,
    legend: { live: true },
    cursor: { points: { size: 6 }, drag: { x: true, y: false } },
    scales: { x: { time: false }, y: {} },
    axes: [
      { ...axis, label: options.xLabel, values: short, space: 60 },
      { ...axis, label: options.yLabel, values: options.log ? powers : short, incrs: options.log ? [1, 2, 5, 10, 20] : undefined, size: room },
    ],
    series: [
      { label: options.xLabel, value: (_, v) => digits(v, 5) },
      ...lines.map((line, i) => ({
        label: line.label,
        stroke: () => shade(COLOURS[i % COLOURS.length]),
        width: 1.5,
        dash: i >= COLOURS.length ? [6, 3] : undefined,
        spanGaps: false, // null is a gap; undefined is a time of another run
        points: { show: false },
        value: (_, v) => show(v),
      })),
    ],
    hooks: {},
  };
  if (options.timed) {
    settings.cursor.sync = { key: 'time', scales: ['x', null], setSeries: false };
    settings.hooks.draw = [markTime, (plot) => markStops(plot, lines)];
  }
  const plot = new uPlot(settings, shown, place);
  plot.table = joined;
  if (options.timed) setUpPress(plot);
  charts.push(plot);
  return plot;
}

// A zero leaves no gap: an error may vanish at every other time.
const decade = (v, least = -Infinity) => (v === null ? v : v ? Math.max(Math.log10(Math.abs(v)), least) : undefined);
// Numbers along an axis: all with powers of ten where the largest is small or large.
function short(_, splits) {
  const most = Math.max(...splits.map(Math.abs));
  const text = most < 1e-3 || most >= 1e6 ? (v) => Number(v.toPrecision(6)).toExponential() : (v) => digits(v, 6);
  return splits.map((v) => (v === null ? '' : v === 0 ? '0' : text(v)));
}
// Round numbers between two others, about five.
function ticks(low, high) {
  const power = 10 ** Math.floor(Math.log10((high - low) / 5));
  const step = power * [1, 2, 5, 10].find((each) => each * power >= 0.999 * (high - low) / 5);
  const first = Math.ceil(low / step), count = Math.floor(high / step) - first + 1;
  return Array.from({ length: count }, (_, k) => (first + k) * step);
}
const powers = (_, splits) => splits.map((v) => (v === null ? '' : `1e${v}`));

// Width of the numbers on the vertical axis [pixels], so that none covers the label.
const room = (_, texts) => Math.max(64, 20 + 7.5 * Math.max(0, ...(texts || []).map((text) => `${text}`.length)));

const widthFor = (place) => Math.max(place.clientWidth, 240);

function vertical(plot, t, colour, dash) {
  const { left, top, width, height } = plot.bbox;
  const x = plot.valToPos(t, 'x', true);
  if (!(x >= left && x <= left + width)) return;
  const pen = plot.ctx;
  pen.save();
  pen.strokeStyle = colour;
  pen.lineWidth = 1.5 * devicePixelRatio;
  pen.setLineDash(dash);
  pen.beginPath();
  pen.moveTo(x, top);
  pen.lineTo(x, top + height);
  pen.stroke();
  pen.restore();
}

// The legend has the values at the pointer, and without one those at the time that is shown.
const tellValues = (plot) => plot.cursor.idx ?? plot.setLegend({ idx: plot.valToIdx(clock.t) });

const markTime = (plot) => vertical(plot, clock.t, shade('--ink'), []);
const markStops = (plot, lines) =>
  lines.filter((line) => line.stopped).forEach((line) => vertical(plot, line.x[line.x.length - 1], shade('--bad'), [5, 4]));

// A press that is no drag goes to its time.
function setUpPress(plot) {
  let from = null;
  plot.over.addEventListener('mousedown', (event) => (from = event.clientX));
  plot.over.addEventListener('mouseup', (event) => {
    if (from !== null && Math.abs(event.clientX - from) < 4) {
      clock.set(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, 'x'));
    }
    from = null;
  });
}

function removeChart(plot) {
  charts.splice(charts.indexOf(plot), 1);
  plot.destroy();
}

function setUpCharts() {
  let width = innerWidth;
  addEventListener('resize', () => {
    if (innerWidth === width) return;
    width = innerWidth;
    fitCharts();
  });
  let drawn = 0;
  clock.onChange(() => {
    const now = performance.now();
    if (clock.playing && now - drawn < 200) return; // all charts at 5 Hz while playing
    drawn = now;
    charts.filter((plot) => plot.hooks.draw).forEach((plot) => { plot.redraw(false, false); tellValues(plot); });
  });
  themeListeners.push(() => charts.forEach((plot) => plot.redraw(false, true)));
  addEventListener('beforeprint', () => fitCharts(680));
  addEventListener('afterprint', () => fitCharts());
}

function fitCharts(width) {
  for (const plot of charts) {
    plot.setSize({ width: width || widthFor(plot.root.parentElement), height: plot.height });
  }
}
