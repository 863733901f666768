"""The last section of report.html: the meaning of its numbers."""

READING = """<section id='reading' class='reading'><h2>How to read this page</h2><dl>
<dt>Completed</dt><dd>The run reached its end time. A stopped run is shown up to its stop.
Its final values are those at the stop. A run is invalid from the
time at which a finding of level error says so.</dd>
<dt>Constraint violation</dt><dd>The largest distance, over the run, between points that a joint
connects.</dd>
<dt>Energy drift</dt><dd>Kinetic, strain and potential energy minus the work of drives and dampers
is constant in an exact solution. The number is its largest change, divided by the largest energy
of the run.</dd>
<dt>Solve</dt><dd>Wall time to build the model and to integrate it. Start of the program, reading,
recovery of results and writing are left out; <code>cost.seconds</code> of summary.json has
them.</dd>
<dt>Minimum, maximum, rms</dt><dd>Of a signal at the output times. <em>show</em> goes to its
largest magnitude.</dd>
<dt>Spectrum</dt><dd>Amplitude of the part of the signal in view, without its mean, with a Hann
window. A pure vibration shows its amplitude at its frequency.</dd>
<dt>Strength ratio R</dt><dd>The factor on all stresses at which the first ply fails, lowest over
points and output times. Below 1 the ply fails in this run. The exposure 1/R grows with the load.
Stresses depend on the modes of the body: use more modes and compare. Shown if
materials have strengths.</dd>
<dt>Keys</dt><dd>Space: play and pause. Left and right: one step. Home and End: first and last
time. Drag over a plot to zoom, double-click to see all again, click to go to that time.</dd>
<dt>More</dt><dd>The folder of each run has <code>summary.json</code> (these numbers for
programs) and <code>result.vtkhdf</code>. In ParaView apply the filter <em>Warp By Vector</em>
with the array <em>displacement</em>, then press play. <code>plymotion report FOLDER
--figures</code> draws the plots as PNG files, <code>--glb</code> writes the animation for Blender
and slides, <code>--vtk</code> for ParaView with sections and strength ratios.</dd></dl>
</section>"""
