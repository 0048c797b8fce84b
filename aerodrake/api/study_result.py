"""Results of a study: a sweep or an error budget."""

import base64
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any, ClassVar

from aerodrake.sweeps.folder import SweepFolder
from aerodrake.sweeps.study_files import StudyFiles


class StudyResult:
    """Results of a study. `print` shows its table, a notebook also its figure.

    Attributes:
        summary: Content of the summary in its folder.
        folder: Folder of the study.
    """

    files: ClassVar[StudyFiles]

    def __init__(self, summary: Mapping[str, Any], folder: Path):
        self.summary = summary
        self.folder = folder

    @staticmethod
    def write(folder: SweepFolder) -> Mapping[str, Any]:
        """Writes summary and figure of a study whose trials all have rows; returns the summary.

        Raises:
            BadInput: if the summary cannot be written.
        """
        raise NotImplementedError

    def __str__(self) -> str:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        figure = self.folder / self.files.figure
        if not figure.exists():  # It could not be drawn.
            return f"<pre>{escape(str(self))}</pre>"
        picture = base64.b64encode(figure.read_bytes()).decode()
        alt = f"Results of the {self.files.kind}"
        image = f'<img alt="{alt}" src="data:image/png;base64,{picture}">'
        return f"<pre>{escape(str(self))}</pre>{image}"
