"""The exam's list at the bridge: what it leaves open, when it holds, and what tries its gaps."""

from __future__ import annotations

import aiohttp
import pytest
from bridge_bench import TWIST, Bench, Client
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from waiting import wait_until_async
from web_fakes import HUNG, FakeRos, on_loop, served

from telex_control.common.params import ConfigError
from telex_teleop.web.bridge.bridge_app import Rosbridge
from telex_teleop.web.bridge.clients.access import Access
from telex_teleop.web.exam.exam_list import Exam
from telex_teleop.web.rights import ExamRights, Rights, UseLists
from telex_teleop.web.server_config import RosbridgeConfig
from telex_teleop.web.tokens import Tokens

LIST = ExamRights.read().hiding(["overview"])
TRIAL = "2026-11-25_210000_ann_slalom"
NEEDED = {
    "publish": [
        *("e_stop", "arm_teleop/delta_joint_cmds", "arm_teleop/delta_twist_cmds"),
        *("arm_teleop/named_pose_cmds", "gripper_teleop/delta_joint_cmds"),
        *("flipper_teleop/delta_joint_cmds", "flipper_teleop/preset_cmds"),
        *("track_teleop/cmd_vel", "track_teleop/speed_scale", "cameras/turret/zoom"),
        *("lamps/gripper/command", "console/telemetry"),
    ],
    "subscribe": [
        *("joint_states", "track_controller/odom", "imu", "dosimeter", "gas", "arm_teleop/status"),
        *("arm_teleop/cartesian_status", "flipper_teleop/presets", "track_teleop/status"),
        *("cameras/front/image_raw/compressed", "cameras/turret/zoom", "lamps/gripper/command"),
        *(
            "training/state",
            "training/text",
            "bridge/clients",
            "bridge/missing_nodes",
            "sim/status",
        ),
        *("sim/stability", "battery", "link/state"),
        "battery/range",
    ],
    "call": [
        *("training/answer", "training/again", "training/abort", "training/read"),
        "arm_teleop/set_mode",
    ],
}
"""What the console of a trainee needs."""
CLOSED = {
    "publish": [
        *("/clock", "/tf", "/rosout", "joint_states", "sim/anything", "training/exam"),
        *("training/state", "bridge/exam", "bridge/clients", "/other/track_teleop/cmd_vel"),
        *("/other/training/exam", "cameras/overview/view", "cameras/overview/zoom"),
        *("/tf2_web_republisher/goal", "replay/state", "x"),
    ],
    "subscribe": [
        *("/tf", "/tf_static", "/rosout", "/rosout_agg", "/clock", "sim/base_pose", "sim/poses"),
        *("sim/scene", "sim/truth", "sim/truth_names", "sim/proximity", "sim/malfunctions"),
        *("sim/range_finder", "sim/gripper_contact", "range_finder"),
        *("cameras/overview/image_raw/compressed", "cameras/overview/view", "cameras/radiation"),
        *("replay/state", "replay/joint_states", "replay/cameras/front/image_raw/compressed"),
        *("replay/sim/poses", "training/events", "training/sheet", "training/exam"),
        *("/tf_repub_1", "/tf2_web_republisher/feedback", "sim/radio", "bridge/actions"),
        *("/crane/joint_states", "/crane/cameras/front/image_raw/compressed", "x"),
    ],
    "call": [
        *("sim/reset", "sim/pause", "sim/unpause", "sim/step", "sim/spawn", "sim/delete"),
        *("sim/load_scene", "sim/list_scenes", "sim/restore", "sim/bookmark", "sim/add_robot"),
        *("sim/move", "sim/find_place", "sim/list_objects", "sim/set_light", "training/tell"),
        *("sim/malfunction", "link/configure", "cameras/configure", "/republish_tfs"),
        *("replay/open", "replay/seek", "training/open", "training/list", "training/note"),
        *("training/start", "training/call_off", "controller_manager/load_controller"),
        "arm_teleop/set_logger_level",
        *("/rosapi/topics", "/rosapi/get_param", "/rosapi/get_param_names", "/crane/sim/reset"),
        *("simulator/set_logger_level", "simulator/get_loggers"),
    ],
    "serve": ["/anything", "training/answer", "x", "bridge/who_am_i"],
    "set": ["speed", "/x", "video_server/hidden_cameras", "rosbridge/exam", "rosbridge/rights"],
    "get": ["robot_description", "simulator/world", "/x", "rosbridge/instructor_token_file"],
}
"""What tells the truth, shows others' trials, or changes the simulation."""


