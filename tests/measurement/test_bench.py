"""The bench as a whole: what it promises about seeds, truth, noise, speed, refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.make_demo import write_demo
from exoid import workbench
from exoid.ground.errors import EffectError, ExoidError
from exoid.measurement.bench.blind import SEAL, draw_hidden, relative_size, write_runs
from exoid.measurement.bench.controller import Controller
from exoid.measurement.bench.hidden import Hidden, parse_hidden, true_model
from exoid.measurement.bench.leg import paper_leg, random_leg, standard_leg
from exoid.measurement.bench.seal import open_seal
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, BenchError, run_bench, simulate, simulate_runs
from exoid.measurement.bench.wearer import Wearer
from exoid.measurement.recording import to_csv
from exoid.measurement.trajectories.trajectory import paper_trajectory
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.model import Model
from exoid.symbolic.model_structure import TABLE_1

SHORT = Bench(duration=4.0)
IDEAL = Bench(duration=6.0, sensors=Sensors.ideal())
STRIBECK = Hidden("stribeck", "knee", {"c": 2.5, "v_s": 0.1})
BRAKE = Effect(
    id="magnet_brake",
    explains="eddy-current brake near mid-flexion",
    torque="c * dtheta2 * exp(-((theta2 + 0.9)/w)**2)",
    joints=("knee",),
    coefficients={"c": Coefficient("N·m·s/rad", min=0.0, typical=3.0)},
    shape={"w": Shape("rad", 0.02, 0.6, typical=0.3)},
    custom=True,
)


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    first, again, other = (to_csv(simulate(effects=[STRIBECK], seed=seed, bench=SHORT)) for seed in (5, 5, 6))
    assert first == again != other


def test_runs_of_one_seed_have_motions_and_noise_of_their_own():
    runs = simulate_runs(3, seed=1, bench=SHORT)
    assert [one.recording.name for one in runs] == ["run_0", "run_1", "run_2"]
    assert not np.allclose(runs[0].motion.q, runs[1].motion.q, atol=0.05)
    alone = run_bench(seed=1, index=2, bench=SHORT, name="run_2")
    assert to_csv(alone.recording) == to_csv(runs[2].recording)


def test_hiding_an_effect_leaves_motion_and_noise_alone():
    plain, hidden = (run_bench(effects=e, seed=3, bench=SHORT) for e in ([], [STRIBECK]))
    noise = [one.recording.tau - one.torque for one in (plain, hidden)]
    assert noise[0] == pytest.approx(noise[1], abs=2e-4)
    assert plain.recording.q == pytest.approx(hidden.recording.q, abs=0.05)


def test_the_recording_looks_like_an_instrumented_leg():
    one = run_bench(seed=2, bench=Bench(duration=30.0))
    recording = one.recording
    assert len(recording) == 3000 and recording.rate == pytest.approx(100.0)
    for j, limit in enumerate(TABLE_1.values()):
        assert limit.angle[0] <= recording.q[:, j].min() and recording.q[:, j].max() <= limit.angle[1]
    error = recording.tau - one.torque
    # Half of the samples have nothing but sensor noise; the spoilt ones are several times larger.
    assert np.median(np.abs(error)) / 0.6745 == pytest.approx(0.5, abs=0.06)
    assert 0.04 < np.mean(np.abs(error) > 2.5) < 0.09
    assert (recording.q - one.motion.q).std() == pytest.approx(6e-5, rel=0.2)
    assert one.saturated == 0.0


@pytest.mark.parametrize("leg", [standard_leg(), paper_leg(), random_leg(np.random.default_rng(4))])
def test_every_leg_follows_and_obeys_its_own_model(leg):
    one = run_bench(leg=leg, seed=1, bench=IDEAL)
    assert one.true.torque(one.motion) == pytest.approx(one.torque, abs=1e-7)
    assert np.array_equal(one.recording.tau, one.torque)
    assert np.array_equal(one.recording.q, one.motion.q)


def test_the_published_motion_can_be_driven():
    path = paper_trajectory()
    one = run_bench(leg=paper_leg(), excitation=path, bench=Bench(duration=10.0, lead_in=2.0))
    assert np.abs(one.motion.q - path.at(one.motion.t).q).max() < 0.1


def test_the_rate_decides_the_step_and_motors_saturate():
    one = run_bench(seed=1, bench=Bench(duration=1.0, rate=300.0))
    assert np.diff(one.motion.t) == pytest.approx(np.full(299, 1.0 / 300.0))
    stiff = Bench(duration=2.0, controller=Controller(bandwidth=(30.0, 30.0)), lead_in=0.0)
    weak = run_bench(leg=paper_leg(), seed=1, bench=stiff)
    assert weak.saturated > 0.0 and np.all(np.abs(weak.torque) <= np.array(paper_leg().torque_limit))


def test_several_effects_and_a_users_own_act_together():
    hidden = [STRIBECK, Hidden("end_stop", "hip", {"theta_s": 0.6}), Hidden(BRAKE, "knee", size=4.0)]
    one = run_bench(effects=hidden, seed=1, bench=IDEAL)
    assert one.true.torque(one.motion) == pytest.approx(one.torque, abs=1e-6)
    assert one.truth.terms == ("stribeck:knee", "end_stop:hip", "magnet_brake:knee")
    assert one.truth.effects[2].values == {"c": 4.0, "w": 0.3}
    plain = run_bench(seed=1, bench=IDEAL)
    assert np.abs(one.torque - plain.torque).max() > 0.5


def test_a_term_the_model_knows_already_is_simulated_too():
    known = Model.standard().with_effect("stribeck", joint="knee")
    one = run_bench(known, seed=1, bench=IDEAL)
    assert one.true.numbers()["stribeck:knee.c"] > 0 and one.truth.terms == ()


def test_cuff_forces_close_the_equation_of_motion():
    wearer = Wearer()
    one = run_bench(seed=1, bench=replace(IDEAL, wearer=wearer))
    f1, f2 = (one.recording.forces[name] for name in ("f1", "f2"))
    assert max(np.abs(f1).max(), np.abs(f2).max()) > 3.0
    knee = wearer.reach[1] * f2
    hip = wearer.reach[0] * f1 + 0.40 * np.cos(one.motion.q[:, 1]) * f2 + knee
    alone = replace(one.motion, force=np.zeros((len(one.motion), 2)))
    assert one.torque + np.column_stack([hip, knee]) == pytest.approx(one.true.torque(alone), abs=1e-7)
    assert to_csv(one.recording).startswith(b"t,q1,q2,tau1,tau2,f1,f2\n")


def test_sizes_are_read_from_text():
    assert parse_hidden("stribeck:knee=2.6") == Hidden("stribeck", "knee", size=2.6)
    assert parse_hidden("gravity_tilt") == Hidden("gravity_tilt")
    ripple = parse_hidden("torque_ripple:knee=a=0.8,n=24")
    assert (ripple.name, dict(ripple.values)) == ("torque_ripple:knee", {"a": 0.8, "n": 24.0})
    for text in (
        "",
        ":knee",
        "stribeck:knee=",
        "stribeck:knee=much",
        "stribeck=nan",
        "a:hip=c=1,c=2",
        "a=c=",
    ):
        with pytest.raises(EffectError, match="not an effect with a size"):
            parse_hidden(text)


def test_a_bare_size_is_the_first_coefficient_and_the_others_keep_proportion():
    base = standard_leg().base
    whole = true_model(Model.standard(), base, [Hidden("joint_spring", "knee")]).numbers()
    double = true_model(
        Model.standard(), base, [Hidden("joint_spring", "knee", size=2.0 * whole["joint_spring:knee.k"])]
    ).numbers()
    for key, value in whole.items():
        assert double[key] == pytest.approx(2.0 * value if key.startswith("joint_spring") else value)


def test_what_makes_no_sense_is_refused():
    with pytest.raises(EffectError, match="stribeck:knee has no number called d"):
        simulate(effects=[Hidden("stribeck", "knee", {"d": 1.0})])
    with pytest.raises(EffectError):
        simulate(effects=[Hidden("no_such_effect", "knee")])
    with pytest.raises(BenchError, match="ran away"):
        simulate(effects=[Hidden("viscous_cubic", "knee", size=-1e6)], bench=SHORT)
    with pytest.raises(BenchError, match="less than two samples"):
        simulate(duration=0.0)
    with pytest.raises(BenchError, match="the step at most"):
        Bench(step=0.01)


def test_blind_recordings_carry_no_trace_and_their_seal_opens(tmp_path):
    made = {}
    for name, hidden in (("a", [STRIBECK]), ("b", [])):
        made[name] = write_runs(tmp_path / name, simulate_runs(2, effects=hidden, seed=9, bench=SHORT))
    names = [[path.name for path in made[name][0]] for name in ("a", "b")]
    assert names[0] == names[1] == ["run_0.csv", "run_1.csv"]
    heads = {path.read_text().split("\n")[0] for name in made for path in made[name][0]}
    assert heads == {"t,q1,q2,tau1,tau2"}
    recordings, seal = made["a"]
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == [*names[0], SEAL]
    assert open_seal(seal, recordings).truth.terms == ("stribeck:knee",)
    assert open_seal(made["b"][1]).truth.terms == ()
    with pytest.raises(ExoidError, match="is not one of the recordings"):
        open_seal(seal, made["b"][0])


def test_draws_respect_bounds_and_leave_some_legs_alone():
    rng = np.random.default_rng(0)
    both = Effect(id="b", explains="", torque={"hip": "c", "knee": "c"}, joints=("both",),
                  coefficients={"c": Coefficient("N·m", typical=2.0)})  # fmt: skip
    drawn = [draw_hidden(rng, [BRAKE, both]) for _ in range(200)]
    assert 0.04 < np.mean([hidden == () for hidden in drawn]) < 0.17
    values = [hidden[0].values for hidden in drawn if hidden and hidden[0].joint == "knee"]
    assert all(0.02 <= v["w"] <= 0.6 and v["c"] > 0 for v in values)
    for hidden in drawn:
        if hidden:
            assert 0.039 < relative_size(hidden[0], standard_leg()) < 0.201
    signs = {np.sign(hidden[0].values["c"]) for hidden in drawn if hidden and hidden[0].joint is None}
    assert signs == {-1.0, 1.0}


@pytest.mark.slow
def test_the_demo_is_small_and_regenerates(tmp_path):
    made = write_demo(tmp_path)
    shipped = Path(workbench.__file__).parent / "demo_data"
    assert sum(path.stat().st_size for path in made) < 1_000_000
    assert open_seal(made[-1], made[:-1]).truth.terms == ("load_friction:knee",)
    for path in made:
        # A last digit of sin or exp may differ between C libraries, and with it a step of the encoder here
        # and there.
        own, theirs = path.read_text(), (shipped / path.name).read_text()
        if own != theirs and path.suffix == ".csv":
            difference = np.abs(_table(own) - _table(theirs))
            assert np.median(difference) < 1e-3 and difference.max() < 3.0


def _table(text):
    return np.array([[float(cell) for cell in line.split(",")] for line in text.split()[1:]])
