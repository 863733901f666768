// On paper the view has no size and no time: pictures at four times, from the home view.

function setUpPrint() {
  const stills = element('div', { id: 'stills' });
  field('stage').after(stills);
  addEventListener('beforeprint', () => {
    for (const each of document.querySelectorAll('details')) each.open = true;
    const { t } = clock, end = array(runShown().scene.t).at(-1), { canvas } = view.renderer;
    const before = [canvas.width, canvas.height];
    for (const each of [canvas, field('overlay')]) [each.width, each.height] = [720, 480];
    const pictures = [0, 1 / 3, 2 / 3, 1].map((part) => {
      clock.t = nearestTime(part * end);
      drawView(homeCamera(runShown().scene, shownNow(runShown().scene)));
      const still = element('canvas', { width: '720', height: '480' }), pen = still.getContext('2d');
      pen.drawImage(canvas, 0, 0);
      pen.drawImage(field('overlay'), 0, 0);
      return element('figure', {}, still, element('figcaption', {}, `t = ${digits(clock.t, 4)} s, deformation ${field('scale').value} times`));
    });
    stills.replaceChildren(...pictures);
    clock.t = t;
    for (const each of [canvas, field('overlay')]) [each.width, each.height] = before;
    drawView();
  });
  addEventListener('afterprint', () => stills.replaceChildren());
}
