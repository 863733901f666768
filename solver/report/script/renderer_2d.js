// Draw in a part of a canvas only; pen.restore() ends it.
function inBox(pen, left, width, height) {
  pen.save();
  pen.translate(left, 0);
  pen.beginPath();
  pen.rect(0, 0, width, height);
  pen.clip();
}

// Drawing without WebGL: triangles from far to near, computed in double precision.

function flatRenderer(canvas) {
  const pen = canvas.getContext('2d');
  return {
    name: 'canvas2d',
    canvas,
    draw(layers, camera, shown, [left, , width, height]) {
      const matrix = cameraMatrix(camera, width / height);
      const faces = [];
      for (const { scene, states, alpha, plain } of layers) {
        scene.bodies.forEach((body, i) => {
          const points = pointsAt(body, states[i], shown.scale), triangles = array(body.triangles), kind = array(body.kind);
          const pixels = [];
          for (let p = 0; p < points.length; p += 3) pixels.push(projected(matrix, points.subarray(p, p + 3), width, height));
          for (let f = 0; f < triangles.length; f += 3) {
            const corners = [0, 1, 2].map((a) => pixels[triangles[f + a]]);
            const colour = plain || kind[f / 3] ? '--grey' : COLOURS[i % COLOURS.length];
            faces.push({ corners, depth: corners[0][2] + corners[1][2] + corners[2][2], colour: shade(colour), alpha });
          }
        });
      }
      faces.sort((a, b) => b.depth - a.depth);
      inBox(pen, left, width, height);
      pen.fillStyle = shade('--paper');
      pen.fillRect(0, 0, width, height);
      for (const { corners, colour, alpha } of faces) {
        pen.globalAlpha = alpha;
        pen.beginPath();
        corners.forEach(([x, y], a) => (a ? pen.lineTo(x, y) : pen.moveTo(x, y)));
        pen.closePath();
        pen.fillStyle = pen.strokeStyle = colour;
        pen.fill();
        pen.stroke();
      }
      pen.restore();
    },
  };
}
