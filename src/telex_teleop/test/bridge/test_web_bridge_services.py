"""Services that clients of the bridge offer, and those that describe the ROS graph."""

from __future__ import annotations

import asyncio
import threading

import pytest
from bridge_bench import Bench, Client
from std_srvs.srv import SetBoolRequest, SetBoolResponse
from telex_msgs.msg import BridgeClients, OverviewView
from web_fakes import on_loop

from telex_teleop.web.bridge.protocol.operations import OperationError
from telex_teleop.web.bridge.services.advertise_service import MAX_PENDING
from telex_teleop.web.bridge.services.rosapi import type_details

SWITCH = {"service": "/mine/switch", "type": "std_srvs/SetBool"}


class Call:
    """A call from the ROS side, in a thread as rospy makes it."""

    def __init__(self, bench, data=True):
        self.outcome = None
        self._answer = bench.ros.services_offered["/mine/switch"]
        self._thread = threading.Thread(target=self._run, args=(SetBoolRequest(data),), daemon=True)
        self._thread.start()

    def _run(self, request):
        try:
            self.outcome = self._answer(request)
        except OperationError as error:
            self.outcome = str(error)

    async def result(self):
        await asyncio.get_running_loop().run_in_executor(None, self._thread.join, 5.0)
        return self.outcome


async def offered(bench):
    client = Client(bench)
    client.say("advertise_service", **SWITCH)
    await bench.settle()
    return client


@on_loop
async def test_a_client_answers_calls_from_ros():
    bench = Bench()
    client = await offered(bench)
    calls = [Call(bench, True), Call(bench, False)]
    asked = [await client.hear() for _ in calls]
    assert {request["id"] for request in asked} == {
        "call_service:/mine/switch:1",
        "call_service:/mine/switch:2",
    }
    for request in reversed(asked):  # in any order
        assert (request["op"], request["service"]) == ("call_service", "/mine/switch")
        values = {"success": request["args"]["data"], "message": "done"}
        client.say("service_response", service="/mine/switch", id=request["id"], values=values)
    assert [await call.result() for call in calls] == [
        SetBoolResponse(True, "done"),
        SetBoolResponse(False, "done"),
    ]
    client.say("unadvertise_service", service="/mine/switch")
    await bench.settle()
    assert bench.ros.services_offered == {}
    assert len(client.outbox) == 0


@pytest.mark.parametrize(
    ("fields", "outcome"),
    [
        ({"values": {"success": True}, "result": False}, SetBoolResponse(True, "")),
        ({"values": {}, "result": True}, SetBoolResponse()),
        ({"result": True}, SetBoolResponse()),
        ({"values": "it is broken", "result": False}, "it is broken"),
        ({"values": "it is broken", "result": True}, "it is broken"),
        ({"result": False}, "the client that offers /mine/switch could not do it"),
    ],
)
def test_what_counts_as_an_answer(fields, outcome):
    async def check():
        bench = Bench()
        client = await offered(bench)
        call = Call(bench)
        request = await client.hear()
        client.say("service_response", service="/mine/switch", id=request["id"], **fields)
        assert await call.result() == outcome

    asyncio.run(check())


@on_loop
async def test_an_answer_that_does_not_fit_fails_the_call_and_is_told():
    bench = Bench()
    client = await offered(bench)
    call = Call(bench)
    request = await client.hear()
    wrong = {"service": "/mine/switch", "id": request["id"], "values": {"success": 5}}
    client.say("service_response", **wrong)
    assert (await client.hear())["msg"].startswith("service_response: success: expected true or")
    assert (await call.result()).startswith("/mine/switch gave a wrong answer: success")
    client.say("service_response", **wrong)
    assert "no call of /mine/switch with this id waits" in (await client.hear())["msg"]


@on_loop
async def test_calls_fail_when_their_client_goes_or_says_nothing():
    bench = Bench(service_timeout=0.1)
    client = await offered(bench)
    late = Call(bench)
    asked = await client.hear()
    assert "did not answer within 0.1 s" in await late.result()
    await bench.settle()
    client.say("service_response", service="/mine/switch", id=asked["id"], values={})
    assert "no call of /mine/switch with this id waits" in (await client.hear())["msg"]
    bench = Bench()
    client = await offered(bench)
    call = Call(bench)
    await client.hear()
    client.session.close()
    assert await call.result() == "the client that offered /mine/switch is gone"
    await bench.settle()
    assert bench.ros.services_offered == {}


@on_loop
async def test_calls_that_were_not_answered_take_no_place():
    bench = Bench(service_timeout=0.1)
    await offered(bench)
    calls = [Call(bench) for _ in range(MAX_PENDING)]
    for call in calls:
        assert "did not answer" in await call.result()
    await bench.settle()
    assert "did not answer" in await Call(bench).result()


@on_loop
async def test_services_of_other_nodes_cannot_be_taken_over():
    bench = Bench(max_services=1)
    client = await offered(bench)
    client.say("advertise_service", service="switch", type="std_srvs/SetBool", id="s")
    assert "a client may offer 1 services at most" in (await client.hear())["msg"]
    client.say("advertise_service", **SWITCH)  # again, as after a reconnection
    await bench.settle()
    assert list(bench.ros.services_offered) == ["/mine/switch"]
    other = Client(bench)
    other.say("advertise_service", service="switch", type="std_srvs/SetBool", id="s")
    assert await other.hear() == {
        "op": "status",
        "level": "error",
        "msg": "advertise_service: /telex/switch is offered by /telex/lamp already",
        "id": "s",
    }


