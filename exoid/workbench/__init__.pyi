"""The names that `exoid.workbench` hands out, each loaded from its module at first use."""

from .command import main as main
