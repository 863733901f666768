"""Cases with studies: a ball on a spring whose best design has a closed form; a laminated tube."""

from typing import Any

V0, M, F_MAX = 2.0, 3.0, 60.0  # speed at the start [m/s], mass [kg], largest force [N]
BEST = (F_MAX / V0) ** 2 / M  # stiffness [N/m]: of a stop in the shortest way, x = v0 sqrt(m / k)

CARBON = {
    "kind": "orthotropic",
    **{"E1": 142.0e9, "E2": 9.8e9, "E3": 9.8e9, "G12": 6.0e9, "G13": 6.0e9, "G23": 4.8e9},
    **{"nu12": 0.3, "nu13": 0.3, "nu23": 0.34, "rho": 1600.0},
}


def oscillator(**study: Any) -> dict[str, Any]:
    """A ball that runs into a spring: the least way at a force of at most F_MAX."""
    unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    return {
        "format": 1,
        "title": "Ball on a spring",
        "bodies": {
            "ball": {
                "kind": "rigid",
                "mass": M,
                "inertia": unit,
                "velocity": [V0, 0.0, 0.0],
                "interfaces": {"centre": {"position": [0.0, 0.0, 0.0]}},
            }
        },
        "ground": {"zero": {"position": [0.0, 0.0, 0.0]}, "wall": {"position": [1.0, 0.0, 0.0]}},
        "joints": {
            "rail": {
                "kind": "prismatic",
                "between": ["ground.zero", "ball.centre"],
                "axis": [1.0, 0.0, 0.0],
            }
        },
        "forces": {
            "buffer": {
                "kind": "spring",
                "between": ["ground.wall", "ball.centre"],
                "stiffness": 100.0,
            }
        },
        "signals": {
            "x": {"kind": "position", "at": "ball.centre", "component": "x"},
            "a": {"kind": "acceleration", "at": "ball.centre", "component": "x"},
        },
        "solver": {"t_end": 0.6, "output_step": 0.01},
        "runs": {"base": {}},
        "design": {
            "parameters": {
                "k": {"of": ["forces.buffer.stiffness"], "kind": "number", "bounds": [50.0, 900.0]}
            },
            "studies": {
                "stop": {
                    "run": "base",
                    "minimise": {"signal": "x", "of": "max"},
                    "subject_to": [{"signal": "a", "of": "min", "min": -F_MAX / M}],
                    "starts": 2,
                    "verify": False,
                    **study,
                }
            },
        },
    }


def tube(plies: int = 2, **design: Any) -> dict[str, Any]:
    """A cantilevered tube of laminated plies of 0.25 mm, radius 25 mm."""
    ply = {"material": "carbon", "angle_deg": 20.0, "thickness": 0.25e-3}
    return {
        "format": 1,
        "title": "Laminated tube",
        "materials": {"carbon": CARBON},
        "sections": {
            "tube": {
                "description": {
                    "convention": "contour",
                    "mesh": {"shape": "tube", "outer_radius": 0.025},
                    "laminates": {"wall": {"plies": [dict(ply) for _ in range(plies)]}},
                    "regions": {"all": {"laminate": "wall"}},
                }
            }
        },
        "bodies": {
            "arm": {
                "kind": "beam",
                "length": 0.6,
                "section": "tube",
                "elements": 8,
                "modes": [{"kind": "lowest", "count": 4}],
                "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}},
            }
        },
        "ground": {"base": {"position": [0.0, 0.0, 0.0]}},
        "joints": {"root": {"kind": "fixed", "between": ["ground.base", "arm.root"]}},
        "signals": {"tip": {"kind": "deflection", "at": "arm.tip", "component": "z"}},
        "solver": {"t_end": 0.01, "output_step": 0.001},
        "runs": {"base": {}},
        "design": design,
    }


STRENGTH = {"Xt": 2280.0e6, "Xc": 1440.0e6, "Yt": 57.0e6, "Yc": 228.0e6, "S12": 71.0e6}


def swung(plies: int = 2, **design: Any) -> dict[str, Any]:
    """The tube with 1 kg at its tip, turned by a drive beside a rigid one that signals read."""
    table = tube(plies, **design)
    table["materials"] = {"carbon": {**CARBON, "strength": STRENGTH}}
    table["gravity"] = [0.0, 0.0, -9.81]
    table["masses"] = {"load": {"mass": 1.0, "at": "arm.tip"}}
    step = {"smooth_step": {"start": 0.0, "duration": 0.05, "value": 0.3}}
    table["joints"]["root"] |= {"kind": "revolute", "axis": [0.0, -1.0, 0.0], "drive": step}
    rigid = {"kind": "difference", "of": "z", "run": "rigid"}
    place = {"kind": "position", "at": "arm.tip", "component": "z"}
    table["signals"] = {"z": place, "error": rigid}
    table["solver"] = {"t_end": 0.06, "output_step": 0.002, "rtol": 1e-9}
    table["runs"] = {"base": {}, "rigid": {"variants": ["rigid"]}}
    table["variants"] = {"rigid": {"bodies": {"arm": {"rigid": True}}}}
    return table


def angles(plies: int, **more: Any) -> dict[str, Any]:
    """A parameter p0, p1, ... for the angle of each ply of the tube."""
    own = {"kind": "angle", "bounds": [-90.0, 90.0], **more}
    key = "sections.tube:laminates.wall.plies.{}.angle_deg"
    return {f"p{k}": {"of": [key.format(k)], **own} for k in range(plies)}
