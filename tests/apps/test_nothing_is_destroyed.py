"""No output is an input, nothing that is no file is replaced, and the files of a command appear together or not."""

import argparse
import errno
import json
import os
import signal
import stat
import threading
from contextlib import suppress
from pathlib import Path

import pytest

from exoid.ground.delivery import PREFIX, Delivery, together
from exoid.ground.files import write_whole
from exoid.ground.inputs import open_input, read_input
from exoid.ground.output import OutputError, check_target
from exoid.workbench.command import find_verbs, main, verb_parser
from exoid.workbench.command_line.files import check_json
from exoid.workbench.command_line.guard import OUTPUTS, protect_inputs
from tests.waiting import HUNG, until

HARMLESS = ("t,q1,q2,tau1,tau2", *(f"{k},{k % 7},{k % 5},{k % 3},{k % 11}" for k in range(20)))


@pytest.fixture
def run(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("\n".join(HARMLESS))
    return path


def names_of(run: Path) -> dict[str, Path]:
    """Every way to name the same file."""
    folder = run.parent
    os.link(run, folder / "hard.json")
    (folder / "link.json").symlink_to(run.name)
    (folder / "twice.json").symlink_to("link.json")
    (folder / "sub").mkdir()
    return {
        "itself": run, "hard link": folder / "hard.json", "link": folder / "link.json",
        "link to a link": folder / "twice.json", "detour": folder / "sub" / ".." / run.name,
    }  # fmt: skip


@pytest.mark.parametrize("verb, option", [
    ("compare", "--json"), ("diagnose", "--json"), ("discover", "--json"), ("discover", "--write"),
    ("identify", "--json"), ("identify", "--write"), ("rivals", "--json"),
])  # fmt: skip
def test_no_output_is_a_recording(verb, option, run, capsys):
    before = run.read_text()
    for name, target in names_of(run).items():
        assert main([verb, str(run), option, str(target)]) == 2, name
        assert "cannot be written" in capsys.readouterr().err, name
        assert run.read_text() == before, name
    assert sorted(path.name for path in run.parent.iterdir()) == sorted(
        ("run.csv", "hard.json", "link.json", "twice.json", "sub")
    )


def test_no_output_is_a_model_a_motion_a_seal_or_a_result(tmp_path, capsys):
    for words in (
        ["generate", "FILE", "--json", "FILE"], ["export", "FILE", "--json", "FILE"],
        ["simulate", "FILE", "--json", "FILE"], ["simulate", "--trajectory", "FILE", "--json", "FILE"],
        ["design", "FILE", "--json", "FILE"], ["design", "--check", "FILE", "--json", "FILE"],
        ["reveal", "FILE", "--json", "FILE"], ["reveal", "x.seal", "--diagnosis", "FILE", "--json", "FILE"],
        ["effects", "--model", "FILE", "--json", "FILE"], ["compare", "x", "--verify", "FILE", "--json", "FILE"],
        ["compare", "x", "--payload", "FILE=2@0.3", "--json", "FILE"],
    ):  # fmt: skip
        path = tmp_path / "given"
        path.write_text('{"name": "x"}')
        assert main([str(path) if word == "FILE" else word.replace("FILE", str(path)) for word in words]) == 2, words
        assert path.read_text() == '{"name": "x"}', words
        assert "Traceback" not in capsys.readouterr().err


def test_an_option_that_writes_is_known_as_one():
    for verb in find_verbs():
        for action in verb_parser(verb)._actions:
            writes = "write" in (action.help or "").split(";")[0].lower() and action.nargs != 0
            names = action.metavar in ("FILE", "DIR")
            if writes and names and "wrote" not in action.help:
                assert action.dest in OUTPUTS, (verb, action.dest)


def test_what_stands_in_the_folder_of_results_is_not_lost_if_it_was_read(tmp_path):
    given = tmp_path / "motion.csv"
    given.write_text("a,b\n")
    with pytest.raises(OSError, match="never written to"), together() as delivery:
        protect_inputs(argparse.Namespace(recordings=[str(given)], out=str(tmp_path)), delivery)
        write_whole(tmp_path / "motion.toml", "x")
        write_whole(given, "new")
    assert given.read_text() == "a,b\n" and not (tmp_path / "motion.toml").exists()


def test_what_was_opened_is_protected_too(tmp_path):
    """A file inside a folder, an archive or a mapping that no word of the command line names."""
    given = tmp_path / "inside.csv"
    given.write_text("a")
    with pytest.raises(OSError, match="never written to"), together():
        read_input(given, 10)
        write_whole(given, "b")
    assert given.read_text() == "a"
    with together():
        read_input(given, 10, remember=False)
        write_whole(given, "b")
    assert given.read_text() == "b"


def test_an_option_in_the_wrong_place_costs_no_file(run, capsys):
    """`compare --json run.csv other.csv` makes the first recording the output."""
    before = run.read_text()
    assert main(["compare", "--json", str(run), "other.csv"]) == 2
    assert "another kind" in capsys.readouterr().err
    assert main(["discover", "other.csv", "--write", str(run)]) == 2
    assert run.read_text() == before
    for there in ("", "{}", '[1]\n{"a"'):
        (run.parent / "old.json").write_text(there)
        check_json(str(run.parent / "old.json"))


def test_what_is_no_file_is_written_into_or_refused_never_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="nobody reads"):
        write_whole(pipe, "x")
    heard = []
    reader = threading.Thread(target=lambda: heard.append(pipe.read_text()))
    reader.start()

    def written():
        with suppress(OSError):  # as long as nobody reads
            return write_whole(pipe, "x" * 200_000)  # more than a pipe holds

    until(written)
    reader.join(HUNG)
    assert heard == ["x" * 200_000] and stat.S_ISFIFO(pipe.stat().st_mode)
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "folder").mkdir()
    for target in ("loop", "folder", "nu\0l"):
        with pytest.raises(OSError, match=r"."):
            write_whole(tmp_path / target, "x")
    assert (tmp_path / "loop").is_symlink() and not list(tmp_path.glob(f"{PREFIX}*"))


