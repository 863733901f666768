// Start: data first, then the parts of the page.

async function start() {
  await unpackArrays();
  clock.end = Math.max(...page.runs.map((run) => array(run.t).at(-1)));
  setUpTheme();
  setUpTables();
  setUpCharts();
  setUpPlots();
  setUpKeys();
  document.documentElement.dataset.ready = 'yes';
}

start().catch((error) => {
  console.error(error);
  document.documentElement.dataset.ready = 'no';
  document.querySelector('header').append(element('p', { class: 'verdict bad' }, `The plots cannot be shown: ${error.message}`));
});
