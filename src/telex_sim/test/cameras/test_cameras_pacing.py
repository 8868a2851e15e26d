import threading

import pytest
from telex_msgs.msg import SceneDescription, ScenePoses

from telex_sim.cameras.ros.camera_topics import LARGE_WEIGHT
from telex_sim.cameras.ros.frame_pacer import OLDEST, FramePacer, next_due
from telex_sim.cameras.ros.scene_inbox import SceneInbox

MILLISECOND = 10**6


def pictures(pacer, poses, until, tick=0.001, work=0.0):
    """Times and stamps of the pictures taken while poses come, as the node takes them.

    ``poses`` gives the stamp of the newest poses at a time (s), a picture takes ``work`` (s).
    """
    taken = []
    now = 0.0005
    while now < until:
        stamp = poses(now)
        if stamp is not None and pacer.is_due(now, stamp):
            pacer.sent(now, stamp)
            taken.append((now, stamp))
            now += work
        now += tick
    return taken


def at_rate(rate):
    return lambda now: int(now * rate) * int(1e9 / rate)


class TestFramePacer:
    @pytest.mark.parametrize("rate", [5.0, 10.0, 25.0, 30.0, 60.0])
    def test_keeps_its_rate(self, rate):
        taken = pictures(FramePacer(rate, 5.0), at_rate(60.0), 4.0)
        assert len(taken) == pytest.approx(4.0 * rate, abs=1)

    def test_never_twice_the_same_poses(self):
        taken = pictures(FramePacer(60.0, 5.0), at_rate(20.0), 2.0)
        stamps = [stamp for _, stamp in taken]
        assert len(stamps) == 40
        assert len(set(stamps)) == 40

    def test_poses_are_shown_when_they_come_not_when_the_slot_begins(self):
        taken = pictures(FramePacer(25.0, 5.0), at_rate(20.0), 2.0)
        ages = [now - stamp * 1e-9 for now, stamp in taken]
        assert max(ages) < 0.003

    def test_what_was_missed_is_not_made_up_for(self):
        taken = pictures(FramePacer(25.0, 5.0), at_rate(60.0), 3.0, work=0.1)
        gaps = [later - sooner for (sooner, _), (later, _) in zip(taken, taken[1:])]
        assert min(gaps) >= 0.1
        assert len(taken) == pytest.approx(27, abs=3)

    def test_while_poses_stand_still_a_picture_now_and_then(self):
        taken = pictures(FramePacer(25.0, 5.0), lambda now: 7 * MILLISECOND, 2.0)
        assert len(taken) == pytest.approx(10, abs=1)

    def test_the_first_picture_comes_at_once_even_if_poses_stand_still(self):
        assert FramePacer(25.0, 5.0).is_due(100.0, 0)

    def test_a_slow_camera_repeats_no_faster_than_its_rate(self):
        taken = pictures(FramePacer(2.0, 5.0), lambda now: 0, 5.0)
        assert len(taken) == pytest.approx(10, abs=1)

    def test_time_that_jumps_back_is_shown(self):
        pacer = FramePacer(25.0, 5.0)
        pacer.sent(10.0, 5000 * MILLISECOND)
        assert pacer.is_due(10.05, 0)

    def test_cameras_of_one_rate_share_their_poses(self):
        early = FramePacer(10.0, 5.0)
        late = FramePacer(10.0, 5.0)
        pictures(early, at_rate(60.0), 0.55)
        taken_early = pictures(early, at_rate(60.0), 2.0)
        taken_late = pictures(late, at_rate(60.0), 2.0)
        assert taken_early[-5:] == taken_late[-5:]


class Paced:
    def __init__(self, rate, weight=1.0, work=None):
        self.pacer = FramePacer(rate, 5.0)
        self.weight = weight
        self.work = work
        self.taken = 0


def serve(cameras, seconds, work=0.0):
    """Take pictures as the node does; their rates (1/s).

    Each takes ``work`` (s), unless the camera says otherwise.
    """
    now = 0.0005
    while now < seconds:
        stamp = int(now * 60.0) * 16 * MILLISECOND
        camera = next_due(cameras, now, stamp)
        if camera is None:
            now += 0.001
            continue
        camera.pacer.sent(now, stamp)
        camera.taken += 1
        now += work if camera.work is None else camera.work
    return [camera.taken / seconds for camera in cameras]


