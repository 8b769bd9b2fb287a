"""Generated C: the committed files are what the derivation gives, byte for byte, in any process."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from exoid.ground.files import sha256
from exoid.symbolic import Model
from exoid.symbolic.codegen.code import generate, stale_files
from exoid.symbolic.codegen.fingerprint import library_versions

ROOT = Path(__file__).parents[2]
GENERATED = ROOT / "generated"


def test_committed_files_are_reproduced():
    recorded = json.loads((GENERATED / "manifest.json").read_text())
    if recorded["versions"] != library_versions():
        pytest.skip(f"the committed C was generated with {recorded['versions']}, here are {library_versions()}")
    assert stale_files(Model.standard(), GENERATED) == ()


@pytest.mark.slow
def test_another_process_with_another_hash_seed_writes_the_same_bytes():
    script = (
        "from exoid.symbolic import Model; from exoid.symbolic.codegen.code import generate; "
        "print(generate(Model.standard()).code)"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "4711"}
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.stdout.rstrip("\n") == generate(Model.standard()).code.rstrip("\n")


def write(folder):
    for name, text in generate(Model.standard()).files.items():
        (folder / name).write_text(text, encoding="utf-8")


def test_what_was_edited_is_stale(tmp_path):
    assert len(stale_files(Model.standard(), tmp_path)) == 3
    write(tmp_path)
    assert stale_files(Model.standard(), tmp_path) == ()
    (tmp_path / "leg.c").write_text("edited")
    assert stale_files(Model.standard(), tmp_path) == ("leg.c",)


def test_manifest_and_text():
    made = generate(Model.standard())
    manifest = json.loads(made.manifest)
    assert manifest["sha256"]["leg.c"] == sha256(made.code)
    assert manifest["operations"]["columns"] < 40
    assert len(manifest["regressor"]) == 10
    assert manifest["model"]["inertial"]["Phi3"] == "a_th*l_sh*m_sh"
    assert str(ROOT) not in made.code + made.header + made.manifest


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_header_serves_a_c_program(tmp_path):
    write(tmp_path)
    (tmp_path / "main.c").write_text(
        '#include <stdio.h>\n#include "leg.h"\n'
        "int main(void) { double s[9] = {0, 0.5, -0.5, 0, 0, 0, 0, 0, 0}, p[8] = {1, 0, 0, 0, 0, 0, 0, 0}, tau[2];\n"
        '  leg_inverse_dynamics_many(1, s, p, 0, 0, 0, tau); printf("%.6f %.6f", tau[0], tau[1]); return 0; }\n'
    )
    build = ["cc", "-std=c99", "-Wall", "-Werror", "main.c", "leg.c", "-lm", "-o", "main"]
    subprocess.run(build, cwd=tmp_path, check=True)
    done = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=True)
    assert done.stdout == "11.757911 0.000000"
