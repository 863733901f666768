// What the surface can be coloured by, and the words of its legend.

const FIELDS = {
  body: { number: 0 },
  displacement: { number: 1, label: 'elastic displacement', units: ['m'], largest: (body) => body.displacement },
  energy: { number: 2, label: 'strain energy', units: ['J/m', 'J/m² (shells)', 'J/m³ (solids)'], largest: (body) => body.energy },
  exposure: { number: 3, label: 'exposure 1/R of the worst ply', units: ['(failure at 1)'], largest: (body) => body.exposure },
  stress: { number: 4, label: 'largest stress along the fibre, of metals von Mises', units: ['Pa'], largest: (body) => body.sites?.stress?.top ?? 0 },
  ply: { number: 5, label: 'ply with the highest exposure of the run' },
};

// Energies of beams, shells, solids are for unit length, area, volume: each has its own range.
const rangeOf = (name, body) => (name === 'energy' && body.sites ? body.sites.dimension - 1 : 0);

function fieldRanges(name, scene) {
  if (name === 'body') return [1, 1];
  if (name === 'ply') return [Math.max(plyNames(scene).length - 1, 1)];
  return [0, 1, 2].map((row) => Math.max(0, ...scene.bodies.filter((body) => rangeOf(name, body) === row).map(FIELDS[name].largest)));
}

const plyNames = (scene) => [...new Set(scene.bodies.flatMap((body) => body.sites?.plies ?? []))];

function fieldLegend({ name, ranges }, scene) {
  if (name === 'ply') {
    return plyNames(scene).flatMap((ply, k) => {
      const chip = element('i', { class: 'chip' });
      chip.style.backgroundPosition = `${(100 * k) / ranges[0]}% 0`;
      return [chip, element('span', {}, ply)];
    }).concat(element('span', {}, FIELDS.ply.label));
  }
  const known = ranges.map((top, i) => [top, FIELDS[name].units[i]]).filter(([top, unit]) => top && unit);
  const ratio = (top) => (name === 'exposure' ? `, R = ${digits(1 / top, 3)}` : '');
  const ends = known.map(([top, unit]) => `${digits(top, 3)} ${unit}${ratio(top)}`).join(', ');
  return [element('span', {}, '0'), element('i', {}), element('span', {}, ends || '0'), element('span', {}, FIELDS[name].label)];
}

const hasStrength = (scene) => scene.bodies.some((body) => body.sites && body.sites.exposure !== undefined);

const rgb = (name) => {
  const text = shade(name).slice(1), full = text.length === 3 ? [...text].map((c) => c + c).join('') : text;
  return [0, 2, 4].map((i) => parseInt(full.slice(i, i + 2), 16) / 255);
};