class TestNextDue:
    def test_all_keep_their_rates_while_there_is_time(self):
        rates = serve([Paced(25.0, 2.0), Paced(10.0), Paced(15.0), Paced(5.0)], 10.0, 0.01)
        assert rates == pytest.approx([25.0, 10.0, 15.0, 5.0], rel=0.03)

    def test_the_first_keeps_its_rate_and_the_others_share_what_is_left(self):
        rates = serve([Paced(25.0, 2.0), *(Paced(10.0) for _ in range(5))], 10.0, 0.02)
        assert rates[0] > 23.5
        assert sum(rates) == pytest.approx(50.0, rel=0.03)
        assert max(rates[1:]) - min(rates[1:]) < 0.3

    def test_what_is_left_is_shared_in_the_proportion_of_their_rates(self):
        rates = serve([Paced(30.0), Paced(15.0), Paced(15.0)], 20.0, 0.05)
        assert rates == pytest.approx([10.0, 5.0, 5.0], rel=0.15)

    def test_weight_is_a_larger_share(self):
        work = 0.03
        rates = serve([Paced(30.0, 2.0), Paced(10.0), Paced(10.0)], 12.0, work)
        assert sum(rates) == pytest.approx(1.0 / work, rel=0.02)
        # Six times as many; a picture less where two would fall into one slot of the first.
        assert 4.5 < rates[0] / rates[1] < 6.5
        assert rates[1] == pytest.approx(rates[2], rel=0.05)

    def test_previews_give_way_first_and_evenly(self):
        # A core is asked for 0.58 s of the large view in each second, and for 0.75 s of the small.
        small = [Paced(10.0, work=0.015) for _ in range(5)]
        rates = serve([Paced(25.0, LARGE_WEIGHT, 0.023), *small], 20.0)
        assert rates[0] > 20.0
        assert min(rates[1:]) > 5.5
        assert rates[0] / 25.0 > 1.15 * max(rates[1:]) / 10.0
        assert max(rates[1:]) - min(rates[1:]) < 0.3

    def test_nobody_grows_old(self):
        cameras = [Paced(25.0, LARGE_WEIGHT), *(Paced(10.0) for _ in range(5))]
        work, oldest, now = 0.08, 0.0, 1.0
        for camera in cameras:
            camera.pacer.sent(now, 0)
        while now < 20.0:
            camera = next_due(cameras, now, int(now * 1e9))
            if camera is None:
                now += 0.001
                continue
            oldest = max(oldest, camera.pacer.waited(now))
            camera.pacer.sent(now, int(now * 1e9))
            camera.taken += 1
            now += work
        assert oldest < OLDEST + 5 * work
        assert cameras[0].taken > 2 * cameras[1].taken

    def test_who_comes_late_is_served_at_once(self):
        busy, late = Paced(60.0, 2.0), Paced(10.0)
        busy.pacer.sent(7.0, 7)
        assert next_due([busy, late], 7.05, 8) is late

    def test_nobody_is_due(self):
        camera = Paced(10.0)
        camera.pacer.sent(5.01, 7)
        assert next_due([camera], 5.02, 8) is None
        assert next_due([], 5.02, 8) is None

    def test_a_rate_that_is_changed_counts_at_once(self):
        camera = Paced(1.0)
        camera.pacer.sent(5.01, 7)
        assert next_due([camera], 5.2, 8) is None
        camera.pacer.rate = 10.0
        assert next_due([camera], 5.2, 8) is camera


class TestSceneInbox:
    def test_a_scene_is_taken_once_poses_stay(self):
        inbox = SceneInbox()
        assert inbox.take_scene() is None
        assert inbox.newest_poses() is None
        scene, poses = SceneDescription(revision=1), ScenePoses(revision=1)
        inbox.put_scene(scene)
        inbox.put_poses(poses)
        assert inbox.take_scene() is scene
        assert inbox.take_scene() is None
        assert inbox.newest_poses() is inbox.newest_poses()
        assert inbox.newest_poses().poses is poses

    def test_only_the_newest_counts(self):
        inbox = SceneInbox()
        for revision in (1, 2, 3):
            inbox.put_scene(SceneDescription(revision=revision))
            inbox.put_poses(ScenePoses(revision=revision))
        assert inbox.take_scene().revision == 3
        assert inbox.newest_poses().poses.revision == 3

    def test_poses_know_those_before_them_in_the_same_scene(self):
        inbox = SceneInbox()
        first, second, other = (ScenePoses(revision=number) for number in (1, 1, 2))
        inbox.put_poses(first)
        assert inbox.newest_poses().earlier is None
        inbox.put_poses(second)
        assert inbox.newest_poses().earlier is first
        inbox.put_poses(other)
        assert inbox.newest_poses().earlier is None

    def test_poses_that_overtake_their_scene_are_kept(self):
        inbox = SceneInbox()
        inbox.put_scene(SceneDescription(revision=1))
        inbox.put_poses(ScenePoses(revision=2))
        inbox.put_scene(SceneDescription(revision=2))
        assert inbox.newest_poses().poses.revision == 2

    def test_poses_of_a_simulation_that_ended_are_dropped(self):
        inbox = SceneInbox()
        inbox.put_scene(SceneDescription(revision=1))
        inbox.put_poses(ScenePoses(revision=1))
        inbox.put_scene(SceneDescription(revision=1))
        assert inbox.newest_poses() is None

    def test_wait_ends_when_something_comes_and_not_for_what_came_before(self):
        inbox = SceneInbox()
        inbox.put_poses(ScenePoses())
        inbox.wait(60.0)
        news = ScenePoses()
        threading.Timer(0.05, inbox.put_poses, [news]).start()
        inbox.wait(60.0)
        assert inbox.newest_poses().poses is news
