// Drawing with WebGL2. Throws where there is none, or where a shader fails.

function glRenderer(canvas) {
  const gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
  if (!gl) throw new Error('no WebGL2');
  const move = makeProgram(gl, SHADERS['move.vert'], SHADERS['surface.frag'], 'v_position');
  const known = new Map(); // bodies on the GPU, by body
  const onGpu = (body) => {
    if (!known.has(body)) known.set(body, bodyOnGpu(gl, move, body));
    return known.get(body);
  };

  // Everything of a body but what is the same for all of a picture.
  function prepare(scene, body, state, shown) {
    const gpu = onGpu(body);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, gpu.q.texture);
    if (body.modes) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, body.modes, 1, gl.RED, gl.FLOAT, Float32Array.from(state.q));
    if (body.sites && shown.field > 1) {
      const { texture, width, height } = gpu.sites, padded = new Float32Array(width * height);
      padded.set(siteValues(scene, body, state, shown.name));
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RED, gl.FLOAT, padded);
    }
    gl.useProgram(move.program);
    gl.bindVertexArray(gpu.vertices);
    gl.uniformMatrix3fv(move.at.u_A, true, state.A);
    gl.uniform3fv(move.at.u_r, state.r);
    gl.uniform1f(move.at.u_scale, shown.scale);
    gl.uniform1i(move.at.u_modes, body.modes);
    gl.uniform1i(move.at.u_field, shown.field > 1 && !body.sites ? 0 : shown.field);
    gl.uniform1f(move.at.u_range, shown.ranges[rangeOf(shown.name, body)] || 1);
    useTexture(gl, move, 'u_q', 0, gpu.q);
    useTexture(gl, move, 'u_shapes', 1, gpu.shapes);
    useTexture(gl, move, 'u_sites', 3, gpu.sites);
    return gpu;
  }

  return {
    name: 'webgl2',
    canvas,
    // layers: [{ scene, states, alpha, colours }], the first is solid; box: part of the canvas
    draw(layers, camera, shown, box) {
      gl.viewport(...box);
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(...box);
      gl.clearColor(...rgb('--paper'), 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.enable(gl.BLEND);
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.useProgram(move.program);
      gl.uniformMatrix4fv(move.at.u_camera, false, cameraMatrix(camera, box[2] / box[3]));
      gl.uniform3fv(move.at.u_eye, eyeOf(camera));
      gl.uniform3fv(move.at.u_joint, rgb('--grey'));
      gl.uniform1f(move.at.u_edges, shown.edges ? 1 : 0);
      for (const { scene, states, alpha, plain } of layers) {
        scene.bodies.forEach((body, i) => {
          const gpu = prepare(scene, body, states[i], plain ? { ...shown, field: 0 } : shown);
          gl.uniform1f(move.at.u_alpha, alpha);
          gl.uniform3fv(move.at.u_colour, plain ? rgb('--grey') : rgb(COLOURS[i % COLOURS.length]));
          gl.polygonOffset(0.05 * i, 4 * i); // of surfaces at the same place, that of the first body is seen
          gl.drawArrays(gl.TRIANGLES, 0, gpu.count);
        });
      }
      gl.disable(gl.POLYGON_OFFSET_FILL);
      gl.bindVertexArray(null);
    },
    // Positions of all corners of a body's triangles: for tests.
    capture(scene, body, state, shown) {
      const gpu = prepare(scene, body, state, shown), buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, 12 * gpu.count, gl.DYNAMIC_READ);
      gl.bindBuffer(gl.ARRAY_BUFFER, null);
      captureInto(gl, buffer, gl.TRIANGLES, gpu.count);
      gl.bindVertexArray(null);
      return readBuffer(gl, buffer, 3 * gpu.count);
    },
  };
}