@pytest.mark.skipif(not hasattr(os, "mknod") or os.geteuid() != 0, reason="only the superuser makes devices")
def test_a_device_stays_a_device(tmp_path):
    try:
        os.mknod(tmp_path / "null", 0o666 | stat.S_IFCHR, os.makedev(1, 3))
        os.mknod(tmp_path / "disk", 0o666 | stat.S_IFBLK, os.makedev(7, 250))
        write_whole(tmp_path / "null", "x")
    except PermissionError:
        pytest.skip("devices are not allowed here")
    assert stat.S_ISCHR((tmp_path / "null").lstat().st_mode)
    (tmp_path / "link").symlink_to("null")
    assert main(["effects", "--json", str(tmp_path / "link"), "--quiet"]) == 0
    assert (tmp_path / "link").is_symlink() and stat.S_ISCHR((tmp_path / "null").lstat().st_mode)
    with pytest.raises(OutputError, match="a disk"):
        check_target(str(tmp_path / "disk"))


def test_a_link_is_followed_and_access_rights_are_kept(tmp_path):
    (tmp_path / "there").write_text("{}")
    (tmp_path / "there").chmod(0o600)
    (tmp_path / "link").symlink_to("there")
    (tmp_path / "dangling").symlink_to("not yet")
    for name in ("link", "dangling"):
        write_whole(tmp_path / name, "[]")
        assert (tmp_path / name).is_symlink() and (tmp_path / name).read_text() == "[]"
    assert stat.S_IMODE((tmp_path / "there").stat().st_mode) == 0o600
    (tmp_path / "there").chmod(0o400)
    with pytest.raises(OSError, match="write-protected"):  # root could, and must not
        write_whole(tmp_path / "link", "{}")


def test_files_appear_together(tmp_path, monkeypatch):
    (tmp_path / "old").write_text("old")
    with together():
        write_whole(tmp_path / "old", "new")
        write_whole(tmp_path / "deep" / "figures" / "1.png", b"1")
        assert (tmp_path / "old").read_text() == "old" and not (tmp_path / "deep" / "figures" / "1.png").exists()
    assert (tmp_path / "old").read_text() == "new"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["deep", "old"]


