#version 300 es
// A point of a surface: r + A (x + o + s (U q + (Theta q) x o)), see solver/results/run_result.py.
precision highp float;
precision highp int;
precision highp sampler2D;
const int WIDTH = 1024; // texels in a row of a texture
uniform mat4 u_camera;
uniform mat3 u_A;
uniform vec3 u_r;
uniform float u_scale;
uniform int u_modes;
uniform int u_field; // 0 body, 1 displacement; of sites 2 energy, 3 exposure, 4 stress, 5 ply
uniform float u_range; // value of the last colour
uniform sampler2D u_q;
uniform sampler2D u_shapes;
uniform sampler2D u_sites;
in vec3 a_base;
in vec3 a_offset;
in uint a_node;
in uint a_site;
in vec4 a_corner; // distances to the edges of the triangle, 1: joint
out vec3 v_position;
out vec4 v_corner;
out float v_value;
flat out float v_first; // of one corner, for the whole triangle

vec3 shape(int texel) {
  return texelFetch(u_shapes, ivec2(texel % WIDTH, texel / WIDTH), 0).xyz;
}

void main() {
  vec3 u = vec3(0.0), theta = vec3(0.0);
  for (int i = 0; i < u_modes; i++) {
    float q = texelFetch(u_q, ivec2(i, 0), 0).x;
    int first = (int(a_node) * u_modes + i) * 2;
    u += q * shape(first);
    theta += q * shape(first + 1);
  }
  v_position = u_r + u_A * (a_base + a_offset + u_scale * (u + cross(theta, a_offset)));
  v_value = -1.0;
  if (u_field == 1) v_value = length(u) / u_range;
  if (u_field > 1 && a_site > 0u) {
    int site = int(a_site) - 1;
    v_value = texelFetch(u_sites, ivec2(site % WIDTH, site / WIDTH), 0).x / u_range;
  }
  if (a_corner.w > 0.5) v_value = -1.0;
  v_first = v_value;
  v_corner = a_corner;
  gl_Position = u_camera * vec4(v_position, 1.0);
}
