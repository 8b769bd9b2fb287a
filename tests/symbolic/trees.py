"""Random torque trees for property tests."""

from hypothesis import strategies as st

from exoid.symbolic.language.tree import FUNCTIONS, Binary, Call, Name, Number, Unary

NAMES = ("theta1", "dtheta2", "c", "v_s")

numbers = st.one_of(
    st.integers(1, 9).map(float), st.floats(0.01, 100.0, allow_nan=False).map(lambda x: float(f"{x:.4g}"))
)
exponents = st.sampled_from([-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0])
leaves = st.one_of(numbers.map(Number), st.sampled_from([*NAMES, "pi"]).map(Name))


def _grow(children):
    call = st.sampled_from(sorted(FUNCTIONS)).flatmap(
        lambda word: st.tuples(*[children] * FUNCTIONS[word]).map(lambda parts: Call(word, parts))
    )
    return st.one_of(
        children.map(lambda part: Unary("-", part)),
        st.builds(Binary, st.sampled_from("+-*/"), children, children),
        st.builds(lambda base, n: Binary("**", base, Number(n)), children, exponents),
        call,
    )


trees = st.recursive(leaves, _grow, max_leaves=12)