@pytest.mark.parametrize("failing", [0, 1, 2])
def test_or_not_at_all(tmp_path, monkeypatch, failing):
    """The disk may be full when a file is written, or refuse when it is put in place."""
    (tmp_path / "b").write_text("old")
    calls, link = iter(range(100)), os.link

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def once(source, target):
        return full() if next(calls) == 1 else link(source, target)

    with pytest.raises(OSError, match="No space") as caught, together():
        write_whole(tmp_path / "b", "1")
        write_whole(tmp_path / "new" / "a", "1")
        if failing == 0:
            monkeypatch.setattr(os, "fsync", full)
        if failing == 1:
            monkeypatch.setattr(os, "link", once)
        write_whole(tmp_path / "c", "1")
        if failing == 2:
            full()
    if failing == 0:
        assert str(tmp_path / "c") in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["b"] and (tmp_path / "b").read_text() == "old"


def test_a_full_disk_leaves_the_old_report(tmp_path, monkeypatch, capsys):
    from exoid.ground import delivery

    out = tmp_path / "out"
    assert main(["effects", "--out", str(out), "--quiet"]) == 0
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    written = delivery._written
    rest = iter(range(100))

    def full(target, write):
        if next(rest) > 5:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(target))
        return written(target, lambda stream: stream.write(b"changed"))

    monkeypatch.setattr(delivery, "_written", full)
    assert main(["effects", "--out", str(out), "--quiet"]) == 2
    assert "No space left" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_two_results_do_not_go_into_one_file(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["effects", "--out", str(out), "--json", str(out / "stribeck.txt"), "--quiet"]) == 2
    assert "cannot be written" in capsys.readouterr().err and not out.exists()


def test_what_another_process_wrote_meanwhile_is_not_replaced(tmp_path):
    for before in (False, True):
        target = tmp_path / f"{before}.json"
        if before:
            target.write_text("first")
        with pytest.raises(OSError, match=r"meanwhile|exists"), together():
            check_target(str(target))
            (tmp_path / "other").write_text("theirs")
            os.replace(tmp_path / "other", target)
            write_whole(target, "ours")
        assert target.read_text() == "theirs"


def test_an_interrupted_command_leaves_nothing(tmp_path):
    for stop in (KeyboardInterrupt, SystemExit):
        with pytest.raises(stop), together():
            write_whole(tmp_path / "new" / "a", "1")
            raise stop
    assert not list(tmp_path.iterdir())


def test_ctrl_c_while_files_change_places_waits(tmp_path, monkeypatch):
    replace = os.replace

    def pressed(source, target):
        os.kill(os.getpid(), signal.SIGINT)
        replace(source, target)

    (tmp_path / "a").write_text("0")
    (tmp_path / "b").write_text("0")
    monkeypatch.setattr(os, "replace", pressed)
    with pytest.raises(KeyboardInterrupt), together():
        write_whole(tmp_path / "a", "1")
        write_whole(tmp_path / "b", "1")
    assert [path.read_text() for path in sorted(tmp_path.iterdir())] == ["1", "1"]


def test_only_ordinary_files_are_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    for name in ("pipe", "loop", ".", "nowhere", "nu\0l", "x" * 5000):
        with pytest.raises(OSError, match=r"."):
            open_input(tmp_path / name)
    for device in ("/dev/zero", "/dev/tty"):
        with pytest.raises(OSError, match=r"."):
            read_input(device, 10)
    (tmp_path / "large").write_bytes(b"x" * 11)
    with pytest.raises(OSError, match="larger"):
        read_input(tmp_path / "large", 10)
    assert read_input(tmp_path / "large", 11) == b"x" * 11


