"""A single missing effect can be significant, however many entries the catalogue has."""


from exoid.diagnosis.rules import RULES
from exoid.symbolic.effect_catalogue import catalogue


def test_the_placebos_are_enough_for_the_whole_catalogue():
    candidates = sum(1 if effect.on_both else len(effect.joints) for effect in catalogue().values())
    spare = 10  # entries of the user's own
    assert 1.0 / (RULES.placebos + 1) <= RULES.level / (candidates + spare)
