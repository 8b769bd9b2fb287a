"""Sentences name effects and numbers in words; an id that nothing is known of stays as it is."""

from exoid.symbolic import Coefficient, Effect
from exoid.symbolic.effect_catalogue import every_effect, find_effect
from exoid.symbolic.wording import called, number_called, number_said, title_of


def test_titles_have_their_place():
    assert called("end_stop:hip") == "End stop at the hip"
    assert title_of(find_effect("stribeck"), "joint_3") == "Stribeck friction at joint_3"
    assert called("gravity_tilt") == title_of(find_effect("gravity_tilt")) == "Tilted frame"
    assert called("a filter on the torque") == "a filter on the torque"
    own = Effect("magnet_brake", torque="c * dtheta", coefficients={"c": Coefficient("N·m·s/rad")})
    assert called("magnet_brake:knee", lambda id: own) == "magnet brake at the knee"


def test_numbers_say_what_they_are():
    stop = find_effect("end_stop")
    assert number_said(stop, "c", 35.2, "N·m/rad", 1.04) == "stiffness of the stop 35.2 ± 1 N·m/rad"
    assert number_said(stop, "theta_s", 1.08, "rad") == "angle at which contact begins 1.08 rad"
    assert number_said(stop, "side", 1.0, "1") == "at large angles"
    assert number_said(stop, "side", -1.0, "1") == "at small angles"
    assert number_called(stop, "unknown") == "unknown"


def test_every_number_of_the_catalogue_can_be_said():
    for effect in every_effect().values():
        for key, number in (*effect.coefficients.items(), *effect.shape.items()):
            said = number_said(effect, key, (getattr(number, "choices", ()) and number.choices[0]) or 1.5, number.unit)
            assert said and not said.endswith(":") and "=" not in said
