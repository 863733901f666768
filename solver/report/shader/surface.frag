#version 300 es
// Light from the eye, the colour of a value between 0 and 1, edges of the mesh.
precision highp float;
precision highp int;
uniform vec3 u_colour;
uniform vec3 u_joint;
uniform vec3 u_eye;
uniform float u_alpha;
uniform float u_edges;
in vec3 v_position;
in vec4 v_corner;
in float v_value;
flat in float v_first;
uniform int u_field;
out vec4 colour;

// Viridis by a polynomial of degree 6 (in the order of powers).
vec3 viridis(float t) {
  const vec3 c0 = vec3(0.2777, 0.0054, 0.3341), c1 = vec3(0.1051, 1.4046, 1.3846);
  const vec3 c2 = vec3(-0.3309, 0.2148, 0.0951), c3 = vec3(-4.6342, -5.7991, -19.3324);
  const vec3 c4 = vec3(6.2283, 14.1799, 56.6906), c5 = vec3(4.7764, -13.7451, -65.3530);
  const vec3 c6 = vec3(-5.4355, 4.6459, 26.3124);
  return c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * c6)))));
}

void main() {
  vec3 base = v_corner.w > 0.5 ? u_joint : u_colour;
  float value = u_field == 5 ? v_first : v_value;
  if (value > 1.0005) base = vec3(0.78, 0.0, 0.13);
  else if (value >= 0.0) base = viridis(value);
  vec3 normal = normalize(cross(dFdx(v_position), dFdy(v_position)));
  float light = 0.45 + 0.55 * abs(dot(normal, normalize(u_eye - v_position)));
  vec3 width = fwidth(v_corner.xyz);
  vec3 near = 1.0 - smoothstep(0.4 * width, 1.4 * width, v_corner.xyz);
  // Edges of triangles that are as thin as a line would hide the surface.
  near *= 1.0 - smoothstep(0.15, 0.4, width);
  float line = u_edges * max(near.x, max(near.y, near.z));
  colour = vec4(mix(base * light, vec3(0.08), 0.45 * line), u_alpha);
}
