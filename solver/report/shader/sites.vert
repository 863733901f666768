#version 300 es
// Strain energy and exposure of each site (station of a beam, cell of a shell) from the modal
// coordinates: F = R q, energy 1/2 F' C F, stress S F of every point, the worst of all criteria.
precision highp float;
precision highp int;
precision highp sampler2D;
const int WIDTH = 1024;
uniform int u_modes;
uniform int u_exposure; // 0: energy alone
uniform int u_firsts[5]; // first texel of: kinds of sites, compliance, ranges of points, points, strengths
uniform sampler2D u_q;
uniform sampler2D u_resultants;
uniform sampler2D u_data;
out vec4 o_site; // energy, exposure, ply, criterion

vec4 texel(sampler2D from, int number) {
  return texelFetch(from, ivec2(number % WIDTH, number / WIDTH), 0);
}

//criteria//

void main() {
  vec4 F[2];
  F[0] = vec4(0.0);
  F[1] = vec4(0.0);
  for (int i = 0; i < u_modes; i++) {
    float q = texelFetch(u_q, ivec2(i, 0), 0).x;
    int first = (gl_VertexID * u_modes + i) * 2;
    F[0] += q * texel(u_resultants, first);
    F[1] += q * texel(u_resultants, first + 1);
  }
  int kind = int(texel(u_data, u_firsts[0] + gl_VertexID).x);
  float energy = 0.0;
  for (int row = 0; row < 8; row++) {
    int first = u_firsts[1] + 16 * kind + 2 * row;
    float strain = dot(texel(u_data, first), F[0]) + dot(texel(u_data, first + 1), F[1]);
    energy += 0.5 * strain * F[row / 4][row % 4];
  }
  o_site = vec4(energy, 0.0, -1.0, -1.0);
  if (u_exposure == 1) {
    vec4 range = texel(u_data, u_firsts[2] + kind);
    for (int point = int(range.x); point < int(range.y); point++) {
      int first = u_firsts[3] + 13 * point;
      float s[6];
      for (int row = 0; row < 6; row++) {
        s[row] = dot(texel(u_data, first + 2 * row), F[0]) + dot(texel(u_data, first + 2 * row + 1), F[1]);
      }
      float ply = texel(u_data, first + 12).x;
      vec2 found = worst(s, u_firsts[4] + 3 * int(ply));
      if (found.x > o_site.y) o_site.yzw = vec3(found.x, ply, found.y);
    }
  }
  gl_Position = vec4(0.0);
}
