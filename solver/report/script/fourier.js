// Amplitude spectrum of a history.

const MOST_SAMPLES = 32768;

// In place, length a power of two.
function fourier(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let half = 1; half < n; half *= 2) {
    for (let k = 0; k < half; k++) {
      const c = Math.cos((Math.PI * k) / half), s = -Math.sin((Math.PI * k) / half);
      for (let i = k; i < n; i += 2 * half) {
        const j = i + half;
        const x = re[j] * c - im[j] * s, y = re[j] * s + im[j] * c;
        re[j] = re[i] - x;
        im[j] = im[i] - y;
        re[i] += x;
        im[i] += y;
      }
    }
  }
}

// { frequency [Hz], amplitude } of values between t0 and t1, without their mean, with a Hann
// window. The history is interpolated at even steps, and padded with zeros to eight times as many
// frequencies, so that the peak of a vibration is met.
function spectrum(t, values, t0, t1) {
  let first = 0, end = t.length;
  while (first < end && t[first] < t0) first++;
  while (end > first && t[end - 1] > t1) end--;
  const count = Math.min(end - first, MOST_SAMPLES / 8);
  if (count < 8) return { frequency: new Float64Array(0), amplitude: new Float64Array(0) };
  const step = (t[end - 1] - t[first]) / (count - 1);
  const even = new Float64Array(count);
  for (let i = 0, k = first; i < count; i++) {
    const at = t[first] + i * step;
    while (k < end - 2 && t[k + 1] < at) k++;
    const part = (at - t[k]) / (t[k + 1] - t[k]);
    even[i] = values[k] + Math.min(part, 1) * (values[k + 1] - values[k]);
  }
  const mean = even.reduce((a, b) => a + b, 0) / count;
  const size = 2 ** Math.ceil(Math.log2(8 * count));
  const re = new Float64Array(size), im = new Float64Array(size);
  let weight = 0;
  for (let i = 0; i < count; i++) {
    const window = 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / (count - 1));
    weight += window;
    re[i] = (even[i] - mean) * window;
  }
  fourier(re, im);
  const half = size / 2;
  const frequency = Float64Array.from({ length: half }, (_, i) => i / (size * step));
  const amplitude = Float64Array.from({ length: half }, (_, i) => (2 * Math.hypot(re[i], im[i])) / weight);
  return { frequency, amplitude };
}
