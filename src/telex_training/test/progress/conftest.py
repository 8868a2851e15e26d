"""Fixtures of the progress tests."""

import pytest
from recorded_trials import judged_trial


@pytest.fixture(scope="session")
def judged(tmp_path_factory):
    """Writes the recording of a trial that was judged into a folder; always the same one."""
    path = judged_trial(tmp_path_factory.mktemp("judged"), others=["bob", "instructor"])
    content = path.read_bytes()

    def write(folder):
        folder.mkdir(exist_ok=True)
        (folder / path.name).write_bytes(content)
        return folder / path.name

    return write
