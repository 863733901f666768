"""Frequencies of a prebent, twisted, tapered blade with couplings, by two routes."""

import numpy as np
import pytest
from samples.beam_samples import dense
from samples.beam_tables import rod_frequencies, write_table

from plymotion.preprocess.beam.beam_body import beam_model, beam_modes, beam_package
from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.sections import given_section
from plymotion.solver.inputs.case.bodies.beams import beam_spec
from plymotion.solver.inputs.case.tables.laws import FOLDER
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.package.body.package_schema import SectionData


def blade(folder, elements):
    body = {
        "kind": "beam",
        "table": "beam.csv",
        "elements": elements,
        "modes": [{"kind": "lowest", "count": 5}],
        "interfaces": {"root": {"at": "start"}},
        "reference": {"kind": "clamped", "at": "root"},
    }
    table = {"bodies": {"blade": body}, "solver": {"t_end": 1.0, "output_step": 0.1}}
    return Mechanism.model_validate(table, context={FOLDER: folder})


def package(mechanism, folder):
    spec, _ = beam_spec("blade", mechanism.bodies["blade"], mechanism, folder)
    beam = read_spec(dict(spec))
    sections = [given_section(table) for table in beam.sections]
    model = beam_model(beam, *(section.line for section in sections))
    modes = beam_modes(model, dense)
    return beam_package(
        model, modes, [SectionData("s", s.line.K, s.line.mass) for s in sections], {}
    )


def test_frequencies_of_a_table_are_those_of_the_rod(tmp_path):
    """The error of the elements falls with the square of their length."""
    write_table(tmp_path / "beam.csv")
    errors = []
    for elements in (32, 64):
        mechanism = blade(tmp_path, elements)
        found = package(mechanism, tmp_path)
        w, mass = rod_frequencies(mechanism.bodies["blade"], found.frequencies[:4])
        errors.append(np.abs(found.frequencies[:4] / w - 1.0).max())
        assert found.invariants.mass == pytest.approx(mass, rel=2e-3)
    assert errors[1] < 1e-3
    assert errors[1] < 0.4 * errors[0]