def access_in(exam, **kind):
    kind = {"instructor": False, **kind}
    return Access(Rights.read(), FakeRos().resolve, "e_stop", exam=exam, **kind)


def full(name):
    return name if name.startswith("/") else f"/telex/{name}"


@pytest.fixture
def exam():
    found = Exam(LIST, "/telex/")
    found.set(TRIAL)
    return found


@pytest.mark.parametrize("use", NEEDED)
def test_what_a_trainee_works_with_stays_open(exam, use):
    access = access_in(exam)
    for name in NEEDED[use]:
        assert access.allows(use, full(name)), name


@pytest.mark.parametrize("use", CLOSED)
@pytest.mark.parametrize("plain", [False, True])
def test_everything_else_is_closed_at_a_plain_bridge_too(exam, use, plain):
    access = access_in(exam, plain=plain)
    for name in CLOSED[use]:
        assert not access.allows(use, full(name)), name
    exam.set("")
    assert access.allows("subscribe", "/tf")


FINDER, PADS = "/telex/range_finder", "/telex/sim/gripper_contact"
EQUIPMENT = {"range_finder": {"topic": FINDER}, "laser_dots": {"max": 8.0}}


@pytest.mark.parametrize("plain", [False, True])
def test_only_the_topics_of_equipment_are_left_of_aids(exam, plain):
    access = access_in(exam, plain=plain)
    exam.equip(EQUIPMENT)
    assert access.allows("subscribe", FINDER)
    assert not access.allows("publish", FINDER)
    for topic in (PADS, "/telex/sim/range_finder", "/telex/sim/proximity"):
        assert not access.allows("subscribe", topic), topic
    exam.equip({"pads": {"topic": PADS}})
    assert access.allows("subscribe", PADS)
    assert not access.allows("subscribe", FINDER)
    exam.set("")
    assert access.allows("subscribe", "/telex/sim/proximity")
    exam.set(TRIAL)
    for nothing in (None, "x", [PADS], {"pads": PADS}, {"pads": {"topic": [PADS]}}):
        exam.equip(nothing)
        assert not access.allows("subscribe", PADS)


def test_nobody_publishes_what_tells_of_exams_whatever_a_file_says():
    everything = UseLists(publish=("/*",), serve=("/*",))
    access = Access(Rights(instructor=everything), FakeRos().resolve, "e_stop", instructor=True)
    assert access.allows("publish", "/telex/training/state")
    for name in ("training/exam", "bridge/exam"):
        assert not access.allows("publish", full(name))
        assert not access.allows("serve", full(name))


def test_a_wrong_file_says_what_is_wrong(tmp_path):
    path = tmp_path / "exam.yaml"
    path.write_text("operator: {publish: []}")
    with pytest.raises(ConfigError, match=r"exam.yaml: operator is unknown; known are .*pages"):
        ExamRights.read(str(path))
    path.write_text("pages: ['/replay/..']")
    with pytest.raises(ConfigError, match=r"pages holds '/replay/\.\.'"):
        ExamRights.read(str(path))
    with pytest.raises(ConfigError, match="cannot be read"):
        ExamRights.read(str(tmp_path / "none.yaml"))


def test_a_list_that_is_empty_leaves_the_e_stop():
    exam = Exam(ExamRights(), "/telex/")
    exam.set(TRIAL)
    access = access_in(exam)
    assert access.allows("publish", "/telex/e_stop")
    assert not access.allows("subscribe", "/telex/joint_states")


# Clients


def exam_bench(**options):
    return Bench(**{"plain": False, "exam_rights": LIST, **options})


async def told(client):
    """What a client has been told so far."""
    heard = []
    while len(client.outbox):
        heard.append(await client.hear())
    return heard


