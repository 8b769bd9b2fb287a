"""Tables of Denavit and Hartenberg: the machine moves as the textbook's matrices say."""

import numpy as np
import pytest

from exoid.optimisation.linear.bodies import Body3D
from exoid.symbolic import Motion, read_model, write_model
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.dh_table import TableError, dh_machine

ROWS = [  # theta°, d, a, alpha°: an arm of four joints, none of whose axes cross
    (20.0, 0.30, 0.10, -90.0),
    (-90.0, 0.02, 0.40, 0.0),
    (90.0, -0.05, 0.05, 90.0),
    (0.0, 0.25, 0.03, -60.0),
]
MASS = 3.0


def table(tmp_path, text=None):
    path = tmp_path / "arm.csv"
    rows = [f"j{k},{theta},{d * 1000},{a},{alpha}" for k, (theta, d, a, alpha) in enumerate(ROWS)]
    path.write_text(text or "\n".join(["joint,theta [deg],d [mm],a,alpha [deg]", *rows, ""]))
    return path


def standard(theta, d, a, alpha):
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])


def modified(theta, d, a, alpha):
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [[c, -s, 0, a], [s * ca, c * ca, -sa, -d * sa], [s * sa, c * sa, ca, d * ca], [0, 0, 0, 1]]
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["standard", "modified"])
def test_a_mass_at_the_end_pulls_as_the_matrices_say(tmp_path, kind):
    model = dh_machine(table(tmp_path), kind)
    step = {"standard": standard, "modified": modified}[kind]
    angles = np.radians([(row[0], row[3]) for row in ROWS])

    def height(q):
        """Of the frame of the last row's end, in which the standard way counts the last link, or of its joint."""
        whole = np.eye(4)
        for at, (theta, alpha), (_, d, a, _) in zip(q, angles, ROWS, strict=True):
            whole = whole @ step(theta + at, d, a, alpha)
        return whole[2, 3]

    theta, d, a = angles[-1][0], ROWS[-1][1], ROWS[-1][2]
    end = [a * np.cos(theta), a * np.sin(theta), d] if kind == "standard" else [0.0, 0.0, 0.0]
    numbers = np.zeros((4, 10))
    numbers[-1] = Body3D(MASS, np.array(end), np.zeros((3, 3))).numbers
    linear = np.concatenate([np.einsum("pjk,jk->p", model.mixture, numbers), np.zeros(8)])
    rng = np.random.default_rng(1)
    for q in rng.uniform(-2.0, 2.0, (6, 4)):
        still = np.zeros((1, 4))
        found = compiled(model).gravity(Motion(np.zeros(1), q[None], still, still), linear)[0]
        rise = [(height(q + 1e-6 * own) - height(q - 1e-6 * own)) / 2e-6 for own in np.eye(4)]
        np.testing.assert_allclose(found, MASS * 9.81 * np.array(rise), atol=1e-6)


def test_gears_become_couplings_and_the_file_keeps_them(tmp_path):
    path = table(tmp_path, "joint;theta [deg];d;a;alpha [deg];gear\na1;0;0.6;0.3;-90;257\na2;-90;0;1.1;0;\n")
    model = dh_machine(path)
    assert model.joints[0].motor == (("a1", 257.0),)
    assert not model.joints[1].motor
    back = read_model(write_model(model, tmp_path / "arm.toml"))
    assert back.joints == model.joints


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("joint,d,a\nx,1,2\n", "alpha"),
        ("joint,d,a,alpha [m]\nx,1,2,3\n", "alpha"),
        ("joint,d,a,alpha\nx,1,2\n", "row 1"),
        ("joint,d,a,alpha\nx,1,two,3\n", "two"),
        ("joint,d,a,alpha\n", "0 rows"),
    ],
)
def test_what_is_wrong_with_a_table_is_said(tmp_path, text, said):
    with pytest.raises(TableError) as found:
        dh_machine(table(tmp_path, text))
    assert said in str(found.value)
