"""A recording played through a watch while the page goes on."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import ExoidError, error_json, internal
from exoid.ground.plain import AsJson

if TYPE_CHECKING:
    from exoid.apps.watch.replaying import Replay
    from exoid.measurement.recording import Recording
    from exoid.symbolic.effect import Effect
    from exoid.symbolic.model import Model


class BackgroundWatch(AsJson):
    """A recording that is being played; `touch` is called whenever there is more to show."""

    def __init__(
        self, model: Model, recording: Recording, index: int, extra: Sequence[Effect], touch: Callable[[], object]
    ) -> None:
        self.index, self.recording = index, recording
        self.played: Replay | None = None
        self.error: dict[str, Any] | None = None
        self.blocks, self.running, self.cancelled = 0, True, False
        self._model, self._extra, self._touch = model, extra, touch
        threading.Thread(target=self._run, name="watch", daemon=True).start()

    def cancel(self) -> None:
        """End it at the next block."""
        self.cancelled = True

    @property
    def fraction(self) -> float:
        """Share of the recording that is played."""
        until = self.recording.t[0] if self.played is None else self.played.until
        return min(1.0, float(until - self.recording.t[0]) / max(self.recording.duration, 1e-9))

    def whole(self) -> dict[str, Any]:
        """Return the reported events and the numbers so far."""
        begins = {"from": float(self.recording.t[0]), "to": float(self.recording.t[-1])}
        return self.to_json() | begins | ({} if self.played is None else self.played.to_json())

    def _run(self) -> None:
        from exoid.apps.watch.replaying import replay

        try:
            self.played = replay(self._model, self.recording, extra=self._extra, progress=self._heard)
        except _CancelledError:
            pass
        except ExoidError as error:
            self.error = error_json(error)
        except Exception as error:  # noqa: BLE001 - the page must go on
            traceback.print_exc()
            self.error = error_json(internal(error))
        self.running = False
        self._touch()

    def _heard(self, played: Replay) -> None:
        if self.cancelled:
            raise _CancelledError
        self.played = played
        self.blocks += 1
        self._touch()

    def _json(self) -> dict[str, Any]:
        return {
            "recording": self.index, "running": self.running, "blocks": self.blocks, "fraction": self.fraction,
            "error": self.error,
        }  # fmt: skip


class _CancelledError(Exception):
    """Another recording is played, or the page is closed."""