@on_loop
async def test_connections_that_are_open_lose_at_once_what_is_not_on_the_list():
    bench = exam_bench()
    trainee, teacher = Client(bench), Client(bench, instructor=True)
    for client in (trainee, teacher):
        client.say("subscribe", topic="joint_states")
        client.say("subscribe", topic="/known", id="secret")
        client.say("advertise", topic="track_teleop/cmd_vel", type=TWIST)
        client.say("advertise", topic=f"/mine{client.id}", type="std_msgs/String")
        client.say("advertise_service", service=f"/serve{client.id}", type="std_srvs/SetBool")
    await bench.settle()
    assert await told(trainee) == await told(teacher) == []
    bench.shared.exam.set(TRIAL)
    said = [each["msg"] for each in await told(trainee) if each["level"] == "error"]
    assert [each.split(" is closed")[0] for each in said] == [
        "unadvertised: /mine1",
        "unsubscribed: /known",
        "unadvertised: /serve1",
    ]
    assert await told(teacher) == []
    await bench.settle()
    assert set(bench.ros.services_offered) == {"/serve2"}
    for topic in ("/known", "/telex/joint_states"):
        bench.ros.receivers[topic](bench_message(topic), None)
    await bench.settle()
    assert [each["topic"] for each in await told(trainee)] == ["joint_states"]
    assert [each["topic"] for each in await told(teacher)] == ["/known", "joint_states"]
    trainee.say("publish", topic="track_teleop/cmd_vel", msg={"linear": {"x": 1.0}})
    trainee.say("publish", topic="/mine1", msg={"data": "cheat"})
    await bench.settle()
    assert [topic for topic, _ in bench.ros.published] == ["/telex/track_teleop/cmd_vel"]
    # What was closed is open again afterwards, to whoever asks for it anew.
    bench.shared.exam.set("")
    await told(trainee)
    trainee.say("subscribe", topic="/known")
    await bench.settle()
    assert await told(trainee) == []


def bench_message(topic):
    return JointState() if topic.endswith("joint_states") else String("secret")


@on_loop
async def test_a_hostile_client_gets_nothing_by_any_operation():
    bench = exam_bench()
    early = Client(bench)
    bench.shared.exam.set(TRIAL)
    for client in (early, Client(bench), Client(bench)):
        for topic in CLOSED["subscribe"]:
            for spelled in (topic, full(topic)):
                client.say("subscribe", topic=spelled, type="std_msgs/String", compression="png")
        for topic in CLOSED["publish"]:
            client.say("advertise", topic=topic, type="std_msgs/String", latch=True)
            client.say("publish", topic=topic, type="std_msgs/String", msg={"data": ""})
        for service in CLOSED["serve"]:
            client.say("advertise_service", service=service, type="std_srvs/SetBool")
        client.say("unsubscribe", topic="/tf")
        client.say("service_response", service="/x", id="call_service:/x:1", values={})
        for service in [*CLOSED["call"], *(f"rosapi/{name}" for name in ASKED)]:
            done, said = await last(client, service)
            assert not done, service
            assert "closed while an exam runs" in said, (service, said)
        assert (await last(client, "/rosapi/get_time"))[0]
        assert (await last(client, "bridge/who_am_i"))[1]["message"] == client.id
        done, answer = await last(client, "bridge/end_exam")
        assert not answer["success"]
        assert "only an instructor" in answer["message"]
    await bench.settle()
    asked = [event for event in bench.ros.events if event[0] in ("subscribe", "advertise")]
    assert asked == []
    assert bench.ros.published == []
    assert bench.ros.services_offered == {}
    assert bench.shared.exam.trial == TRIAL


ASKED = ("topics", "get_param", "get_param_names", "has_param", "set_param", "nodes", "services")


async def last(client, service):
    """Answer of a service, past what was said of other operations."""
    client.say("call_service", service=service, args={"name": "/x", "value": "1"}, id="q")
    while True:
        heard = await client.hear()
        if heard["op"] == "service_response":
            return heard["result"], heard["values"]


