// The data of the page: the index (JSON) and the arrays (gzip in base64, byte-shuffled).

const page = JSON.parse(document.getElementById('index').textContent);
const TYPES = { f4: Float32Array, f8: Float64Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };
let stored = null; // all bytes of the arrays
const unpacked = new Map();

async function unpackArrays() {
  const text = atob(document.getElementById('arrays').textContent);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  stored = new Uint8Array(await new Response(stream).arrayBuffer());
}

// The array of a number in the index, as a typed array in row-major order.
function array(number) {
  if (!unpacked.has(number)) {
    const { type, shape, at } = page.arrays[number];
    const count = shape.reduce((a, b) => a * b, 1);
    const values = new TYPES[type](count);
    const bytes = new Uint8Array(values.buffer), size = values.BYTES_PER_ELEMENT;
    for (let b = 0; b < size; b++) {
      const from = at + b * count;
      for (let i = 0; i < count; i++) bytes[i * size + b] = stored[from + i];
    }
    unpacked.set(number, values);
  }
  return unpacked.get(number);
}

const runOf = (name) => page.runs.find((run) => run.name === name);
