"""What is known of a patient: names, mappings, files, and what is refused (ranges: ``test_numeric_fields``)."""

from dataclasses import replace

import pytest

from jawenv.anatomy.knowledge import IMAGED, LEVELS, Knowledge, knowledge
from jawenv.base.errors import InputError


def test_a_name_a_mapping_and_a_file_say_the_same(tmp_path):
    path = tmp_path / "knowledge.yaml"
    path.write_text("mass: 0.05\nhead_tilt_deg: 2\n")
    expected = Knowledge(mass=0.05, head_tilt_deg=2.0)
    for given in ({"mass": 0.05, "head_tilt_deg": 2}, path, str(path), expected):
        assert knowledge(given) == expected
    assert knowledge("imaged") is IMAGED and knowledge(None).exact and LEVELS["exact"].exact
    assert not expected.exact and replace(expected, mass=0.0, head_tilt_deg=0.0).exact


@pytest.mark.parametrize("given", ["atlas", "no", {"weight": 0.1}, {"mass": -0.1}, {"attachments": 1.0}, 3])
def test_one_line_says_what_is_allowed(given):
    with pytest.raises(InputError) as error:
        knowledge(given)
    assert "\n" not in str(error.value)
