// What the surface can be coloured by, and the words of its legend.

const FIELDS = {
  body: { number: 0 },
  displacement: { number: 1, label: 'elastic displacement', units: ['m'], largest: (body) => body.displacement },
  energy: { number: 2, label: 'strain energy', units: ['J/m', 'J/m² (shells)', 'J/m³ (solids)'], largest: (body) => body.energy },
  exposure: { number: 3, label: 'exposure 1/R of the worst ply', units: ['(failure at 1)'], largest: (body) => body.exposure },
};

// Energies of beams, shells, solids are for unit length, area, volume: each has its own range.
const rangeOf = (name, body) => (name === 'energy' && body.sites ? body.sites.dimension - 1 : 0);

function fieldRanges(name, scene) {
  if (name === 'body') return [1, 1];
  return [0, 1, 2].map((row) => Math.max(0, ...scene.bodies.filter((body) => rangeOf(name, body) === row).map(FIELDS[name].largest)));
}

function fieldLegend({ name, ranges }) {
  const known = ranges.map((top, i) => [top, FIELDS[name].units[i]]).filter(([top, unit]) => top && unit);
  const ends = known.map(([top, unit]) => `${digits(top, 3)} ${unit}`).join(', ');
  return [element('span', {}, '0'), element('i', {}), element('span', {}, ends || '0'), element('span', {}, FIELDS[name].label)];
}

const hasStrength = (scene) => scene.bodies.some((body) => body.sites && body.sites.exposure !== undefined);

const rgb = (name) => {
  const text = shade(name).slice(1), full = text.length === 3 ? [...text].map((c) => c + c).join('') : text;
  return [0, 2, 4].map((i) => parseInt(full.slice(i, i + 2), 16) / 255);
};
