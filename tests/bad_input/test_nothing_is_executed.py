"""Text from a model file stays text, wherever it is written to; a name that hides another is refused."""

import ast
import re
import shutil
import subprocess
import xml.etree.ElementTree as xml

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.ground.errors import ModelFileError
from exoid.ground.output import json_text, write_text
from exoid.ground.text import in_comment, printable
from exoid.measurement.bench.leg import standard_leg
from exoid.symbolic.codegen.code import generate
from exoid.symbolic.model import Model, read_model
from exoid.symbolic.model_file import Numbers, write_model
from exoid.workbench.command import main
from exoid.workbench.export import c, casadi, numpy, urdf
from exoid.workbench.identified import ExportError, Options, ready
from exoid.workbench.reserved import is_taken
from exoid.workbench.terminal.screen import Screen, warn
from tests.exported_module import python_module

EVIL = "int exoid_evil;"
NAMES = (
    f"a */ {EVIL} /*", f"a *\\\n/ {EVIL} /*", f"a *\\\r\n/ {EVIL} /*", f"a *??/\n/ {EVIL} /*", f"a *\\ \n/ {EVIL}",
    f'a """\n{EVIL}\n"""', f"a\n{EVIL}", f"a\u2028{EVIL}", f"a\x0b*\x0b/{EVIL}",
    "a \\", "a \\u0022\\u0022\\u0022 \\N{x}",
    "--> <robot>", "\x1b]0;x\x07", "*" * 9 + "/", "*\u200b/" + EVIL, "{name} %s {0}", "a \u202e */", "???/\n??/\n*/",
)  # fmt: skip


def numbers_of(model):
    base = dict(zip([p.name for p in model.parameters], standard_leg().base, strict=False))
    linear = {p.name: base.get(p.name, 0.7 * (p.typical or 1.0)) for p in model.parameters}
    return Numbers(linear, {s.name: s.shape.typical or 0.5 * (s.shape.min + s.shape.max) for s in model.shapes}, None)


def code_of(text):
    """C without its comments, as a compiler sees it: trigraphs first, then joined lines, then comments."""
    text = text.replace("??/", "\\")
    text = re.sub(r"\\[ \t]*\r?\n", "", text)
    return re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)


@pytest.mark.parametrize("name", NAMES)
def test_a_model_name_is_never_code(name):
    model = Model(name=name)
    made = ready(model, numbers_of(model))
    sources = [generate(model).header, *c.write(made, Options()).values()]
    assert [code_of(text) for text in sources] == [
        code_of(text)
        for text in (generate(Model()).header, *c.write(ready(Model(), numbers_of(Model())), Options()).values())
    ]
    for text in numpy.write(made, Options()).values():
        tree = ast.parse(text)
        assert [type(node).__name__ for node in tree.body] == ["Expr", "Import", "FunctionDef"]
    for text in urdf.write(made, Options()).values():
        assert xml.fromstring(text.encode()).tag == "robot"


@pytest.mark.skipif(not shutil.which("gcc"), reason="no gcc")
def test_a_compiler_agrees(tmp_path):
    """With trigraphs, and every warning about comments an error."""
    for k, name in enumerate(NAMES):
        path = tmp_path / f"{k}.h"
        path.write_text(generate(Model(name=name)).header, encoding="utf-8")
        words = ["gcc", "-std=c99", "-trigraphs", "-Wall", "-Wcomment", "-Werror", "-E", "-P", str(path)]
        seen = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        assert "evil" not in seen, name


def test_words_of_an_effect_are_never_code(tmp_path):
    path = tmp_path / "leg.toml"
    text = f"""
name = "x"
[[effects]]
id = "brake"
joint = "knee"
[[custom_effects]]
id = "brake"
joint = "knee"
torque = "c * tanh(dtheta / w)"
explains = "*/ {EVIL} /* <script>alert(1)</script>"
title = "*/ {EVIL}"
coefficients = {{ c = {{ unit = "N·m" }} }}
shape = {{ w = {{ unit = "rad/s", min = 0.1, max = 1 }} }}
"""
    path.write_text(text)
    model = read_model(path)
    for written in (generate(model).header, *c.write(ready(model, numbers_of(model)), Options()).values()):
        assert "evil" not in code_of(written)
    for unit in (f"*/ {EVIL} /*", f"*\\\\\\n/ {EVIL}", "N·m */"):
        path.write_text(text.replace('"N·m"', f'"{unit}"'))
        with pytest.raises(ModelFileError, match="unit"):
            read_model(path)


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet=st.one_of(st.sampled_from('*/\\?"\n\r-<>{}%\u2028\x0b'), st.characters()), max_size=30))
def test_no_text_ends_a_comment(text):
    inert = in_comment(text)
    assert "*/" not in inert and "/*" not in inert and "--" not in inert and '"' not in inert
    assert "\\" not in inert and "??" not in inert and len((inert + " ").splitlines()) == 1
    assert printable(inert) == inert


@pytest.mark.parametrize("name", [
    "numpy", "Numpy", "math", "string", "casadi", "json", "int", "double", "class", "None", "lambda", "match",
    "main", "stdio", "sympy", "con", "lpt1", "_x", "__init__", "restrict", "tgmath", "exoid",
])  # fmt: skip
def test_a_name_that_hides_another_is_refused(name):
    with pytest.raises(ExportError, match=r"already means|cannot prefix"):
        Options(name=name)


