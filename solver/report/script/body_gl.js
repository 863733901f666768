// A body in WebGL: corners of its triangles, mode shapes, values of its sites.

const ATTRIBUTES = ['a_base', 'a_offset', 'a_node', 'a_site', 'a_corner'];

function bodyOnGpu(gl, program, body) {
  const triangles = array(body.triangles), count = triangles.length;
  const [node, offset, nodes, site, edges, kind] = ['node', 'offset', 'nodes', 'site', 'edges', 'kind'].map((name) => array(body[name]));
  const base = new Float32Array(3 * count), away = new Float32Array(3 * count), corner = new Float32Array(4 * count);
  const nodeOf = new Uint32Array(count);
  for (let c = 0; c < count; c++) {
    const point = triangles[c], f = Math.floor(c / 3), n = (nodeOf[c] = node[point]);
    for (let a = 0; a < 3; a++) {
      base[3 * c + a] = nodes[3 * n + a];
      away[3 * c + a] = offset[3 * point + a];
      // Edge a-(a+1) is opposite to corner a+2; one that is not drawn is far from everywhere.
      const opposite = (a + 2) % 3;
      corner[4 * c + opposite] = edges[f] & (1 << a) ? (c % 3 === opposite ? 1 : 0) : 1;
    }
    corner[4 * c + 3] = kind[f];
  }
  const found = {
    body,
    count,
    vertices: gl.createVertexArray(),
    shapes: makeTexture(gl, array(body.shapes), 3),
    q: makeTexture(gl, new Float32Array(Math.max(body.modes, 1)), 1, Math.max(body.modes, 1)),
    sites: makeTexture(gl, new Float32Array(body.sites ? page.arrays[body.sites.energy.steps].shape[1] : 1), 1),
  };
  gl.bindVertexArray(found.vertices);
  [base, away, nodeOf, site, corner].forEach((values, i) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    const at = gl.getAttribLocation(program.program, ATTRIBUTES[i]);
    if (at < 0) return;
    gl.enableVertexAttribArray(at);
    if (values instanceof Uint32Array) gl.vertexAttribIPointer(at, 1, gl.UNSIGNED_INT, 0, 0);
    else gl.vertexAttribPointer(at, values.length / count, gl.FLOAT, false, 0, 0);
  });
  gl.bindVertexArray(null);
  gl.bindBuffer(gl.ARRAY_BUFFER, null);
  return found;
}
