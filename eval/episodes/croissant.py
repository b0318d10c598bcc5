"""A data set's description for machines: Croissant 1.0 with its vocabulary for responsible use (RAI)."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from jawenv.base.extras import needs
from jawenv.base.files import write_text

FILE = "croissant.json"
ENCODINGS = {".arrow": "application/vnd.apache.arrow.file", ".hdf5": "application/x-hdf5", ".json": "application/json"}
"""Suffix of a file -> its media type."""
CITATION = (
    "M. S. Young, Stiffness Parameter Identification of the Muscles of Mastication, Texas A&M University, 2016; jawenv"
)
RESPONSIBLE_USE: dict[str, Any] = {
    "data_collection": "Simulated: one episode of one agent for each patient, from reset(seed) to its end.",
    "data_collection_type": ["Software Collection"],
    "data_biases": [
        "Patients are drawn from one assumed population (docs/environment.md); no real person's jaw is in the data."
    ],
    "data_limitations": [
        "The simulation leaves out active resistance, pain and disease of the joint.",
        "The truth in info is for judging; a policy must not read it.",
    ],
    "data_use_cases": ["Offline learning, imitation, models of the dynamics, and checks of tools."],
    "data_social_impact": "Nothing learned here has been tried on a person, and nothing here may move a real jaw.",
    "personal_sensitive_information": ["None: all patients are simulated."],
    "data_release_maintenance_plan": "A change of an environment's observation, reward or defaults raises its -vN.",
}


def write_croissant(folder: Path, name: str, description: str) -> Path:
    """Describe the files of a data set.

    Args:
        folder: of the data set.
        name: of the data set, as ``jawenv/jaw/refined-v0``.
        description: what is in it, and what made it.

    Returns:
        The file, ``croissant.json`` in the folder.

    Raises:
        MissingPackageError: mlcroissant is not installed.
        InputError: the file cannot be written.
    """
    with needs("--croissant", "mlcroissant", group="dataset"):
        import mlcroissant
    files = sorted(path for path in folder.rglob("*") if path.suffix in ENCODINGS and path.name != FILE)
    metadata = mlcroissant.Metadata(
        name=name,
        description=description,
        license=["https://spdx.org/licenses/MIT"],
        version=f"{name.rpartition('-v')[2]}.0.0",
        cite_as=CITATION,
        distribution=[
            mlcroissant.FileObject(
                id=str(path.relative_to(folder)),
                name=str(path.relative_to(folder)),
                content_url=str(path.relative_to(folder)),
                content_size=f"{path.stat().st_size} B",
                encoding_formats=[ENCODINGS[path.suffix]],
                sha256=hashlib.sha256(path.read_bytes()).hexdigest(),
            )
            for path in files
        ],
        **RESPONSIBLE_USE,
    )
    write_text(folder / FILE, json.dumps(metadata.to_json(), indent=2, default=str) + "\n")
    return folder / FILE
