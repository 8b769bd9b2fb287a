"""`exoid watch` in a fleet: where events go, what is scraped, what survives a restart, and messages of ROS 2."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import sys
import urllib.request
from argparse import Namespace
from functools import cache
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from exoid.apps.watch.events import Event
from exoid.apps.watch.io.hook import Hook
from exoid.apps.watch.io.joint_states import heard, joint_state_line
from exoid.apps.watch.io.report import Report, device_of
from exoid.apps.watch.live import Lines
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.state import StateError, WatchState
from exoid.apps.watch.watcher import Watcher
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.symbolic.model import Model
from exoid.workbench.command import main
from exoid.workbench.command_line.parser import UsageError
from tests.waiting import HUNG, until

LEARN = 8
"""Blocks that say what is usual: the least that sets thresholds in a test."""
EVENTS = [{"event": "suspected", "t": 1.0, "joint": "knee"}, {"event": "change", "t": 2.0, "sentence": "$(echo no)"}]


@pytest.fixture(scope="module")
def stream() -> np.ndarray:
    """Return samples (N, 5) of the bench, 100 s."""
    one = bench_run().recording
    return np.column_stack([one.t, one.q, one.tau])


@cache
def bench_run():
    return run_bench(seed=5, bench=Bench(duration=100.0))


@pytest.fixture(scope="module")
def learnt(stream) -> Watcher:
    watcher = Watcher(Model.standard(), Settings(learn=LEARN, most_learn=LEARN))
    watcher.push(stream[:6000])
    assert watcher.reference is not None
    return watcher


def report(watcher=None, heartbeat=0.0, device="leg-7"):
    args = Namespace(json=None, out=None, quiet=True, heartbeat=heartbeat)
    made, told = Report(args, watcher or Watcher(Model.standard()), device), []
    made.others.append(SimpleNamespace(take=told.append, close=lambda: None))
    return made, told


def test_every_event_says_when_by_the_wall_clock_and_of_which_device():
    made, told = report()
    made.all([Event("start", 0.0, "here"), Event("change", 3.0, "there")])
    assert [(one["event"], one["t"]) for one in told] == [("start", 0.0), ("change", 3.0)]
    assert {one["device"] for one in told} == {"leg-7"}
    assert all(one["at"].endswith("+00:00") and one["at"].startswith("20") for one in told)
    assert made.alarms == 1


def test_a_heartbeat_comes_whether_or_not_samples_do():
    made, told = report(heartbeat=10.0)
    made.beat(0)
    assert told == []
    made.beaten -= 11.0
    made.came -= 11.0
    made.beat(0)
    assert [(one["event"], one["known"]) for one in told] == [("heartbeat", False)]
    assert "no sample for" in told[0]["sentence"]
    made.beaten -= 11.0
    made.beat(50)
    assert told[-1]["silent"] == 0.0


@pytest.mark.parametrize("name", ["a/b", "", "leg 7", "x" * 65, "+"])
def test_a_device_has_a_name_that_a_topic_can_hold(name):
    with pytest.raises(UsageError, match="is no name"):
        device_of(name)
    assert device_of("leg-7.left") == "leg-7.left" and device_of(None)


def test_a_command_gets_every_event_as_json_and_no_shell_sees_it(tmp_path):
    script, out = tmp_path / "tell.py", tmp_path / "out"
    script.write_text("import sys\nopen(sys.argv[1], 'a').write(sys.stdin.read() + sys.argv[2] + '\\n')\n")
    hook = Hook(f"{sys.executable} '{script}' '{out}' '; touch {tmp_path}/made'")
    for event in EVENTS:
        hook.take(event)
    hook.close()
    told = out.read_text().splitlines()
    assert [json.loads(line) for line in told[::2]] == EVENTS
    assert set(told[1::2]) == {f"; touch {tmp_path}/made"} and not (tmp_path / "made").exists()


def test_a_command_that_fails_is_told_and_one_that_there_is_not_refused(tmp_path, capsys):
    script = tmp_path / "fail.py"
    script.write_text("import sys\nsys.exit('the pager is off')\n")
    hook = Hook(f"{sys.executable} {script}")
    hook.take(EVENTS[0])
    hook.close()
    assert "status 1: the pager is off" in capsys.readouterr().err
    for command in ("no-such-command-at-all", "", "'unclosed"):
        with pytest.raises(UsageError):
            Hook(command)


def test_numbers_and_counts_are_scraped_on_the_loopback_address(learnt):
    pytest.importorskip("prometheus_client")
    from exoid.apps.watch.io.prometheus import Scraped

    scraped = Scraped(0, "leg-7")
    try:
        scraped.take({"event": "change"})
        scraped.look(learnt, 100)
        with urllib.request.urlopen(f"http://127.0.0.1:{scraped.port}/metrics", timeout=HUNG) as answer:
            text = answer.read().decode()
        with pytest.raises(UsageError, match="cannot be taken"):
            Scraped(scraped.port, "leg-7")
        assert scraped.server.server_address[0] == "127.0.0.1"
    finally:
        scraped.close()
    assert 'exoid_watch_events_total{device="leg-7",event="change"} 1.0' in text
    assert 'exoid_watch_known{device="leg-7"} 1.0' in text
    value = next(line for line in text.splitlines() if 'name="coulomb:hip",side="value",unit="N·m"' in line)
    assert float(value.split()[-1]) == pytest.approx(learnt.numbers.estimates()[4].value)


@pytest.fixture
def broker(tmp_path):
    """Return the port of an MQTT broker that this test has started."""
    pytest.importorskip("paho.mqtt.client")
    program = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")
    if program is None:
        pytest.skip("needs mosquitto, an MQTT broker")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    (tmp_path / "broker.conf").write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n")
    process = subprocess.Popen([program, "-c", str(tmp_path / "broker.conf")], stderr=subprocess.DEVNULL)
    try:
        until(lambda: _answers(port))
        yield port
    finally:
        process.kill()
        process.wait()


def test_events_reach_an_mqtt_broker(broker):
    from paho.mqtt.client import Client
    from paho.mqtt.enums import CallbackAPIVersion

    from exoid.apps.watch.io.mqtt import Broker

    got = []
    listener = Client(CallbackAPIVersion.VERSION2)
    listener.on_message = lambda client, user, message: got.append((message.topic, message.payload.decode()))
    listener.on_connect = lambda client, *rest: client.subscribe("lab/#", qos=1)
    ready = []
    listener.on_subscribe = lambda *rest: ready.append(1)
    listener.connect("127.0.0.1", broker)
    listener.loop_start()
    until(lambda: ready)
    made = Broker(f"mqtt://127.0.0.1:{broker}/lab", "leg-7")
    for event in EVENTS:
        made.take(event)
    made.close()
    until(lambda: len(got) >= 4)
    listener.disconnect()
    listener.loop_stop()
    assert [(t, json.loads(p)) for t, p in got if not t.endswith("status")] == [
        (f"lab/leg-7/{one['event']}", one) for one in EVENTS
    ]
    assert [p for t, p in got if t == "lab/leg-7/status"] == ["online", "offline"]


def _answers(port):
    with socket.socket() as one:
        return not one.connect_ex(("127.0.0.1", port))


@pytest.mark.parametrize("address", ["host", "http://host", "mqtt://", "mqtt://user:secret@host", "mqtt://host/a/#"])
def test_what_is_no_broker_is_refused(address):
    pytest.importorskip("paho.mqtt.client")
    from exoid.apps.watch.io.mqtt import Broker

    with pytest.raises(UsageError):
        Broker(address, "leg-7")


@pytest.mark.slow
def test_what_was_learnt_comes_back_as_it_was(learnt, stream):
    content = learnt.state().to_bytes()
    again = Watcher(Model.standard(), learnt.settings, restored=WatchState.from_bytes(content))
    events = again.push(stream[6000:7500])
    told = next(one for one in events if one.event == "reference")
    assert told.more["restored"] and told.t < 66.0  # at once, with no learning
    np.testing.assert_array_equal(again.reference.now.linear, learnt.reference.now.linear)
    assert again.reference.detector.limit == pytest.approx(learnt.reference.detector.limit, rel=0.05)
    before = {one.name: one.value for one in learnt.numbers.estimates()}
    assert {one.name: one.value for one in again.numbers.estimates()} == pytest.approx(before, rel=0.05, abs=0.1)
    kept = WatchState.from_bytes(content)
    older = {name: values for name, values in kept.arrays.items() if name != "estimator.feigned"}
    assert Watcher(Model.standard(), learnt.settings, restored=WatchState(older, kept.about)).push(stream[6000:7500])


@pytest.mark.slow
def test_what_changed_goes_on_to_be_known_and_new_damage_is_none_of_it(learnt, stream):
    """Friction of the knee rises by 2 N·m while nobody watches; what is usual stays what it was."""
    damaged = stream.copy()
    damaged[:, 4] += 2.0 * np.tanh(bench_run().motion.dq[:, 1] / 0.02)
    state = WatchState.from_bytes(learnt.state().to_bytes())
    first = Watcher(Model.standard(), learnt.settings, restored=state)
    events = [one for k in range(0, 4000, 500) for one in first.push(damaged[k : k + 500])]
    named = next(one for one in events if one.event == "change")
    assert named.names == ("coulomb:knee",) and not named.since.slow
    second = Watcher(Model.standard(), learnt.settings, restored=WatchState.from_bytes(first.state().to_bytes()))
    events = [one for k in range(4000, len(damaged), 500) for one in second.push(damaged[k : k + 500])]
    assert not any(one.alarm for one in events) and "coulomb:knee" in second.changed
    repaired = Watcher(Model.standard(), learnt.settings, restored=WatchState.from_bytes(first.state().to_bytes()))
    events = [one for k in range(4000, len(stream), 500) for one in repaired.push(stream[k : k + 500])]
    assert [(one.kind, one.sentence) for one in events if one.alarm] == [
        ("over", "over again: coulomb:knee is as it was before")
    ]
    assert not repaired.changed


def test_a_state_of_something_else_is_refused(learnt, stream):
    content = learnt.state().to_bytes()
    for bad in (b"", b"PK\x03\x04", content[: len(content) // 2], b"\x80\x04N."):
        with pytest.raises(StateError, match="damaged"):
            WatchState.from_bytes(bad)
    other = Model.standard(thigh_length=0.45)
    with pytest.raises(StateError, match="model"):
        Watcher(other, learnt.settings, restored=WatchState.from_bytes(content)).push(stream[:3000])
    slow = stream[::2]
    with pytest.raises(StateError, match="Hz"):
        Watcher(Model.standard(), learnt.settings, restored=WatchState.from_bytes(content)).push(slow[:3000])


@pytest.mark.slow
def test_the_command_keeps_what_it_learns_and_goes_on_with_it(tmp_path, stream, capsys):
    name, state = str(tmp_path / "run.csv"), tmp_path / "leg.state"
    np.savetxt(name, stream[:4500], delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    asked = ["watch", "standard", name, "--learn", "40", "--state", str(state), "--json", "-", "--quiet"]
    assert main(asked) == 0 and state.read_bytes()[:2] == b"PK"
    capsys.readouterr()
    assert main([*asked, "--device", "leg-7"]) == 0
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert next(one for one in told if one["event"] == "reference")["restored"]
    assert {one["device"] for one in told} == {"leg-7"}
    (tmp_path / "other.state").write_text("mine")
    assert main([*asked[:4], "20", "--state", str(tmp_path / "other.state")]) == 2
    assert (tmp_path / "other.state").read_text() == "mine"


def message(k: int, names=("knee", "hip"), effort=True) -> SimpleNamespace:
    """Return a JointState with its joints in another order than the model's."""
    stamp = SimpleNamespace(sec=1_700_000_000 + k // 100, nanosec=10_000_000 * (k % 100))
    values = {"position": [-0.8, 0.5 + 0.001 * k], "velocity": [], "effort": [1.5, 3.0 + k] if effort else []}
    return SimpleNamespace(header=SimpleNamespace(stamp=stamp), name=list(names), **values)


def test_joint_states_are_samples_in_the_order_of_the_model():
    lines = Lines(Model.standard().joints)
    rows = lines.feed("".join(joint_state_line(message(k), "joint_states") for k in range(60)), last=True)
    assert rows.shape == (60, 5)
    np.testing.assert_allclose(np.diff(rows[:, 0]), 0.01, atol=1e-6)
    np.testing.assert_allclose(rows[7, 1:], [0.507, -0.8, 10.0, 1.5])


def test_a_bag_played_on_a_topic_is_heard_as_it_is_read(tmp_path, monkeypatch):
    """rclpy is played by one that takes its messages from a recorded bag."""
    reader = pytest.importorskip("rosbags.highlevel")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    bag, topic = tmp_path / "bag", "/joint_states"
    with Writer(bag, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        link = writer.add_connection(topic, "sensor_msgs/msg/JointState", typestore=store)
        for k in range(60):
            one = message(k)
            stamp = kinds["builtin_interfaces/msg/Time"](one.header.stamp.sec, one.header.stamp.nanosec)
            sent = kinds["sensor_msgs/msg/JointState"](
                kinds["std_msgs/msg/Header"](stamp, ""), one.name,
                *(np.array(getattr(one, field)) for field in ("position", "velocity", "effort")),
            )  # fmt: skip
            at = stamp.sec * 1_000_000_000 + stamp.nanosec
            writer.write(link, at, store.serialize_cdr(sent, "sensor_msgs/msg/JointState"))
    with reader.AnyReader([bag], default_typestore=store) as played:
        waiting = [played.deserialize(raw, one.msgtype) for one, _, raw in played.messages()]
    subscribed = []
    node = SimpleNamespace(create_subscription=lambda kind, name, hear, quality: subscribed.append((name, hear)))

    def spin_once(node, timeout_sec):
        for _ in range(min(25, len(waiting))):
            subscribed[0][1](waiting.pop(0))

    rclpy = ModuleType("rclpy")
    vars(rclpy).update(
        init=lambda: None, ok=lambda: bool(waiting), create_node=lambda name: node, spin_once=spin_once,
        try_shutdown=lambda: None,
    )  # fmt: skip
    modules = {"rclpy": rclpy, "rclpy.qos": ModuleType("rclpy.qos"), "sensor_msgs": ModuleType("sensor_msgs")}
    modules["rclpy.qos"].qos_profile_sensor_data = SimpleNamespace(depth=5)
    modules["sensor_msgs.msg"] = ModuleType("sensor_msgs.msg")
    modules["sensor_msgs.msg"].JointState = object
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    lines = Lines(Model.standard().joints)
    rows = np.concatenate([*(lines.feed(text) for text in heard(topic)), lines.feed("", last=True)])
    assert subscribed[0][0] == topic and rows.shape == (60, 5)
    np.testing.assert_allclose(rows[7, 1:], [0.507, -0.8, 10.0, 1.5])


def test_without_ros_that_is_said(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "rclpy", None)
    assert main(["watch", "standard", "ros2:/joint_states"]) == 2
    assert "ROS 2 is not there" in capsys.readouterr().err