@on_loop
async def test_offering_calling_and_withdrawing_happen_in_their_order():
    bench = Bench()
    bench.ros.serving_takes = 0.05
    client = Client(bench)
    call = {"service": SWITCH["service"], "args": {"data": True}}
    for number in range(10):
        # No pause between them, as roslibjs's own tests have none.
        client.say("advertise_service", **SWITCH)
        client.say("call_service", **call, id=f"call {number}")
        client.say("unadvertise_service", service=SWITCH["service"])
        client.say("call_service", **call, id="too late")
        asked = await client.hear()
        assert asked["op"] == "call_service"
        answer = {"values": {"success": True, "message": str(number)}, "result": True}
        client.say("service_response", service=SWITCH["service"], id=asked["id"], **answer)
        answered = await client.hear()
        assert (answered["id"], answered["result"]) == (f"call {number}", True)
        assert answered["values"]["message"] == str(number)
        late = await client.hear()
        assert (late["id"], late["values"]) == ("too late", "there is no service /mine/switch")
    assert bench.ros.services_offered == {}


@on_loop
async def test_a_client_that_goes_takes_along_what_was_still_to_be_withdrawn():
    bench = Bench()
    client = await offered(bench)
    client.say("call_service", service=SWITCH["service"], args={"data": True}, id="c")
    client.say("unadvertise_service", service=SWITCH["service"])
    assert (await client.hear())["op"] == "call_service"
    client.session.close()
    await bench.settle()
    assert bench.ros.services_offered == {}


# rosapi


@on_loop
async def test_the_graph_is_described():
    client = Client(Bench())
    ask = client.ask
    names = await ask("rosapi/topics_for_type", ["sensor_msgs/JointState"])
    assert names == (True, {"topics": ["/telex/joint_states"]})
    assert await ask("rosapi/services_for_type", ["std_srvs/SetBool"]) == (
        True,
        {"services": ["/telex/switch"]},
    )
    details = (await ask("rosapi/service_request_details", ["std_srvs/SetBool"]))[1]["typedefs"]
    assert (details[0]["fieldnames"], details[0]["fieldtypes"]) == (["data"], ["bool"])
    details = (await ask("rosapi/service_response_details", ["std_srvs/SetBool"]))[1]["typedefs"]
    assert details[0]["fieldnames"] == ["success", "message"]
    assert (await ask("rosapi/message_details", ["no/Such"]))[0] is False
    raw = (await ask("rosapi/topics_and_raw_types"))[1]
    assert raw["typedefs_full_text"][0].strip() == "string data"
    assert (await ask("rosapi/node_details", ["/n"]))[1]["services"] == ["/n"]
    assert await ask("rosapi/publishers", ["/known"]) == (True, {"publishers": []})
    assert await ask("rosapi/has_param", ["limit"]) == (True, {"exists": True})
    assert await ask("rosapi/has_param", ["absent"]) == (True, {"exists": False})


@on_loop
async def test_who_offers_a_service_and_where():
    bench = Bench()
    client = Client(bench)
    own = {"service": "/rosapi/topics"}
    assert await client.ask("rosapi/service_node", ["/telex/switch"]) == (
        True,
        {"node": "/telex/lamp"},
    )
    assert (await client.ask("rosapi/service_node", own))[1] == {"node": "/telex/rosbridge"}
    assert (await client.ask("rosapi/service_node", ["/absent"]))[1] == {"node": ""}
    assert (await client.ask("rosapi/service_host", ["switch"]))[1] == {"host": "lamp.example"}
    assert (await client.ask("rosapi/service_host", own))[1] == {"host": "bridge.example"}
    assert (await client.ask("rosapi/service_host", ["/absent"]))[1] == {"host": ""}
    kinds = {"std_srvs/SetBool": ["/telex/lamp"], "rosapi/Topics": ["/telex/rosbridge"]}
    for kind, nodes in {**kinds, "std_srvs/Empty": []}.items():
        answer = await client.ask("rosapi/service_providers", {"service": kind})
        assert answer == (True, {"providers": nodes})
    bench.ros.params["/rosdistro"] = "noetic\n"
    answer = await client.ask("rosapi/get_ros_version")
    assert answer == (True, {"version": 1, "distro": "noetic"})
    kind = (await client.ask("rosapi/service_type", ["/rosapi/get_ros_version"]))[1]
    assert kind == {"type": "rosapi/GetROSVersion"}


@on_loop
async def test_an_action_server_is_known_by_its_five_topics():
    bench = Bench()
    parts = ("goal", "cancel", "feedback", "status", "result")
    bench.ros.active |= {f"/telex/flippers/{part}" for part in parts}
    bench.ros.active |= {f"/telex/half/{part}" for part in parts[:4]}
    answer = await Client(bench).ask("rosapi/action_servers")
    assert answer == (True, {"action_servers": ["/telex/flippers"]})


def test_types_are_described_with_all_that_is_inside():
    details = {entry["type"]: entry for entry in type_details(BridgeClients)}
    assert list(details) == [
        "telex_msgs/BridgeClients",
        "std_msgs/Header",
        "telex_msgs/BridgeClient",
    ]
    whole = details["telex_msgs/BridgeClients"]
    assert whole["fieldtypes"] == ["std_msgs/Header", "string", "telex_msgs/BridgeClient"]
    assert whole["fieldarraylen"] == [-1, -1, 0]
    assert whole["examples"] == ["{}", "", "[]"]
    assert details["std_msgs/Header"]["examples"] == ["0", "{}", ""]
    constants = type_details(OverviewView)[0]
    assert len(constants["constnames"]) == len(constants["constvalues"])
