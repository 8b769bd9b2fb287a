"""Arms in space for tests: URDF texts of random trees with possible links."""

import numpy as np

KINDS = ("revolute", "continuous", "prismatic")


def body(rng):
    """An <inertial> that could exist: its tensor is that of a few points of mass."""
    points, mass = rng.normal(size=(6, 3)) * 0.1, float(rng.uniform(0.5, 4.0))
    own = mass / 6.0 * sum(point @ point * np.eye(3) - np.outer(point, point) for point in points - points.mean(axis=0))
    names = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    tensor = " ".join(f'{name}="{float(own[i, j])!r}"' for name, i, j in names)
    centre, turned = numbers(rng.normal(size=3) * 0.1), numbers(rng.normal(size=3))
    return f'<inertial><origin xyz="{centre}" rpy="{turned}"/><mass value="{mass!r}"/><inertia {tensor}/></inertial>'


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def arm_text(seed, count, kinds=("revolute",), branch=False):
    """A robot of `count` moving joints j0.. of random axes and origins, with a plate fixed to every link."""
    rng = np.random.default_rng(seed)
    parts = ['<link name="base"/>']
    for k in range(count):
        carrier = "base" if k == 0 else "plate1" if branch and k == 3 else f"plate{k - 1}"
        parts.append(f'<link name="link{k}">{body(rng)}</link><link name="plate{k}">{body(rng)}</link>')
        for name, kind, above, below in ((f"j{k}", kinds[k % len(kinds)], carrier, f"link{k}"),
                                         (f"f{k}", "fixed", f"link{k}", f"plate{k}")):  # fmt: skip
            origin = f'<origin xyz="{numbers(rng.normal(size=3) * 0.3)}" rpy="{numbers(rng.normal(size=3))}"/>'
            axis = "" if kind == "fixed" else f'<axis xyz="{numbers(rng.normal(size=3))}"/>'
            limit = "" if kind == "fixed" else '<limit lower="-2" upper="2" velocity="2" effort="9"/>'
            parts.append(f'<joint name="{name}" type="{kind}"><parent link="{above}"/><child link="{below}"/>'
                         f"{origin}{axis}{limit}</joint>")  # fmt: skip
    return f'<robot name="arm">{"".join(parts)}</robot>'
