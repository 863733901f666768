// What the surface can be coloured by, and the words of its legend.

const CRITERIA = ['max-stress', 'Tsai-Hill', 'Tsai-Wu', 'Hashin', 'von Mises'];
const FIELDS = {
  body: { number: 0 },
  displacement: { number: 1, label: 'elastic displacement [m]', largest: (body) => body.displacement },
  energy: { number: 2, label: 'strain energy for unit length [J/m], of shells for unit area [J/m²]', largest: (body) => body.energy },
  exposure: { number: 3, label: 'exposure 1/R of the worst ply [-], failure at 1', largest: () => 1 },
};

const fieldRange = (name, scene) => (name === 'body' ? 1 : Math.max(...scene.bodies.map(FIELDS[name].largest)) || 1);

const hasStrength = (scene) => scene.bodies.some((body) => body.sites && body.sites.starts.at(-1) > 0);

const rgb = (name) => {
  const text = shade(name).slice(1), full = text.length === 3 ? [...text].map((c) => c + c).join('') : text;
  return [0, 2, 4].map((i) => parseInt(full.slice(i, i + 2), 16) / 255);
};