@on_loop
async def test_an_instructor_ends_the_list_and_who_only_says_so_does_not():
    bench = exam_bench()
    teacher, trainee = Client(bench, instructor=True), Client(bench)
    assert await teacher.ask("bridge/end_exam") == (
        True,
        {"success": False, "message": "no exam's list holds"},
    )
    bench.shared.exam.set(TRIAL)
    assert (await last(trainee, "/rosapi/topics"))[0] is False
    assert (await teacher.ask("/rosapi/topics"))[0]
    assert (await teacher.ask("bridge/end_exam"))[1]["success"]
    assert (await last(trainee, "/rosapi/topics"))[0]
    # Where no token is asked for, everybody can say that he is an instructor.
    bench = exam_bench(proven=False)
    claims = Client(bench, instructor=True)
    bench.shared.exam.set(TRIAL)
    assert not (await last(claims, "/rosapi/topics"))[0]
    assert not (await last(claims, "bridge/end_exam"))[1]["success"]
    assert bench.shared.exam.trial == TRIAL


# The bridge, the training node, and their crashes


def bridge(ros, warnings):
    tokens = Tokens(instructor="teacher")
    return Rosbridge(RosbridgeConfig(), ros, warnings.append, tokens)


@on_loop
async def test_the_list_holds_from_the_training_nodes_word_until_its_next():
    ros, warnings = FakeRos(), []
    parameter = "/telex/rosbridge/exam"

    def say(trial):
        ros.receivers["/telex/training/exam"](String(trial), "/telex/training")

    async with served(
        bridge(ros, warnings).make_app(), "ws"
    ) as url, aiohttp.ClientSession() as http:
        await wait_until_async(lambda: "/telex/training/exam" in ros.receivers and ros.exams)
        assert ros.exams == [""]
        say(TRIAL)
        await wait_until_async(lambda: ros.exams == ["", TRIAL])
        assert ros.params[parameter] == TRIAL
        # The training node has died: nothing is heard of it, and the list stays.
        assert not await asks(http, url, "/rosapi/topics")
        assert await asks(http, f"{url}?role=instructor&token=teacher", "/rosapi/topics")
    # The bridge has, too: its successor knows before its first client.
    left, ros = ros.params, FakeRos()
    ros.params = left
    second = bridge(ros, warnings)
    assert second.shared.exam.trial == TRIAL
    async with served(second.make_app(), "ws") as url, aiohttp.ClientSession() as http:
        assert not await asks(http, url, "/rosapi/topics")
        await wait_until_async(lambda: "/telex/training/exam" in ros.receivers and ros.exams)
        assert ros.exams == [TRIAL]
        say("")  # a training node that has come back
        await wait_until_async(lambda: ros.exams[-1] == "")
        assert parameter not in ros.params
        assert await asks(http, url, "/rosapi/topics")
        say(TRIAL)
        await wait_until_async(lambda: ros.exams[-1] == TRIAL)
        assert await asks(http, f"{url}?role=instructor&token=teacher", "bridge/end_exam")
        await wait_until_async(lambda: ros.exams[-1] == "")
    assert warnings == []


@on_loop
async def test_what_the_robot_has_stays_subscribed_when_the_list_begins():
    ros, warnings = FakeRos(), []
    app = bridge(ros, warnings)

    def heard():
        return [event[1] for event in ros.events if event[0] == "subscribe"]

    async with served(app.make_app(), "ws") as url, aiohttp.ClientSession() as http:
        await wait_until_async(lambda: "/telex/training/exam" in ros.receivers)
        async with http.ws_connect(url) as socket:
            for topic in (FINDER, PADS):
                ask = {"op": "subscribe", "topic": topic, "type": "std_msgs/String", "id": topic}
                await socket.send_json(ask)
            await wait_until_async(lambda: {FINDER, PADS} <= set(heard()))
            ros.params["/telex/equipment"] = EQUIPMENT  # the simulator has come meanwhile
            ros.receivers["/telex/training/exam"](String(TRIAL), "/telex/training")
            said = await socket.receive_json(timeout=HUNG)
            assert said["msg"].startswith(f"unsubscribed: {PADS} is closed")
            ros.receivers[FINDER](String("1.5"), None)
            assert (await socket.receive_json(timeout=HUNG))["topic"] == FINDER
        ros.receivers["/telex/training/exam"](String(""), "/telex/training")
        await wait_until_async(lambda: ros.exams[-1:] == [""] and not app.shared.exam.trial)
    assert warnings == []


async def asks(http, url, service):
    """Whether a new connection gets an answer of a service."""
    async with http.ws_connect(url) as socket:
        await socket.send_json({"op": "call_service", "service": service})
        return (await socket.receive_json(timeout=HUNG))["result"]
