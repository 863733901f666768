// Failure criteria as in solver/strength/criteria: exposures 1/R of a stress in ply axes, order
// 11 22 33 23 13 12. Strengths in three texels: kind, yield stress, Xt, Xc; Yt, Yc, Zt, Zc;
// S23, S13, S12, F12_star.
float ray(float a, float b) { // 1/R of a R^2 + b R = 1
  float under = b * b + 4.0 * a;
  if (under < 0.0 || (a <= 0.0 && b <= 0.0)) return 0.0;
  float root = sqrt(under);
  return b >= 0.0 ? 0.5 * (b + root) : 2.0 * a / (root - b);
}

float maxStress(float s[6], vec3 t, vec3 c, vec3 shear) {
  vec3 n = vec3(s[0], s[1], s[2]), v = abs(vec3(s[3], s[4], s[5])) / shear;
  vec3 used = max(max(n / t, -n / c), v);
  return max(used.x, max(used.y, used.z));
}

float tsaiHill(float s[6], vec3 t, vec3 c, vec3 shear) {
  vec3 n = vec3(s[0], s[1], s[2]), v = vec3(s[3], s[4], s[5]) / shear;
  vec3 u = max(n / t, -n / c);
  vec3 tt = 1.0 / (t * t), cc = 1.0 / (c * c);
  float X = n.x >= 0.0 ? tt.x : cc.x;
  float Y = n.y >= 0.0 ? tt.y : cc.y, Zof2 = n.y >= 0.0 ? tt.z : cc.z;
  float Z = n.z >= 0.0 ? tt.z : cc.z, Yof3 = n.z >= 0.0 ? tt.y : cc.y;
  float pairs = (X + Y - Zof2) * n.x * n.y + (X + Z - Yof3) * n.x * n.z + (Y + Z - tt.x) * n.y * n.z;
  return sqrt(max(dot(u, u) + dot(v, v) - pairs, 0.0));
}

float tsaiWu(float s[6], vec3 t, vec3 c, vec3 shear, float star) {
  vec3 n = vec3(s[0], s[1], s[2]), v = vec3(s[3], s[4], s[5]) / shear;
  vec3 w = n / sqrt(t * c);
  float a = dot(w, w) + dot(v, v) + 2.0 * star * (w.x * w.y + w.x * w.z + w.y * w.z);
  return ray(max(a, 0.0), dot(n, 1.0 / t - 1.0 / c));
}

float hashin(float s[6], vec3 t, vec3 c, vec3 shear) {
  float sum = s[1] + s[2], d = (s[1] - s[2]) / shear.x;
  vec3 v = vec3(s[3], s[4], s[5]) / shear;
  float along = v.z * v.z + v.y * v.y, across = 0.25 * d * d + v.x * v.x;
  float square = sum * sum * (1.0 / (t.y * t.y) - 0.25 / (shear.x * shear.x));
  float half_ = 0.5 * c.y / shear.x, push = (half_ * half_ - 1.0) / c.y;
  float matrix = sum >= 0.0 ? ray(square + across + along, 0.0) : ray(across + along, push * sum);
  float pull = s[0] / t.x;
  float fibre = s[0] >= 0.0 ? ray(pull * pull + along, 0.0) : -s[0] / c.x;
  return max(matrix, fibre);
}

float vonMises(float s[6], float yieldStress) {
  vec3 d = vec3(s[0] - s[1], s[1] - s[2], s[2] - s[0]), v = vec3(s[3], s[4], s[5]);
  return sqrt(0.5 * dot(d, d) + 3.0 * dot(v, v)) / yieldStress;
}

// The highest exposure and the number of its criterion in CRITERIA (script/colours.js).
vec2 worst(float s[6], int first) {
  vec4 one = texel(u_data, first), two = texel(u_data, first + 1), three = texel(u_data, first + 2);
  if (one.x < 0.5) return vec2(0.0, -1.0);
  if (one.x > 1.5) return vec2(vonMises(s, one.y), 4.0);
  vec3 t = vec3(one.z, two.x, two.z), c = vec3(one.w, two.y, two.w), shear = three.xyz;
  float found[4];
  found[0] = maxStress(s, t, c, shear);
  found[1] = tsaiHill(s, t, c, shear);
  found[2] = tsaiWu(s, t, c, shear, three.w);
  found[3] = hashin(s, t, c, shear);
  vec2 top = vec2(-1.0);
  for (int k = 0; k < 4; k++) if (found[k] > top.x) top = vec2(found[k], float(k));
  return top;
}
