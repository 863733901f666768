// The picture as a file: PNG of one time, WebM of the motion.

// The picture with its caption and legend on one canvas.
function drawPicture(made = document.createElement('canvas')) {
  const { canvas } = view.renderer, pen = made.getContext('2d'), { ratio } = shownNow(runShown().scene);
  if (made.width !== canvas.width || made.height !== canvas.height) [made.width, made.height] = [canvas.width, canvas.height];
  pen.drawImage(canvas, 0, 0);
  pen.drawImage(field('overlay'), 0, 0);
  pen.font = `${13 * ratio}px system-ui, sans-serif`;
  pen.fillStyle = shade('--ink');
  pen.fillText(field('caption').textContent, 10 * ratio, 20 * ratio);
  const right = made.width - 10 * ratio, bottom = made.height - 12 * ratio;
  pen.textAlign = 'right';
  // Rows of the legend from below: its last words, then pairs of colour and words.
  const parts = field('legend').hidden ? [] : [...field('legend').children].filter((part) => part.tagName === 'SPAN').reverse();
  if (parts.length === 3 && parts[2].textContent === '0') parts.splice(1, 2, { textContent: `0 to ${parts[1].textContent}` });
  parts.forEach((part, k) => pen.fillText(part.textContent, right, bottom - 18 * k * ratio));
  pen.textAlign = 'left';
  [...field('legend').querySelectorAll('i')].reverse().forEach((bar, k) => {
    if (!parts.length) return;
    const chip = bar.className === 'chip', wide = (chip ? 14 : 120) * ratio;
    const x = right - wide - (chip ? pen.measureText(parts[k + 1].textContent).width + 8 * ratio : 0), y = bottom - 18 * (chip ? k + 1 : parts.length) * ratio - 10 * ratio;
    const at = chip ? parseFloat(bar.style.backgroundPosition) / 100 : 0, fill = pen.createLinearGradient(x - 1e5 * at * chip, 0, x - 1e5 * at * chip + (chip ? 1e5 : wide), 0);
    const colours = getComputedStyle(bar).backgroundImage.match(/rgba?\([^)]*\)/g); // of page.css
    colours.forEach((colour, i) => fill.addColorStop(i / (colours.length - 1), colour));
    pen.fillStyle = fill;
    pen.fillRect(x, y, wide, 11 * ratio);
  });
  return made;
}

const fileName = (end) => `${page.case}-${runShown().name}${end}`;

function savePng() {
  drawView();
  drawPicture().toBlob((blob) => download(fileName(`-${digits(clock.t, 4)}s.png`), blob, 'image/png'));
}

let recorder = null;

// From the start at the speed that is chosen; a second press ends it early.
function saveFilm() {
  if (recorder) return recorder.stop();
  const made = drawPicture(), parts = [];
  recorder = new MediaRecorder(made.captureStream(30), { mimeType: 'video/webm', videoBitsPerSecond: 8e6 });
  recorder.addEventListener('dataavailable', (event) => parts.push(event.data));
  recorder.addEventListener('stop', () => {
    recorder = null;
    clock.playing = false;
    field('webm').textContent = 'video';
    download(fileName('.webm'), new Blob(parts, { type: 'video/webm' }), 'video/webm');
  });
  const frame = () => {
    if (!recorder) return;
    drawView();
    drawPicture(made);
    if (clock.playing) requestAnimationFrame(frame);
    else setTimeout(() => recorder?.state === 'recording' && recorder.stop(), 200); // with the last picture
  };
  field('webm').textContent = 'end video';
  clock.playing = false;
  clock.set(0);
  recorder.addEventListener('start', () => {
    clock.toggle();
    requestAnimationFrame(frame);
  });
  recorder.start();
}

function setUpFilm() {
  field('png').addEventListener('click', savePng);
  field('webm').addEventListener('click', saveFilm);
  field('webm').disabled = !globalThis.MediaRecorder?.isTypeSupported('video/webm');
}
