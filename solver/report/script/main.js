// Start: data first, then the parts of the page.

async function start() {
  await unpackArrays();
  clock.end = Math.max(...page.runs.map((run) => array(run.t).at(-1)));
  setUpTheme();
  setUpTables();
  setUpCharts();
  setUpView();
  setUpPlaces();
  setUpPlots();
  setUpKeys();
  // The page opens with the mechanism in motion, unless the reader's system asks for reduced motion.
  if (view.renderer && !matchMedia('(prefers-reduced-motion: reduce)').matches) clock.toggle();
  // For tests of the page, and for those who want the numbers behind the picture.
  globalThis.plymotion = { page, array, clock, view, bodyState, pointsAt, jointLines, siteValues, vectorsAt, cameraMatrix, projected, spectrum, short, ticks, drawView, shownNow, charts };
  document.documentElement.dataset.readyMs = String(Math.round(performance.now()));
  document.documentElement.dataset.ready = 'yes';
}

start().catch((error) => {
  console.error(error);
  document.documentElement.dataset.ready = 'no';
  document.querySelector('header').append(element('p', { class: 'verdict bad' }, `The plots cannot be shown: ${error.message}`));
});
