// Numbers as text, and elements from text (never from HTML).

const digits = (value, count = 4) =>
  value === null || value === undefined || Number.isNaN(value) ? '–' : String(Number(value.toPrecision(count)));

function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

const button = (text, label, press) =>
  element('button', { type: 'button', 'aria-label': label, title: label, onclick: press }, text);

// A long description would not fit beside the axis.
const unitOf = (series) => `${series.text.length + series.unit.length < 25 ? series.text : series.name} [${series.unit}]`;
