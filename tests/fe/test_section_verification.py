"""`--verify`: K by a second method, which shares no text and no solution with the first."""

from typing import Any

import numpy as np
import pytest
from samples.section_cases import section
from samples.section_specs import rectangle_spec
from samples.shell_specs import METAL

from plymotion.preprocess.section import section_verification
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_problem import section_problem
from plymotion.preprocess.section.section_verification import LARGEST, verified
from plymotion.preprocess.section.space.layers import layup
from plymotion.solver.inputs.section.shapes.library import expand

pytestmark = pytest.mark.one_end

TWISTED = {"initial_curvature": [0.3, 0.0, 0.0]}


def analysed(spec: dict[str, Any]) -> tuple[str, list[str]]:
    found = analyse(spec, estimate=False, verify=True)
    return found.provenance["verification"], [w["code"] for w in found.warnings]


@pytest.mark.parametrize("number", ["02", "06", "11", "21"])
def test_two_methods_agree(number: str) -> None:
    words, codes = analysed(section(number))
    assert float(words.split()[-1]) < 1e-8
    assert "verification-differs" not in codes


def test_thin_strips() -> None:
    words, codes = analysed(rectangle_spec(1.0, 1e-2, METAL))
    assert float(words.split()[-1]) < LARGEST
    assert "verification-differs" not in codes
    assert analysed(rectangle_spec(1.0, 1e-3, METAL))[0].startswith("not done for very thin walls")


@pytest.mark.provokes("verification-differs")
def test_a_wrong_stiffness_is_found() -> None:
    spec = rectangle_spec(2.0, 1.0, METAL)
    problem = section_problem(spec, "section", 2)
    C = layup(spec, problem.mesh, problem.space, "section").stiffness
    K = analyse(spec, estimate=False).K
    for share, codes in ((0.0, []), (1e-5, ["verification-differs"])):
        wrong = K + share * np.diag([0, 0, 0, K[3, 3], 0, 0])
        found = verified(problem.space, C, wrong, k=None, own=False)
        # over the diagonal of the wrong matrix
        assert found.difference == pytest.approx(share / (1.0 + share), abs=1e-10)
        assert [w["code"] for w in found.warnings] == codes


def test_a_twisted_and_curved_section() -> None:
    spec = rectangle_spec(1.0, 0.5, METAL) | {"initial_curvature": [0.5, 0.3, -0.4]}
    spec["mesh"] = expand("rectangle", {"width": 1.0, "height": 0.5, "density": 0.4})
    words, codes = analysed(spec)
    assert float(words.split()[-1]) < 1e-10
    assert "verification-differs" not in codes


def test_what_is_not_compared_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(section_verification, "MOST_TWISTED", 100)
    words, codes = analysed(rectangle_spec(2.0, 1.0, METAL) | TWISTED)
    assert words == "not done for a twisted or curved section of more than 100 unknowns"
    assert codes == []
