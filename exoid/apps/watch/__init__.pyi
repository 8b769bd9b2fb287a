"""The names that `exoid.apps.watch` hands out, each loaded from its module at first use."""

from .following import follow as follow
from .following import watch as watch
from .replaying import replay as replay
