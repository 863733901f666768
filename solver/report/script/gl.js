// WebGL2: programs, textures and buffers.

const WIDTH = 1024; // texels in a row, as in the shaders

function makeProgram(gl, vertex, fragment, captured) {
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) || 'shader');
  }
  gl.transformFeedbackVaryings(program, [captured], gl.INTERLEAVED_ATTRIBS);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || 'link');
  const found = { program, at: {} };
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(program, i).name;
    found.at[name.replace('[0]', '')] = gl.getUniformLocation(program, name);
  }
  return found;
}

// A texture of float texels with 1, 3 or 4 numbers, in rows of WIDTH (one row for `width`).
function makeTexture(gl, values, channels, width = WIDTH) {
  const [inside, format] = { 1: [gl.R32F, gl.RED], 3: [gl.RGB32F, gl.RGB], 4: [gl.RGBA32F, gl.RGBA] }[channels];
  const height = Math.max(1, Math.ceil(values.length / channels / width));
  const padded = new Float32Array(width * height * channels);
  padded.set(values);
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, inside, width, height, 0, format, gl.FLOAT, padded);
  for (const name of ['MIN_FILTER', 'MAG_FILTER']) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.NEAREST);
  return { texture, width, height };
}

function useTexture(gl, program, name, unit, { texture }) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.uniform1i(program.at[name], unit);
}

// Run a vertex shader over `count` vertices and keep what it gives in a buffer.
function captureInto(gl, buffer, mode, count) {
  const feedback = gl.createTransformFeedback();
  gl.bindTransformFeedback(gl.TRANSFORM_FEEDBACK, feedback);
  gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
  gl.enable(gl.RASTERIZER_DISCARD);
  gl.beginTransformFeedback(mode);
  gl.drawArrays(mode, 0, count);
  gl.endTransformFeedback();
  gl.disable(gl.RASTERIZER_DISCARD);
  gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, null);
  gl.bindTransformFeedback(gl.TRANSFORM_FEEDBACK, null);
  gl.deleteTransformFeedback(feedback);
}

function readBuffer(gl, buffer, count) {
  const found = new Float32Array(count);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.getBufferSubData(gl.ARRAY_BUFFER, 0, found);
  gl.bindBuffer(gl.ARRAY_BUFFER, null);
  return found;
}
