"""Names of trials, which are those of their recordings."""

from telex_training.ros.session import free_name


def test_two_trials_of_one_second_have_recordings_of_their_own(tmp_path):
    assert free_name(tmp_path, "ann_slalom") == "ann_slalom"
    (tmp_path / "ann_slalom.mcap").touch()
    assert free_name(tmp_path, "ann_slalom") == "ann_slalom_2"
    (tmp_path / "ann_slalom_2.mcap").touch()
    assert free_name(tmp_path, "ann_slalom") == "ann_slalom_3"
