"""A case of one arm, a laminated tube that is described in the case file."""

TUBE = """
convention = "contour"
mesh = { shape = "tube", outer_radius = 0.03 }
laminates.wall = { material = "carbon", angles_deg = [30, -30], ply_thickness = 0.5e-3 }
regions.all = { laminate = "wall" }
"""
CARBON = """
[materials.carbon]
kind = "orthotropic"
E1 = 130e9
E2 = 9e9
E3 = 9e9
G12 = 5e9
G13 = 5e9
G23 = 3e9
nu12 = 0.3
nu13 = 0.3
nu23 = 0.4
rho = 1600.0
"""
CASE = f"""
format = 1
title = "arm"
{CARBON}
[sections.tube.description]
{TUBE}
[bodies.arm]
kind = "beam"
length = 1.0
section = "tube"
modes = [{{ kind = "lowest", count = 2 }}]
interfaces = {{ root = {{ at = "start" }}, tip = {{ at = "end" }} }}
[ground.hinge]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.hinge", "arm.root"]
axis = [0.0, 0.0, 1.0]
[parameters]
plus = 1.0
[solver]
t_end = 0.1
output_step = 0.01
[runs.base]
"""
