// The plots of the page: figures of the case with all their runs, then balances of one run.

const TIME = 'time [s]';
const ROUNDING = -18; // exponent below which errors are rounding alone: they would fill the scale

function addPlot(list, title, lines, yLabel, options = {}) {
  const place = element('div', { class: 'chart', role: 'img', 'aria-label': `${title}: plot over time` });
  const below = element('div', { class: 'chart' });
  const tools = element('div', { class: 'tools' });
  list.append(element('figure', {}, element('figcaption', {}, element('h3', {}, title), tools), place, below));
  const plot = drawChart(place, lines, { height: 260, xLabel: TIME, yLabel, timed: true, ...options });
  const file = `${page.case}-${title}`.replace(/[^A-Za-z0-9]+/g, '-').toLowerCase();
  tools.append(
    button('all', `${title}: show all times`, () => resetZoom()),
    button('spectrum', `${title}: spectrum of the part in view`, (event) => toggleSpectrum(event.currentTarget, plot, below, lines, yLabel)),
    button('CSV', `${title}: download as CSV`, () => download(`${file}.csv`, csvOf(plot, lines, yLabel), 'text/csv')),
  );
  return plot;
}

function resetZoom() {
  for (const plot of charts) plot.setScale('x', { min: plot.data[0][0], max: plot.data[0][plot.data[0].length - 1] });
}

function csvOf(plot, lines, yLabel) {
  const columns = lines.map((line, i) => ({ head: `${line.label}: ${yLabel}`, values: plot.table[i + 1] }));
  return csv([{ head: TIME, values: plot.table[0] }, ...columns]);
}

function toggleSpectrum(press, plot, below, lines, yLabel) {
  if (below.plot) {
    removeChart(below.plot);
    below.plot = null;
    press.setAttribute('aria-pressed', 'false');
    return;
  }
  const { min, max } = plot.scales.x;
  const found = lines.map((line) => ({ label: line.label, ...spectrum(line.x, line.y, min, max) })).filter((line) => line.frequency.length && line.amplitude.every(Number.isFinite));
  if (!found.length) return;
  const shown = found.map((line) => ({ label: line.label, x: line.frequency, y: line.amplitude }));
  below.plot = drawChart(below, shown, { height: 220, xLabel: 'frequency [Hz]', yLabel: `amplitude of ${yLabel}`, log: true });
  zoomToPeaks(below.plot, shown);
  press.setAttribute('aria-pressed', 'true');
}

// Frequencies up to the last with a thousandth of the largest amplitude, and six decades.
function zoomToPeaks(plot, lines) {
  let last = 0, highest = 0;
  for (const { y } of lines) for (const v of y) highest = Math.max(highest, v);
  for (const { x, y } of lines) y.forEach((v, i) => { if (v > 1e-3 * highest) last = Math.max(last, x[i]); });
  plot.batch(() => {
    plot.setScale('x', { min: 0, max: Math.max(2 * last, lines[0].x[8]) });
    const top = Math.log10(highest);
    plot.setScale('y', { min: top - 6, max: top + 0.3 });
  });
}

function lineOf(run, series, label) {
  return { label, x: array(run.t), y: array(series.values), stopped: run.stopped };
}

function setUpPlots() {
  const list = document.getElementById('plot-list');
  const draw = (place, figure) => {
    if (figure.against) { addOrbit(place, figure); return; }
    const runs = figure.runs.map(runOf);
    const series = runs.map((run) => run.signals.find((signal) => signal.name === figure.signal));
    const lines = runs.map((run, i) => lineOf(run, series[i], run.title));
    for (const line of lines) if (!line.y.some(Number.isFinite)) line.label += figure.ratio ? ': no stress' : ': no finite values';
    const { low, high } = range(lines.map((line) => line.y));
    addPlot(place, figure.title, lines, unitOf(series[0]), { log: figure.ratio && high > 10 * low });
  };
  page.figures.filter((figure) => !figure.more).forEach((figure) => draw(list, figure));
  const others = page.figures.filter((figure) => figure.more);
  if (others.length) list.append(otherSignals(others, draw));
  const balances = element('div', { class: 'balances' });
  const choice = element('select', { id: 'balance-run', onchange: () => showBalances(balances, page.runs[choice.selectedIndex]) });
  choice.append(...page.runs.map((run) => element('option', {}, run.title)));
  if (page.runs[0].energies) {
    list.append(element('p', { class: 'choice' }, element('label', { for: 'balance-run' }, 'Verification of '), choice), balances);
    showBalances(balances, page.runs[0]);
  }
  fitCharts();
}

// Signals without a figure of the case: drawn when they are asked for.
function otherSignals(figures, draw) {
  const inside = element('div', { class: 'balances' });
  const made = element('details', { class: 'choice' }, element('summary', {}, `${figures.length} more signals`), inside);
  made.addEventListener('toggle', () => {
    if (inside.children.length) return;
    figures.forEach((figure) => draw(inside, figure));
    fitCharts();
  });
  return made;
}

function showBalances(place, run) {
  for (const plot of charts.filter((each) => place.contains(each.root))) removeChart(plot);
  place.replaceChildren();
  addPlot(place, 'Energies', run.energies.map((series) => lineOf(run, series, series.text)), 'energy [J]');
  const used = (group, words) => group.map((series) => lineOf(run, series, words(series))).filter((line) => line.y.some((v) => v));
  const errors = [...used(run.balance, () => 'energy balance [-]'), ...used(run.violations, (series) => `constraint, ${series.text} [${series.unit}]`)];
  if (errors.length) addPlot(place, 'Errors', errors, 'error', { log: true, least: ROUNDING });
}