def test_what_was_left_by_a_killed_process_goes_after_a_day(tmp_path):
    for name, age in (("old", 2e5), ("young", 10.0)):
        path = tmp_path / f"{PREFIX}{name}.part"
        path.write_text("x")
        os.utime(path, (0, path.stat().st_mtime - age))
    write_whole(tmp_path / "a", "1")
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"{PREFIX}young.part", "a"]


def test_sigterm_clears_away_and_says_so(tmp_path, monkeypatch, capsys):
    from exoid.workbench.commands import effects

    def killed(args):
        write_whole(tmp_path / "a", "1")
        os.kill(os.getpid(), signal.SIGTERM)
        signal.pause()

    monkeypatch.setattr(effects, "run", killed)
    before = signal.getsignal(signal.SIGTERM)
    assert main(["effects"]) == 143
    assert "terminated" in capsys.readouterr().err and not list(tmp_path.iterdir())
    assert signal.getsignal(signal.SIGTERM) is before


def test_json_is_still_written_where_it_may(tmp_path):
    path = tmp_path / "found.json"
    for _ in range(2):
        assert main(["effects", "--json", str(path), "--quiet"]) == 0
        assert json.loads(path.read_text())["schema"] == "exoid.effects/1"
    assert Delivery().place(path) == path


def others_in(folder: Path, *names: str) -> dict[Path, str]:
    """Files of somebody else's, called as exoid calls its own."""
    folder.mkdir(parents=True, exist_ok=True)
    found = {folder / name: f"my own {name}\n" if not name.endswith(".toml") else "mass = 3.1\n" for name in names}
    for path, text in found.items():
        path.write_text(text)
    return found


@pytest.mark.parametrize("name, words", [
    ("effects.json", ("effects", "stribeck")), ("stribeck.txt", ("effects", "stribeck")),
    ("result.json", ("compare", "run.csv")), ("report.html", ("compare", "run.csv")),
    ("leg.h", ("generate",)), ("equations_latex.tex", ("generate", "--print", "--as", "latex")),
    ("exoid.bash", ("completion", "bash")), ("model.toml", ("add", "stribeck:hip", "run.csv")),
    ("table.csv", ("campaign", "plan.toml")), ("parameters.csv", ("campaign", "plan.toml")),
])  # fmt: skip
def test_what_exoid_did_not_write_is_not_replaced(name, words, run, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plan.toml").write_text('verb = "compare"\nfiles = "run.csv"\n')
    files = others_in(tmp_path / "mine", name)
    assert main([*words, "--out", "mine", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert "not written by exoid" in said and name in said
    assert {path: path.read_text() for path in (tmp_path / "mine").iterdir()} == files


def test_what_exoid_wrote_is_replaced_the_next_time(tmp_path, capsys):
    for words in (
        ["effects", "stribeck"], ["generate", "--print", "--as", "latex"], ["completion", "zsh"], ["generate"],
    ):  # fmt: skip
        for _ in range(2):
            assert main([*words, "--out", str(tmp_path / words[0]), "--quiet"]) == 0, capsys.readouterr().err


def test_a_model_that_nobody_named_is_written_anew_only_if_exoid_wrote_it(tmp_path):
    from exoid.symbolic import Model
    from exoid.workbench.command_line.inputs import check_new_model

    target = tmp_path / "leg_stribeck.toml"
    Model().save(target)
    check_new_model(str(target), None, named=False)
    target.write_text('name = "by hand"\n')
    check_new_model(str(target), None)
    with pytest.raises(OutputError, match="not written by exoid"):
        check_new_model(str(target), None, named=False)


def test_a_session_is_known_by_what_exoid_wrote_into_it(run, tmp_path, capsys):
    pytest.importorskip("starlette")
    for names in (("session.json", "model.toml"), ("report.html",), ("model.toml",)):
        files = others_in(tmp_path / "-".join(names), *names)
        assert main(["open", str(run), "--out", str(tmp_path / "-".join(names)), "--no-browser", "--quiet"]) == 2
        said = capsys.readouterr().err
        assert "there is something else" in said or "not written by exoid" in said
        assert {path: path.read_text() for path in (tmp_path / "-".join(names)).iterdir()} == files
