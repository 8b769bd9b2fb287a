"""Settings written once: what a record of them refuses, and what verbs and options make of it."""

from __future__ import annotations

import argparse
import inspect

import pytest

import exoid
from exoid.diagnosis.separation.settings import SeparationOptions, SeparationSettings
from exoid.diagnosis.settings import DiagnosisOptions, DiagnosisSettings, DiscoveryOptions, DiscoverySettings
from exoid.ground.errors import ExoidError
from exoid.ground.settings import SettingError, settings_in
from exoid.optimisation.contest.settings import ContestOptions, ContestSettings
from exoid.optimisation.excitation.criteria import CRITERIA
from exoid.optimisation.excitation.settings import CRITERION_NAMES, DesignError, DesignOptions, DesignSettings
from exoid.optimisation.fitting.settings import FitOptions, FitSettings
from exoid.workbench.command_line.options import add_settings, settings_given

PAIRS = {
    "design": (DesignSettings, DesignOptions),
    "separate": (SeparationSettings, SeparationOptions),
    "rivals": (ContestSettings, ContestOptions),
    "identify": (FitSettings, FitOptions),
    "discover": (DiscoverySettings, DiscoveryOptions),
    "diagnose": (DiagnosisSettings, DiagnosisOptions),
}


@pytest.mark.parametrize("verb", PAIRS)
def test_the_keywords_of_a_verb_are_its_settings(verb):
    record, keywords = PAIRS[verb]
    assert set(keywords.__annotations__) == {entry.name for entry, _ in settings_in(record)}
    assert record.__name__ in str(inspect.signature(getattr(exoid, verb)).parameters["settings"])


def test_keywords_have_the_types_of_the_record():
    for record, keywords in PAIRS.values():
        types = {name: one for kind in record.__mro__ for name, one in vars(kind).get("__annotations__", {}).items()}
        for name, written in keywords.__annotations__.items():
            assert getattr(written, "__forward_arg__", written) == types[name], f"{keywords.__name__}.{name}"


def test_a_wrong_name_is_answered_with_the_right_one():
    with pytest.raises(SettingError, match="did you mean 'harmonics'"):
        exoid.design(harmonic=3)
    with pytest.raises(TypeError, match="no setting 'xyz'"):
        exoid.discover(exoid.Model.standard(), [], xyz=1)
    with pytest.raises(SettingError, match="no setting 'most'"):
        exoid.diagnose(exoid.Model.standard(), [], most=3)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"criterion": "best"}, "one of: condition, d_optimal, worst"),
        ({"harmonics": 21}, "give 1 to 20 harmonics"),
        ({"period": float("nan")}, "give a period of 0.01 to 100000 s"),
        ({"use": 0.0}, "0 of the limits"),
    ],
)
def test_a_value_that_cannot_be_is_refused_wherever_it_is_given(words, message):
    for make in (DesignSettings, exoid.design):
        with pytest.raises(DesignError, match=message):
            make(**words)


def test_machines_of_many_joints_may_have_more_effects():
    assert [DiscoverySettings().limited(joints).most_terms for joints in (1, 3, 6)] == [6, 6, 12]
    seconds = [DiscoverySettings().limited(joints).whole_seconds for joints in (1, 2, 3, 6, 7)]
    assert seconds[:2] == [900.0, 900.0] and seconds[2] == pytest.approx(400.0) and seconds[3:] == [120.0, 120.0]


def test_changes_are_made_to_the_record_that_is_given():
    given = DiscoverySettings(seed=3, most=2)
    assert DiscoverySettings.chosen(given, {"most": 1}).limited(6).most_terms == 1
    assert DiscoverySettings.chosen(given, {}) is not DiscoverySettings() and given.most == 2
    assert DiscoverySettings.chosen(given, {"most": 1}).seed == 3


def test_an_option_is_what_its_setting_is(capsys):
    parser = argparse.ArgumentParser()
    add_settings(parser, DesignSettings, "period", "rest", "criterion", use={"metavar": "SHARE"})
    assert settings_given(parser.parse_args([]), DesignSettings, "use") == {
        "period": 10.0, "rest": False, "criterion": "condition"
    }  # fmt: skip
    with pytest.raises(SystemExit):
        parser.parse_args(["--period", "0"])
    assert "give a period of 0.01 to 100000 s" in capsys.readouterr().err
    assert "length of one period (10 s)" in parser.format_help()


def test_the_names_of_criteria_are_those_that_are_computed():
    assert tuple(CRITERIA) == CRITERION_NAMES


def test_a_setting_that_is_not_there_is_bad_input_for_commands_too():
    assert issubclass(SettingError, ExoidError)
