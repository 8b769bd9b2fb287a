"""`exoid watch` on streams as they are: lines that end later, logs that are rotated, pipes that are closed, Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from exoid.workbench.command import main
from tests.waiting import HUNG, until

ROOT = Path(__file__).parents[3]
HEADER = "t,q1,q2,tau1,tau2\n"


def rows(first: int, last: int) -> str:
    return "".join(f"{k / 100:.2f},{0.5 + 0.001 * (k % 50)},-0.8,{k % 7},1.5\n" for k in range(first, last))


def wait_for(path: Path, text: str, count: int, process: subprocess.Popen[str]) -> None:
    """Wait until `text` is there so often; AssertionError where the process ends before."""

    def there() -> bool:
        if path.exists() and path.read_text(encoding="utf-8").count(text) >= count:
            return True
        assert process.poll() is None, process.communicate()
        return False

    until(there, lambda: path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_a_growing_log_is_followed_through_rotation_until_interrupted(tmp_path: Path) -> None:
    log, out = tmp_path / "log.csv", tmp_path / "out.jsonl"
    log.write_text(HEADER + rows(0, 300) + "3.00,0.5,-0.", encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, "-m", "exoid", "watch", "standard", "--follow", str(log), "--json", str(out)],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        wait_for(out, '"start"', 1, process)
        with log.open("a", encoding="utf-8") as stream:  # the end of the partial line, and two that are none
            stream.write("8,1,1.5\n{broken\n3.01,oops,-0.8,1,1\n3.011,nan,-0.8,1,1\n" + rows(302, 400))
        wait_for(out, '"skipped"', 2, process)
        log.rename(tmp_path / "log.1")
        log.write_text(HEADER + "rotated\n" + rows(400, 500), encoding="utf-8")
        wait_for(out, '"skipped"', 3, process)
        log.write_text("", encoding="utf-8")
        log.write_text(HEADER + "again\n", encoding="utf-8")
        wait_for(out, '"skipped"', 4, process)
        process.send_signal(signal.SIGINT)
        said, complaints = process.communicate(timeout=HUNG)
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()
    assert process.returncode == 2  # too short to say what is usual
    assert "Traceback" not in said + complaints
    events = [json.loads(line) for line in out.read_text(encoding="utf-8").splitlines()]
    assert events[-1]["event"] == "summary"
    assert events[-1]["seconds"] > 4.5  # what was written after the rotation was watched too
    assert [e["line"] for e in events if e["event"] == "skipped"] == [303, 304, 2, 2]
    assert all("t" in e for e in events)
    assert [e["channels"] for e in events if e["event"] == "bad_samples"] == [["q1"], ["q1"]]  # begins, and is over


def test_standard_input_that_is_closed_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", None)
    assert main(["watch", "standard", "-"]) == 2
    assert "standard input is closed" in capsys.readouterr().err


@pytest.mark.slow
def test_numbers_of_a_model_file_are_said_not_to_be_used_and_a_result_is_no_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, model, result = tmp_path / "run.csv", tmp_path / "leg.toml", tmp_path / "fit.json"
    run.write_text(HEADER + rows(0, 300), encoding="utf-8")
    model.write_text('name = "leg"\n[identified.parameters]\nPhi1 = 1.2\n', encoding="utf-8")
    result.write_text('{"schema": "exoid.fit/1"}\n', encoding="utf-8")
    assert main(["watch", str(model), str(run)]) == 2
    said = capsys.readouterr().out
    assert "are not used" in said
    assert "too little to say what is usual" in said
    assert main(["watch", str(result), str(run)]) == 2
    assert "exoid identify --write" in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="signals of Unix")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
@pytest.mark.parametrize("piped", [False, True])
def test_whatever_ends_it_there_is_a_summary(tmp_path: Path, name: str, piped: bool) -> None:
    log, out = tmp_path / "log.csv", tmp_path / "out.jsonl"
    log.write_text(HEADER + rows(0, 800), encoding="utf-8")
    source = ["-"] if piped else ["--follow", str(log)]
    process = subprocess.Popen(
        [sys.executable, "-m", "exoid", "watch", "standard", *source, "--json", str(out)],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdin is not None
    try:
        if piped:
            process.stdin.write(log.read_text(encoding="utf-8"))
            process.stdin.flush()
        wait_for(out, '"start"', 1, process)
        process.send_signal(getattr(signal, name))
        complaints = process.communicate(timeout=HUNG)[1]
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()
    assert process.returncode == 2, complaints
    assert "nothing was looked for" in complaints
    assert json.loads(out.read_text(encoding="utf-8").splitlines()[-1])["event"] == "summary"


def test_a_slow_stream_is_refused_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.csv"
    log.write_text(HEADER + "".join(f"{k},{k * 0.37 % 1.2},-0.8,{k % 7},1.5\n" for k in range(90)), encoding="utf-8")
    later = time.time() + 3600.0
    os.utime(log, (later, later))  # a machine that is busy for seconds would find a file that grows no more
    assert main(["watch", "standard", str(log)]) == 2
    said = capsys.readouterr()
    assert "too low for a cut-off" in " ".join(said.err.split())
    assert "Phi1" not in said.out


@pytest.mark.slow
def test_a_logger_that_starts_again_in_degrees_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, out = tmp_path / "log.csv", tmp_path / "out.jsonl"
    again = "Logger restarted\nt,q2 [deg],q1 [deg],tau1,tau2\n"
    log.write_text(f"Logger started\n{HEADER}{rows(0, 300)}{again}{rows(300, 600)}", encoding="utf-8")
    main(["watch", "standard", str(log), "--json", str(out)])
    events = [json.loads(line) for line in out.read_text(encoding="utf-8").splitlines()]
    assert [e["event"] for e in events] == ["skipped", "skipped", "columns", "start", "summary"]
    assert [e["t"] for e in events[:3]] == pytest.approx([0.0, 2.99, 2.99])
    assert "q1 from 'q1' in deg" in events[2]["sentence"]
    assert "named anew" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("text", ["", HEADER, "nothing here\n"])
def test_where_nothing_was_looked_for_the_exit_status_says_so(
    tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.csv"
    log.write_text(text, encoding="utf-8")
    assert main(["watch", "standard", str(log)]) == 2
    assert "nothing was looked for" in capsys.readouterr().err


@pytest.mark.slow
def test_a_report_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from benchmarks.watched_leg import exact_rows

    log, out = tmp_path / "log.csv", tmp_path / "out"
    stream = exact_rows(0.0, 60.0, 100.0)
    log.write_text(HEADER + "\n".join(",".join(f"{x:.6f}" for x in row) for row in stream.tolist()), encoding="utf-8")
    assert main(["watch", "standard", str(log), "--learn", "30", "--out", str(out), "--json", str(tmp_path / "j")]) == 0
    assert "report.html" in capsys.readouterr().out
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "The numbers over time" in page
    assert "no change" in page
    kept = json.loads((out / "result.json").read_text(encoding="utf-8"))
    streamed = [json.loads(line) for line in (tmp_path / "j").read_text(encoding="utf-8").splitlines()]
    assert kept["events"] == streamed
    assert len(kept["t"]) == len(kept["numbers"]["Phi1"]["value"]) > 1
