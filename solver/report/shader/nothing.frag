#version 300 es
// For programs whose vertices are all that is asked for.
precision highp float;
precision highp int;
out vec4 colour;
void main() { colour = vec4(0.0); }
