"""Events to an MQTT broker: `--mqtt mqtt://user@host:1883/prefix`, one JSON object each, at least once.

    prefix/device/EVENT      every event ("exoid" is the usual prefix)
    prefix/device/status     "online" or "offline", retained; the broker says "offline" where the watch is gone
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Mapping
from typing import Any
from urllib.parse import urlsplit

from exoid.ground.errors import ExoidError
from exoid.ground.extras import needing
from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.terminal.screen import warn

PORTS = {"mqtt": 1883, "mqtts": 8883}
"""Schemes and their usual ports; the second is encrypted."""
PASSWORD = "EXOID_MQTT_PASSWORD"
"""The environment variable that holds the password of the user."""
KEPT = 10_000
"""Events that are kept at most while the broker cannot be reached."""
LAST = 10.0
"""s that are waited in the end for the broker to have the last events."""


class Broker:
    """Publishes every event it takes; ExoidError where the broker cannot be reached at the beginning."""

    def __init__(self, address: str, device: str) -> None:
        with needing("fleet", "events by MQTT", "paho-mqtt"):
            from paho.mqtt.client import Client
            from paho.mqtt.enums import CallbackAPIVersion
        parts = urlsplit(address)
        if parts.scheme not in PORTS or not parts.hostname or set(address) & set("+#?"):
            raise UsageError(f"{address!r} is no MQTT broker", remedy="give mqtt://host, mqtt://user@host:1883/prefix")
        if parts.password is not None:
            raise UsageError("a password on the command line is seen by everybody", remedy=f"put it into ${PASSWORD}")
        self.base = f"{parts.path.strip('/') or 'exoid'}/{device}"
        self.client = Client(CallbackAPIVersion.VERSION2)
        self.client.max_queued_messages_set(KEPT)
        if parts.username:
            self.client.username_pw_set(parts.username, os.environ.get(PASSWORD))
        if parts.scheme == "mqtts":
            self.client.tls_set()
        self.client.will_set(f"{self.base}/status", "offline", qos=1, retain=True)
        self.client.on_connect = self._connected
        self.answered, self.reason = threading.Event(), ""
        self.lost = 0
        self.last: Any = None
        try:
            self.client.connect(parts.hostname, parts.port or PORTS[parts.scheme])
        except (OSError, ValueError) as error:
            remedy = "check host and port"
            raise ExoidError(f"the MQTT broker cannot be reached: {error}", where=address, remedy=remedy) from error
        self.client.loop_start()
        if not self.answered.wait(LAST) or self.reason:
            self.client.loop_stop()
            what = f"the MQTT broker does not let us in: {self.reason or 'no answer'}"
            raise ExoidError(what, where=address, remedy=f"check the user, and the password in ${PASSWORD}")

    def take(self, event: Mapping[str, Any]) -> None:
        """Publish an event."""
        text = json.dumps(event, ensure_ascii=True, allow_nan=False)
        sent = self.client.publish(f"{self.base}/{event['event']}", text, qos=1)
        if sent.rc == 15:  # its queue is full
            self.lost += 1
        else:
            self.last = sent

    def close(self) -> None:
        """Wait until the broker has the last event, say goodbye."""
        if self.client.is_connected():
            self.last = self.client.publish(f"{self.base}/status", "offline", qos=1, retain=True)
            self.last.wait_for_publish(LAST)
        if self.last is None or not self.last.is_published():
            warn("the MQTT broker has not confirmed the last events")
        if self.lost:
            warn(f"{self.lost} events were not published: the broker was away for too long")
        self.client.disconnect()
        self.client.loop_stop()

    def _connected(self, client: Any, user: Any, flags: Any, reason: Any, properties: Any) -> None:
        """Say that the watch is there, now and whenever the connection comes back."""
        if reason.is_failure:
            if self.answered.is_set() and not self.reason:
                warn(f"the MQTT broker refuses the connection: {reason}")
            self.reason = str(reason)
        else:
            self.reason = ""
            client.publish(f"{self.base}/status", "online", qos=1, retain=True)
        self.answered.set()
