"""Metrics of a watch, to be scraped by Prometheus: `--prometheus PORT`, on the loopback address alone.

    exoid_watch_events_total{event}            events so far
    exoid_watch_change{name}                   1 while something named differs from what is usual
    exoid_watch_parameter{name,unit,side}      the model's parameters: value, low and high
    exoid_watch_stream_seconds, _blocks, _known, _last_sample_timestamp_seconds, _lost_samples{why}
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from exoid.ground.extras import needing
from exoid.workbench.command_line.parser import UsageError

if TYPE_CHECKING:
    from exoid.apps.watch.watcher import Watcher

LOOPBACK = "127.0.0.1"


class Scraped:
    """Serves what it takes; UsageError where the port is not free. `port` is the one taken, where 0 was asked for."""

    def __init__(self, port: int, device: str) -> None:
        with needing("fleet", "numbers for Prometheus", "prometheus-client"):
            from prometheus_client import CollectorRegistry, Counter, Gauge, start_http_server
        registry, own = CollectorRegistry(), {"device": device}

        def gauge(name: str, about: str, *labels: str) -> Any:
            made = Gauge(f"exoid_watch_{name}", about, ("device", *labels), registry=registry)
            return made if labels else made.labels(**own)

        self.device, self.blocks = device, -1
        self.events = Counter("exoid_watch_events", "events so far", ("device", "event"), registry=registry)
        self.changes = gauge("change", "1 while this differs from what is usual", "name")
        self.numbers = gauge("parameter", "parameters of the model, with 95 % intervals", "name", "unit", "side")
        self.lost = gauge("lost_samples", "samples passed over", "why")
        self.seconds = gauge("stream_seconds", "where in the stream one is")
        self.judged = gauge("blocks", "blocks judged")
        self.known = gauge("known", "1 where what is usual is known and changes are looked for")
        self.came = gauge("last_sample_timestamp_seconds", "when the last sample came, by the clock of this machine")
        try:
            self.server, self.thread = start_http_server(port, LOOPBACK, registry)
        except OSError as error:
            raise UsageError(f"port {port} cannot be taken: {error.strerror}", remedy="give another one") from error
        self.host, self.port = LOOPBACK, int(self.server.server_port)

    def take(self, event: Mapping[str, Any]) -> None:
        """Count an event."""
        self.events.labels(self.device, event["event"]).inc()

    def look(self, watcher: Watcher, came: int) -> None:
        """Take over what the watcher knows; `came` samples since it was asked last."""
        self.seconds.set(watcher.last)
        if came:
            self.came.set(time.time())
        if watcher.blocks == self.blocks:
            return
        self.blocks = watcher.blocks
        self.judged.set(watcher.blocks)
        self.known.set(watcher.reference is not None)
        self.changes.clear()
        for name in watcher.changed:
            self.changes.labels(self.device, name).set(1)
        for why, count in watcher.stream.lost.items():
            self.lost.labels(self.device, why).set(count)
        for item in () if watcher.numbers is None else watcher.numbers.estimates():
            for side in ("value", "low", "high"):
                value = getattr(item, side)  # infinite while too little has been seen
                self.numbers.labels(self.device, item.name, item.unit, side).set(value)

    def close(self) -> None:
        """Give the port back."""
        self.server.shutdown()
        self.server.server_close()
        self.thread.join(5.0)