def test_a_name_of_ones_own_is_fine():
    assert not any(is_taken(name) for name in ("exoid_leg", "my_leg", "Leg2", "numpy_leg", "context"))
    for wrong in ("", "a b", "a/b", "ä", "a" * 41, "1a", "a\n", "../a"):
        with pytest.raises(ExportError):
            Options(name=wrong)


@pytest.mark.skipif(not shutil.which("gcc"), reason="no gcc")
@pytest.mark.parametrize("effect", ["backlash", "hysteresis", "time_delay"])
def test_one_sample_that_is_no_number_does_not_stay(effect, tmp_path):
    import ctypes

    model = Model.standard().with_effect(effect, "knee")
    made = ready(model, numbers_of(model))
    assert made.memories
    for name, text in c.write(made, Options(sample_time=0.01)).items():
        (tmp_path / name).write_text(text)
    library = tmp_path / "leg.so"
    words = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC", "-O2"]
    subprocess.run([*words, "exoid_leg.c", "-o", str(library), "-lm"], cwd=tmp_path, check=True)
    torque = ctypes.CDLL(str(library)).exoid_leg_torque
    t = np.arange(0.0, 2.0, 0.01)
    motion = [np.sin(3 * t + k) for k in range(6)]

    def run(bad):
        state, out = (ctypes.c_char * 4096)(), []
        for k in range(len(t)):
            rows = [(ctypes.c_double * 2)(motion[i][k], motion[i + 1][k]) for i in (0, 2, 4)]
            if k in bad:
                for row in rows:
                    row[0] = row[1] = bad[k]
            tau = (ctypes.c_double * 2)()
            torque(state, ctypes.c_double(t[k]), *rows, tau)
            out.append(tuple(tau))
        return np.array(out)

    clean = run({})
    for bad in ({0: np.nan}, {50: np.nan}, {50: np.inf, 51: -np.inf, 52: np.nan}, {0: np.inf, 1: np.nan}):
        seen = run(bad)
        assert not np.isfinite(seen[list(bad)]).any()
        rest = np.delete(np.arange(len(t)), list(bad))
        assert np.isfinite(seen[rest]).all()
        np.testing.assert_allclose(seen[150:], clean[150:], atol=1e-6)
    scope = python_module(numpy.write(made, Options())["exoid_leg.py"], tmp_path, "leg_module")
    q, dq, ddq = (np.column_stack(motion[i : i + 2]) for i in (0, 2, 4))
    for first in (0, 50):
        broken = q.copy()
        broken[first] = np.nan
        seen = scope.torque(t, broken, dq, ddq)
        assert np.isfinite(seen[first + 20 :]).all() and np.isnan(seen[first]).any()


def test_numbers_that_overflow_are_not_exported(tmp_path, capsys):
    from exoid.symbolic.model_file import model_content

    model = Model()
    for big in (1e308, -1e308, 1e200):
        linear = {**numbers_of(model).linear, "Phi1": big}
        if big == 1e200:  # large, but every torque is a number
            c.write(ready(model, Numbers(linear, {}, None)), Options())
            continue
        with pytest.raises(ExportError, match="not finite"):
            ready(model, Numbers({**linear, "Phi4": big, "Phi3": big}, {}, None), "leg.toml")
        for form in (c, numpy, casadi):
            try:
                texts = form.write(ready(model, Numbers(linear, {}, None)), Options())
            except ExportError:
                continue
            assert not any(re.search(r"\b(inf|nan)\b", text) for text in texts.values())
    write_model(model, tmp_path / "leg.toml")
    assert model_content(model)["name"] == model.name
    numbers = "\n".join(f'"{name}" = 1e308' for name in linear)
    with (tmp_path / "leg.toml").open("a") as stream:
        stream.write(f"\n[identified.parameters]\n{numbers}\n")
    assert main(["export", str(tmp_path / "leg.toml"), "--out", str(tmp_path / "out"), "--quiet"]) == 2
    assert "not finite" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_file_name_does_not_command_the_terminal(tmp_path, capsys):
    name = "\x1b[2J\x1b]0;owned\x07\x9b31m\u202e.csv"
    for words in (["compare", name], ["generate", name], ["reveal", name], ["compare", "x", "--json", f"{name}/y"],
                  ["effects", name], [name], ["effects", f"--{name}"]):  # fmt: skip
        assert main(words) == 2
    warn(name)
    screen = Screen()
    screen.say(name)
    screen.table(name, [name, "b"], [[name, 1]], note=name)
    out = capsys.readouterr()
    for text in (out.out, out.err):
        assert text and not set(text) & {"\x1b", "\x07", "\x9b", "\u202e"}, text
    assert "\\x1b[2J" in out.err


def test_a_file_name_in_another_encoding_is_no_traceback(tmp_path, capsys):
    name = b"caf\xe9\x9b.csv".decode("utf-8", "surrogateescape")
    text = json_text({"file": name, "control": "\x7f\x9b\u2028"})
    assert text.isprintable() or set(text) - {"\n"} == {c for c in text if c.isprintable()}
    import json

    assert json.loads(text) == {"file": name, "control": "\x7f\x9b\u2028"}
    assert write_text(tmp_path / "a.html", name).read_text() == "caf\\udce9\\udc9b.csv"
    assert main(["compare", str(tmp_path / name)]) == 2
    assert "Traceback" not in capsys.readouterr().err
